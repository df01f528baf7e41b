"""A loose packing: nothing touches, nothing sticks out, as much as was asked for, the same from the same seed."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from wearfem.dem.feed import packing, uniform_sizes
from wearfem.errors import UserError

LOW, HIGH = (-0.1, 0.0, 1.0), (0.1, 0.15, 1.3)
SIZES = uniform_sizes(0.002, 0.008)


def test_spheres_lie_inside_and_apart_across_periodic_sides_too():
    radius, position = packing(LOW, HIGH, SIZES, count=1500, seed=3)
    assert len(radius) == 1500
    assert (position - radius[:, None] >= np.array(LOW) - 1e-12).all()  # rounding of numbers near 1
    assert (position + radius[:, None] <= np.array(HIGH) + 1e-12).all()  # as above
    tree = cKDTree(position - LOW, boxsize=np.subtract(HIGH, LOW))
    pairs = tree.query_pairs(2 * SIZES.largest, output_type="ndarray")
    apart = position[pairs[:, 0]] - position[pairs[:, 1]]
    apart -= np.subtract(HIGH, LOW) * np.round(apart / np.subtract(HIGH, LOW))
    assert len(pairs) > 100
    assert (np.linalg.norm(apart, axis=1) - radius[pairs].sum(axis=1)).min() > -1e-12  # as above


def test_the_mass_is_met_to_half_of_a_sphere():
    radius, _ = packing(LOW, HIGH, SIZES, mass=1.2, density=2500.0)
    total = (2500.0 * 4.0 / 3.0 * np.pi * radius**3).sum()
    assert abs(total - 1.2) <= 0.5 * 2500.0 * 4.0 / 3.0 * np.pi * SIZES.largest**3


def test_layers_fill_from_the_bottom():
    radius, position = packing(LOW, HIGH, SIZES, count=100)
    assert (
        position[:, 2].max() + 0.0 < LOW[2] + 2 * 2 * 1.1 * SIZES.largest
    )  # 108 cells a layer, so one layer


def test_the_seed_decides():
    one, two, other = (packing(LOW, HIGH, SIZES, count=50, seed=seed) for seed in (1, 1, 2))
    assert (one[1] == two[1]).all() and (one[0] == two[0]).all()
    assert not (one[1] == other[1]).all()


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"count": 100_000}, "not for 100000 spheres"),
        ({"mass": 100.0, "density": 2500.0}, "not for 100 kg"),
        ({"mass": 1.0}, "give `count`, or `mass` with `density`"),
        ({}, "give `count`, or `mass` with `density`"),
    ],
)
def test_what_cannot_be_is_told(given, sentence):
    with pytest.raises(UserError, match=sentence):
        packing(LOW, HIGH, SIZES, **given)
