"""How the rest of the mesh follows its worn face: as an elastic body whose boundary slides in its own planes."""

from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, kron
from scipy.sparse.linalg import cg
from skfem import Basis, BilinearForm, ElementHex1, ElementTetP1, MeshHex, MeshTet

from wearfem.errors import UserError
from wearfem.liner.corners import facet_vector, unworn
from wearfem.liner.mesh import WEAR, SolidMesh

FLAT = 1e-14  # eigenvalue of sum n n^T over the largest, within which facets lie in one plane: 1e-7 rad
FROM_VTK = np.array([0, 4, 3, 1, 7, 5, 2, 6])  # place in VTK's hexahedron of each corner of scikit-fem's
ACCURACY = 1e-6  # of the motion of the interior, relative to that of the worn face


def follow(mesh: SolidMesh, displacement: np.ndarray, moved: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Motion (n, 3) [m] of all nodes, given that of the worn face.

    Linear elasticity with Young's modulus 1 / volume of each element, so that small elements move as one piece and large ones
    give way, and Poisson's ratio 0. A node of a side slides in all directions that lie in every facet around it (in a plane, or
    along an edge or the axis of a drum) and that keep it on the border of its groups (a bolt's pad keeps its outline): the
    sides sweep no volume.

    Parameters
    ----------
    mesh
        Before the motion.
    displacement, moved
        (n, 3) [m] and (n,) bool: the motion of the worn face, and its nodes.
    held
        (n, 3, 3) projectors on the directions in which nodes of the worn face are held; along the rest they slide, as the body
        pulls them.

    Source
    ------
    Stein, Tezduyar and Benney 2003, J. Appl. Mech. 70, 58-63 (mesh motion stiffened by the Jacobian).
    """
    free = _free_directions(mesh, moved, held)
    stiffness = _stiffness(mesh)
    full = np.where(moved[:, None], displacement, 0.0).ravel()
    load = -(free.T @ (stiffness @ full))
    if not load.any():
        return full.reshape(-1, 3)
    matrix = csr_array(free.T @ stiffness @ free)
    scale = 1.0 / np.sqrt(matrix.diagonal())
    matrix = csr_array(matrix.multiply(scale[:, None]).multiply(scale[None, :]))
    found, failed = cg(matrix, scale * load, rtol=ACCURACY, maxiter=5000)
    if failed:
        raise UserError(
            f"{mesh.name}: the mesh cannot follow its worn face, because the elastic mesh motion does not converge; "
            "its elements are badly shaped, so remesh the liner."
        )
    return (full + free @ (scale * found)).reshape(-1, 3)


@BilinearForm
def _slopes(u: Any, v: Any, w: Any) -> Any:
    return u.grad[w["of_trial"]] * v.grad[w["of_test"]] / w.volume


def _stiffness(mesh: SolidMesh) -> csr_array:
    """(3n, 3n) [-] numbered node by node: the integral of strain : strain / volume.

    Put together from the nine products of slopes of scalar functions: 1/2 (grad u : grad v + grad u : grad v^T).
    """
    hexahedra = mesh.element.shape[1] == 8
    order = FROM_VTK if hexahedra else np.arange(4)
    corner, place = np.ascontiguousarray(mesh.element[:, order].T), np.ascontiguousarray(mesh.node.T)
    if hexahedra:
        basis = Basis(MeshHex(place, corner, validate=False), ElementHex1(), intorder=2)
    else:
        basis = Basis(MeshTet(place, corner, validate=False), ElementTetP1(), intorder=0)
    volume = np.abs(basis.dx).sum(axis=1, keepdims=True)
    relative = np.broadcast_to(volume / volume.mean(), basis.dx.shape)
    total = csr_array((3 * len(mesh.node), 3 * len(mesh.node)))
    for trial, test in np.ndindex(3, 3):
        part = csr_array(_slopes.assemble(basis, volume=relative, of_trial=trial, of_test=test))
        component = np.zeros((3, 3))
        component[trial, test] = 0.5
        total = total + kron(part, component + 0.5 * np.eye(3) * (trial == test), format="csr")
    return csr_array(total)


def _free_directions(mesh: SolidMesh, moved: np.ndarray, held: np.ndarray) -> csr_array:
    """(3n, k) orthonormal directions in which the nodes are free, three rows a node."""
    count = len(mesh.node)
    hold = np.zeros((count, 3, 3))
    facet = unworn(mesh)
    vector = facet_vector(mesh.node, facet)
    normal = vector / np.linalg.norm(vector, axis=1, keepdims=True)
    for k in range(facet.shape[1]):
        np.add.at(hold, facet[:, k], normal[:, :, None] * normal[:, None, :])
    _hold_borders(mesh, facet, normal, hold)
    hold[moved] = held[moved]
    side = np.flatnonzero(np.trace(hold, axis1=1, axis2=2) > 0.0)
    inner = np.ones(count, bool)
    inner[side] = False
    value, axis = np.linalg.eigh(hold[side])
    slides = value <= FLAT * value[:, -1:]
    which, column = np.nonzero(slides)
    row = np.concatenate(
        [
            (3 * side[which, None] + np.arange(3)).ravel(),
            (3 * np.flatnonzero(inner)[:, None] + np.arange(3)).ravel(),
        ]
    )
    inner_count = 3 * int(inner.sum())
    number = np.concatenate([np.repeat(np.arange(len(which)), 3), len(which) + np.arange(inner_count)])
    data = np.concatenate([axis[which, :, column].ravel(), np.ones(inner_count)])
    return csr_array(coo_array((data, (row, number)), shape=(3 * count, len(which) + inner_count)))


def _hold_borders(mesh: SolidMesh, facet: np.ndarray, normal: np.ndarray, hold: np.ndarray) -> None:
    """Hold nodes on the border of groups within a plane: across the border they do not slide. Adds to `hold` (n, 3, 3)."""
    names = [name for name in sorted(mesh.group) if name not in (WEAR, "rim")]
    kind = np.zeros((len(facet), len(names)), bool)
    for column, name in enumerate(names):
        group = mesh.group[name]
        if group.ndim == 2 and group.shape[1] == facet.shape[1]:
            every = np.sort(np.concatenate([facet, group]), axis=1)
            number = np.unique(every, axis=0, return_inverse=True)[1].ravel()
            kind[:, column] = np.isin(number[: len(facet)], number[len(facet) :])
    label = np.unique(kind, axis=0, return_inverse=True)[1].ravel() if names else np.zeros(len(facet), int)
    sides = facet.shape[1]
    edge = np.sort(np.stack([facet, np.roll(facet, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(facet)), sides)
    order = np.lexsort((edge[:, 1], edge[:, 0]))
    same = (edge[order[1:]] == edge[order[:-1]]).all(axis=1)
    p, q = order[:-1][same], order[1:][same]
    border = label[owner[p]] != label[owner[q]]
    p = p[border]
    along = mesh.node[edge[p, 1]] - mesh.node[edge[p, 0]]
    across = np.cross(along / np.linalg.norm(along, axis=1, keepdims=True), normal[owner[p]])
    for end in range(2):
        np.add.at(hold, edge[p, end], across[:, :, None] * across[:, None, :])
