"""Meshes, supports and fields that are none, through the functions that a user calls: each is told in one sentence, nothing is lost."""

import sys
from dataclasses import replace

import meshio
import numpy as np
import pytest

from wearfem import cli
from wearfem.errors import UserError
from wearfem.liner.block import Hexahedra, Tetrahedra, block, sheet
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.mesh import SolidMesh
from wearfem.liner.mesh_check import check_mesh
from wearfem.liner.mesh_file import read_mesh, write_mesh
from wearfem.liner.recede import StepTooLong, advance, recede
from wearfem.liner.solve import Structure, solve_elastic
from wearfem.liner.support import ElasticBolt, Fixed, X, Z
from wearfem.liner.traction import nodal_traction
from wearfem.proofs.recession import STEEL
from wearfem.units import mm

PLATE = block((0.0, 0.0, 0.0), (0.3, 0.2, 0.04), (3, 2, 1), Hexahedra, name="plate")
SHEET = sheet((0.0, 0.0), (0.3, 0.2), (3, 2), 0.04)
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)


def written(folder, cells, *, point=CORNERS, ending="vtu"):
    path = folder / f"mesh.{ending}"
    meshio.write(path, meshio.Mesh(point, cells))
    return path


def hanging():
    """One hexahedron on a side of which two lie, so that no whole facet meets another."""
    one = block((0, 0, 0), (1, 1, 1), (1, 1, 1), Hexahedra)
    two = block((1, 0, 0), (2, 1, 1), (1, 2, 1), Hexahedra)
    node = np.concatenate([one.node, two.node])
    node, place = np.unique(node, axis=0, return_inverse=True)
    element = place.ravel()[np.concatenate([one.element, two.element + len(one.node)])]
    return SolidMesh(node, element, {"wear": place.ravel()[one.wear]})


SHELLS = {
    "three triangles at an edge": ([[0, 1, 2], [1, 0, 3], [0, 1, 4]], "1 edges belong to more than two triangles"),
    "one triangle turned": ([[0, 1, 2], [0, 1, 3]], "run through twice in the same direction.*flip the turned ones"),
    "a triangle twice": ([[0, 1, 2], [1, 0, 3], [2, 0, 1]], None),  # copies are formats' way to tag; they become one
    "a triangle without area": ([[0, 1, 2], [0, 4, 5]], "1 of 2 elements have no area"),
}  # fmt: skip


@pytest.mark.parametrize(("triangle", "words"), SHELLS.values(), ids=SHELLS)
@pytest.mark.parametrize("ending", ["vtu", "stl"])
def test_surfaces_that_are_none(triangle, words, ending, tmp_path):
    path = written(tmp_path, [("triangle", np.array(triangle))], ending=ending)
    if words is None:
        assert len(read_mesh(path, thickness=0.1).element) == 2
        return
    with pytest.raises(UserError, match=words):
        read_mesh(path, thickness=0.1)


def test_an_open_surface_is_a_shell_and_an_open_solid_is_refused(tmp_path):
    path = written(tmp_path, [("triangle", np.array([[0, 1, 2], [1, 0, 3]]))], ending="stl")
    assert len(read_mesh(path, thickness=0.1).wear) == 2  # an open surface: nothing is wrong
    with pytest.raises(UserError, match="holds surfaces only, so it is a shell; give its thickness"):
        read_mesh(path)
    with pytest.raises(
        UserError, match="2 edges belong to more than two facets of the boundary, the first at .1, 0, 0.5. m"
    ):
        check_mesh(hanging())


def test_solids_that_share_an_edge_or_overlap(tmp_path):
    edge = np.array([[0, 1, 2, 4], [0, 1, 3, 5]])
    with pytest.raises(UserError, match="edges belong to more than two facets of the boundary.*no inside"):
        read_mesh(written(tmp_path, [("tetra", edge)]))
    over = np.array([[0, 1, 2, 4], [0, 1, 2, 5], [0, 1, 2, 3]])
    node = CORNERS.copy()
    node[3] = [0.3, 0.3, 2.0]
    with pytest.raises(UserError, match="3 elements share one facet; elements overlap"):
        read_mesh(written(tmp_path, [("tetra", over)], point=node))


def test_reversed_orientation(tmp_path):
    turned = replace(PLATE, group={"wear": PLATE.wear[:, ::-1]})
    with pytest.raises(
        UserError, match="6 of 6 facets of the group 'wear' are turned against the boundary.*out of it"
    ):
        check_mesh(turned)
    write_mesh(tmp_path / "a.vtu", turned)
    assert wear_surface(Liner(read_mesh(tmp_path / "a.vtu"), STEEL)).normal[:, 2] == pytest.approx(
        1.0
    )  # a file's are turned
    inside_out = replace(PLATE, element=PLATE.element[:, [4, 5, 6, 7, 0, 1, 2, 3]])
    with pytest.raises(UserError, match="6 of 6 elements are inverted"):
        check_mesh(inside_out)


