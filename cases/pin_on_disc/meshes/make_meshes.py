"""Make the meshes of the disc with gmsh: `python make_meshes.py`. They are shipped, so running the case needs no gmsh.

The top is meshed irregularly at the size that the file is named after, like the paper's disc; the bottom, which nothing
touches, is coarser. Triangles are turned outward, coordinates are in m, and the axis of the disc is z with the top at z = 0.
"""

from pathlib import Path

import gmsh
import meshio
import numpy as np

RADIUS, HEIGHT = 26.5e-3, 6e-3  # [m]
SIZES = (0.55e-3, 1.1e-3, 2.2e-3, 4.4e-3)  # [m] Table X
COARSE = 4.4e-3  # [m] at the bottom


def disc(size: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (p, 3) [m] and triangles (t, 3) of the disc's skin, its top meshed at `size` [m]."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)
    gmsh.model.occ.addCylinder(0.0, 0.0, -HEIGHT, 0.0, 0.0, HEIGHT, RADIUS)
    gmsh.model.occ.synchronize()
    for dim, tag in gmsh.model.getEntities(0):
        at_top = gmsh.model.getValue(dim, tag, [])[2] > -0.5 * HEIGHT
        gmsh.model.mesh.setSize([(dim, tag)], size if at_top else COARSE)
    gmsh.model.mesh.generate(2)
    tag, point, _ = gmsh.model.mesh.getNodes()
    triangle = np.searchsorted(np.sort(tag), gmsh.model.mesh.getElementsByType(2)[1].reshape(-1, 3))
    point = point.reshape(-1, 3)[np.argsort(tag)]
    gmsh.finalize()
    point[np.abs(point[:, 2]) < 1e-9 * HEIGHT, 2] = 0.0
    a, b, c = np.moveaxis(point[triangle], 1, 0)
    outward = (a + b + c) / 3.0 - [0.0, 0.0, -0.5 * HEIGHT]
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), outward) < 0.0
    triangle[inward] = triangle[inward][:, ::-1]
    return point, triangle


if __name__ == "__main__":
    for size in SIZES:
        point, triangle = disc(size)
        path = Path(__file__).parent / f"disc_{size * 1e3:g}_mm.vtu"
        meshio.Mesh(point, [("triangle", triangle.astype(np.int32))]).write(path)
        edge = np.linalg.norm(np.diff(point[triangle[:, [0, 1, 2, 0]]], axis=1), axis=2)
        top = (point[triangle, 2] == 0.0).all(axis=1)
        print(
            f"{path.name}: {len(triangle)} triangles, {top.sum()} on top, mean edge there {edge[top].mean():.3g} m"
        )
