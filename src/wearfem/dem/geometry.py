"""Spheres against triangles and planes: which points touch, once each, however a surface is cut.

A sphere touches a surface at its closest point. Where several triangles offer one, three rules decide:

* A candidate whose point does not rise above the tangent plane of a deeper one is no contact of its own: it is the same flat or
  convex neighbourhood, cut into triangles.
* Two candidate contacts with overlaps d1 >= d2, normals n1, n2 and points p1, p2 share one Hertz patch as far as their contact circles
  (radius sqrt(r d1)) overlap: c = max(0, n1 . n2) max(0, 1 - |p1 - p2|^2 / (4 r d1)).
* Each candidate takes the share of its overlap that the others do not already push out: l_i >= 0 with l_i + sum_j c_ij l_j >= d_i,
  one of the two an equality.

On a plane, and over a convex edge, the deepest candidate takes all and the others nothing, to the last bit; in a concave corner with separate
patches both act in full; in between, and from one to the other, the force is continuous. No adjacency is needed: joints between
different surfaces, T-joints and duplicates are seamless too.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from wearfem.dem.motion import STILL, Motion, alike
from wearfem.jit import inlined, kernel
from wearfem.vector import dot, norm
from wearfem.surface import Plane, Surface


SWEEPS = 4096  # of projected Gauss-Seidel at most, for three contacts and more; two are solved in closed form
LEVEL = 1e-9  # part of a radius by which a point must rise above a plane to be above it, not on it


class Geometry(NamedTuple):
    """All triangles and planes of a model, in the frames of their bodies."""

    corner: np.ndarray  # (t, 9) [m]
    normal: np.ndarray  # (t + planes, 3)
    point: np.ndarray  # (planes, 3) [m] on each plane
    facet: np.ndarray  # (t + planes,) int32, among all facets of the model; -1 on planes
    material: np.ndarray  # (t + planes,) int32
    body: np.ndarray  # (t + planes,) int32
    moves: np.ndarray  # (b,) bool
    frame: np.ndarray  # (b,) int32, the first body that moves alike: contacts carry on from one to the other
    extent: np.ndarray  # (b,) [m] farthest point from the pivot, to bound its speed
    cell_origin: np.ndarray  # (b, 3) [m] of a grid of cells over the triangles of each body
    cell_size: np.ndarray  # (b,) [m]
    cell_count: np.ndarray  # (b, 3) int64
    cell_offset: np.ndarray  # (b,) int64
    cell_start: np.ndarray  # (cells + 1,) int64
    cell_triangle: np.ndarray  # (entries,) int32


def geometry(
    walls: Sequence[tuple[Surface | Plane, Motion]],
    number: dict,
    cell: float,
    period: np.ndarray,
    low: np.ndarray,
) -> Geometry:
    """Pack surfaces and planes with their motions. `number` maps materials to their numbers; `cell` [m] is a good cell size.

    Where the domain is periodic, copies of the triangles near its ends let a sphere across the border touch them.
    """
    corners, normals, facets, materials, owners = [np.zeros((0, 9))], [np.zeros((0, 3))], [], [], []
    facet_base = 0
    grids = []
    extents = []
    planes = [(k, wall) for k, (wall, _) in enumerate(walls) if isinstance(wall, Plane)]
    for k, (wall, motion) in enumerate(walls):
        if isinstance(wall, Plane):
            grids.append(None)
            extents.append(0.0)
            continue
        corner, normal, facet = wall.corner.reshape(-1, 9), wall.normal, wall.facet + facet_base
        for axis in range(3):
            if period[axis] > 0.0:
                ends = corner[:, axis::3]
                after = ends.min(axis=1) < low[axis] + cell
                before = ends.max(axis=1) > low[axis] + period[axis] - cell
                shift = np.zeros(9)
                shift[axis::3] = period[axis]
                corner = np.concatenate([corner, corner[after] + shift, corner[before] - shift])
                normal = np.concatenate([normal, normal[after], normal[before]])
                facet = np.concatenate([facet, facet[after], facet[before]])
        facet_base += wall.facet_count
        grids.append((sum(map(len, corners)), corner))
        corners.append(corner)
        normals.append(normal)
        facets.append(facet)
        materials.append(np.full(len(corner), number[wall.material]))
        owners.append(np.full(len(corner), k))
        pivot = np.asarray(motion.centre)
        extents.append(float(np.linalg.norm(wall.point - pivot, axis=1).max()) if motion.rate else 0.0)
    for k, plane in planes:
        direction = np.asarray(plane.normal, float)
        normals.append((direction / np.linalg.norm(direction))[None])
        facets.append(np.array([-1]))
        materials.append(np.array([number[plane.material]]))
        owners.append(np.array([k]))
    empty = [np.zeros(0, int)]
    origin, size = np.zeros((len(walls), 3)), np.ones(len(walls))
    cells, offset, start, entries = (
        np.zeros((len(walls), 3), np.int64),
        np.zeros(len(walls), np.int64),
        [0],
        [np.zeros(0, int)],
    )
    for k, grid in enumerate(grids):
        offset[k] = len(start) - 1
        if grid is None:
            continue
        first, corner = grid
        origin[k], size[k], cells[k], counts, members = _cells_of_triangles(corner, cell)
        start.extend(start[-1] + np.cumsum(counts))
        entries.append(members + first)
    return Geometry(
        corner=np.ascontiguousarray(np.concatenate(corners)),
        normal=np.ascontiguousarray(np.concatenate(normals)),
        point=np.array([p.point for _, p in planes], float).reshape(-1, 3),
        facet=np.concatenate(facets or empty).astype(np.int32),
        material=np.concatenate(materials or empty).astype(np.int32),
        body=np.concatenate(owners or empty).astype(np.int32),
        moves=np.array([not alike(motion, STILL) for _, motion in walls], bool),
        frame=np.array(
            [next(k for k, (_, one) in enumerate(walls) if alike(one, motion)) for _, motion in walls],
            np.int32,
        ),
        extent=np.array(extents),
        cell_origin=origin,
        cell_size=size,
        cell_count=cells,
        cell_offset=offset,
        cell_start=np.array(start, np.int64),
        cell_triangle=np.concatenate(entries).astype(np.int32),
    )


def _cells_of_triangles(corner: np.ndarray, cell: float):
    """A grid over the bounding boxes of triangles: origin, cell size, counts along axes, entries by cell, triangles by cell."""
    box_low, box_high = corner.reshape(-1, 3, 3).min(axis=1), corner.reshape(-1, 3, 3).max(axis=1)
    origin, extent = box_low.min(axis=0), box_high.max(axis=0) - box_low.min(axis=0)
    while np.prod(extent // cell + 1) > 8 * len(corner) + 1000:
        cell *= 1.25
    count = (extent // cell + 1).astype(np.int64)
    low = np.clip(((box_low - origin) // cell).astype(np.int64), 0, count - 1)
    high = np.clip(((box_high - origin) // cell).astype(np.int64), 0, count - 1)
    keys, members = [], []
    for t in range(len(corner)):
        a, b, c = (np.arange(low[t, k], high[t, k] + 1) for k in range(3))
        key = ((a[:, None, None] * count[1] + b[:, None]) * count[2] + c).ravel()
        keys.append(key)
        members.append(np.full(len(key), t))
    key, member = np.concatenate(keys), np.concatenate(members)
    order = np.argsort(key, kind="stable")
    return origin, cell, count, np.bincount(key, minlength=int(np.prod(count))), member[order]


@inlined
def height_above(geometry, item, x, y, z):
    """Signed distance [m] of a point, in the body's frame, from the plane of a triangle or from a plane."""
    triangles = len(geometry.corner)
    if item < triangles:
        px, py, pz = geometry.corner[item, 0], geometry.corner[item, 1], geometry.corner[item, 2]
    else:
        q = item - triangles
        px, py, pz = geometry.point[q, 0], geometry.point[q, 1], geometry.point[q, 2]
    return dot(
        x - px, y - py, z - pz, geometry.normal[item, 0], geometry.normal[item, 1], geometry.normal[item, 2]
    )  # fmt: skip


