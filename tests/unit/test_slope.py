"""The free surface and its slope: planted heaps are read as they were planted."""

import math

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.slope import Profile, fit_line, free_surface


def planted(angle, seed=0):
    """Spheres filling a wedge 0.3 m long under a slope of `angle` [degree] at random, with some flying above."""
    random = np.random.default_rng(seed)
    along, across = 0.3 * random.random(60_000), 0.04 * random.random(60_000)
    height = 0.3 * random.random(60_000)
    inside = height < (0.3 - along) * math.tan(math.radians(angle))
    flying = np.flatnonzero(~inside)[:8]
    chosen = np.concatenate([np.flatnonzero(inside), flying])
    return along[chosen], across[chosen], height[chosen], np.full(len(chosen), 0.003)


@pytest.mark.parametrize("angle", [15.0, 30.0, 40.0])
def test_a_planted_slope_is_read(angle):
    line = fit_line(free_surface(*planted(angle), cell=0.006, width=0.04))
    assert line.angle == pytest.approx(angle, abs=0.5)  # tops scatter by about 1 mm over 0.2 m: 0.3 degrees
    assert line.low - 0.3 <= angle <= line.high + 0.3  # as above: the interval is that of the line
    assert line.column_count > 25


def test_a_rising_slope_is_negative():
    along, across, height, radius = planted(30.0)
    line = fit_line(free_surface(-along, across, height, radius, cell=0.006, width=0.04))
    assert line.angle == pytest.approx(-30.0, abs=0.5)  # as above


def test_a_line_is_exact_and_single_columns_do_not_matter():
    along = np.linspace(0.0, 1.0, 41)
    height = 1.0 - along * math.tan(math.radians(35.0))
    height[[7, 30]] += 0.1
    assert fit_line(Profile(along, height)).angle == pytest.approx(35.0, abs=1e-10)  # rounding


def test_the_profile_is_the_median_top_of_the_strips():
    along, across = np.array([0.5, 0.5, 0.5, 0.5, 1.5]), np.array([0.5, 0.6, 1.5, 2.5, 0.5])
    profile = free_surface(
        along, across, np.array([1.0, 2.0, 3.0, 9.0, 5.0]), np.full(5, 0.25), cell=1.0, width=3.0
    )
    assert profile.along.tolist() == [0.5]  # the second column has particles in one strip of three only
    assert profile.height.tolist() == [3.25]


def test_too_short_a_slope_is_told():
    with pytest.raises(UserError, match="a line needs 4"):
        fit_line(Profile(np.arange(4.0), np.arange(4.0)))
