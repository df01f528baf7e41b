"""The corners of a surface: which facets meet smoothly at a node, and which across a sharp edge."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from wearfem.liner.mesh import SolidMesh

SHARP = np.pi / 6.0  # [rad] an edge that turns by more keeps two depths, one a side


@dataclass(frozen=True)
class Corners:
    """Facets, the triangles that stand for them, and their corners merged where the surface is smooth.

    Where facets meet smoothly at a node their corners there are one: one normal and one depth. Across a sharp edge, and
    across the border of the worn face, they are two. A dart, an edge that is sharp at one end and smooth at the other, has two at the
    one and one at the other. A facet of four corners is covered twice by half triangles, once by each diagonal, so that
    its volume is that of the bilinear facet and no diagonal is preferred.
    """

    outline: np.ndarray  # (k, 3|4) nodes of all facets; the worn ones first, in their order
    worn: np.ndarray  # (k,) bool by facet
    triangle: np.ndarray  # (t, 3) nodes
    facet: np.ndarray  # (t,) the facet of each triangle
    weight: np.ndarray  # (t,) 1, or 1/2 for facets of four corners
    corner: np.ndarray  # (t, 3) merged corner that each corner of a triangle belongs to
    node: np.ndarray  # (c,) node of each merged corner
    of_worn: np.ndarray  # (c,) bool: the merged corner belongs to worn facets
    edge: np.ndarray  # (s, 2) facets on both sides of each inner edge of the worn face that is smooth
    edge_corner: np.ndarray  # (s, 2) merged corners at its ends


def cover(facet: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (t, 3) of triangles among the corners of facets, the facet (t,), and the weight (t,)."""
    count, corners = facet.shape
    if corners == 3:
        return np.tile([0, 1, 2], (count, 1)), np.arange(count), np.ones(count)
    both = np.array([[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3]])
    return np.tile(both, (count, 1)), np.repeat(np.arange(count), 4), np.full(4 * count, 0.5)


def facet_vector(node: np.ndarray, facet: np.ndarray) -> np.ndarray:
    """(k, 3) [m2] area times mean normal of each facet"""
    first = node[facet[:, 0]]
    if facet.shape[1] == 3:
        return 0.5 * np.cross(node[facet[:, 1]] - first, node[facet[:, 2]] - first)
    return 0.5 * np.cross(node[facet[:, 2]] - first, node[facet[:, 3]] - node[facet[:, 1]])


def facet_area(node: np.ndarray, facet: np.ndarray) -> np.ndarray:
    """(k,) [m2] area of each facet; of four corners, the mean of what its two diagonals give"""
    place, owner, weight = cover(facet)
    a, b, c = np.moveaxis(node[np.take_along_axis(facet[owner], place, axis=1)], 1, 0)
    return np.bincount(owner, 0.5 * weight * np.linalg.norm(np.cross(b - a, c - a), axis=1), len(facet))


def find_corners(
    node: np.ndarray, worn: np.ndarray, other: np.ndarray, sharp: float = SHARP, whole: bool = False
) -> Corners:
    """Merge the corners of a surface.

    Parameters
    ----------
    node
        (n, 3) [m].
    worn, other
        (f, 3|4) and (k, 3|4) facets that wear and that do not, oriented alike.
    sharp
        [rad] an edge that turns by more is sharp.
    whole
        No edge is sharp and no border counts: one corner a node, as for a shell, whose thickness has one value a node.
    """
    facet = np.concatenate([worn, other])
    is_worn = np.arange(len(facet)) < len(worn)
    count, sides = facet.shape
    vector = facet_vector(node, facet)
    normal = vector / np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-300)

    number = np.arange(count * sides).reshape(count, sides)
    begin, end = facet, np.roll(facet, -1, axis=1)
    key = np.sort(np.stack([begin.ravel(), end.ravel()], axis=1), axis=1)
    order = np.lexsort((number.ravel(), key[:, 1], key[:, 0]))
    same = (key[order[1:]] == key[order[:-1]]).all(axis=1)
    single = np.concatenate([[True], ~same])
    run = np.cumsum(single) - 1
    pair = np.flatnonzero(same & (np.bincount(run)[run[1:]] == 2))
    p, q = (
        order[pair],
        order[pair + 1],
    )  # the same edge seen from its two facets, run through in opposite senses
    left, right = p // sides, q // sides
    along = (normal[left] * normal[right]).sum(axis=1)
    smooth = (along > np.cos(sharp)) & (is_worn[left] == is_worn[right])
    if whole:
        smooth[:] = True
    p, q, left, right = p[smooth], q[smooth], left[smooth], right[smooth]
    p_end = left * sides + (p % sides + 1) % sides
    q_end = right * sides + (q % sides + 1) % sides
    one, two = np.concatenate([p, p_end]), np.concatenate([q_end, q])
    if whole:  # triangles that touch only in a node share it too
        first = np.unique(facet.ravel(), return_index=True, return_inverse=True)
        one, two = first[1][first[2].ravel()], number.ravel()
    joined = coo_array((np.ones(len(one)), (one, two)), shape=(number.size, number.size))
    corners, label = connected_components(joined, directed=False)
    label = label.reshape(count, sides)
    at = np.empty(corners, np.int64)
    at[label] = facet
    of_worn = np.zeros(corners, bool)
    of_worn[label[: len(worn)]] = True

    place, owner, weight = cover(facet)
    inner = is_worn[left] & is_worn[right]
    ends = np.stack([label.ravel()[p], label.ravel()[p_end]], axis=1)
    return Corners(
        facet,
        is_worn,
        np.take_along_axis(facet[owner], place, axis=1),
        owner,
        weight,
        np.take_along_axis(label[owner], place, axis=1),
        at,
        of_worn,
        np.stack([left, right], axis=1)[inner],
        ends[inner],
    )


def unworn(mesh: SolidMesh) -> np.ndarray:
    """(k, 3|4) the facets of the boundary that do not wear"""
    boundary = mesh.boundary
    every = np.sort(np.concatenate([mesh.wear, boundary]), axis=1)
    _, inverse = np.unique(every, axis=0, return_inverse=True)
    inverse = inverse.ravel()
    return boundary[~np.isin(inverse[len(mesh.wear) :], inverse[: len(mesh.wear)])]
