"""The liner as a thick shell: stiffness, loads, and stress of flat triangles in space whose thickness and offset vary.

Displacements are (n, 6): translations [m] along and rotations [rad] about the global axes, at the nodes of the reference surface.
The triangles lie in the middle surface, whose corners hang on the nodes by rigid levers offset x normal; so a shell that is worn on
one side bends as its true middle surface does, and pulls while it bends. The formulas of one triangle are in `shell_element.py`.

**Valid for** small displacements of isotropic elastic shells up to about a fifth as thick as the span; stresses are those of the shell
theory, right a thickness away from edges, point loads and steps of thickness.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from wearfem.errors import UserError
from wearfem.liner.liner import node_normal, worn_face
from wearfem.liner.mesh import ShellMesh, group_of
from wearfem.liner.shell_element import (
    ALPHA,
    MEMBRANE,
    PLATE,
    SHEAR_CORRECTION,
    area_of,
    axes_of,
    local_stiffness,
    membrane_strain,
    plane_stress,
    plate_strain,
    thickness_moments,
)
from wearfem.liner.strength import von_mises
from wearfem.material import Material

_AT_ONCE = 20_000  # triangles: what a block needs is some 200 MB


@dataclass(frozen=True)
class Shell:
    """A shell as the solver sees it: see `body.Body`. Its points are the nodes of the mesh.

    Loads on a group of triangles (k, 3) act on the worn face, loads on edges (k, 2) and points (k, 1) at the nodes; supports hold
    the nodes.
    """

    mesh: ShellMesh
    material: Material

    freedom = 6  # degrees of freedom of a point: displacement, rotation vector
    direct_limit = (
        1_000_000  # [degrees of freedom] factors of surfaces stay thin: 4 GB and a minute at 600 000
    )

    @property
    def point(self) -> np.ndarray:
        """(n, 3) [m]"""
        return self.mesh.node

    @property
    def interpolation(self) -> sparse.csr_matrix:
        """(n, n) from nodes to points: the same"""
        return sparse.identity(len(self.mesh.node), format="csr")

    @cached_property
    def stiffness(self) -> sparse.csr_matrix:
        """(6 n, 6 n) see `shell_stiffness`"""
        return shell_stiffness(self.mesh, self.material)

    @cached_property
    def rigid_motions(self) -> np.ndarray:
        """(n, 6, 6) translations along x, y, z and rotations about the axes x, y, z through the origin"""
        motion = np.tile(np.eye(6), (len(self.mesh.node), 1, 1))
        motion[:, :3, 3:] = np.cross(np.eye(3), self.mesh.node[:, None]).transpose(0, 2, 1)
        return motion

    def share(self, group: str) -> tuple[sparse.csr_matrix, np.ndarray]:
        """Even shares (n, k) of the nodes in each triangle, edge or point of a group, and its area [m2], length [m] or zero (k,)."""
        corner = group_of(self.mesh, group)
        count, corners = corner.shape
        column = np.repeat(np.arange(count), corners)
        share = sparse.csr_matrix(
            (np.full(corner.size, 1.0 / corners), (corner.ravel(), column)),
            shape=(len(self.mesh.node), count),
        )
        place = self.mesh.node[corner]
        if corners == 3:
            return share, area_of(axes_of(place)[1])
        return share, np.linalg.norm(place[:, -1] - place[:, 0], axis=1)

    def load(self, group: str, force: np.ndarray) -> np.ndarray:
        """(n, 6) loads of forces (k, 3) [N] spread evenly over triangles of the worn face, over edges, or on points"""
        corner = group_of(self.mesh, group)
        if corner.shape[1] == 3:
            return face_load(self.mesh, corner, force)
        if corner.shape[1] == 2:
            return edge_load(self.mesh, corner, force)
        load = np.zeros((len(self.mesh.node), 6))
        np.add.at(load[:, :3], corner[:, 0], force)
        return load

    def weight(self, gravity: np.ndarray) -> np.ndarray:
        """(n, 6) see `gravity_load`"""
        return gravity_load(self.mesh, self.material, gravity)

    def stress(self, displacement: np.ndarray) -> np.ndarray:
        """(n, 3, 3) [Pa] at the nodes, on the face, worn or back, where the von Mises stress is higher"""
        section = resultants(self.mesh, self.material, displacement)
        worn, back = (at_nodes(self.mesh, section.stress(height)) for height in (0.5, -0.5))
        return np.where((von_mises(worn) >= von_mises(back))[:, None, None], worn, back)


def middle_surface(mesh: ShellMesh) -> np.ndarray:
    """(n, 3) [m] points of the middle surface beside the nodes"""
    return mesh.node + mesh.offset[:, None] * node_normal(mesh)


def shell_stiffness(mesh: ShellMesh, material: Material) -> sparse.csr_matrix:
    """The stiffness (6 n, 6 n) of a shell; row 6 i + c is component c of node i.

    Raises
    ------
    UserError
        for a thickness that is not above zero, or triangles whose middle surface has no area.
    """
    _check(mesh)
    count = len(mesh.element)
    block = np.empty((count, 18, 18))
    lever = middle_surface(mesh) - mesh.node
    for start in range(0, count, _AT_ONCE):
        corner = mesh.element[start : start + _AT_ONCE]
        axes, xy = axes_of((mesh.node + lever)[corner])
        local = local_stiffness(xy, mesh.thickness[corner], material.young_modulus, material.poisson_ratio)
        turn = _to_local(axes, lever[corner])
        local = local.reshape(-1, 3, 6, 3, 6).transpose(0, 1, 3, 2, 4)
        globally = turn.transpose(0, 1, 3, 2)[:, :, None] @ local @ turn[:, None]
        block[start : start + _AT_ONCE] = globally.transpose(0, 1, 3, 2, 4).reshape(-1, 18, 18)
    freedom = (6 * mesh.element[:, :, None] + np.arange(6)).reshape(count, 18).astype(np.int32)
    row, column = np.repeat(freedom, 18, axis=1), np.tile(freedom, (1, 18))
    size = 6 * len(mesh.node)
    return sparse.coo_matrix((block.ravel(), (row.ravel(), column.ravel())), shape=(size, size)).tocsr()


def face_load(mesh: ShellMesh, facet: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Nodal forces and moments (n, 6) [N, N m] of forces (k, 3) [N] spread over triangles (k, 3) of the worn face.

    A third of a force goes to each corner of its triangle there, and from the worn face to the node: F_i and r_i x F_i,
    r_i = (offset + thickness / 2) x normal. Force, and moment about any point, are those of the forces at the triangles' centroids.
    """
    nodal = np.zeros_like(mesh.node)
    np.add.at(nodal, facet, np.repeat(force[:, None] / 3.0, 3, axis=1))
    return np.hstack([nodal, np.cross(worn_face(mesh) - mesh.node, nodal)])


