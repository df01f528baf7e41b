"""Forecasts beside lives whose end is known by quadrature: how often the interval holds the truth."""

import numpy as np
import pytest
from scipy.stats import kstest

from wearfem.proofs import forecast as proof


def test_the_truth_lies_anywhere_among_the_draws():
    """A few lives: the rank of the truth is even, so that both too narrow and too wide draws would be seen."""
    found = proof.told(12, first=8000)
    # a right forecast fails once in a thousand; ranks all within 0.4 to 0.6, or half of them outside the draws, do
    assert kstest([one.rank for one in found], "uniform").pvalue > 1e-3
    middle, line = (
        np.sqrt(np.mean([(getattr(one, name) - 1.0) ** 2 for one in found]))
        for name in ("middle", "straight_line")
    )
    assert middle < line  # the laws bend: a straight line is off by a tenth and more


@pytest.mark.slow
def test_the_interval_holds_the_truth():
    for claim in proof.coverage(proof.told(336)):
        assert claim.holds, claim


@pytest.mark.slow
@pytest.mark.xfail(
    reason="lives of 64 equal facets are told some 0.6 % early, 0.5 % is asked: at this noise samples cannot tell equal facets from such "
    "that differ by 0.5 %, whose lives are told as much too late (decision 0012)",
    strict=True,
)
def test_the_first_of_many_equal_facets_is_told_in_time():
    for claim in proof.equal_facets(30):
        assert claim.holds, claim
