"""Which triangle lies beyond which edge: borders, sharp edges, and the smooth parts between them."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


def neighbours(point: np.ndarray, triangle: np.ndarray, sharp: float) -> np.ndarray:
    """The same edge in the neighbouring triangle, for the directed edges 3 t + k from corner k of triangle t to the next.

    Parameters
    ----------
    point
        (p, 3) [m]
    triangle
        (t, 3) oriented alike, as in a `Surface`.
    sharp
        [rad] Edges whose two triangles have normals further apart than this are borders.

    Returns
    -------
    numpy.ndarray
        (3 t,) directed edge 3 s + j in the neighbour s, run through backwards; -1 at borders.
    """
    begin, end = triangle.ravel(), np.roll(triangle, -1, axis=1).ravel()
    forward, backward = begin * len(point) + end, end * len(point) + begin
    order = np.argsort(forward)
    place = np.minimum(np.searchsorted(forward[order], backward), len(order) - 1)
    twin = np.where(forward[order[place]] == backward, order[place], -1)
    a, b, c = np.moveaxis(point[triangle], 1, 0)
    normal = np.cross(b - a, c - a)
    normal = np.repeat(normal / np.linalg.norm(normal, axis=1, keepdims=True), 3, axis=0)
    apart = np.linalg.norm(normal - normal[twin], axis=1) > 2.0 * np.sin(0.5 * sharp)
    return np.where(apart, -1, twin)


def parts(twin: np.ndarray) -> np.ndarray:
    """(t,) number of the connected part that each triangle belongs to, where `twin` are its `neighbours`"""
    inner = np.flatnonzero(twin >= 0)
    pair = (np.ones(len(inner), bool), (inner // 3, twin[inner] // 3))
    return connected_components(coo_array(pair, shape=(len(twin) // 3,) * 2), directed=False)[1]