@inlined
def nearest_on_triangle(geometry, item, x, y, z):
    """The point of a triangle nearest to (x, y, z), and whether it is inside its edges (Ericson 2005, section 5.1.5)."""
    ax, ay, az = geometry.corner[item, 0], geometry.corner[item, 1], geometry.corner[item, 2]
    ux, uy, uz = geometry.corner[item, 3] - ax, geometry.corner[item, 4] - ay, geometry.corner[item, 5] - az
    vx, vy, vz = geometry.corner[item, 6] - ax, geometry.corner[item, 7] - ay, geometry.corner[item, 8] - az
    px, py, pz = x - ax, y - ay, z - az
    d1, d2 = dot(ux, uy, uz, px, py, pz), dot(vx, vy, vz, px, py, pz)
    uu, uv, vv = dot(ux, uy, uz, ux, uy, uz), dot(ux, uy, uz, vx, vy, vz), dot(vx, vy, vz, vx, vy, vz)
    d3, d4, d5, d6 = d1 - uu, d2 - uv, d1 - uv, d2 - vv
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    s, t, inside = 0.0, 0.0, False
    if d1 <= 0.0 and d2 <= 0.0:
        s, t = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        s, t = 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        s, t = 0.0, 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        s, t = d1 / (d1 - d3), 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        s, t = 0.0, d2 / (d2 - d6)
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        s = 1.0 - t
    else:
        scale = 1.0 / (va + vb + vc)
        s, t, inside = vb * scale, vc * scale, True
    return ax + s * ux + t * vx, ay + s * uy + t * vy, az + s * uz + t * vz, inside