def edge_load(mesh: ShellMesh, edge: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Nodal forces and moments (n, 6) [N, N m] of forces (k, 3) [N] spread over edges (k, 2) of the border, at the nodes.

    Half of a force goes to each end. Edges bow when their ends turn in the plane, so the part of the force across the edge, F_b, makes
    moments -/+ alpha_b / 12 F_b l about the normal, equal and opposite at the ends (Felippa 2003, consistent lumping).
    """
    load = np.zeros((len(mesh.node), 6))
    np.add.at(load[:, :3], edge, np.repeat(force[:, None] / 2.0, 2, axis=1))
    along = mesh.node[edge[:, 1]] - mesh.node[edge[:, 0]]
    normal = node_normal(mesh)[edge].sum(axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    moment = ALPHA / 12.0 * np.einsum("ki,ki->k", np.cross(along, normal), force)[:, None] * normal
    np.add.at(load[:, 3:], edge, np.stack([-moment, moment], axis=1))
    return load


def pressure_load(mesh: ShellMesh, pressure: np.ndarray | float) -> np.ndarray:
    """Nodal forces and moments (n, 6) [N, N m] of a pressure (f,) [Pa] that presses on the worn face where it is now."""
    a, b, c = np.moveaxis(worn_face(mesh)[mesh.wear], 1, 0)
    area = 0.5 * np.cross(b - a, c - a)  # vector, into the flow
    return face_load(mesh, mesh.wear, -area * np.broadcast_to(pressure, len(area))[:, None])


def gravity_load(mesh: ShellMesh, material: Material, gravity: np.ndarray) -> np.ndarray:
    """Nodal forces and moments (n, 6) [N, N m] of the shell's own weight, which acts in the middle surface; `gravity` (3,) in m/s2."""
    middle = middle_surface(mesh)
    share = thickness_moments(area_of(axes_of(middle[mesh.element])[1]), mesh.thickness[mesh.element], 1).sum(
        axis=2
    )
    mass = material.density * np.bincount(mesh.element.ravel(), share.ravel(), len(mesh.node))
    nodal = mass[:, None] * np.asarray(gravity)
    return np.hstack([nodal, np.cross(middle - mesh.node, nodal)])


@dataclass(frozen=True)
class Resultants:
    """What a section of the shell carries, at each corner of each triangle, about the triangle's own axes.

    A moment is positive where it pulls the worn face.
    """

    axes: np.ndarray  # (e, 3, 3) rows: the two directions in the triangle, and the normal
    thickness: np.ndarray  # (e, 3) [m]
    force: np.ndarray  # (e, 3, 3) [N/m] N_x, N_y, N_xy
    moment: np.ndarray  # (e, 3, 3) [N] M_x, M_y, M_xy
    shear: np.ndarray  # (e, 3, 2) [N/m] Q_x, Q_y

    def stress(self, height: float) -> np.ndarray:
        """(e, 3, 3, 3) [Pa] stress tensors in global axes, at `height` thicknesses above the middle: 1/2 is the worn face, -1/2 the back.

        In the plane sigma = N / h + 12 height M / h^2; across it tau = 3/2 (1 - 4 height^2) Q / h.
        """
        h = self.thickness[:, :, None]
        plane = self.force / h + 12.0 * height * self.moment / h**2
        across = 1.5 * (1.0 - 4.0 * height**2) * self.shear / h
        local = np.zeros((*self.thickness.shape, 3, 3))
        local[..., 0, 0], local[..., 1, 1] = plane[..., 0], plane[..., 1]
        local[..., 0, 1] = local[..., 1, 0] = plane[..., 2]
        local[..., 2, :2] = local[..., :2, 2] = across
        axes = self.axes[:, None]
        return axes.transpose(0, 1, 3, 2) @ local @ axes


def resultants(mesh: ShellMesh, material: Material, displacement: np.ndarray) -> Resultants:
    """Normal forces, moments and shear forces of a shell with displacements (n, 6)."""
    _check(mesh)
    middle, corner = middle_surface(mesh), mesh.element
    axes, xy = axes_of(middle[corner])
    turn = _to_local(axes, (middle - mesh.node)[corner])
    local = (turn @ displacement[corner][..., None]).reshape(-1, 18)
    h = mesh.thickness[corner]
    uniform, linear = membrane_strain(xy, material.poisson_ratio)
    curvature, slip = plate_strain(xy, h, material.poisson_ratio)
    in_plane, plate = local[:, MEMBRANE], local[:, PLATE]
    sheet = plane_stress(material.young_modulus, material.poisson_ratio)
    strain = np.einsum("eikd,ed->eik", uniform[:, None] + linear, in_plane)
    return Resultants(
        axes,
        h,
        h[:, :, None] * strain @ sheet,
        h[:, :, None] ** 3 / 12.0 * np.einsum("eikd,ed->eik", curvature, plate) @ sheet,
        SHEAR_CORRECTION * material.shear_modulus * h[:, :, None] * np.einsum("eikd,ed->eik", slip, plate),
    )


def at_nodes(mesh: ShellMesh, value: np.ndarray) -> np.ndarray:
    """(n, ...) means at the nodes of values (e, 3, ...) at the corners, weighted by the triangles' areas."""
    weight = np.repeat(area_of(axes_of(middle_surface(mesh)[mesh.element])[1])[:, None], 3, axis=1)
    total = np.zeros((len(mesh.node), *value.shape[2:]))
    np.add.at(total, mesh.element, weight.reshape(weight.shape + (1,) * (value.ndim - 2)) * value)
    whole = np.bincount(mesh.element.ravel(), weight.ravel(), len(mesh.node))
    return total / whole.reshape(-1, *(1,) * (value.ndim - 2))


def _to_local(axes: np.ndarray, lever: np.ndarray) -> np.ndarray:
    """(e, 3, 6, 6) from the node's displacement to the corner's, in the triangle's axes: u + theta x lever, and theta."""
    x, y, z = np.moveaxis(lever, -1, 0)
    nothing = np.zeros_like(x)
    arm = np.stack([nothing, z, -y, -z, nothing, x, y, -x, nothing], axis=-1).reshape(*x.shape, 3, 3)
    turn = np.zeros((*x.shape, 6, 6))
    turn[..., :3, :3] = turn[..., 3:, 3:] = axes[:, None]
    turn[..., :3, 3:] = axes[:, None] @ arm
    return turn


def _check(mesh: ShellMesh) -> None:
    bad = ~(mesh.thickness > 0.0)
    if bad.any():
        first = int(np.argmax(bad))
        raise UserError(
            f"{mesh.name}: the thickness is {mesh.thickness[first]:g} m at node {first} and not above 0 at {bad.sum()} of "
            f"{len(bad)} nodes; take worn-through triangles out of the mesh before its strength is asked for."
        )
