"""Liners from mesh files and back: gmsh, VTU, VTK, STL, Abaqus, Exodus and all else that meshio reads with its tags."""

from collections.abc import Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.errors import UserError, in_words
from wearfem.liner.mesh import WEAR, LinerMesh, ShellMesh, SolidMesh, find_facets, triangles
from wearfem.liner.mesh_check import check_mesh
from wearfem.liner.quality import determinant
from wearfem.surface_file import WIDEST

_CORNERS = {"triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8}  # and what they are in the file's names
_MOST_TAGS = 256  # an integer array with more different values numbers cells and does not tag them


def read_mesh(
    path: Path,
    *,
    scale: float | None = None,
    thickness: float | None = None,
    offset: float | None = None,
    rename: Mapping[str, str] | None = None,
    name: str = "",
) -> LinerMesh:
    """The liner of a mesh file: a `SolidMesh` if it holds volumes, a `ShellMesh` if it holds surfaces only.

    Parameters
    ----------
    path
        A file in any format of meshio.
    scale
        Metres in one unit of the file: `mm` for a drawing in millimetres. Without it the file is in metres, and refused if
        it is wider than 20 m.
    thickness, offset
        [m] of a shell, everywhere; by default the file's point data `thickness` and `offset` (in the file's unit), and without
        them offset 0.
    rename
        Names of groups in the file and what they are here: `{"tag_3": "wear"}`.
    name
        What messages call it; by default the file's name.

    Notes
    -----
    - Groups are what the file names: gmsh's physical groups, element sets, node sets (facets with all corners in the set), and cell data
      of whole numbers: an array of 0 and 1 is the group of its own name, any other is one group for each value `v` above 0, `NAME_v`
      (`gmsh:physical_3` without a physical name). Of a group of volumes nothing is kept. Side sets of Abaqus and Exodus are not read
      by meshio: name the elements or the nodes of the worn face instead. A shell without the group `wear` and without other groups
      of triangles wears everywhere.
    - Elements of second order lose their middle nodes: geometry is straight.
    - Volume elements are turned to a positive volume and facets outwards. Triangles keep their order, for nobody else knows where the flow
      is: see `ShellMesh.turned`. Quadrilaterals without volumes become two triangles each. Points of an STL at one place become one,
      and nodes without elements are left out.

    Raises
    ------
    UserError
        for a file that is missing or unreadable, with elements of several kinds, by its size in millimetres, for a shell without
        thickness, and for all that `check_mesh` refuses.
    """
    path = Path(path)
    if not path.is_file():
        raise UserError(f"There is no mesh file {path}; give the path of a file with elements.")
    file = _read(path)
    point = np.asarray(file.points, float)
    if point.ndim != 2 or point.shape[1] != 3:
        raise UserError(f"{path} has points of shape {point.shape}; a liner needs three coordinates.")
    if path.suffix.lower() == ".stl":  # repeats its points in every triangle
        point, place = np.unique(point, axis=0, return_inverse=True)
        for block in file.cells:
            block.data = place.ravel()[block.data]
    kind, element = _elements(path, file)
    solid = kind in ("tetra", "hexahedron")
    used, number = np.unique(element, return_inverse=True)
    new = np.full(len(point), -1)
    new[used] = np.arange(len(used))
    width = float(np.ptp(point[used], axis=0).max())
    if scale is None and width > WIDEST:
        raise UserError(
            f"{path} is {width:.4g} m wide, so it is probably drawn in mm; give scale=mm (or scale=1.0 if it is in m)."
        )
    metre = scale or 1.0
    node, element = point[used] * metre, number.reshape(element.shape)
    label = name or path.name
    if solid:
        if thickness is not None or offset is not None:
            raise UserError(
                f"{path} holds volumes, which have their own thickness; leave out thickness and offset."
            )
        mesh: LinerMesh = SolidMesh(node, _positive(node, element), name=label)
    else:
        given = {
            what: _by_node(value, file.point_data.get(what), used, metre)
            for what, value in (("thickness", thickness), ("offset", offset))
        }
        if given["thickness"] is None:
            raise UserError(
                f"{path} holds surfaces only, so it is a shell; give its thickness in m, such as thickness=20 * mm."
            )
        depth = np.zeros(len(used)) if given["offset"] is None else given["offset"]
        mesh = ShellMesh(node, element, given["thickness"], depth, name=label)
    group: dict[str, np.ndarray] = {}
    for tag, facet in _groups(file, new, mesh):
        tag = (rename or {}).get(tag, tag)
        group[tag] = _unique(np.concatenate([group[tag], facet])) if tag in group else _unique(facet)
    if not solid and WEAR not in group and not any(facet.shape[1] == 3 for facet in group.values()):
        group[WEAR] = mesh.element
    mesh = replace(mesh, group=group)
    check_mesh(mesh)
    return mesh


def write_mesh(path: Path, mesh: LinerMesh) -> None:
    """Write the mesh with its groups to `.vtu` or `.msh` (gmsh 2.2, binary), so that `read_mesh` returns it as it is.

    Every group is a block of cells of its own beside the elements; in a VTU its cell data of the group's name is 1 there and 0
    elsewhere. A shell keeps its `thickness` and `offset` [m] as point data.

    Raises
    ------
    UserError
        for another ending of the file's name.
    """
    import meshio  # slow to import

    path = Path(path)
    writers = {".vtu": "vtu", ".msh": "gmsh22"}
    if path.suffix not in writers:
        raise UserError(
            f"{path} ends with '{path.suffix}'; meshes are written to {in_words(sorted(writers), 'or')}."
        )
    names = {2: "line", 3: "triangle", 4: "quad"}
    whole = {3: "triangle", 4: "tetra", 8: "hexahedron"}[mesh.element.shape[1]]
    parts = [(whole, mesh.element), *((names[facet.shape[1]], facet) for facet in mesh.group.values())]
    data: dict[str, list[np.ndarray]] = {}
    if path.suffix == ".msh":
        data = {"gmsh:physical": [np.full(len(cell), k, np.int32) for k, (_, cell) in enumerate(parts)]}
        data["gmsh:geometrical"] = [np.full(len(cell), 1 + k, np.int32) for k, (_, cell) in enumerate(parts)]
    else:
        for own, name in enumerate(mesh.group, start=1):
            data[name] = [np.full(len(cell), int(k == own), np.int32) for k, (_, cell) in enumerate(parts)]
    shell = {"thickness": mesh.thickness, "offset": mesh.offset} if isinstance(mesh, ShellMesh) else {}
    meshio.write(
        path,
        meshio.Mesh(
            mesh.node,
            parts,
            point_data=shell,
            cell_data=data,
            field_data={
                name: np.array([k, 1 if facet.shape[1] == 2 else 2])
                for k, (name, facet) in enumerate(mesh.group.items(), start=1)
            },
        ),
        file_format=writers[path.suffix],
    )


def _read(path: Path) -> Any:
    import meshio  # slow to import

    try:
        with redirect_stdout(StringIO()):  # meshio prints what the formats that it tried in vain had to say
            return meshio.read(path)
    except ImportError as error:
        raise UserError(
            f"{path} cannot be read without the package {error.name}: pip install {error.name}."
        ) from error
    except (Exception, SystemExit) as error:  # what meshio raises depends on the format; for some it exits
        raise UserError(
            f"{path} cannot be read as a mesh ({error}); use gmsh's MSH, VTU, STL or INP."
        ) from error


def _shape(kind: str) -> str:
    """The shape of a meshio cell type: `tetra10` is a `tetra`."""
    return kind.rstrip("0123456789")


def _elements(path: Path, file: Any) -> tuple[str, np.ndarray]:
    """The kind and the corners (e, c) of the elements: volumes where there are any, or triangles."""
    found: dict[str, list[np.ndarray]] = {}
    for block in file.cells:
        shape = _shape(block.type)
        if shape not in ("vertex", "line") and len(block.data):
            found.setdefault(shape, []).append(block.data[:, : _CORNERS.get(shape, 0)])
    volume = sorted(found.keys() - {"triangle", "quad"})
    if len(volume) > 1 or volume and volume[0] not in _CORNERS:
        raise UserError(
            f"{path} holds {in_words(volume)} elements; a liner is of tetrahedra alone or of hexahedra alone, so mesh it with one kind."
        )
    if volume:
        return volume[0], _unique(np.concatenate(found[volume[0]]))
    if not found:
        raise UserError(f"{path} has no triangles and no volumes; export the liner as a mesh of elements.")
    cells = [triangles(cell)[0] for shape in ("triangle", "quad") for cell in found.get(shape, [])]
    return "triangle", _unique(np.concatenate(cells))


def _unique(cell: np.ndarray) -> np.ndarray:
    """Cells (k, c) without the copies that formats make of what belongs to several groups; order stays."""
    _, first = np.unique(np.sort(cell, axis=1), axis=0, return_index=True)
    return cell[np.sort(first)]


def _positive(node: np.ndarray, element: np.ndarray) -> np.ndarray:
    """The same elements with a positive volume"""
    order = [0, 2, 1, 3] if element.shape[1] == 4 else [4, 5, 6, 7, 0, 1, 2, 3]
    inverted = determinant(SolidMesh(node, element)).sum(axis=1) < 0.0
    return np.where(inverted[:, None], element[:, order], element)


def _by_node(
    value: float | None, stored: np.ndarray | None, used: np.ndarray, metre: float
) -> np.ndarray | None:
    if value is not None:
        return np.full(len(used), float(value))
    return None if stored is None else np.asarray(stored, float).ravel()[used] * metre


def _groups(file: Any, new: np.ndarray, mesh: LinerMesh) -> Iterator[tuple[str, np.ndarray]]:
    """Named facets of a solid, or triangles and edges of a shell, in the mesh's node numbers and orientation."""
    solid = isinstance(mesh, SolidMesh)
    for name, number, chosen in _tags(file):
        block = file.cells[number]
        shape = _shape(block.type)
        if shape in (("triangle", "quad") if solid else ("line", "triangle", "quad")):
            facet = new[block.data[chosen][:, : _CORNERS.get(shape, 2)]]
            if isinstance(mesh, SolidMesh):
                yield name, _outward(facet, mesh)
            else:
                yield name, triangles(facet)[0] if shape == "quad" else facet
    for name, points in file.point_sets.items():
        inside = np.zeros(len(mesh.node) + 1, bool)
        inside[new[np.asarray(points, int)]] = True
        inside[-1] = False  # where nodes without elements went
        facet = _spanned(mesh, inside)
        if len(facet):
            yield name, facet


def _outward(facet: np.ndarray, mesh: SolidMesh) -> np.ndarray:
    """The facets in the order of the boundary's; those that are not on it stay as they are, for the check to tell."""
    boundary = mesh.boundary
    if facet.shape[1] != boundary.shape[1]:
        return facet
    found = find_facets(facet, boundary)
    return np.where(found[:, None] < 0, facet, boundary[found])


def _spanned(mesh: LinerMesh, inside: np.ndarray) -> np.ndarray:
    """Facets whose corners are all inside; of a shell, triangles if they reach all of the nodes, or else edges."""
    if isinstance(mesh, SolidMesh):
        return mesh.boundary[inside[mesh.boundary].all(axis=1)]
    triangle = mesh.element[inside[mesh.element].all(axis=1)]
    if len(np.unique(triangle)) == inside.sum():
        return triangle
    edge = np.concatenate([mesh.element[:, [0, 1]], mesh.element[:, [1, 2]], mesh.element[:, [2, 0]]])
    pair, count = np.unique(np.sort(edge, axis=1), axis=0, return_counts=True)
    border = edge[find_facets(pair[count == 1], edge)]
    return border[inside[border].all(axis=1)]


def _tags(file: Any) -> Iterator[tuple[str, int, np.ndarray]]:
    """Every tag of cells: its name, the number of a block, and which cells of the block."""
    sets = {name: blocks for name, blocks in file.cell_sets.items() if not name.startswith("gmsh:")}
    for name, blocks in sets.items():
        for number, chosen in enumerate(blocks):
            if chosen is not None and len(chosen):
                yield name, number, np.asarray(chosen, int)
    names = {tuple(int(n) for n in value): name for name, value in file.field_data.items()}
    for key, blocks in file.cell_data.items():
        values = np.unique(np.concatenate([np.asarray(block).ravel() for block in blocks]))
        if key == "gmsh:geometrical" or (key == "gmsh:physical" and sets):
            continue
        if not np.issubdtype(values.dtype, np.integer) or len(values) > _MOST_TAGS:
            continue
        flag = key != "gmsh:physical" and set(values.tolist()) <= {0, 1}
        for number, block in enumerate(blocks):
            dimension = {"line": 1, "triangle": 2, "quad": 2}.get(_shape(file.cells[number].type), 3)
            for value in values[values > 0]:
                chosen = np.flatnonzero(np.asarray(block).ravel() == value)
                name = key if flag else names.get((int(value), dimension), f"{key}_{value}")
                if len(chosen):
                    yield name, number, chosen
