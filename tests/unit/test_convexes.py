"""Faces with convexes: whole tiles that meet, fit to themselves across, look into the flow and wear like any shell."""

from math import radians

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.liner.convexes import Convex, Fineness, Pattern, bent_shell, embossed_strip
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.mesh import WEAR
from wearfem.liner.recede import recede, volume
from wearfem.material import Material

BASE = Pattern(Convex(3e-3, 2e-3, 2e-3), 40e-3, 30e-3)
COARSE = Fineness(8, 2, 1)
STEEL = Material("steel", 7932.0, 78e9, 0.3)
ROUNDING = 1e-12


def edges(triangle):
    edge = np.sort(np.concatenate([triangle[:, [0, 1]], triangle[:, [1, 2]], triangle[:, [2, 0]]]), axis=1)
    return np.unique(edge, axis=0, return_counts=True)


def liner(rows=4, radius=2.0):
    return Liner(bent_shell(embossed_strip(BASE, rows, 2, COARSE), radius, radians(30.0), 20e-3), STEEL)


@pytest.mark.parametrize("pattern", [BASE, Pattern(BASE.convex, 40e-3, 30e-3, staggered=False)])
def test_tiles_meet_without_gaps(pattern):
    strip = embossed_strip(pattern, 4, 2)
    length, width = 4 * pattern.tile[0], 2 * pattern.tile[1]
    edge, count = edges(strip.triangle)
    border = strip.node[edge[count == 1]]
    assert count.max() == 2
    around = np.abs(border[:, 1] - border[:, 0]).sum()
    assert around == pytest.approx(2.0 * (length + width), rel=ROUNDING)
    corner = strip.node[strip.triangle]
    area = 0.5 * np.linalg.det(corner[:, 1:] - corner[:, :1])
    assert (area > 0.0).all()
    assert area.sum() == pytest.approx(length * width, rel=ROUNDING)


def test_a_strip_fits_to_itself_across():
    strip = embossed_strip(BASE, 4, 2)
    left = np.sort(strip.node[strip.node[:, 1] < 1e-9, 0])
    right = np.sort(strip.node[strip.node[:, 1] > 30e-3 - 1e-9, 0])
    np.testing.assert_allclose(left, right, atol=1e-15)  # rounding of metres


def test_convexes_stand_at_the_corners_of_rhombi():
    strip = embossed_strip(BASE, 4, 2)
    top = strip.node[np.isclose(strip.height, 2e-3)]
    expected = {
        (10.0, 7.5),
        (30.0, 22.5),
        (50.0, 7.5),
        (70.0, 22.5),
    }  # [mm] c0 / 2 and d0 / 2 from row to row
    assert {tuple(np.round(1e3 * place, 6)) for place in top} == expected
    assert strip.convex_volume == pytest.approx(
        4.0 * 0.937 * BASE.convex.volume, rel=1e-3
    )  # of the mesh, see convergence
    # The rim is a polygon in the ellipse; convexes rise inside it and nowhere else.
    corner = strip.node[strip.triangle]
    raised = strip.height[strip.triangle].max(axis=1) > 0.0
    np.testing.assert_array_equal(strip.on_convex, raised)
    plan = 0.5 * np.linalg.det(corner[:, 1:] - corner[:, :1])[strip.on_convex].sum()
    assert plan == pytest.approx(4.0 * 8.0 * np.sin(np.pi / 8.0) * 3e-3 * 2e-3, rel=ROUNDING)


def test_alike_are_the_same_triangles_of_other_tiles_and_their_mirror_images():
    strip = embossed_strip(BASE, 4, 2)
    corner = np.column_stack([strip.node, strip.height])[strip.triangle]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    count = np.bincount(strip.alike)
    mean = np.bincount(strip.alike, area) / count
    np.testing.assert_allclose(area, mean[strip.alike], rtol=1e-9)
    assert set(count) == {8}  # four tiles of its kind, left and right
    rows = np.bincount(strip.row)
    assert set(rows) == {len(strip.row) // 4}


def test_bent_into_an_arc():
    new = liner(rows=6)
    surface = wear_surface(new)
    distance = np.hypot(surface.point[:, 0], surface.point[:, 2])
    flat = embossed_strip(BASE, 6, 2, COARSE).height == 0.0
    np.testing.assert_allclose(distance[flat], 2.0, rtol=ROUNDING)
    # Tops rise along the normals of a faceted cylinder, off the true ones by half the angle between facets, 5 mm / 2 m at most.
    np.testing.assert_allclose(np.sort(distance)[:6], 2.0 - 2e-3, atol=2e-3 * (5e-3 / 2.0) ** 2)
    centre = surface.corner.mean(axis=1) * (1.0, 0.0, 1.0)
    assert (np.einsum("fi,fi->f", surface.normal, -centre) > 0.0).all()
    assert len(new.mesh.group[WEAR]) == len(embossed_strip(BASE, 6, 2, COARSE).triangle)


@pytest.mark.parametrize(
    ("radius", "tolerance"),
    # The walls between the normals of a shell's rim twist, so 25 steps sweep a little more or less than one: by 1/radius.
    [(2.0, 1e-7), (1000.0, 1e-9)],
)
def test_convexes_wear_away_and_the_mesh_does_not_mind(radius, tolerance):
    worn, strip = liner(radius=radius), embossed_strip(BASE, 4, 2, COARSE)
    surface = wear_surface(worn)
    before, asked = volume(worn.mesh), 0.0
    for _ in range(25):  # 2.5 mm off the convexes, which are 2 mm high, and 0.25 mm off the rest
        depth = np.where(strip.on_convex, 0.1e-3, 0.01e-3)
        asked += float(depth @ wear_surface(worn).facet_area)
        worn = recede(worn, depth)
    assert before - volume(worn.mesh) == pytest.approx(asked, rel=tolerance, abs=0.0)
    top = np.isclose(strip.height, 2e-3)
    face = np.hypot(*wear_surface(worn).point[:, [0, 2]].T)
    flat = strip.height == 0.0
    assert face[top].min() > radius  # below where the rest was: gone
    assert face[flat].max() - radius < 2.5e-3
    assert worn.mesh.thickness.min() > 15e-3
    assert (wear_surface(worn).area < 3.0 * surface.area.max()).all()  # no facet stands upright


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Convex(3e-3, 2e-3, 0.0), "must be above 0 mm"),
        (lambda: Pattern(Convex(12e-3, 2e-3, 2e-3), 40e-3, 30e-3), "make the spacing along the flow larger"),
        (lambda: Pattern(Convex(3e-3, 9e-3, 2e-3), 40e-3, 30e-3), "make the spacing across the flow larger"),
        (lambda: Fineness(sectors=12), "a multiple of 8"),
        (lambda: embossed_strip(BASE, 4, 3), "an even number of columns"),
        (lambda: embossed_strip(BASE, 0, 2), "at least one row"),
    ],
)
def test_mistakes_end_in_a_sentence(make, sentence):
    with pytest.raises(UserError, match=sentence):
        make()
