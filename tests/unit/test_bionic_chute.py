"""The case bionic_chute: what its own lines do, without running particles."""

from math import pi
from pathlib import Path

import numpy as np
import pytest

from wearfem.case import load_any_case, parts_of
from wearfem.errors import UserError
from wearfem.liner.liner import wear_surface
from wearfem.loads import FacetLoads

CASE = Path(__file__).parents[2] / "cases" / "bionic_chute"
COARSE = {"sectors": 8, "rings": 2, "rings_around": 1, "end": np.radians(64.16)}


def loads_of(surface, load_distance):
    """Loads of given load distance (b, f) [N m], one second a block, nothing else."""
    blocks, facets = load_distance.shape
    nothing, classes = np.zeros((blocks, facets)), np.zeros((blocks, facets, 0))
    return FacetLoads(
        np.ones(blocks), surface.facet_area, nothing, np.zeros((blocks, facets, 3)), nothing, load_distance,
        nothing, nothing, nothing, nothing, classes, classes, np.zeros((blocks, facets, 0, 0)),
        np.zeros(1), np.zeros(1), np.zeros(1),
    )  # fmt: skip


def zone_angle(surface):
    """(f,) [rad] least angle of the corners of each facet"""
    return np.arctan2(-surface.corner[..., 2], -surface.corner[..., 0]).min(axis=1)


@pytest.fixture(scope="module")
def case():
    return load_any_case(CASE, COARSE)


def test_alike_keeps_volume_and_forgets_which_one(case):
    surface, random = wear_surface(case.liner), np.random.default_rng(7)
    rate = random.exponential(1e-9, (3, surface.facet_count))
    loads = loads_of(surface, rate)
    (alike,) = case.effects
    mean = alike.modify(rate, loads, case.liner)
    # Areas of facets alike differ by their place on the faceted arc, less than the square of a facet over the radius, 6e-6.
    worn = alike.row >= alike.first
    volume = (rate * worn) @ surface.facet_area
    np.testing.assert_allclose(mean @ surface.facet_area, volume, rtol=1e-5)
    assert (mean[:, ~worn] == 0.0).all()
    assert 35.34 <= np.degrees(zone_angle(surface)[worn].min()) < 35.34 + 0.6  # a tile of 20 mm at the most
    for kind in range(alike.alike.max() + 1):
        same = (alike.alike == kind) & (alike.row == 20)
        assert np.ptp(mean[0, same]) < 1e-9 * mean[0, same].mean()  # rounding
    # Each value is a mean of 11 rows with two or more facets each: noise falls with the root of their number at least.
    inner = (alike.row > alike.first + 10) & (alike.row < alike.row.max() - 10)
    assert mean[:, inner].std() < 1.1 * rate.std() / np.sqrt(22.0)


def test_alike_leaves_alone_what_does_not_differ(case):
    surface = wear_surface(case.liner)
    (alike,) = case.effects
    kind = 1e-9 * (1.0 + alike.alike.astype(float))[None, :]
    worn = alike.row >= alike.first
    mean = alike.modify(kind, loads_of(surface, kind), case.liner)
    np.testing.assert_allclose(mean, kind * worn, rtol=1e-12)  # rounding


def test_zone_2_is_measured_to_its_borders(case):
    where, surface = (
        case.measure.where,
        wear_surface(load_any_case(CASE, {**COARSE, "convexes": False}).liner),
    )
    length = 2.0 * (64.15 - 35.34) * pi / 180.0
    # Chords for arcs, (5 mm / 2 m)^2 / 24, and borders that cut triangles in proportion to angle and not to area: a quarter of a
    # facet at most, of the 1.006 m.
    assert where.zone_2 @ surface.facet_area == pytest.approx(length * 0.03, rel=0.003)
    load = np.ones((2, surface.facet_count))
    full, convex = (where.volume_rate(loads_of(surface, load), part).sum() for part in (1.0, where.on_convex))
    assert full == pytest.approx(2.0 * 3.0e-13 * where.zone_2.sum() / 0.15, rel=1e-12)  # k, 0.15 of the width
    assert 0.0 < convex < full


def test_without_convexes_the_same_mesh_is_smooth():
    smooth, embossed = (load_any_case(CASE, {**COARSE, "convexes": c}) for c in (False, True))
    np.testing.assert_array_equal(smooth.liner.mesh.element, embossed.liner.mesh.element)
    point = wear_surface(smooth.liner).point
    np.testing.assert_allclose(np.hypot(point[:, 0], point[:, 2]), 2.0, rtol=1e-12)  # rounding
    assert wear_surface(embossed.liner).facet_area.sum() > wear_surface(smooth.liner).facet_area.sum()


def test_frozen_and_moving_are_the_same_case_but_for_that():
    assert load_any_case(CASE, {**COARSE, "frozen": True}).frozen
    with pytest.raises(UserError, match="their spacing leaves room"):
        load_any_case(CASE, {"minor_radius": 9e-3})


def test_parts_of_another_case():
    chute = parts_of(CASE.parent / "transfer_chute")
    assert chute.RADIUS == 2.0
    with pytest.raises(UserError, match="there is no case"):
        parts_of(CASE.parent / "transfer_shute")
