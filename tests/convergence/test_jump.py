"""Orders in time, and closed forms within what is asked."""

import numpy as np
import pytest

from wearfem.proofs import jump
from wearfem.proofs._plants import by_jumps, layered, seen_through_noise


def test_closed_forms():
    for claim in jump.closed_forms():
        assert claim.holds, claim
        assert claim.tolerance == 1e-3  # 0.1 % is asked


def test_orders():
    plant = jump.falling()
    coarse, fine = (jump.equal_jumps(plant, count) for count in (40, 80))
    # a quarter: the first jump is of another kind, and the number of samples is off by one or two
    assert jump.observed_order(plant, coarse, fine, with_bias=True) == pytest.approx(2.0, abs=0.25)
    assert jump.observed_order(plant, coarse, fine) == pytest.approx(3.0, abs=0.25)


@pytest.mark.slow
def test_orders_of_every_plant():
    plants = (jump.growing(), jump.falling(), jump.field_with_feedback())
    failed = [claim for claim in jump.order(plants, (80, 160)) if not claim.holds]
    assert not failed


@pytest.mark.slow
def test_a_border_no_longer_costs_three_times_the_floor():
    """At most 2 times the statistical floor is asked; 1.67 and 1.24 were found on these seeds."""
    for noise in jump.NOISES:
        plant = seen_through_noise(layered(), noise)
        cost = np.mean([by_jumps(plant, plant.goal, seed).cost for seed in range(jump.SEEDS)])
        assert cost < 2.0 * jump.floor(plant)
