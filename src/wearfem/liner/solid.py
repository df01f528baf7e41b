"""The liner as an elastic solid: quadratic displacements on tetrahedra or hexahedra with straight edges.

Weak form of linear elasticity: for all v,  int lambda div(u) div(v) + 2 mu eps(u) : eps(v) dV = loads(v),
with lambda = E nu / ((1 + nu) (1 - 2 nu)) and mu = G. Tetrahedra carry 10 points (complete quadratic), hexahedra 27 (triquadratic);
both are integrated exactly on straight and on parallelepiped elements. Quadratic displacements do not lock in bending, nor where the
material hardly changes its volume (nu = 0.49): see `wearfem verify solid`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from skfem import (
    CellBasis,
    ElementHex1,
    ElementHex2,
    ElementTetP1,
    ElementTetP2,
    FacetBasis,
    MeshHex,
    MeshTet,
)

from wearfem.errors import UserError
from wearfem.liner.mesh import SolidMesh, group_of
from wearfem.material import Material

CHUNK = 4096  # elements whose matrices are held in memory at once
VTK_TO_SKFEM = np.array([6, 2, 5, 7, 1, 3, 4, 0])  # corners of a hexahedron of VTK in the order of scikit-fem


@dataclass(frozen=True)
class Solid:
    """A `Body` of solid elements: p points (corners, then edge, face and cell centres) of 3 displacements each.

    Valid for small displacements and strains and isotropic elastic material, nu < 0.5.
    """

    mesh: SolidMesh
    material: Material

    freedom = 3  # degrees of freedom of a point: displacement in x, y, z
    direct_limit = (
        60_000  # [degrees of freedom] above it, multigrid is faster than factors and takes less memory
    )

    def __post_init__(self) -> None:
        if self.material.poisson_ratio >= 0.5:
            raise UserError(
                f"{self.material.name}: poisson_ratio is {self.material.poisson_ratio}, which no displacement element can follow; "
                "give a value below 0.5, 0.49 for rubber."
            )

    @cached_property
    def _basis(self) -> CellBasis:
        """The quadratic shape functions: which elements share which points."""
        kind, element = (MeshTet, ElementTetP2()) if self._tetrahedra else (MeshHex, ElementHex2())
        corner = self.mesh.element if self._tetrahedra else self.mesh.element[:, VTK_TO_SKFEM]
        return CellBasis(kind(self.mesh.node.T.copy(), corner.T.copy()), element, intorder=1)

    @property
    def _tetrahedra(self) -> bool:
        return self.mesh.element.shape[1] == 4

    @cached_property
    def point(self) -> np.ndarray:
        """(p, 3) [m] where the degrees of freedom live; the first n are the nodes of the mesh"""
        return np.ascontiguousarray(self._basis.doflocs.T)

    @cached_property
    def stiffness(self) -> sparse.csr_matrix:
        """(3p, 3p) [N/m]; degree of freedom 3 i + a moves point i along axis a"""
        shear = self.material.shear_modulus
        lame = 2.0 * shear * self.material.poisson_ratio / (1.0 - 2.0 * self.material.poisson_ratio)
        shape, parts = (3 * len(self.point),) * 2, []
        for basis in self.elements(order=2 if self._tetrahedra else 4):
            gradient = np.stack([field[0].grad for field in basis.basis])  # (i, a, element, quadrature point)
            count, _, elements, _ = gradient.shape
            gradient = np.moveaxis(gradient, 2, 0).reshape(elements, 3 * count, -1)
            product = (gradient * basis.dx[:, None, :]) @ np.swapaxes(gradient, 1, 2)
            product = product.reshape(elements, count, 3, count, 3)  # int d_a phi_i d_b phi_j dV
            matrix = lame * product + shear * np.swapaxes(product, 2, 4)
            matrix += shear * np.einsum("eicjc,ab->eiajb", product, np.eye(3))
            number = (3 * basis.element_dofs.T[:, :, None] + np.arange(3)).reshape(elements, -1)
            row, column = np.broadcast_arrays(number[:, :, None], number[:, None, :])
            parts.append(sparse.csr_matrix((matrix.ravel(), (row.ravel(), column.ravel())), shape=shape))
        while len(parts) > 1:  # in pairs: each entry is copied as often as the number of parts can be halved
            parts = [sum(parts[first + 1 : first + 2], parts[first]) for first in range(0, len(parts), 2)]
        return parts[0]

    @cached_property
    def volume(self) -> np.ndarray:
        """(p,) [m3] integral of each point's shape function: how a force by volume is shared out"""
        total = np.zeros(len(self.point))
        for basis in self.elements(order=2 if self._tetrahedra else 4):
            share = np.stack([(np.asarray(field[0]) * basis.dx).sum(axis=1) for field in basis.basis])
            np.add.at(total, basis.element_dofs, share)
        return total

    def weight(self, gravity: np.ndarray) -> np.ndarray:
        """(p, 3) [N] of the body under `gravity` (3,) [m/s2]"""
        return self.material.density * self.volume[:, None] * gravity

    @cached_property
    def rigid_motions(self) -> np.ndarray:
        """(p, 3, 6) translations along x, y, z and rotations about axes through the origin"""
        turn = np.cross(np.eye(3)[None, :, :], self.point[:, None, :])  # (p, axis, component)
        unit = np.broadcast_to(np.eye(3), turn.shape)
        return np.concatenate([unit, np.swapaxes(turn, 1, 2)], axis=2)

    def share(self, group: str) -> tuple[sparse.csr_matrix, np.ndarray]:
        """How evenly spread forces on the k facets of a group go to the points.

        Returns
        -------
        share : (p, k) sparse
            int phi_i dA / A of facet k. Columns sum to one, and the shares of a facet have its centroid as their centre, for shape
            functions sum to one and reproduce positions: force and moment are those of the facet forces at the centroids (of a warped
            facet: the centroid of its Gauss points). All points of the facet are stored, corners of quadratic triangles with zero.
        area : (k,) [m2]
        """
        whole = self._basis
        facet = _find(group_of(self.mesh, group), whole.mesh.facets.T)
        basis = FacetBasis(
            whole.mesh, whole.elem, facets=facet, intorder=4, dofs=whole.dofs, disable_doflocs=True
        )
        value = np.stack([np.broadcast_to(np.asarray(field[0]), basis.dx.shape) for field in basis.basis])
        area = basis.dx.sum(axis=1)
        weight = (value * basis.dx).sum(axis=2) / area
        local, column = np.nonzero(np.abs(value).max(axis=2) > 1e-9)  # shape functions that live on the facet
        row = basis.element_dofs[local, column]
        shape = (len(self.point), len(facet))
        return sparse.csr_matrix((weight[local, column], (row, column)), shape=shape), area

    def load(self, group: str, force: np.ndarray) -> np.ndarray:
        """(p, 3) [N] at the points, of forces (k, 3) [N] spread evenly over the facets of a group"""
        return self.share(group)[0] @ force

    @cached_property
    def interpolation(self) -> sparse.csr_matrix:
        """(p, n) values at the points of a field that is linear between the nodes"""
        whole = self._basis
        at_point = self._linear(whole.elem.doflocs.T)  # (i, c) of the element's points and corners
        row, column = np.broadcast_arrays(whole.element_dofs[:, None, :], whole.mesh.t[None, :, :])
        value = np.broadcast_to(at_point[:, :, None], row.shape)
        _, first = np.unique(row * np.int64(len(self.mesh.node)) + column, return_index=True)
        entry = (value.ravel()[first], (row.ravel()[first], column.ravel()[first]))
        matrix = sparse.csr_matrix(entry, shape=(len(self.point), len(self.mesh.node)))
        matrix.eliminate_zeros()
        return matrix

    def _linear(self, place: np.ndarray) -> np.ndarray:
        """(q, c) linear shape functions of the corners at places (3, q) in the reference element"""
        element, count = (ElementTetP1(), 4) if self._tetrahedra else (ElementHex1(), 8)
        return np.stack([element.lbasis(place, corner)[0] for corner in range(count)], axis=1)

    def stress(self, displacement: np.ndarray) -> np.ndarray:
        """(n, 3, 3) [Pa] at the nodes of the mesh: means over the elements around, weighted by their volume.

        Strain is taken at as many Gauss points as the element has corners, where that of a quadratic element converges fastest
        (Barlow 1976), and goes linearly from there to the corners (Hinton and Campbell 1974).
        """
        shear, ratio = self.material.shear_modulus, self.material.poisson_ratio
        total, weight = np.zeros((len(self.mesh.node), 3, 3)), np.zeros(len(self.mesh.node))
        for basis in self.elements(order=2 if self._tetrahedra else 3):
            gradient = np.zeros((3, 3, *basis.dx.shape))  # (component, axis, element, Gauss point)
            for dofs, field in zip(basis.element_dofs, basis.basis, strict=True):
                gradient += displacement[dofs].T[:, None, :, None] * field[0].grad
            strain = 0.5 * (gradient + np.swapaxes(gradient, 0, 1))
            bulk = np.einsum("aaeq->eq", strain) * (ratio / (1.0 - 2.0 * ratio))
            value = 2.0 * shear * (strain + np.eye(3)[:, :, None, None] * bulk)
            at_corner = np.einsum("cq,abeq->ceab", np.linalg.inv(self._linear(basis.X)), value)
            size = basis.dx.sum(axis=1)
            corner = basis.mesh.t[:, basis.tind]
            np.add.at(total, corner, at_corner * size[:, None, None])
            weight += np.bincount(corner.ravel(), np.tile(size, len(corner)), len(weight))
        return total / weight[:, None, None]

    def elements(self, order: int) -> Iterator[CellBasis]:
        """The elements with their shape functions at Gauss points of an order, some at a time."""
        whole = self._basis
        for first in range(0, whole.mesh.nelements, CHUNK):
            part = np.arange(first, min(first + CHUNK, whole.mesh.nelements))
            yield CellBasis(
                whole.mesh, whole.elem, elements=part, intorder=order, dofs=whole.dofs, disable_doflocs=True
            )


def _find(facet: np.ndarray, known: np.ndarray) -> np.ndarray:
    """(k,) the place of each facet among the facets known, by their three lowest corners"""

    def key(corners: np.ndarray) -> np.ndarray:
        low = np.sort(corners, axis=1)[:, :3].astype(np.int64)
        return (low[:, 0] * count + low[:, 1]) * count + low[:, 2]

    count = int(known.max()) + 1
    order = np.argsort(key(known))
    return order[np.searchsorted(key(known)[order], key(facet))]
