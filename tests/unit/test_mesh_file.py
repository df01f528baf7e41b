"""Mesh files: what is written reads back the same, whatever the format calls a group; and what is no liner is told why."""

from dataclasses import replace

import meshio
import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.liner.block import Hexahedra, Tetrahedra, block, mapped, sheet
from wearfem.liner.mesh_check import check_mesh
from wearfem.liner.mesh_file import read_mesh, write_mesh
from wearfem.units import mm

SHELL = mapped(
    sheet((0, 0), (2, 1), (4, 3), 0.01, offset=0.002),
    lambda x: np.column_stack([x[:, 0], x[:, 1], 0.1 * np.sin(x[:, 0])]),
)
SHELL = replace(SHELL, thickness=0.01 + 0.001 * np.arange(len(SHELL.node)))
MESHES = {
    "tetrahedra": block((0, 0, 0), (1, 2, 0.5), (2, 3, 2), Tetrahedra),
    "hexahedra": block((0, 0, 0), (1, 2, 0.5), (2, 3, 2), Hexahedra),
    "shell": SHELL,
}
MESHIO = {4: "tetra", 8: "hexahedron", 3: "triangle"}


def same(facet, other):
    return {tuple(sorted(row)) for row in facet} == {tuple(sorted(row)) for row in other}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("ending", ["vtu", "msh"])
def test_what_is_written_reads_back_the_same(mesh, ending, tmp_path):
    path = tmp_path / f"a.{ending}"
    write_mesh(path, mesh)
    back = read_mesh(path)
    assert type(back) is type(mesh) and set(back.group) == set(mesh.group)
    for what in ("node", "element") + (("thickness", "offset") if hasattr(mesh, "offset") else ()):
        assert (getattr(back, what) == getattr(mesh, what)).all()
    for name, facet in mesh.group.items():
        assert same(back.group[name], facet) and len(back.group[name]) == len(facet)
        assert (np.sort(back.group[name], axis=1) == np.sort(facet, axis=1)).all(), (
            "the order of fields by facet"
        )


@pytest.mark.parametrize("ending", ["vtk", "inp", "e"])
@pytest.mark.parametrize("kind", ["tetrahedra", "hexahedra"])
def test_node_sets_and_tags_of_other_formats(kind, ending, tmp_path):
    if ending == "e":
        pytest.importorskip("netCDF4")
    mesh, path = MESHES[kind], tmp_path / f"a.{ending}"
    top = np.unique(mesh.wear)
    cells = [(MESHIO[mesh.element.shape[1]], mesh.element)]
    if ending == "vtk":
        facet = "triangle" if kind == "tetrahedra" else "quad"
        cells += [(facet, mesh.wear), (facet, mesh.group["bottom"][:, ::-1])]
        tag = [np.full(len(c), k) for k, (_, c) in enumerate(cells, start=1)]
        meshio.write(path, meshio.Mesh(mesh.node, cells, cell_data={"tag": tag}))
        back = read_mesh(path, rename={"tag_2": "wear", "tag_3": "bottom"})
        assert same(back.group["bottom"], mesh.group["bottom"])
    else:
        meshio.write(path, meshio.Mesh(mesh.node, cells, point_sets={"wear": top}))
        back = read_mesh(path)
    assert same(back.wear, mesh.wear) and back.volume == pytest.approx(1.0, rel=1e-12)  # rounding of sums


def test_abaqus_element_sets_of_a_shell_of_quads(tmp_path):
    cells = [("quad", np.array([[0, 1, 2, 3]])), ("quad", np.array([[1, 4, 5, 2]]))]
    node = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], float)
    sets = {"wear": [np.array([0]), np.array([], int)]}
    meshio.write(tmp_path / "a.inp", meshio.Mesh(node, cells, cell_sets=sets, point_sets={"support": [0, 3]}))
    back = read_mesh(tmp_path / "a.inp", thickness=0.01)
    assert len(back.element) == 4 and same(back.wear, [[0, 1, 2], [0, 2, 3]])
    assert same(back.group["support"], [[0, 3]])


def test_an_stl_is_a_shell_that_wears_everywhere(tmp_path):
    meshio.write(tmp_path / "a.stl", meshio.Mesh(1e3 * SHELL.node, [("triangle", SHELL.element)]))
    with pytest.raises(UserError, match=r"2000 m wide, so it is probably drawn in mm; give scale=mm"):
        read_mesh(tmp_path / "a.stl", thickness=0.01)
    back = read_mesh(tmp_path / "a.stl", scale=mm, thickness=0.01)
    assert len(back.node) == len(SHELL.node) and len(back.wear) == len(SHELL.element)
    with pytest.raises(UserError, match="shell; give its thickness in m"):
        read_mesh(tmp_path / "a.stl", scale=mm)


