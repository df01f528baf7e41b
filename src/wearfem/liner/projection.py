"""From a depth by facet to a depth by corner: positive, within the values around, and exact in volume."""

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import cg

from wearfem.errors import UserError
from wearfem.liner.corners import Corners, facet_vector


def mass(corners: Corners, node: np.ndarray) -> csr_array:
    """(c, c) [m2] consistent mass of linear fields on the worn face; rows sum to each corner's area"""
    at, share = _worn_triangles(corners, node)
    count = len(corners.node)
    value = share[:, None, None] * (1.0 + np.eye(3)) / 12.0
    row, column = np.broadcast_arrays(at[:, :, None], at[:, None, :])
    return csr_array(coo_array((value.ravel(), (row.ravel(), column.ravel())), shape=(count, count)))


def _worn_triangles(corners: Corners, node: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Merged corners (t, 3) of the worn triangles and their weighted areas (t,) [m2]."""
    worn = corners.worn[corners.facet]
    a, b, c = np.moveaxis(node[corners.triangle[worn]], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return corners.corner[worn], corners.weight[worn] * area


def to_corners(corners: Corners, node: np.ndarray, depth: np.ndarray, *, upwind: bool = True) -> np.ndarray:
    """Depth (c,) [m] at the merged corners whose volume is that of the facets, sum of depth x area.

    The low order depth shares each facet's volume equally among its corners. Limited fluxes along the edges of the surface, M_ij the
    consistent mass, bring it towards

    - the L2 projection: M_ij (w_i - w_j), w its solution, and
    - the upwind depth: 2 M_ij (D_i - D_j), D_i = -s_i (largest - least depth around i) / 2. s is 1 where the facets around i
      form a valley, -1 on a peak, so a valley follows its slower facets and a peak its faster: Roe's flux of the
      Hamilton-Jacobi equation. As differences of D the fluxes lose no volume and are of third order where the surface
      is smooth; at a kink, they
      give the shock of the entropy solution instead of ripples.

    Parameters
    ----------
    corners, node
        Of the surface as it is, node (n, 3) [m].
    depth
        (f,) [m] by worn facet, 0 or more.
    upwind
        Whether to use the second flux.

    Source
    ------
    Zalesak 1979, J. Comput. Phys. 31, eqs. 10-14 (limiter); Kuzmin and Turek 2002, J. Comput. Phys. 175 (fluxes of the
    consistent mass); Roe
    1981, J. Comput. Phys. 43 (upwinding by the jump); Osher and Shu 1991, SIAM J. Numer. Anal. 28 (as a Hamiltonian).

    Valid for
    ---------
    any triangulation; within each corner's bounds, the least and the largest depth of the facets that meet there.
    """
    at, area = _worn_triangles(corners, node)
    count = len(corners.node)
    owner = corners.facet[corners.worn[corners.facet]]
    by_corner, by_depth, by_area = (
        at.ravel(),
        np.repeat(depth[owner], 3),
        np.repeat(area / 3.0, 3),
    )
    lumped = np.bincount(by_corner, by_area, count)
    load = np.bincount(by_corner, by_area * by_depth, count)
    inside = np.maximum(lumped, 1e-300)
    low = load / inside
    least, largest = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(least, by_corner, by_depth)
    np.maximum.at(largest, by_corner, by_depth)

    matrix = mass(corners, node)
    target = _solve(matrix, load, low, corners.of_worn)
    if upwind:
        spread = np.where(corners.of_worn, largest - least, 0.0)
        target = target - valley(corners, node, depth) * spread
    edge = coo_array(matrix)
    i, j = edge.coords
    flux = edge.data * (target[i] - target[j])
    flux[i == j] = 0.0
    gain = np.bincount(i, np.maximum(flux, 0.0), count)
    loss = np.bincount(i, np.minimum(flux, 0.0), count)
    room_up = np.where(corners.of_worn, (np.maximum(largest, low) - low) * lumped, 0.0)
    room_down = np.where(corners.of_worn, (np.minimum(least, low) - low) * lumped, 0.0)
    up = np.minimum(1.0, np.divide(room_up, gain, out=np.ones(count), where=gain > 0.0))
    down = np.minimum(1.0, np.divide(room_down, loss, out=np.ones(count), where=loss < 0.0))
    limit = np.where(flux > 0.0, np.minimum(up[i], down[j]), np.minimum(down[i], up[j]))
    return np.maximum(low + np.bincount(i, limit * flux, count) / inside, 0.0)


def _solve(matrix: csr_array, load: np.ndarray, start: np.ndarray, used: np.ndarray) -> np.ndarray:
    """The L2 projection by conjugate gradients; the mass matrix is well conditioned on any mesh once scaled by its diagonal."""
    if not load.any():
        return start
    inside = np.flatnonzero(used)
    part = matrix[inside][:, inside]
    scale = 1.0 / np.sqrt(part.diagonal())
    scaled = csr_array(part.multiply(scale[:, None]).multiply(scale[None, :]))
    found, failed = cg(scaled, scale * load[inside], x0=start[inside] / scale, rtol=1e-13, maxiter=200)
    if failed:
        raise UserError(
            f"the worn face has triangles without area among its {len(load)} corners, so a depth cannot be brought to its nodes; "
            "mend the mesh there."
        )
    result = start.copy()
    result[inside] = scale * found
    return result


def valley(corners: Corners, node: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """(c,) from 1, where all edges that meet at a corner are valleys, to -1 for peaks; 0 on planes and saddles.

    s = sum l angle / sum l (|angle| + |difference of depth| / distance): an edge counts as far as it turns by more than this very step
    turns it, so noise on a plane has no sign.
    """
    left, right = corners.edge[:, 0], corners.edge[:, 1]
    vector = facet_vector(node, corners.outline)
    normal = vector / np.linalg.norm(vector, axis=1, keepdims=True)
    centre = node[corners.outline].mean(axis=1)
    apart = centre[right] - centre[left]
    distance = np.linalg.norm(apart, axis=1)
    ends = corners.node[corners.edge_corner]
    length = np.linalg.norm(node[ends[:, 0]] - node[ends[:, 1]], axis=1)
    angle = -((normal[right] - normal[left]) * apart).sum(axis=1) / distance
    made = np.abs(depth[right] - depth[left]) / distance
    count = len(corners.node)
    at = corners.edge_corner.ravel()
    total = np.bincount(at, np.repeat(length * angle, 2), count)
    size = np.bincount(at, np.repeat(length * (np.abs(angle) + made), 2), count)
    return np.divide(total, size, out=np.zeros(count), where=size > 0.0)
