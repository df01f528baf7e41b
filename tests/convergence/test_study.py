"""Converged answers against closed forms, and what is said where there is none."""

from math import isnan, nan

import numpy as np
import pytest

from wearfem.convergence import converged
from wearfem.errors import UserError
from wearfem.proofs import study


def test_claims():
    for claim in study.claims():
        assert claim.holds, f"{claim.claim}: {claim.computed} against {claim.expected}"


@pytest.mark.parametrize("order", [0.6, 1.0, 1.7, 2.0, 3.3])
def test_a_power_is_found_from_any_sizes(order):
    h = np.array([0.31, 1.0, 0.5])
    found = converged(h, -2.0 + 0.3 * h**order)
    assert found.value == pytest.approx(-2.0, abs=1e-9)  # the fit ends where rounding hides the rest
    assert found.order == pytest.approx(order, abs=1e-7)


def test_a_published_example():
    """Celik et al. (2008), Table 1, first column: 18000, 8000 and 4500 cells in 2-D; p = 1.53, extrapolated 6.1685."""
    found = converged(np.array([18000, 8000, 4500]) ** -0.5, [6.063, 5.972, 5.863])
    assert found.order == pytest.approx(1.53, abs=0.006)  # printed to two digits
    assert found.value == pytest.approx(6.1685, abs=0.0006)  # from sizes rounded to 1.5 and 1.333 there
    assert abs(found.value - 6.063) * 1.25 <= found.error * (1.0 + 1e-12)


@pytest.mark.parametrize(
    ("value", "noise", "reason"),
    [
        ([1.0, 2.0, 1.0, 2.0], None, "from one side"),
        ([1.0, 2.0, 3.0, 4.0], None, "by the order"),  # of sizes 1/8 ... 1: like a logarithm
    ],
)
def test_no_answer_where_there_is_none(value, noise, reason):
    found = converged([0.125, 0.25, 0.5, 1.0], value, noise)
    assert reason in found.reason and not found.told and found.error == np.inf


def test_no_dependence():
    same = converged([1, 2, 4], [5.0, 5.0, 5.0])
    assert (same.value, same.error) == (5.0, 0.0) and isnan(same.order)
    hidden = converged([1, 2, 4], [5.0, 5.1, 4.95], 0.1)
    assert hidden.value == pytest.approx(np.mean([5.0, 5.1, 4.95]), rel=1e-12)  # rounding
    assert hidden.noise == pytest.approx(0.1 / np.sqrt(3.0), rel=1e-12)  # of a mean of three


@pytest.mark.parametrize(
    ("size", "value", "noise"),
    [
        ([1, 2], [1, 2], None),
        ([1, 1, 2], [1, 2, 3], None),
        ([0, 1, 2], [1, 2, 3], None),
        ([1, 2, 3], [1, 2, nan], None),
        ([1, 2, 3], [1, 2, 3], 0.0),
    ],
)
def test_mistakes_are_sentences(size, value, noise):
    with pytest.raises(UserError, match="a converged answer was"):
        converged(size, value, noise)
