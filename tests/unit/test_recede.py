"""What recession refuses, where a liner wears through, and what is left when it opens."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.liner.block import Hexahedra, Tetrahedra, block, mapped, sheet
from wearfem.liner.breakthrough import breakthrough, open_surface, thickness
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import SolidMesh
from wearfem.liner.mesh_check import check_mesh
from wearfem.liner.recede import StepTooLong, advance, recede, removed_volume, volume
from wearfem.proofs.recession import STEEL

PLATE = block((0.0, 0.0, 0.0), (0.3, 0.2, 0.04), (9, 6, 4), Tetrahedra, name="plate")
SHEET = sheet((0.0, 0.0), (0.3, 0.2), (9, 6), 0.04)
BOTH = pytest.mark.parametrize("mesh", [PLATE, SHEET], ids=["solid", "shell"])


def even(mesh, depth):
    return np.full(len(mesh.wear), depth)


@BOTH
@pytest.mark.parametrize(
    ("depth", "words"),
    [
        (lambda n: np.zeros(n - 1), "has 108 facets"),
        (lambda n: np.where(np.arange(n) == 7, np.nan, 0.0), "facet 7 is nan"),
        (lambda n: np.where(np.arange(n) == 3, -1e-3, 0.0), "facet 3 is -0.001 m"),
        (lambda n: np.where(np.arange(n) == 2, np.inf, 0.0), "facet 2 is inf"),
    ],
    ids=["length", "nan", "negative", "infinite"],
)
def test_a_depth_that_is_none_is_refused(mesh, depth, words):
    with pytest.raises(UserError, match=words):
        recede(Liner(mesh, STEEL), depth(len(mesh.wear)))


@BOTH
def test_no_depth_changes_nothing(mesh):
    new = recede(Liner(mesh, STEEL), even(mesh, 0.0), service_time=3.0, throughput=5.0)
    assert (new.mesh.node == mesh.node).all()
    assert (new.service_time, new.throughput) == (3.0, 5.0)


@BOTH
def test_depth_time_and_throughput_add_up_and_the_old_liner_stays(mesh):
    old = Liner(mesh, STEEL)
    before = mesh.node.copy()
    new = recede(recede(old, even(mesh, 1e-3), service_time=1.0), even(mesh, 2e-3), throughput=4.0)
    assert new.depth == pytest.approx(3e-3, rel=1e-15)  # a sum of two
    assert (new.service_time, new.throughput) == (1.0, 4.0)
    assert (mesh.node == before).all()
    assert not old.depth.any()


@BOTH
def test_thickness_falls_by_the_depth(mesh):
    assert thickness(mesh) == pytest.approx(0.04, rel=1e-12)  # rounding
    new = recede(Liner(mesh, STEEL), even(mesh, 5e-3)).mesh
    assert thickness(new) == pytest.approx(0.035, rel=1e-12)  # rounding


def test_the_back_of_a_shell_stays():
    new = recede(Liner(SHEET, STEEL), np.linspace(0.0, 4e-3, len(SHEET.wear))).mesh
    back = new.offset - 0.5 * new.thickness
    assert back == pytest.approx(-0.02, rel=1e-15)  # rounding
    assert (new.node == SHEET.node).all()


@BOTH
def test_wearing_through_is_an_event_with_a_place(mesh):
    depth = even(mesh, 0.03)
    depth[17] = 0.05
    event = breakthrough(mesh, depth, least=0.0)
    assert event.facet == 17
    assert event.share == pytest.approx(0.8, rel=1e-12)  # 40 of 50 mm
    assert event.place == pytest.approx(mesh.node[mesh.wear[17]].mean(axis=0))
    assert breakthrough(mesh, even(mesh, 0.03)) is None


@BOTH
def test_a_step_is_cut_where_the_liner_wears_through(mesh):
    liner, depth = Liner(mesh, STEEL), even(mesh, 0.05)
    result = advance(liner, depth, service_time=10.0)
    assert result.breakthrough is not None
    assert 0.7 < result.share < 0.8  # a little is left: 5 % of a facet's length, 1e-3 of a shell
    assert result.liner.service_time == pytest.approx(10.0 * result.share)
    lost = volume(mesh) - volume(result.liner.mesh)
    assert lost == pytest.approx(
        result.share * removed_volume(mesh, depth), rel=1e-10
    )  # as asked of every step
    with pytest.raises(StepTooLong, match="wears through facet") as refused:
        recede(liner, depth)
    assert refused.value.share == result.share
    recede(liner, 0.999 * refused.value.share * depth)


def test_a_step_that_turns_elements_over_is_refused_and_a_share_offered():
    depth = 0.036 * np.random.default_rng(1).integers(
        0, 2, len(PLATE.wear)
    )  # spikes of 36 mm beside facets that stay
    with pytest.raises(StepTooLong, match="turn elements over") as refused:
        recede(Liner(PLATE, STEEL), depth)
    assert 0.0 < refused.value.share < 1.0
    recede(Liner(PLATE, STEEL), refused.value.share * depth)
    result = advance(Liner(PLATE, STEEL), depth)
    assert result.share == refused.value.share
    assert result.remesh_needed


@pytest.mark.parametrize("kind", [Tetrahedra, Hexahedra], ids=["tetrahedra", "hexahedra"])
def test_a_solid_opens_where_it_is_worn_through(kind):
    mesh = block((0.0, 0.0, 0.0), (0.3, 0.2, 0.04), (9, 6, 2), kind, name="plate")
    centre = mesh.node[mesh.wear].mean(axis=1)
    away = ((centre[:, :2] - [0.15, 0.1]) ** 2).sum(axis=1)
    depth = 4e-3 * np.exp(-away / (2.0 * 0.06**2))
    liner = Liner(mesh, STEEL)
    for _ in range(15):
        result = advance(liner, depth, service_time=1.0)
        liner = result.liner
        if result.breakthrough:
            break
    assert result.breakthrough is not None
    assert away[result.breakthrough.facet] < 0.03**2
    opening = open_surface(liner)
    assert 0 < len(opening.facet) < len(mesh.wear)
    check_mesh(opening.liner.mesh)
    assert (opening.liner.depth == liner.depth[opening.facet]).all()
    assert opening.liner.service_time == liner.service_time
    left, before = opening.liner.mesh, liner.mesh
    assert volume(left) + opening.lost == pytest.approx(
        volume(before), rel=1e-9
    )  # warped facets cut two ways
    assert (left.node == before.node[opening.node]).all()
    recede(opening.liner, even(left, 1e-5))


def test_a_shell_opens_where_it_is_worn_through():
    worn = recede(Liner(SHEET, STEEL), even(SHEET, 1e-3))
    thin = worn.mesh.thickness.copy()
    thin[SHEET.wear[30]] = 1e-6
    worn = replace(worn, mesh=replace(worn.mesh, thickness=thin))
    opening = open_surface(worn)
    assert 30 not in opening.facet
    check_mesh(opening.liner.mesh)
    assert len(opening.liner.mesh.element) == len(opening.facet) == len(opening.liner.depth)


def test_a_warped_hexahedron_has_the_volume_of_its_trilinear_map():
    cube = block((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (1, 1, 1), Hexahedra)
    node = cube.node.copy()
    node[-1] += (0.3, 0.2, 0.4)
    one, two = 0.5 - np.sqrt(1.0 / 12.0), 0.5 + np.sqrt(1.0 / 12.0)
    total = 0.0
    for r in (one, two):  # Gauss: exact for the determinant, of degree 2 in each coordinate
        for s in (one, two):
            for t in (one, two):
                shape = np.array([(r, 1 - r), (s, 1 - s), (t, 1 - t)])
                jacobian = np.zeros((3, 3))
                for x, at in zip(node, cube.node.astype(int), strict=True):
                    value = [shape[k, 0] if at[k] else shape[k, 1] for k in range(3)]
                    slope = [1.0 if at[k] else -1.0 for k in range(3)]
                    jacobian += np.outer(
                        x,
                        [
                            slope[0] * value[1] * value[2],
                            value[0] * slope[1] * value[2],
                            value[0] * value[1] * slope[2],
                        ],
                    )
                total += np.linalg.det(jacobian) / 8.0
    assert volume(SolidMesh(node, cube.element)) == pytest.approx(total, rel=1e-14)  # rounding


def test_a_facet_that_tilts_at_the_rim_is_as_thick_as_the_plate():
    """Its inward line leaves by the side of the plate, far below the facet."""
    flat = block((0.0, 0.0, 0.0), (0.2, 0.2, 0.04), (8, 8, 4))
    tilted = mapped(
        flat, lambda x: x - np.outer(0.06 * x[:, 0] * x[:, 2] / 0.04, [0, 0, 1])
    )  # by 3.4 degrees
    left = tilted.node[tilted.wear].mean(axis=1)[:, 2]
    # along the tilted normal the way to the back is longer by 1 / cos; corners lie up to half an edge lower
    assert (thickness(tilted) > left * 0.95 - 0.06 * 0.025).all()
    assert (thickness(tilted) < left * 1.05).all()
