"""Second order in time, and closed forms within what is asked."""

import pytest

from wearfem.proofs import jump


def test_closed_forms():
    for claim in jump.closed_forms():
        assert claim.holds, claim
        assert claim.tolerance == 1e-3  # 0.1 % is asked


def test_second_order():
    plant = jump.falling()
    coarse, fine = (jump.equal_jumps(plant, count) for count in (40, 80))
    # 1.75 to 2.25: the first jump is of another kind, and the number of samples is off by one or two
    assert jump.observed_order(plant, coarse, fine) == pytest.approx(2.0, abs=0.25)


@pytest.mark.slow
def test_second_order_of_every_plant():
    plants = (jump.growing(), jump.falling(), jump.field_with_feedback())
    failed = [claim for claim in jump.order(plants, (80, 160)) if not claim.holds]
    assert not failed


@pytest.mark.slow
@pytest.mark.xfail(
    reason="10 of 12 promises within a factor 2, 90 % asked; layered borders cost too much: decision 0006"
)
def test_promises_and_costs_as_asked():
    failed = [claim.claim for claim in jump.everything() if not claim.holds]
    assert not failed
