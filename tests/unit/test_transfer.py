"""Fields from one mesh to another: areas of overlap by hand, conservation and bounds on random meshes."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from wearfem.liner.transfer import clipped_area, nearest_point, overlap, transfer, transfer_nodes
from wearfem.material import Material
from wearfem.surface import Surface

STEEL = Material("steel", 7850.0, 80e9, 0.3)


def random_square(seed: int, count: int, bent: float = 0.0) -> Surface:
    random = np.random.default_rng(seed)
    side = np.linspace(0.0, 1.0, 6)
    border = [[x, y] for x in side for y in (0.0, 1.0)] + [[x, y] for x in (0.0, 1.0) for y in side[1:-1]]
    place = np.concatenate([border, 0.05 + 0.9 * random.random((count, 2))])
    triangle = Delaunay(place).simplices
    a, b, c = np.moveaxis(place[triangle], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangle = np.where(area[:, None] < 0.0, triangle[:, ::-1], triangle)[np.abs(area) > 1e-9]
    return Surface(np.column_stack([place, bent * place[:, 0] * (1.0 - place[:, 0])]), triangle, STEEL)


def test_areas_of_overlap_by_hand():
    triangle = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]])
    for other, area in (
        ([[0, 0], [1, 0], [0, 1]], 0.5),  # itself
        ([[0.25, 0.25], [0.5, 0.25], [0.25, 0.5]], 1 / 32),  # inside
        ([[-1, -1], [3, -1], [-1, 3]], 0.5),  # around
        ([[2, 2], [3, 2], [2, 3]], 0.0),  # away
        ([[1, 0], [1, 1], [0, 1]], 0.0),  # only an edge in common
        ([[0, 0], [1, 0], [1, 1]], 0.25),  # cut along the diagonal
        ([[0.5, -1], [2, -1], [0.5, 2]], 0.125),  # cut along x = 1/2
    ):
        found = clipped_area(np.array([other], float), triangle)[0]
        assert abs(found - area) < 1e-15  # rounding


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 60), st.integers(1, 60))
def test_overlaps_of_a_plane_fill_both_meshes(seed, first, second):
    before, after = random_square(seed, first), random_square(seed + 1, second)
    share = overlap(before, after)
    assert (
        np.abs(share.sum(axis=1) - after.facet_area).max() < 1e-9
    )  # overlaps below 1e-9 of a facet are left out
    assert np.abs(share.sum(axis=0) - before.facet_area).max() < 1e-9


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(5, 60), st.integers(5, 60), st.floats(0.0, 1.0))
def test_integral_bounds_and_constants(seed, first, second, bent):
    before, after = random_square(seed, first, bent), random_square(seed + 1, second, bent)
    field = np.random.default_rng(seed).random((2, len(before.triangle)))
    new = transfer(field, before, after)
    old_total, new_total = field @ before.facet_area, new @ after.facet_area
    limit = 1e-10 * old_total
    reachable = new.max(axis=1) < field.max(axis=1)  # not pushed against the bounds by a large change of area
    assert (np.abs(new_total - old_total) <= limit)[reachable].all()
    assert (new >= field.min(axis=1, keepdims=True)).all() and (new <= field.max(axis=1, keepdims=True)).all()
    constant = transfer(np.full(len(before.triangle), 0.3), before, after)
    assert np.abs(constant - 0.3).max() < 1e-15  # rounding


def test_a_linear_field_stays_linear_to_the_size_of_facets():
    before, after = random_square(1, 400), random_square(2, 400)
    x = before.corner.mean(axis=1)[:, 0]
    new = transfer(x, before, after)
    there = after.corner.mean(axis=1)[:, 0]
    edge = np.sqrt(before.area.max())
    assert np.abs(new - there).max() < edge  # a facet's mean is known to the size of the old facets
    assert (
        np.sqrt(after.area @ (new - there) ** 2) < 0.02
    )  # and in the mean much better: 1/sqrt(800) = 0.035 is their size


def test_the_back_of_a_thin_plate_is_not_its_front():
    front = random_square(1, 20)
    point = np.concatenate([front.point, front.point - [0.0, 0.0, 0.001]])
    back = front.triangle[:, ::-1] + len(front.point)
    before = Surface(point, np.concatenate([front.triangle, back]), STEEL)
    field = np.where(np.arange(len(before.triangle)) < len(front.triangle), 1.0, 0.0)
    assert np.array_equal(transfer(field, before, before), field)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.0, 0.5))
def test_the_nearest_point_is_where_the_surface_is(seed, bent):
    surface = random_square(seed, 30, bent)
    random = np.random.default_rng(seed)
    start, weight = random.integers(len(surface.triangle), size=20), random.dirichlet(np.ones(3), 20)
    point = np.einsum("mk,mki->mi", weight, surface.corner[start])
    found, part = nearest_point(point, surface.point, surface.triangle)
    place = np.einsum("mk,mki->mi", part, surface.corner[found])
    assert np.abs(place - point).max() < 1e-12  # rounding


def test_nodal_fields_keep_linear_functions_and_their_integral():
    before, after = random_square(3, 50), random_square(4, 80)
    linear = 1.0 + before.point @ [1.0, 2.0, 0.0]
    new = transfer_nodes(linear, before.point, before.triangle, after.point, after.triangle)
    assert np.abs(new - 1.0 - after.point @ [1.0, 2.0, 0.0]).max() < 1e-12  # rounding: nothing to balance
