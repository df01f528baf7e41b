"""Fields from an old mesh of a surface to a new one: nothing lost, nothing beyond what was there, constants untouched."""

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from wearfem.surface import Surface

TRACE = 1e-9  # part of a triangle's area below which an overlap is rounding


def transfer(field: np.ndarray, before: Surface, after: Surface) -> np.ndarray:
    """A facet field on the old surface as one on the new surface.

    Each new facet gets the mean over the old facets that it covers, weighted by the area of their overlap. Where both are plane that
    is the L2 projection and keeps the integral; on a curved surface, whose area the new mesh changes by the square of the edge
    length, what the integral lacks is given back to each facet in proportion to its distance from the largest
    (or smallest) value that it covers.

    Parameters
    ----------
    field
        (f,) or (b, f) on the facets of `before`.
    before, after
        Two meshes of one surface.

    Returns
    -------
    numpy.ndarray
        (g,) or (b, g) on the facets of `after`. Each value lies between the least and the largest that its facet covers, so a constant
        stays what it is; and sum of field x area stays what it is, unless the bounds forbid it: a constant on a surface whose area
        has changed. Then the bounds are kept, and the integral comes as near as they allow.

    Notes
    -----
    Source: conservative interpolation by supermesh, Farrell et al., Comput. Methods Appl. Mech. Eng. 198 (2009) 2632; the bounded
    correction is the one of flux-corrected remapping with one factor (Liska et al., J. Comput. Phys. 229 (2010) 1467).
    """
    share = overlap(before, after)
    mean = share / share.sum(axis=1)[:, None]
    rows = np.atleast_2d(np.asarray(field, float))
    result = []
    for row in rows:
        lower, upper = _bounds(share, row)
        total = row @ before.facet_area
        result.append(balanced(mean @ row, lower, upper, after.facet_area, total))
    return np.array(result).reshape(*np.shape(field)[:-1], after.facet_count)


def balanced(
    value: np.ndarray, lower: np.ndarray, upper: np.ndarray, weight: np.ndarray, total: float
) -> np.ndarray:
    """The values moved towards a bound, all by one part of their way, until sum of weight x value is `total`; at most to the bound."""
    value = np.clip(value, lower, upper)
    lack = total - weight @ value
    way = (upper if lack > 0.0 else lower) - value
    room = weight @ way
    return value + min(lack / room, 1.0) * way if room else value


def overlap(before: Surface, after: Surface) -> csr_array:
    """(g, f) [m2] area that each new facet shares with each old one, measured in the plane of the new triangle.

    A new facet that covers nothing, such as a sliver over a gap, counts as covering the old triangle nearest to it.
    """
    new, old = after.corner, before.corner
    centre, other = new.mean(axis=1), old.mean(axis=1)
    reach = np.linalg.norm(new - centre[:, None], axis=2).max(axis=1)
    extent = np.linalg.norm(old - other[:, None], axis=2).max(axis=1)
    rows, columns = _near(centre, reach, other, extent)
    near = reach[rows] + extent[columns]
    gap = other[columns] - centre[rows]
    normal = after.normal[rows]
    level = np.abs(np.einsum("pi,pi->p", gap, normal)) <= 0.5 * near
    level &= np.einsum("pi,pi->p", normal, before.normal[columns]) > 0.5
    rows, columns, normal = rows[level], columns[level], normal[level]
    east = new[rows, 1] - new[rows, 0]
    east /= np.linalg.norm(east, axis=1, keepdims=True)
    frame = np.stack([east, np.cross(normal, east)], axis=2)
    origin = centre[rows][:, None]
    shared = clipped_area((old[columns] - origin) @ frame, (new[rows] - origin) @ frame)
    kept = shared > TRACE * np.minimum(after.area[rows], before.area[columns])
    rows, columns, shared = rows[kept], columns[kept], shared[kept]
    bare = np.setdiff1d(np.arange(after.facet_count), after.facet[rows])
    bare = np.flatnonzero(np.isin(after.facet, bare))
    nearest = cKDTree(other).query(centre[bare])[1] if len(bare) else bare
    rows, columns = np.concatenate([rows, bare]), np.concatenate([columns, nearest])
    shared = np.concatenate([shared, after.area[bare]])
    shape = (after.facet_count, before.facet_count)
    return coo_array((shared, (after.facet[rows], before.facet[columns])), shape=shape).tocsr()