@pytest.mark.parametrize(
    ("supports", "free"),
    [
        ([], "translation along x, translation along y, translation along z, rotation about x.* and rotation about z"),
        ([Fixed("bottom", (Z,))], "translation along x, translation along y and rotation about z"),
        ([Fixed("bottom", (Z,)), Fixed("x_low", (X,))], "the translation along y"),
        ([ElasticBolt("x_low", 1e6, 0.0)], "translation along y, translation along z and rotation about x"),
        ([Fixed("bolt_1")], "no group 'bolt_1'; it has bottom, rim"),
    ],
    ids=["nothing", "table", "table and wall", "bolt without shear", "wrong name"],
)  # fmt: skip
def test_missing_supports_name_the_free_motion(supports, free):
    with pytest.raises(UserError, match=free):
        solve_elastic(Liner(PLATE, STEEL), Structure(supports))


@pytest.mark.parametrize("thickness", [0.0, -0.01, np.nan])
def test_zero_thickness(thickness, tmp_path):
    path = written(tmp_path, [("triangle", np.array([[0, 1, 2], [1, 0, 3]]))], ending="stl")
    words = "one finite number in m" if np.isnan(thickness) else "the thickness is .* and not above 0.*in m"
    with pytest.raises(UserError, match=words):
        read_mesh(path, thickness=thickness)
    flat = np.where([False, False, True], 0.5 * PLATE.node, PLATE.node) * [1.0, 1.0, 0.0]
    with pytest.raises(UserError, match="elements have no volume"):
        check_mesh(replace(PLATE, node=flat))
    with pytest.raises(UserError, match="the thickness is 0 m at node 0"):
        solve_elastic(
            Liner(replace(SHEET, thickness=0.0 * SHEET.thickness), STEEL), Structure([Fixed("rim")])
        )


@pytest.mark.parametrize("mesh", [PLATE, SHEET], ids=["solid", "shell"])
def test_fields_that_are_none(mesh):
    liner, count = Liner(mesh, STEEL), len(mesh.wear)
    holed = np.zeros(count)
    holed[2] = np.nan
    cases = [
        (lambda: recede(liner, holed), "the depth of facet 2 is nan"),
        (lambda: advance(liner, holed), "the depth of facet 2 is nan"),
        (lambda: recede(liner, np.zeros(count + 1)), f"'wear' has {count} facets"),
        (lambda: recede(liner, np.zeros((count, 1))), f"'wear' has {count} facets"),
        (lambda: recede(liner, np.full(count, 5.0)), "5000 mm in one step wears through facet"),  # 5 mm given as metres
        (lambda: replace(liner, depth=holed), f"{count - 1} values of it finite"),
        (lambda: Liner(mesh, STEEL, np.zeros(count + 1)), f"'wear' has {count} facets"),
        (lambda: wear_surface(liner, np.zeros(3)), r"displacement of shape \(3,\)"),
        (lambda: wear_surface(liner, np.full(mesh.node.shape, np.nan)), "finite numbers in m"),
        (lambda: nodal_traction(liner, np.zeros((count + 1, 3))), rf"finite forces in N of shape \({count}, 3\)"),
        (lambda: nodal_traction(liner, np.full((count, 3), np.nan)), "finite forces in N"),
    ]  # fmt: skip
    for make, words in cases:
        with pytest.raises(UserError, match=words):
            make()
    assert (liner.mesh.node == mesh.node).all() and not liner.depth.any()  # nothing is lost
    with pytest.raises(StepTooLong) as told:
        recede(liner, np.full(count, 5.0))
    assert 0.0 < told.value.share < 0.04 / 5.0  # what may be taken instead


@pytest.mark.parametrize(
    "mesh",
    [PLATE, block((0, 0, 0), (0.3, 0.2, 0.04), (3, 2, 1), Tetrahedra)],
    ids=["hexahedra", "tetrahedra"],
)
def test_a_mesh_in_millimetres_is_noticed(mesh, tmp_path):
    write_mesh(tmp_path / "a.vtu", replace(mesh, node=1e3 * mesh.node))
    with pytest.raises(UserError, match="is 300 m wide, so it is probably drawn in mm; give scale=mm"):
        read_mesh(tmp_path / "a.vtu")
    assert read_mesh(tmp_path / "a.vtu", scale=mm).node == pytest.approx(mesh.node, rel=1e-15)  # rounding
    for scale in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(UserError, match="give the metres in one unit of the file"):
            read_mesh(tmp_path / "a.vtu", scale=scale)


def test_a_thickness_in_millimetres_is_noticed(tmp_path):
    path = written(tmp_path, [("triangle", np.array([[0, 1, 2], [1, 0, 3]]))], ending="stl")
    with pytest.raises(
        UserError, match=r"the thickness is 20 m, but the whole shell is 2.236 m wide.*as 20 \* mm"
    ):
        read_mesh(path, thickness=20.0)


def test_a_case_with_a_bad_mesh_ends_with_code_2_and_leaves_nothing(tmp_path, monkeypatch, capsys):
    write_mesh(tmp_path / "plate.vtu", replace(PLATE, node=1e3 * PLATE.node))
    (tmp_path / "case.py").write_text(
        "from pathlib import Path\n"
        "from wearfem.liner.mesh_file import read_mesh\n"
        "def case():\n"
        "    return read_mesh(Path(__file__).with_name('plate.vtu'))\n"
    )
    out = tmp_path / "run"
    monkeypatch.setattr(sys, "argv", ["wearfem", "run", str(tmp_path), "--out", str(out)])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    said = capsys.readouterr().err
    assert ended.value.code == 2 and not out.exists()
    assert said.startswith("wearfem: ") and "probably drawn in mm" in said and said.count("\n") == 1
