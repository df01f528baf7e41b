"""Spheres against triangles and planes: which points touch, once each, however a surface is cut.

A sphere touches a surface at its closest point. Where several triangles offer one, three rules decide:

* A candidate whose point does not rise above the tangent plane of a deeper one is no contact of its own: it is the same flat
  or convex neighbourhood, cut into triangles.
* Two candidate contacts with overlaps d1 >= d2, normals n1, n2 and points p1, p2 share one Hertz patch as far as their
  contact circles (radius sqrt(r d1)) overlap: c = max(0, n1 . n2) max(0, 1 - |p1 - p2|^2 / (4 r d1)).
* Each candidate takes the share of its overlap that the others do not already push out:
  l_i >= 0 with l_i + sum_j c_ij l_j >= d_i, one of the two an equality.

On a plane, and over a convex edge, the deepest candidate takes all and the others nothing, to the last bit; in a concave
corner with separate patches both act in full; in between, and from one to the other, the force is continuous. No adjacency
is needed: joints between different surfaces, T-joints and duplicates are seamless too.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from wearfem.dem.motion import Motion, alike
from wearfem.jit import inlined, kernel
from wearfem.material import Material
from wearfem.surface import Plane, Surface
from wearfem.vector import cross, dot, norm

SWEEPS = 4096  # of projected Gauss-Seidel at most, for three contacts and more; two are solved in closed form
LEVEL = 1e-9  # part of a radius by which a point must rise above a plane to be above it, not on it
RIM = 1e-6  # part of a radius by which a face reaches beyond its edges


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
    number: dict[Material, int],
    cell: float,
    period: np.ndarray,
    low: np.ndarray,
) -> Geometry:
    """Pack surfaces and planes with their motions. `number` maps materials to their numbers; `cell` [m] is a good cell size.

    Where the domain is periodic, copies of the triangles near its ends let a sphere across the border touch them.
    """
    count = len(walls)
    corners, normals, facets = [np.zeros((0, 9))], [np.zeros((0, 3))], [np.zeros(0, int)]
    materials, owners = [np.zeros(0, int)], [np.zeros(0, int)]
    extent = np.zeros(count)
    origin, size, cells = np.zeros((count, 3)), np.ones(count), np.zeros((count, 3), np.int64)
    offset, starts, entries = np.zeros(count, np.int64), [np.zeros(1, np.int64)], [np.zeros(0, int)]
    facet_base = triangle_base = 0
    for k, (shape, motion) in enumerate(walls):
        offset[k] = sum(map(len, starts)) - 1
        if isinstance(shape, Plane):
            continue
        source, shift = _periodic_copies(shape.corner, cell, period, low)
        corner = shape.corner[source] + shift[:, None, :]
        origin[k], size[k], cells[k], per_cell, members = _cells_of_triangles(corner, cell)
        starts.append(starts[-1][-1] + np.cumsum(per_cell))
        entries.append(members + triangle_base)
        corners.append(corner.reshape(-1, 9))
        normals.append(shape.normal[source])
        facets.append(shape.facet[source] + facet_base)
        materials.append(np.full(len(source), number[shape.material]))
        owners.append(np.full(len(source), k))
        if motion.rate:
            extent[k] = np.linalg.norm(shape.point - np.asarray(motion.centre), axis=1).max()
        facet_base += shape.facet_count
        triangle_base += len(source)
    planes = [(k, shape) for k, (shape, _) in enumerate(walls) if isinstance(shape, Plane)]
    for k, plane in planes:
        direction = np.asarray(plane.normal, float)
        normals.append((direction / np.linalg.norm(direction))[None])
        facets.append(np.array([-1]))
        materials.append(np.array([number[plane.material]]))
        owners.append(np.array([k]))
    return Geometry(
        corner=np.ascontiguousarray(np.concatenate(corners)),
        normal=np.ascontiguousarray(np.concatenate(normals)),
        point=np.array([plane.point for _, plane in planes], float).reshape(-1, 3),
        facet=np.concatenate(facets).astype(np.int32),
        material=np.concatenate(materials).astype(np.int32),
        body=np.concatenate(owners).astype(np.int32),
        moves=np.array([motion.moves for _, motion in walls], bool),
        frame=np.array(
            [next(k for k, (_, one) in enumerate(walls) if alike(one, motion)) for _, motion in walls],
            np.int32,
        ),
        extent=extent,
        cell_origin=origin,
        cell_size=size,
        cell_count=cells,
        cell_offset=offset,
        cell_start=np.concatenate(starts),
        cell_triangle=np.concatenate(entries).astype(np.int32),
    )


def _periodic_copies(
    corner: np.ndarray, cell: float, period: np.ndarray, low: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (k,) and shifts (k, 3) [m]: all triangles where they are, then copies beyond the ends of periodic axes."""
    source, shift = np.arange(len(corner)), np.zeros((len(corner), 3))
    for axis in np.flatnonzero(period):
        along = corner[source][:, :, axis] + shift[:, None, axis]
        step = period[axis] * np.eye(3)[axis]
        after = along.min(axis=1) < low[axis] + cell
        before = along.max(axis=1) > low[axis] + period[axis] - cell
        shift = np.concatenate([shift, shift[after] + step, shift[before] - step])
        source = np.concatenate([source, source[after], source[before]])
    return source, shift


