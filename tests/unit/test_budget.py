"""The cheapest plan of a life: its limits, and what it trades."""

from statistics import NormalDist

import numpy as np
import pytest

from wearfem.wear.budget import LEAST, cheapest_plan, deviation_beside

LIFE = 1e7  # [s]
FLOW = {
    "change": 1.0,
    "bend": 2.0,
    "noise_density": 0.01,
    "memory": 1.0,
    "block": 0.25,
    "tolerance": 0.02,
    "confidence": 0.9,
}


def plan(longest=np.inf, **other):
    return cheapest_plan(LIFE, longest, **{**FLOW, **other})


def test_deviation_without_bias():
    # 0.9 of a normal lies within 1.645 deviations; bisection of 60 steps leaves rounding
    assert deviation_beside(np.zeros(1), 0.9)[0] == pytest.approx(1.0 / NormalDist().inv_cdf(0.95), rel=1e-9)


def test_noise_asks_for_the_statistical_floor():
    """Much noise: as much sampling as it demands by itself, within what a small bias costs."""
    floor = 10.0 * (NormalDist().inv_cdf(0.95) / 0.02) ** 2
    assert floor <= plan(noise_density=10.0).sampling <= 1.05 * floor


def test_a_long_memory_is_waited_for_and_a_small_change_is_not():
    assert plan(memory=4.0).warm_up > plan(memory=1.0).warm_up
    assert plan(change=0.0, bend=0.0).warm_up == FLOW["block"]  # nothing changes: only the block of the move


def test_a_bend_shortens_jumps_and_bounds_hold():
    assert plan(bend=20.0).jump < plan(bend=2.0).jump
    assert plan(longest=1e5).jump <= 1e5 * (1.0 + 1e-12)  # rounding of the logarithmic grid


def test_dear_warm_ups_make_jumps_long():
    short, long = plan(memory=0.1), plan(memory=3.0)
    assert long.jump > short.jump
    assert long.sampling >= LIFE / long.jump * LEAST * FLOW["block"] * (1.0 - 1e-9)


def test_jumps_are_as_long_as_the_trapezoid_rule_allows():
    """Without noise and change, dear warm-ups: b N^-2 / 12 of the life uses up the share of the tolerance that bias may have."""
    free = plan(change=0.0, bend=20.0, noise_density=1e-12, block=1e-3)
    bias = 20.0 / 12.0 * (free.jump / LIFE) ** 2
    # the grid has 60 numbers of jumps, neighbours some 8 % apart, and never takes one too few
    assert 0.85 * 0.5 * 0.02 <= bias <= 0.5 * 0.02 * (1.0 + 1e-9)