@inlined
def touching_point(geometry, item, x, y, z, radius):
    """How a sphere at (x, y, z) in the body's frame touches a triangle or plane: overlap, point, normal towards the centre.

    The overlap is not positive where they do not touch.
    """
    nx, ny, nz = geometry.normal[item, 0], geometry.normal[item, 1], geometry.normal[item, 2]
    height = height_above(geometry, item, x, y, z)
    if height < 0.0:
        nx, ny, nz, height = -nx, -ny, -nz, -height
    overlap, px, py, pz = radius - height, x - height * nx, y - height * ny, z - height * nz
    if overlap > 0.0 and item < len(geometry.corner):
        qx, qy, qz, inside = nearest_on_triangle(geometry, item, x, y, z)
        if not inside:
            px, py, pz = qx, qy, qz
            distance = norm(x - px, y - py, z - pz)
            overlap = radius - distance
            if distance > 0.0:
                nx, ny, nz = (x - px) / distance, (y - py) / distance, (z - pz) / distance
    return overlap, px, py, pz, nx, ny, nz


@inlined
def common(contact, a, b, radius):
    """c of two contacts (rows: overlap, point, normal): how far they push the same way through the same patch."""
    along, square = 0.0, 0.0
    for k in range(3):
        along += contact[a, 4 + k] * contact[b, 4 + k]
        square += (contact[a, 1 + k] - contact[b, 1 + k]) ** 2
    apart = square / (4.0 * radius * max(contact[a, 0], contact[b, 0]))
    return max(along, 0.0) * max(1.0 - apart, 0.0)


@inlined
def rises(contact, a, b, radius):
    """Whether the point of contact a lies above the tangent plane of contact b, as only a concave corner makes it."""
    height = 0.0
    for k in range(3):
        height += (contact[a, 1 + k] - contact[b, 1 + k]) * contact[b, 4 + k]
    return height > LEVEL * radius


@kernel
def share_overlap(contact, count, radius, share):
    """Fill `share` (count,) with the part of its overlap that each contact really has, 0 to 1; returns how many have any."""
    candidates = 0
    for a in range(count):
        share[a] = 1.0
        for b in range(count):
            if b == a or contact[b, 0] < contact[a, 0] or (contact[b, 0] == contact[a, 0] and b > a):
                continue
            if not rises(contact, a, b, radius):
                share[a] = -1.0
                break
        if share[a] > 0.0:
            candidates += 1
    if candidates == 2:
        a = 0
        while share[a] < 0.0:
            a += 1
        b = a + 1
        while share[b] < 0.0:
            b += 1
        c = common(contact, a, b, radius)
        first, second = contact[a, 0] - c * contact[b, 0], contact[b, 0] - c * contact[a, 0]
        if first > 0.0 and second > 0.0:
            share[a] = first / ((1.0 - c * c) * contact[a, 0])
            share[b] = second / ((1.0 - c * c) * contact[b, 0])
        else:
            share[a], share[b] = (1.0 if first > 0.0 else 0.0), (1.0 if second > 0.0 else 0.0)
    elif candidates > 2:
        share_among_many(contact, count, radius, share)
    acting = 0
    for a in range(count):
        share[a] = max(share[a], 0.0)
        if share[a] > 0.0:
            acting += 1
    return acting


@kernel
def share_among_many(contact, count, radius, share):
    """The shares of three candidates and more, those that are not negative, by projected Gauss-Seidel until they stand."""
    for _ in range(SWEEPS):
        largest_change = 0.0
        for a in range(count):
            if share[a] >= 0.0:
                rest = contact[a, 0]
                for b in range(count):
                    if b != a and share[b] > 0.0:
                        rest -= common(contact, a, b, radius) * share[b] * contact[b, 0]
                new = max(rest, 0.0) / contact[a, 0]
                largest_change = max(largest_change, abs(new - share[a]))
                share[a] = new
        if largest_change < 1e-14:
            break
