"""The liner as files for ParaView and pyvista: its body with what is known inside, its worn face with what is known of wear."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from wearfem.errors import UserError, in_words
from wearfem.liner.breakthrough import thickness
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.mesh import LinerMesh, ShellMesh
from wearfem.liner.quality import quality
from wearfem.liner.strength import Strength
from wearfem.record import hdf5_file, whole_file, write_surface

_VTK_TYPE = {"triangle": 5, "tetra": 10, "hexahedron": 12}
_ENDINGS = (".vtkhdf", ".vtu")


def write_liner(
    folder: Path,
    liner: Liner,
    *,
    rate: np.ndarray | None = None,
    strength: Strength | None = None,
    displacement: np.ndarray | None = None,
    ending: str = ".vtkhdf",
) -> tuple[Path, Path]:
    """Write the liner as two files that ParaView (5.12 or newer) and pyvista open as they are.

    Parameters
    ----------
    folder
        Made if it is not there; files of the same names are replaced.
    liner
        `liner`: its elements; `quality [-]` of each, of a shell `thickness [m]` and `offset [m]` by node.
        `worn_face`: its triangles, with `depth [m]`, `thickness [m]` and the number `facet` of the facet that each belongs to.
    rate
        (f,) [m/s] of wear: `rate [m/s]` on the worn face.
    strength
        Of one load case: `von Mises stress [Pa]`, `stress [Pa]` (xx, yy, zz, xy, yz, xz) and `displacement [m]` by node.
    displacement
        (n, 3) [m] by node, by default that of `strength`.
    ending
        `.vtkhdf`, or `.vtu` for older programs (by meshio).

    Returns
    -------
    tuple of Path
        of the body and of the worn face.

    Raises
    ------
    UserError
        for fields of the wrong length and for another ending.
    """
    mesh = liner.mesh
    by_node: dict[str, np.ndarray] = {}
    if isinstance(mesh, ShellMesh):
        by_node |= {"thickness [m]": mesh.thickness, "offset [m]": mesh.offset}
    if strength is not None:
        displacement = strength.displacement if displacement is None else displacement
        row, column = np.array([[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]])
        by_node |= {
            "von Mises stress [Pa]": strength.von_mises,
            "stress [Pa]": strength.stress[:, row, column],
        }
    if displacement is not None:
        by_node["displacement [m]"] = displacement
    by_facet = {
        "depth [m]": liner.depth,
        "thickness [m]": thickness(mesh),
        "facet": np.arange(len(mesh.wear)),
    }
    if rate is not None:
        by_facet["rate [m/s]"] = rate
    for name, value in by_facet.items():
        _require_length(mesh, name, value, len(mesh.wear), "facets that wear")
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    body, worn = (folder / f"{name}{ending}" for name in ("liner", "worn_face"))
    write_body(body, mesh, point_data=by_node, cell_data={"quality [-]": quality(mesh)})
    surface = wear_surface(liner)
    on_triangle = {name: np.asarray(value)[surface.facet] for name, value in by_facet.items()}
    if ending == ".vtkhdf":
        write_surface(worn, surface.point, surface.triangle, on_triangle)
    else:
        _write_vtu(worn, surface.point, "triangle", surface.triangle, {}, on_triangle)
    return body, worn


def write_body(
    path: Path,
    mesh: LinerMesh,
    *,
    point_data: Mapping[str, np.ndarray] | None = None,
    cell_data: Mapping[str, np.ndarray] | None = None,
) -> None:
    """Write the elements of a mesh as a VTKHDF UnstructuredGrid (version 2.0), or as a VTU.

    Parameters
    ----------
    path
        The file; its ending says the format, `.vtkhdf` or `.vtu`. `read_mesh` wants its groups too: for it use `write_mesh`.
    mesh
        Of a shell the triangles through its nodes are written.
    point_data, cell_data
        (n,) or (n, k) by node and (e,) or (e, k) by element, by name with unit; HDF5 keeps `/` for itself, so `m/s` is
        written as `m per s`.

    Raises
    ------
    UserError
        for data of the wrong length and for another ending.
    """
    path = Path(path)
    if path.suffix not in _ENDINGS:
        raise UserError(
            f"{path} ends with '{path.suffix}'; bodies are written to {in_words(_ENDINGS, 'or')}."
        )
    kind = {3: "triangle", 4: "tetra", 8: "hexahedron"}[mesh.element.shape[1]]
    for data, count, what in (
        (point_data, len(mesh.node), "nodes"),
        (cell_data, len(mesh.element), "elements"),
    ):
        for name, value in (data or {}).items():
            _require_length(mesh, name, value, count, what)
    if path.suffix == ".vtu":
        _write_vtu(path, mesh.node, kind, mesh.element, point_data or {}, cell_data or {})
        return
    count, corners = mesh.element.shape
    with hdf5_file(path) as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
        root.attrs.create("Type", np.bytes_("UnstructuredGrid"))
        for name, number in (
            ("Points", len(mesh.node)),
            ("Cells", count),
            ("ConnectivityIds", mesh.element.size),
        ):
            root[f"NumberOf{name}"] = np.array([number], dtype=np.int64)
        root["Points"] = mesh.node
        root["Connectivity"] = mesh.element.ravel()
        root["Offsets"] = corners * np.arange(count + 1, dtype=np.int64)
        root["Types"] = np.full(count, _VTK_TYPE[kind], dtype=np.uint8)
        for place, data in (("PointData", point_data), ("CellData", cell_data)):
            group = root.create_group(place)
            for name, value in (data or {}).items():
                group[name.replace("/", " per ")] = np.ascontiguousarray(value)


def _write_vtu(
    path: Path,
    point: np.ndarray,
    kind: str,
    cell: np.ndarray,
    point_data: Mapping[str, np.ndarray],
    cell_data: Mapping[str, np.ndarray],
) -> None:
    import meshio  # slow to import

    by_cell = {name: [np.asarray(value)] for name, value in cell_data.items()}
    with whole_file(path) as temporary:
        meshio.write(
            temporary,
            meshio.Mesh(point, [(kind, cell)], point_data=dict(point_data), cell_data=by_cell),
            file_format="vtu",
        )


def _require_length(mesh: LinerMesh, name: str, value: np.ndarray, count: int, what: str) -> None:
    if len(value) != count:
        raise UserError(
            f"{mesh.name}: '{name}' has {len(value)} values, but the mesh has {count} {what}; give one for each, of this mesh as it is now."
        )
