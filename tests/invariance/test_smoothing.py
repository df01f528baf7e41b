"""What smoothing must keep, on whatever triangulation, by property tests."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from wearfem.material import Material
from wearfem.proofs.smoothing import folded, needles, uneven
from wearfem.surface import Surface
from wearfem.wear.smooth import HelmholtzFilter

STEEL = Material("steel", 7850.0, 80e9, 0.3)
meshes = st.one_of(
    st.integers(0, 10**6).map(lambda seed: needles(seed, 60)),
    st.integers(3, 9).map(uneven),
    st.integers(2, 5).map(folded),
)


@settings(max_examples=60, deadline=None)
@given(meshes, st.floats(-4.0, 2.0), st.integers(0, 10**6))
def test_volume_sign_and_bounds_are_kept(surface, exponent, seed):
    random = np.random.default_rng(seed)
    depth = random.random(len(surface.triangle)) * (random.random(len(surface.triangle)) < 0.1)
    smoother = HelmholtzFilter(surface, 10.0**exponent)
    smooth = smoother(depth)
    assert smooth.min() >= 0.0  # exact: no subtraction anywhere in the solve
    assert smooth.max() <= depth.max() * (1.0 + 1e-10)  # rounding x condition of needles
    volume, before = (np.bincount(smoother.part, surface.area * field) for field in (smooth, depth))
    assert np.abs(volume - before).max() <= 1e-12 * before.sum()  # rounding of sums, part by part


@settings(max_examples=20, deadline=None)
@given(meshes, st.floats(-3.0, 1.0), st.integers(0, 10**6))
def test_what_one_facet_hands_to_another_it_gets_back(surface, exponent, seed):
    one, two = np.random.default_rng(seed).random((2, len(surface.triangle)))
    smoother = HelmholtzFilter(surface, 10.0**exponent)
    there, back = surface.area * two @ smoother(one), surface.area * one @ smoother(two)
    assert abs(there - back) <= 1e-11 * there  # rounding x condition of needles


def test_the_diagonal_does_not_matter_when_the_mesh_is_fine():
    def apart(cells: int) -> float:
        surface = uneven(cells)
        quad = surface.triangle.reshape(-1, 2, 3)
        a, b, c, d = quad[:, 0, 0], quad[:, 0, 1], quad[:, 0, 2], quad[:, 1, 2]
        other = np.stack([np.stack([a, b, d], axis=1), np.stack([b, c, d], axis=1)], axis=1)
        facet = np.repeat(np.arange(len(quad)), 2)
        x, y = surface.point[quad[:, 0]].mean(axis=1)[:, :2].T
        depth = np.cos(2.0 * np.pi * x) * np.cos(np.pi * y)
        one, two = (
            HelmholtzFilter(Surface(surface.point, cut.reshape(-1, 3), STEEL, facet), 0.15)(depth)
            for cut in (quad, other)
        )
        return float(np.abs(one - two).max())

    coarse, fine = apart(16), apart(64)
    assert fine < 0.01  # (k h)^2 = 1 %
    assert fine < coarse / 8.0  # order 2 would be 16; meshes are random


def test_smoothing_goes_with_the_surface_when_it_is_moved_and_turned():
    surface = uneven(12)
    rotation = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    moved = Surface(surface.point @ rotation.T + [1.0, -2.0, 3.0], surface.triangle, STEEL)
    depth = np.random.default_rng(1).random(len(surface.triangle))
    apart = HelmholtzFilter(moved, 0.1)(depth) - HelmholtzFilter(surface, 0.1)(depth)
    assert np.abs(apart).max() < 1e-12  # rounding of coordinates a few metres from the origin
