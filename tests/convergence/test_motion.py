"""The order of the time integration, what is conserved, and how the rest converges."""

import math

import numpy as np
import pytest

from wearfem.case import Window
from wearfem.dem.sample import sample
from wearfem.proofs import motion, seams


def test_an_elastic_impact_is_second_order():
    assert motion.observed_order(motion.after_impact, 2e-5) == pytest.approx(2.0, abs=0.1)  # asymptotic range


def test_a_damped_swing_is_second_order():
    assert motion.observed_order(motion.swing, 2e-5) == pytest.approx(2.0, abs=0.1)  # asymptotic range


def test_collisions_keep_momentum_and_angular_momentum():
    momentum, angular_momentum, lost = motion.colliding_cloud()
    assert lost > 0.1  # they did collide
    assert momentum < 1e-13  # rounding
    assert angular_momentum < 1e-12  # rounding, arms included


def test_elastic_oblique_impacts_never_create_energy():
    gains = motion.oblique_gains()
    assert len(gains) > 150  # the others have not parted yet
    assert gains.max() < 1e-6  # truncation at 1 us


@pytest.mark.parametrize("name", motion.ROLLING_LAWS)
def test_the_ledger_of_a_tumbling_bed_closes(name):
    gap, dissipated = motion.tumbling_bed(motion.ROLLING_LAWS[name], duration=0.15)
    assert abs(gap) < 1e-3 * dissipated  # the claim, at 4 % of the smallest Rayleigh time


@pytest.mark.slow
@pytest.mark.parametrize("name", motion.ROLLING_LAWS)
def test_the_ledger_closes_over_a_second(name):
    gap, dissipated = motion.tumbling_bed(motion.ROLLING_LAWS[name])
    assert abs(gap) < 1e-3 * dissipated  # the claim


def test_load_distance_converges_with_the_step():
    """A sliding sphere that friction slows and turns: F (v t - 7/4 mu F/m t^2) where the arm is R.

    Sums at the ends of steps are first order.
    """
    duration, speed = 0.012, 0.5  # it rolls after 19 ms
    mass = 4.0 / 3.0 * math.pi * seams.RADIUS**3 * seams.ORE.density
    arm = 1.0 - seams.resting_overlap(seams.LOAD) / seams.RADIUS
    slowing = 0.5 * seams.LOAD / mass * (1.0 + arm**2 / 0.4)
    exact = speed * duration - slowing / 2.0 * duration**2
    errors = []
    for time_step in (4e-5, 2e-5, 1e-5):
        flow, model = seams.on_the_plate(
            (seams.plate(8, seed=1),),
            (-0.011, 0.007),
            (0.8, 0.6),
            speed=speed,
            rolling=False,
            time_step=time_step,
        )
        flow.particles.held[:] = 0
        _, loads, _ = sample(flow, model, Window(duration))
        errors.append(loads.load_distance.sum() / (seams.LOAD * exact) - 1.0)
    orders = np.log2(np.abs(errors[:-1]) / np.abs(errors[1:]))
    assert (orders > 0.9).all()  # first order
    assert abs(errors[-1]) < 1e-3  # dt / duration = 5e-4
