"""The liner as a value: its mesh as it is now, what it is made of, and how much it has lost."""

from dataclasses import dataclass, field

import numpy as np

from wearfem.errors import UserError
from wearfem.liner.mesh import LinerMesh, ShellMesh, triangles
from wearfem.material import Material
from wearfem.surface import Surface


@dataclass(frozen=True)
class Liner:
    """Everything that a restart must know of the liner. Nothing ever changes it: `recede` returns another."""

    mesh: LinerMesh
    material: Material
    depth: np.ndarray = field(
        default_factory=lambda: np.zeros(0)
    )  # (f,) [m] worn off each facet so far; zeros by default
    service_time: float = 0.0  # [s]
    throughput: float = 0.0  # [kg]

    def __post_init__(self) -> None:
        if not len(self.depth):
            object.__setattr__(self, "depth", np.zeros(len(self.mesh.wear)))
        count, depth = len(self.mesh.wear), np.asarray(self.depth, float)
        if depth.shape != (count,) or not np.isfinite(depth).all():
            raise UserError(
                f"{self.mesh.name}: a depth worn so far of shape {depth.shape}, {np.isfinite(depth).sum()} values of it finite, was given, "
                f"but the group 'wear' has {count} facets; give one finite number in m for each, in its order."
            )


def wear_surface(liner: Liner, displacement: np.ndarray | None = None) -> Surface:
    """The worn face as the particles meet it; `facet` numbers the facets of `mesh.wear`.

    Parameters
    ----------
    liner
        As it is now.
    displacement
        (n, 3) [m] of the mesh's nodes, where the liner's bending matters to the flow: see `flexure.py`.

    Raises
    ------
    UserError
        for a displacement of the wrong shape or not finite.
    """
    if displacement is not None and (
        np.shape(displacement) != liner.mesh.node.shape or not np.isfinite(displacement).all()
    ):
        raise UserError(
            f"{liner.mesh.name}: a displacement of shape {np.shape(displacement)} was given; finite numbers in m of shape "
            f"{liner.mesh.node.shape} are needed, of this mesh as it is now."
        )
    mesh = liner.mesh
    node = worn_face(mesh) if isinstance(mesh, ShellMesh) else mesh.node
    node = node if displacement is None else node + displacement
    corner, facet = triangles(mesh.wear)
    used, triangle = np.unique(corner, return_inverse=True)
    return Surface(node[used], triangle.reshape(-1, 3), liner.material, facet, mesh.name)


def worn_face(mesh: ShellMesh) -> np.ndarray:
    """(n, 3) [m] points of the shell's worn face above its nodes"""
    return mesh.node + (mesh.offset + 0.5 * mesh.thickness)[:, None] * node_normal(mesh)


def node_normal(mesh: ShellMesh) -> np.ndarray:
    """(n, 3) unit normals at the nodes of a shell: means of the triangles around, weighted by their angle there"""
    a, b, c = np.moveaxis(mesh.node[mesh.element], 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    total = np.zeros_like(mesh.node)
    for corner, (p, q, r) in enumerate(((a, b, c), (b, c, a), (c, a, b))):
        cosine = np.einsum("ei,ei->e", q - p, r - p) / (
            np.linalg.norm(q - p, axis=1) * np.linalg.norm(r - p, axis=1)
        )
        np.add.at(total, mesh.element[:, corner], np.arccos(np.clip(cosine, -1.0, 1.0))[:, None] * normal)
    return total / np.linalg.norm(total, axis=1, keepdims=True)