def _cells_of_triangles(
    corner: np.ndarray, cell: float
) -> tuple[np.ndarray, float, np.ndarray, np.ndarray, np.ndarray]:
    """A grid over the boxes around triangles: origin, cell size, cells along axes, triangles in each cell, and which."""
    box_low, box_high = corner.min(axis=1), corner.max(axis=1)
    origin, extent = box_low.min(axis=0), box_high.max(axis=0) - box_low.min(axis=0)
    while np.prod(np.floor(extent / cell) + 1) > 8 * len(corner) + 1000:
        cell *= 1.25
    cells = (extent // cell + 1).astype(np.int64)
    low = np.clip(((box_low - origin) // cell).astype(np.int64), 0, cells - 1)
    span = np.clip(((box_high - origin) // cell).astype(np.int64), 0, cells - 1) - low + 1
    copies = np.prod(span, axis=1)
    member = np.repeat(np.arange(len(corner)), copies)
    within = np.arange(len(member)) - np.repeat(np.cumsum(copies) - copies, copies)
    low, span = low[member], span[member]
    place = low + np.stack(
        [within // (span[:, 1] * span[:, 2]), within // span[:, 2] % span[:, 1], within % span[:, 2]], 1
    )
    key = (place[:, 0] * cells[1] + place[:, 1]) * cells[2] + place[:, 2]
    per_cell = np.bincount(key, minlength=int(np.prod(cells)))
    return origin, cell, cells, per_cell, member[np.argsort(key, kind="stable")]


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

    The overlap is not positive where they do not touch. A face reaches a trifle (RIM) beyond its edges: so close to a joint
    the edge of the next triangle lies as deep as the face to the last bit, but its normal would be tilted by up to RIM.
    """
    nx, ny, nz = geometry.normal[item, 0], geometry.normal[item, 1], geometry.normal[item, 2]
    height = height_above(geometry, item, x, y, z)
    if height < 0.0:
        nx, ny, nz, height = -nx, -ny, -nz, -height
    overlap, px, py, pz = radius - height, x - height * nx, y - height * ny, z - height * nz
    if overlap > 0.0 and item < len(geometry.corner):
        qx, qy, qz, inside = nearest_on_triangle(geometry, item, x, y, z)
        dx, dy, dz = qx - px, qy - py, qz - pz
        if not inside and dot(dx, dy, dz, dx, dy, dz) > RIM * RIM * radius * radius:
            px, py, pz = qx, qy, qz
            distance = norm(x - px, y - py, z - pz)
            overlap = radius - distance
            if distance > 0.0:
                nx, ny, nz = (x - px) / distance, (y - py) / distance, (z - pz) / distance
    return overlap, px, py, pz, nx, ny, nz


@inlined
def well_inside(geometry, item, x, y, z, margin):
    """Whether a point on a triangle lies farther than `margin` [m] from all its edges."""
    nx, ny, nz = geometry.normal[item, 0], geometry.normal[item, 1], geometry.normal[item, 2]
    inside = True
    for k in range(3):
        a, b = 3 * k, (3 * k + 3) % 9
        ux = geometry.corner[item, b] - geometry.corner[item, a]
        uy = geometry.corner[item, b + 1] - geometry.corner[item, a + 1]
        uz = geometry.corner[item, b + 2] - geometry.corner[item, a + 2]
        px, py, pz = (
            x - geometry.corner[item, a],
            y - geometry.corner[item, a + 1],
            z - geometry.corner[item, a + 2],
        )
        cx, cy, cz = cross(ux, uy, uz, px, py, pz)
        inside = inside and dot(cx, cy, cz, nx, ny, nz) > margin * norm(ux, uy, uz)
    return inside


@inlined
def lies_below(geometry, item, px, py, pz, nx, ny, nz, level):
    """Whether a triangle rises nowhere by more than `level` [m] above the plane through (px, py, pz) with normal n."""
    highest = -math.inf
    for k in range(3):
        dx = geometry.corner[item, 3 * k] - px
        dy = geometry.corner[item, 3 * k + 1] - py
        dz = geometry.corner[item, 3 * k + 2] - pz
        highest = max(highest, dot(dx, dy, dz, nx, ny, nz))
    return highest <= level


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
