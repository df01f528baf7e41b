"""How far each node of the worn face moves so that every face around it recedes by its own depth, and the volume is exact."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array

from wearfem.errors import UserError
from wearfem.liner.corners import SHARP, Corners, facet_area
from wearfem.liner.projection import mass, to_corners

ROUNDING = 1e-14  # of the volume, where the local correction has nothing more to do
FLAT = 5e-3  # eigenvalue over the largest, below which planes that meet in a node are one plane: 8 degrees


@dataclass(frozen=True)
class Offset:
    """What a depth does to the nodes of a surface."""

    displacement: np.ndarray  # (n, 3) [m]
    depth: np.ndarray  # (n,) [m] largest depth of a node's corners
    moved: np.ndarray  # (n,) bool: nodes of the worn face
    hold: np.ndarray  # (n, 3, 3) projector on the directions in which a node of the worn face may not slide
    asked: float  # [m3] sum of depth x area of the facets as they were
    swept: float  # [m3] by the whole surface; equal to `asked` to 1e-13


def swept_by_corner(corners: Corners, node: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """(t, 3) [m3] volume that triangles sweep inward on a straight way, as shares of their corners.

    The area vector of a moving triangle is a square polynomial of time, so its mean over the way is exact:
    N = a x b / 2 + (a x d + c x b) / 4 + c x d / 6, edges a, b and their changes c, d; a corner that moves by u sweeps -u.N / 3.
    """
    p, u = node[corners.triangle], displacement[corners.triangle]
    a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    c, d = u[:, 1] - u[:, 0], u[:, 2] - u[:, 0]
    vector = np.cross(a, b) / 2.0 + (np.cross(a, d) + np.cross(c, b)) / 4.0 + np.cross(c, d) / 6.0
    return -np.einsum("tkj,tj->tk", u, vector) / 3.0 * corners.weight[:, None]


def offset(
    corners: Corners,
    node: np.ndarray,
    depth: np.ndarray,
    *,
    slide: np.ndarray | None = None,
    direction: np.ndarray | None = None,
) -> Offset:
    """Move the worn face inward by a depth (f,) [m] of its facets.

    A node moves by the u of least length with n.u = -w for each of its merged corners (normal n, depth w) and n.u = 0,
    which goes first, for
    the sides that it slides in: on a face along its normal, on an edge to where the two receded faces meet, in a
    corner to where three meet.
    Eigenvalues of sum n n^T below `FLAT` x the largest are left out. Then w + (volume asked - volume swept) / area is
    taken at each merged corner until the volume is exact: w >= 0 throughout, what a corner without depth cannot give
    goes to its neighbours.

    Parameters
    ----------
    corners
        Of the surface as it is, worn facets first.
    node
        (n, 3) [m].
    depth
        (f,) [m]; the volume asked is sum depth x area at this, the old, geometry.
    slide
        (n, 3) [m] motion along the surface, and of the nodes of sides, that is added; the volume that it sweeps is made good, beside
        the nodes that sweep it, or in proportion to depth where a curved side sweeps it.
    direction
        (n, 3) unit vectors into the flow; with them nodes move along these only (a shell).

    Raises
    ------
    UserError
        where no motion of the nodes removes the volume asked (a fin that would vanish).

    Source
    ------
    Jiao 2007, J. Comput. Phys. 220, 612-625, section 3 (offset of faces, eigenvalue analysis); the local correction is our own.
    """
    count = len(corners.node)
    area = facet_area(node, corners.outline[: len(depth)])
    asked_total = float(depth @ area)
    w = to_corners(corners, node, depth)
    matrix = mass(corners, node)
    corner_area = matrix.sum(axis=1)
    asked = w * corner_area
    move, hold = _mover(corners, node, direction)
    extra = 0.0 if slide is None else slide
    used = corners.of_worn & (corner_area > 0.0)
    spread = _neighbours(corners, matrix)
    together = _nodewise(corners, corner_area)
    share = _shares(corners, corner_area)
    for _ in range(300):
        displacement = move(w) + extra
        by_corner = swept_by_corner(corners, node, displacement).ravel()
        swept, total = share @ by_corner, float(by_corner.sum())
        elsewhere = (total - swept.sum()) / asked_total if asked_total else 0.0
        missing = together @ np.where(used, asked * (1.0 - elsewhere) - swept, 0.0)
        if np.abs(missing).sum() <= ROUNDING * asked_total or abs(total - asked_total) <= 1e-15 * asked_total:
            break
        wanted = w + np.divide(missing, corner_area, out=np.zeros(count), where=used)
        stuck = np.minimum(wanted, 0.0) * corner_area
        w = np.maximum(wanted, 0.0)
        if stuck.any():
            asked = asked - stuck + _to_givers(spread, w).T @ stuck
    if not abs(total - asked_total) <= 1e-10 * asked_total:
        raise UserError(
            f"The worn face cannot lose the {asked_total:.4g} m3 asked for (its nodes would sweep {total:.4g} m3): it has a fin thinner "
            "than the step, or facets turned over; take shorter steps or remesh the liner."
        )
    moved = np.zeros(len(node), bool)
    moved[corners.node[corners.of_worn]] = True
    deepest = np.zeros(len(node))
    np.maximum.at(deepest, corners.node, w)
    return Offset(displacement, deepest, moved, hold, asked_total, total)


def _mover(
    corners: Corners, node: np.ndarray, direction: np.ndarray | None
) -> tuple[Callable[[np.ndarray], np.ndarray], np.ndarray]:
    """The function from depths (c,) of merged corners to displacements (n, 3) of nodes, and the directions held (n, 3, 3)."""
    count, worn = len(node), corners.of_worn
    displacement = np.zeros((count, 3))
    if direction is not None:

        def along(w: np.ndarray) -> np.ndarray:
            displacement[corners.node[worn]] = -w[worn, None] * direction[corners.node[worn]]
            return displacement

        return along, np.broadcast_to(np.eye(3), (count, 3, 3))
    normal = _corner_normal(corners, node)
    touched = np.unique(corners.node[worn])
    side = _side_planes(corners, normal)
    free = np.eye(3) - _span(_sum_of_squares(corners.node[side], normal[side], count)[touched])[0]
    within = np.zeros((count, 3, 3))
    within[touched] = free
    at = corners.node[worn]
    plane = np.einsum("cij,cj->ci", within[at], normal[worn])
    held, solve = _span(_sum_of_squares(at, plane, count)[touched])

    def meet(w: np.ndarray) -> np.ndarray:
        right = np.stack([np.bincount(at, -w[worn] * plane[:, k], count) for k in range(3)], axis=1)
        displacement[touched] = np.einsum("nij,nj->ni", solve, right[touched])
        return displacement

    hold = np.zeros((count, 3, 3))
    hold[touched] = held + np.eye(3) - free
    return meet, hold


def _sum_of_squares(at: np.ndarray, vector: np.ndarray, count: int) -> np.ndarray:
    """(n, 3, 3) sum of v v^T at each node"""
    total = np.zeros((count, 3, 3))
    np.add.at(total, at, vector[:, :, None] * vector[:, None, :])
    return total


def _span(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Projector on the directions that symmetric matrices (k, 3, 3) span, eigenvalues above `FLAT` x the largest, and the inverse there."""
    value, vector = np.linalg.eigh(matrix)
    keep = value > np.maximum(FLAT * value[:, -1:], 1e-12)
    inverse = np.where(keep, 1.0 / np.where(keep, value, 1.0), 0.0)
    return (
        np.einsum("nik,nk,njk->nij", vector, keep.astype(float), vector),
        np.einsum("nik,nk,njk->nij", vector, inverse, vector),
    )