def _near(
    centre: np.ndarray, reach: np.ndarray, other: np.ndarray, extent: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of spheres that touch. Large ones are asked for apart from small ones, so that one large triangle does not cost all."""
    tree, pairs = cKDTree(centre), []
    edges = np.unique(np.concatenate([np.quantile(extent, [0.5, 0.9, 0.99]), [extent.max()]]))
    lower = -np.inf
    for upper in edges:
        member = np.flatnonzero((extent > lower) & (extent <= upper))
        lower = upper
        if not len(member):
            continue
        found = tree.query_ball_point(other[member], extent[member] + reach.max())
        pairs.append(
            (np.concatenate([np.asarray(f, int) for f in found]), np.repeat(member, [len(f) for f in found]))
        )
    rows, columns = (np.concatenate(part) for part in zip(*pairs, strict=True))
    touch = np.linalg.norm(centre[rows] - other[columns], axis=1) <= reach[rows] + extent[columns]
    return rows[touch], columns[touch]


def clipped_area(polygon: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """(p,) [m2] area of a convex polygon (p, k, 2) inside a triangle (p, 3, 2), both anticlockwise.

    Sutherland and Hodgman 1974, Commun. ACM 17, 32: cut along one side of the triangle after the other, all pairs at once. A polygon with
    fewer corners than the array has places repeats its last one.
    """
    for side in range(3):
        a = triangle[:, side]
        along = triangle[:, (side + 1) % 3] - a
        height = (
            along[:, None, 0] * (polygon - a[:, None])[..., 1]
            - along[:, None, 1] * (polygon - a[:, None])[..., 0]
        )
        following, next_height = np.roll(polygon, -1, axis=1), np.roll(height, -1, axis=1)
        inside, crossing = height >= 0.0, (height >= 0.0) != (next_height >= 0.0)
        part = np.divide(height, height - next_height, out=np.zeros_like(height), where=crossing)
        cut = polygon + part[..., None] * (following - polygon)
        count, places = polygon.shape[:2]
        every = np.stack([polygon, cut], axis=2).reshape(count, 2 * places, 2)
        kept = np.stack([inside, crossing], axis=2).reshape(count, 2 * places)
        corners = kept.sum(axis=1)
        place = np.minimum(np.arange(max(corners.max(initial=0), 1)), np.maximum(corners - 1, 0)[:, None])
        order = np.take_along_axis(np.argsort(~kept, axis=1, kind="stable"), place, axis=1)
        polygon = np.take_along_axis(every, order[..., None], axis=1)
        polygon[~kept.any(axis=1)] = 0.0
    x, y = np.moveaxis(polygon - polygon[:, :1], 2, 0)
    return 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)


def _bounds(share: csr_array, field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest value that each new facet covers."""
    covered = field[share.indices]
    start = share.indptr[:-1]
    return np.minimum.reduceat(covered, start), np.maximum.reduceat(covered, start)


def transfer_nodes(
    field: np.ndarray, node: np.ndarray, triangle: np.ndarray, new_node: np.ndarray, new_triangle: np.ndarray
) -> np.ndarray:
    """A nodal field (n,) of a triangulated surface, such as the thickness of a shell, as one on the nodes (m,) of a new mesh.

    Linear interpolation at the nearest point of the old surface, then balanced as in `transfer`: the integral of the linear field is
    kept, within the values at the corners of the triangle found.
    """
    found, part = nearest_point(new_node, node, triangle)
    corner = field[triangle[found]]
    value = np.einsum("mk,mk->m", part, corner)
    total = _lumped(node, triangle) @ field
    return balanced(value, corner.min(axis=1), corner.max(axis=1), _lumped(new_node, new_triangle), total)


def _lumped(node: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """(n,) [m2] a third of the triangles around each node: the integral of a linear field is its sum weighted by this"""
    a, b, c = np.moveaxis(node[triangle], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.bincount(triangle.ravel(), np.repeat(area, 3), len(node))


def nearest_point(
    point: np.ndarray, node: np.ndarray, triangle: np.ndarray, among: int = 16
) -> tuple[np.ndarray, np.ndarray]:
    """The triangle (m,) nearest to each point, and the weights (m, 3) of its corners at the nearest place.

    Looked for among the triangles around the nearest nodes' centres: those with the `among` nearest centres.
    """
    a, b, c = np.moveaxis(node[triangle], 1, 0)
    among = min(among, len(triangle))
    number = cKDTree((a + b + c) / 3.0).query(point, among)[1].reshape(len(point), among)
    corner = node[triangle[number]]  # (m, among, 3, 3)
    away = point[:, None] - corner[:, :, 0]
    first, second = corner[:, :, 1] - corner[:, :, 0], corner[:, :, 2] - corner[:, :, 0]
    aa, ab, bb = (
        np.einsum("mki,mki->mk", x, y) for x, y in ((first, first), (first, second), (second, second))
    )
    da, db = np.einsum("mki,mki->mk", away, first), np.einsum("mki,mki->mk", away, second)
    u, v = (bb * da - ab * db) / (aa * bb - ab**2), (aa * db - ab * da) / (aa * bb - ab**2)
    choices = [np.stack([1.0 - u - v, u, v], axis=2)]
    inside = (choices[0] >= 0.0).all(axis=2)
    for k in range(3):  # the nearest place on each side, for points beyond it
        begin, end = corner[:, :, k], corner[:, :, (k + 1) % 3]
        part = np.einsum("mki,mki->mk", point[:, None] - begin, end - begin) / ((end - begin) ** 2).sum(
            axis=2
        )
        weight = np.zeros_like(choices[0])
        weight[:, :, k], weight[:, :, (k + 1) % 3] = 1.0 - np.clip(part, 0, 1), np.clip(part, 0, 1)
        choices.append(weight)
    weight = np.stack(choices, axis=2)  # (m, among, 4, 3)
    distance = np.linalg.norm(np.einsum("mkcj,mkji->mkci", weight, corner) - point[:, None, None], axis=3)
    distance[:, :, 0][~inside] = np.inf
    best = distance.reshape(len(point), -1).argmin(axis=1)
    row = np.arange(len(point))
    return number[row, best // 4], weight.reshape(len(point), -1, 3)[row, best]