def test_second_order_drops_to_corners_and_inverted_elements_are_turned(tmp_path):
    node = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    middle = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    node = np.concatenate([node, [(node[a] + node[b]) / 2 for a, b in middle]])
    cell = np.arange(10)[[1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]  # inverted
    mesh = meshio.Mesh(node, [("tetra10", [cell]), ("triangle6", [[0, 1, 2, 4, 5, 6]])],
                       cell_data={"gmsh:physical": [[7], [3]], "gmsh:geometrical": [[1], [1]]},
                       field_data={"wear": np.array([3, 2])})  # fmt: skip
    meshio.write(tmp_path / "a.msh", mesh, file_format="gmsh22")
    back = read_mesh(tmp_path / "a.msh")
    assert back.element.shape == (1, 4) and len(back.node) == 4 and back.volume == pytest.approx(1 / 6)
    a, b, c = back.node[back.wear[0]]
    assert np.cross(b - a, c - a)[2] == -1.0  # out of the solid


def cut(mesh, **change):
    return replace(mesh, **change)


def test_what_is_no_liner_is_told_in_a_sentence():
    solid, shell = MESHES["tetrahedra"], MESHES["shell"]
    nan, flat = solid.node.copy(), solid.node.copy()
    nan[5] = np.nan
    first = solid.element[0]
    flat[first[0]] = flat[first[1:]].mean(axis=0)
    turned = shell.element.copy()
    turned[3] = turned[3, ::-1]
    inverted = solid.element.copy()
    inverted[2] = inverted[2, [1, 0, 2, 3]]
    fin = np.concatenate([shell.element, [[0, 5, 19]]])  # a third triangle at an edge of the sheet
    inner = np.array([[*first[:2], first[3]]])
    hinge = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0], [0, 0, -1]], float)
    cases = {
        "node 5 is .*nan": lambda: cut(solid, node=nan),
        "nodes are numbered 0 to 35": lambda: cut(solid, element=solid.element + 30),
        r"a mesh needs \(n, 3\) nodes": lambda: cut(solid, element=solid.element[:, :3]),
        "elements have no volume": lambda: cut(solid, node=flat),
        "1 of 72 elements are inverted, the first is number 2": lambda: cut(solid, element=inverted),
        "elements are there twice": lambda: cut(solid, element=np.concatenate([solid.element, solid.element[:1]])),
        "1 of 37 nodes belong to no element": lambda: cut(solid, node=np.concatenate([solid.node, [[9, 9, 9]]])),
        "1 of 1 facets of the group 'wear' are no facets of the boundary": lambda: cut(solid, group={"wear": inner}),
        "1 facets of the group 'wear' are there twice": lambda: cut(
            solid, group={"wear": np.concatenate([solid.wear, solid.wear[:1]])}
        ),
        "12 of 12 facets of the group 'wear' are turned against": lambda: cut(
            solid, group={"wear": solid.wear[:, ::-1]}
        ),
        "no group 'wear'; it has bottom and rim": lambda: cut(
            solid, group={name: solid.group[name] for name in ("rim", "bottom")}
        ),
        "the group 'wear' is empty": lambda: cut(solid, group={"wear": solid.wear[:0]}),
        "1 edges belong to more than two facets of the boundary": lambda: cut(
            solid, node=hinge, element=[[0, 1, 2, 3], [0, 1, 4, 5]], group={}
        ),
        "edges are run through twice in the same direction": lambda: cut(shell, element=turned),
        "belong to more than two triangles": lambda: cut(shell, element=fin),
        "the thickness is 0 m at node 0": lambda: cut(shell, thickness=0.0 * shell.thickness),
        "the thickness is -0.01 m at node 0": lambda: cut(shell, thickness=0.0 * shell.thickness - 0.01),
        r"the thickness has shape \(1,\)": lambda: cut(shell, thickness=shell.thickness[:1]),
    }  # fmt: skip
    for sentence, make in cases.items():
        with pytest.raises(UserError, match=sentence):
            check_mesh(make())
            pytest.fail(sentence)
    for mesh in MESHES.values():
        check_mesh(mesh)
    check_mesh(shell.turned)


def test_files_that_are_no_liner(tmp_path):
    with pytest.raises(UserError, match="There is no mesh file"):
        read_mesh(tmp_path / "none.msh")
    (tmp_path / "a.msh").write_text("nonsense")
    with pytest.raises(UserError, match="cannot be read as a mesh"):
        read_mesh(tmp_path / "a.msh")
    node = np.random.default_rng(1).random((9, 3))
    mixed = [("tetra", [[0, 1, 2, 3]]), ("wedge", [[3, 4, 5, 6, 7, 8]])]
    meshio.write(tmp_path / "a.vtu", meshio.Mesh(node, mixed))
    with pytest.raises(UserError, match="holds tetra and wedge elements; a liner is of tetrahedra alone"):
        read_mesh(tmp_path / "a.vtu")
    meshio.write(tmp_path / "b.vtu", meshio.Mesh(node, [("line", [[0, 1]])]))
    with pytest.raises(UserError, match="has no triangles and no volumes"):
        read_mesh(tmp_path / "b.vtu")
    write_mesh(tmp_path / "c.vtu", MESHES["tetrahedra"])
    with pytest.raises(UserError, match="leave out thickness"):
        read_mesh(tmp_path / "c.vtu", thickness=0.1)
    with pytest.raises(UserError, match="meshes are written to .msh or .vtu"):
        write_mesh(tmp_path / "c.stl", MESHES["tetrahedra"])