def _corner_normal(corners: Corners, node: np.ndarray) -> np.ndarray:
    """(c, 3) unit normals: means of the triangles around, weighted by area."""
    a, b, c = np.moveaxis(node[corners.triangle], 1, 0)
    vector = np.cross(b - a, c - a) * corners.weight[:, None]
    total = np.zeros((len(corners.node), 3))
    for k in range(3):
        np.add.at(total, corners.corner[:, k], vector)
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)


def _side_planes(corners: Corners, normal: np.ndarray) -> np.ndarray:
    """(c,) bool: corners of sides that a worn node slides in.

    A side that goes on from the worn face without a sharp edge is not slid in: it tilts.
    """
    worn, count = corners.of_worn, int(corners.node.max()) + 1
    mean = np.zeros((count, 3))
    np.add.at(mean, corners.node[worn], normal[worn])
    has = np.linalg.norm(mean, axis=1) > 0.0
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300)
    along = (mean[corners.node] * normal).sum(axis=1)
    return ~worn & has[corners.node] & (along < np.cos(SHARP))


def _shares(corners: Corners, area: np.ndarray) -> csr_array:
    """(c, 3 t) to which merged corner of the worn face each corner of a triangle adds what it sweeps.

    Corners of sides add to the worn corners of their node, in proportion to area.
    """
    at = corners.corner.ravel()
    own = corners.of_worn[at]
    column = np.flatnonzero(own)
    worn = np.flatnonzero(corners.of_worn)
    count, nodes = len(corners.node), int(corners.node.max()) + 1
    total = np.bincount(corners.node[worn], area[worn], nodes)
    part = csr_array(
        (area[worn] / total[corners.node[worn]], (worn, corners.node[worn])), shape=(count, nodes)
    )
    side = np.flatnonzero(~own)
    direct = csr_array((np.ones(len(column)), (at[column], column)), shape=(count, len(at)))
    by_node = csr_array((np.ones(len(side)), (corners.node[at[side]], side)), shape=(nodes, len(at)))
    return csr_array(direct + part @ by_node)


