"""What the solver asks of an elastic body, whatever elements it is made of."""

from typing import Protocol

import numpy as np
from scipy import sparse

from wearfem.liner.mesh import LinerMesh
from wearfem.material import Material


class Body(Protocol):
    """An elastic body in points: p points that move, of which the first n are the nodes of the mesh.

    A point has `freedom` m degrees of freedom: its displacement (m = 3), or displacement and rotation vector (m = 6). Degree of
    freedom m i + a is the a-th of point i.
    """

    freedom: int
    direct_limit: int  # degrees of freedom up to which factors are cheaper than multigrid

    @property
    def mesh(self) -> LinerMesh:
        """The mesh that the body was made from."""

    @property
    def material(self) -> Material:
        """What it is made of."""

    @property
    def point(self) -> np.ndarray:
        """(p, 3) [m] places of the points"""

    @property
    def stiffness(self) -> sparse.csr_matrix:
        """(m p, m p) of the body without supports; [N/m] for displacements"""

    @property
    def rigid_motions(self) -> np.ndarray:
        """(p, m, 6) translations along x, y, z and rotations about the axes x, y, z through the origin"""

    @property
    def interpolation(self) -> sparse.csr_matrix:
        """(p, n) values at the points of a field given at the nodes: the coarse space of multigrid"""

    def share(self, group: str) -> tuple[sparse.csr_matrix, np.ndarray]:
        """How evenly spread forces on the k facets (or edges) of a group go to the points.

        Returns
        -------
        share : (p, k) sparse
            Columns sum to one and have the facet's centroid as their centre. All points of the facet are stored, those without a
            share as zero: they are the points that a support of the group holds.
        area : (k,) [m2]
            Of the facets; [m] for edges.
        """

    def load(self, group: str, force: np.ndarray) -> np.ndarray:
        """(p, m) loads of forces (k, 3) [N] spread evenly over the facets of a group: of the same force and moment"""

    def weight(self, gravity: np.ndarray) -> np.ndarray:
        """(p, m) loads of the body's weight under gravity (3,) [m/s2]"""

    def stress(self, displacement: np.ndarray) -> np.ndarray:
        """(n, 3, 3) [Pa] at the nodes of the mesh for displacements (p, m); of a shell, on the face where von Mises stress is higher"""
