"""What the makers share: gmsh with an empty model, and the liner of what was drawn in it."""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from wearfem.liner.mesh import LinerMesh
from wearfem.liner.mesh_file import read_mesh
from wearfem.liner.mesher import gmsh_model

NEAR = 1e-5  # [m] within which a face lies on a plane; gmsh's boxes are 1e-7 m too wide


def empty_model(name: str, size: float) -> AbstractContextManager[Any]:
    """gmsh with an empty model and edges of about `size` [m]"""
    options = {
        "Mesh.MshFileVersion": 4.1, "Mesh.Binary": 1, "Mesh.MeshSizeMax": size, "Mesh.MeshSizeMin": size / 4, "Mesh.Optimize": 1,
    }  # fmt: skip
    return gmsh_model(name, options)


Where = Callable[[np.ndarray, np.ndarray, np.ndarray], bool]  # lowest corner, highest corner, centre [m]


def mesh_of(
    gmsh: Any, faces: Mapping[str, Where], curves: Mapping[str, Where] | None = None, **shell: float
) -> LinerMesh:
    """The model meshed: tetrahedra with `shell` left out, else triangles with that `thickness` and `offset` [m].

    Each group holds all faces (of the outside) or curves that its condition takes, by their box and centre of mass.
    """
    occ = gmsh.model.occ
    occ.synchronize()
    outside = (
        gmsh.model.getEntities(2) if shell else gmsh.model.getBoundary(occ.getEntities(3), oriented=False)
    )
    gmsh.model.addPhysicalGroup(
        2 if shell else 3, [tag for _, tag in gmsh.model.getEntities(2 if shell else 3)]
    )
    entities = [(2, name, where, outside) for name, where in faces.items()]
    entities += [(1, name, where, gmsh.model.getEntities(1)) for name, where in (curves or {}).items()]
    for dimension, name, where, among in entities:
        tags = []
        for _, tag in among:
            box = np.array(gmsh.model.getBoundingBox(dimension, tag))
            if where(box[:3], box[3:], np.array(occ.getCenterOfMass(dimension, tag))):
                tags.append(tag)
        gmsh.model.addPhysicalGroup(dimension, tags, name=name)
    gmsh.model.mesh.generate(2 if shell else 3)
    if not shell:
        gmsh.model.mesh.optimize("Netgen")  # lifts the worst tetrahedron where plates are one element thick
    with TemporaryDirectory() as folder:
        path = Path(folder) / "model.msh"
        gmsh.write(str(path))
        return read_mesh(path, name=gmsh.model.getCurrent(), **shell)


def flat(axis: int, place: float) -> Where:
    """Faces or curves in the plane where the coordinate `axis` is `place` [m]."""
    return lambda low, high, centre: abs(low[axis] - place) < NEAR and abs(high[axis] - place) < NEAR


def either(*conditions: Where) -> Where:
    """Faces that any of the conditions takes."""
    return lambda low, high, centre: any(one(low, high, centre) for one in conditions)


def everything(low: np.ndarray, high: np.ndarray, centre: np.ndarray) -> bool:
    """All faces."""
    return True


def upright(low: np.ndarray, high: np.ndarray, centre: np.ndarray) -> bool:
    """Faces that rise in z."""
    return bool(high[2] - low[2] > 2 * NEAR)