def _nodewise(corners: Corners, area: np.ndarray) -> csr_array:
    """(c, c) sum over the worn corners of a node, shared out by area: where more than three faces meet, none has its way alone."""
    worn = np.flatnonzero(corners.of_worn)
    shape = (len(corners.node), int(corners.node.max()) + 1)
    one = csr_array((np.ones(len(worn)), (worn, corners.node[worn])), shape=shape)
    total = np.maximum(np.bincount(corners.node[worn], area[worn], shape[1]), 1e-300)
    part = csr_array((area[worn] / total[corners.node[worn]], (worn, corners.node[worn])), shape=shape)
    return csr_array(part @ one.T)


def _to_givers(spread: csr_array, w: np.ndarray) -> csr_array:
    """(c, c) `spread`, weighted by the depth that the neighbours can give; as it is where none has any. Rows sum to 1."""
    able = csr_array(spread * w[None, :])
    total = able.sum(axis=1)
    scale = np.divide(1.0, total, out=np.zeros(len(total)), where=total > 0.0)
    return csr_array(diags_array(scale) @ able + diags_array((total <= 0.0).astype(float)) @ spread)


def _neighbours(corners: Corners, matrix: csr_array) -> csr_array:
    """(c, c) means over the neighbours of a corner and the other corners of its node, weighted by area; rows sum to 1."""
    worn = np.flatnonzero(corners.of_worn)
    shape = (matrix.shape[0], int(corners.node.max()) + 1)
    root = csr_array((np.sqrt(matrix.sum(axis=1)[worn] / 12.0), (worn, corners.node[worn])), shape=shape)
    off = csr_array(matrix + root @ root.T)
    off = csr_array(off - diags_array(off.diagonal()))
    total = off.sum(axis=1)
    scale = np.divide(1.0, total, out=np.zeros(len(total)), where=total > 0.0)
    return csr_array(off.multiply(scale[:, None]))
