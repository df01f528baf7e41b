"""Surfaces from files: STL, VTU, gmsh and all else that meshio reads."""

from pathlib import Path

import numpy as np

from wearfem.errors import UserError
from wearfem.material import Material
from wearfem.surface import Surface

WIDEST = 20.0  # [m] beyond which coordinates are taken for millimetres, unless a scale is given


def read_surface(path: Path, material: Material, *, scale: float | None = None, name: str = "") -> Surface:
    """The triangles of a mesh file as a surface.

    Parameters
    ----------
    path
        A file in any format of meshio; cells other than triangles are left out.
    material
        What the surface is made of.
    scale
        Metres in one unit of the file: `mm` for a drawing in millimetres. Without it the file is in metres, and refused if
        it is wider than 20 m.
    name
        What messages call it; by default the file's name.

    Raises
    ------
    UserError
        for a file that is missing, unreadable, without triangles, or by its size in millimetres.
    """
    if not path.is_file():
        raise UserError(f"There is no mesh file {path}; give the path of a file with triangles.")
    point, triangle = _triangles(path)
    if not len(triangle):
        raise UserError(f"{path} has no triangles; export the surface as a triangle mesh.")
    width = float(np.ptp(point[np.unique(triangle)], axis=0).max())
    if scale is None and width > WIDEST:
        raise UserError(
            f"{path} is {width:.4g} m wide, so it is probably drawn in mm; give scale=mm (or scale=1.0 if it is in m)."
        )
    used, triangle = np.unique(triangle, return_inverse=True)
    return Surface(point[used] * (scale or 1.0), triangle.reshape(-1, 3), material, name=name or path.name)


def _triangles(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points (p, 3) and triangles (t, 3) of a file; points at one place, as STL repeats them, become one."""
    import meshio  # slow to import

    try:
        mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # what meshio raises depends on the format; for some it exits
        raise UserError(
            f"{path} cannot be read as a mesh ({error}); use STL, VTU, PLY or gmsh's MSH."
        ) from error
    triangle = np.concatenate(
        [np.zeros((0, 3), int), *(block.data for block in mesh.cells if block.type == "triangle")]
    )
    if mesh.points.shape[1] != 3:
        raise UserError(f"{path} has points with {mesh.points.shape[1]} coordinates; a surface needs 3.")
    point, place = np.unique(np.asarray(mesh.points, float), axis=0, return_inverse=True)
    return point, place.ravel()[triangle]
