"""Who may touch which wall: particles near surfaces and planes, their candidates, and the contacts handed on."""

import math
from typing import NamedTuple

import numpy as np

from wearfem.dem.geometry import height_above, nearest_on_triangle
from wearfem.dem.motion import point_into_body
from wearfem.jit import kernel, parallel, prange
from wearfem.vector import norm

MOST_TOUCHING = 6  # wall contacts of one particle with a history

# Columns of a wall contact's record: contact point and normal in the body's frame, contact.Memory, share of the overlap, and the
# number of its triangle or plane.
POINT, DIRECTION, MEMORY, SHARE, ITEM = 0, 3, 6, 14, 15
RECORD = 16


class WallList(NamedTuple):
    """Particles near walls, the triangles and planes they may touch, and their contacts, one row a particle."""

    particle: np.ndarray  # (m,) int32, ascending
    row_of: np.ndarray  # (n,) int32, -1 for particles away from walls
    candidate_start: np.ndarray  # (m + 1,) int64
    candidate: np.ndarray  # (k,) int32, number of a triangle or plane
    body: np.ndarray  # (m, MOST_TOUCHING) int32, of the contacts with history; -1 where there is none
    record: np.ndarray  # (m, MOST_TOUCHING, RECORD)
    chunk_start: np.ndarray  # (chunks + 1,) int64, first row of a chunk


@kernel
def near_walls(geometry, pose, position, radius, skin, low, high, counts, candidates):
    """Candidates of particles [low, high): `counts` (n,) each; listed in `candidates` if there is room. Returns their number.

    A triangle or plane is a candidate if it is within reach.
    """
    found = 0
    bodies = len(geometry.extent)
    triangles = len(geometry.corner)
    for i in range(low, high):
        before = found
        reach = radius[i] + skin
        for plane in range(triangles, len(geometry.normal)):
            x, y, z = point_into_body(
                pose, geometry.body[plane], position[i, 0], position[i, 1], position[i, 2]
            )
            if abs(height_above(geometry, plane, x, y, z)) < reach:
                if found < len(candidates):
                    candidates[found] = plane
                found += 1
        for body in range(bodies):
            if geometry.cell_count[body, 0] == 0:
                continue
            x, y, z = point_into_body(pose, body, position[i, 0], position[i, 1], position[i, 2])
            found = _near_triangles(geometry, body, x, y, z, reach, found, before, candidates)
        counts[i] = found - before
    return found


@kernel
def _near_triangles(geometry, body, x, y, z, reach, found, before, candidates):
    """Append the triangles of one body within reach of a point in its frame, each once."""
    size = geometry.cell_size[body]
    cx, cy, cz = geometry.cell_count[body, 0], geometry.cell_count[body, 1], geometry.cell_count[body, 2]
    ox, oy, oz = (
        x - geometry.cell_origin[body, 0],
        y - geometry.cell_origin[body, 1],
        z - geometry.cell_origin[body, 2],
    )
    a0, a1 = max(int(math.floor((ox - reach) / size)), 0), min(int(math.floor((ox + reach) / size)), cx - 1)
    b0, b1 = max(int(math.floor((oy - reach) / size)), 0), min(int(math.floor((oy + reach) / size)), cy - 1)
    c0, c1 = max(int(math.floor((oz - reach) / size)), 0), min(int(math.floor((oz + reach) / size)), cz - 1)
    mine = found
    for a in range(a0, a1 + 1):
        for b in range(b0, b1 + 1):
            for c in range(c0, c1 + 1):
                cell = geometry.cell_offset[body] + (a * cy + b) * cz + c
                for k in range(geometry.cell_start[cell], geometry.cell_start[cell + 1]):
                    t = geometry.cell_triangle[k]
                    if abs(height_above(geometry, t, x, y, z)) >= reach:
                        continue
                    px, py, pz, _ = nearest_on_triangle(geometry, t, x, y, z)
                    if norm(x - px, y - py, z - pz) >= reach:
                        continue
                    known = False
                    for m in range(mine, min(found, len(candidates))):
                        known = known or candidates[m] == t
                    if not known:
                        if found < len(candidates):
                            candidates[found] = t
                        found += 1
    return found


@parallel
def near_walls_all(geometry, pose, position, radius, skin, bounds, counts, candidates, found):
    """`near_walls` for all chunks."""
    for chunk in prange(len(bounds) - 1):
        found[chunk] = near_walls(
            geometry,
            pose,
            position,
            radius,
            skin,
            bounds[chunk],
            bounds[chunk + 1],
            counts,
            candidates[chunk],
        )


def list_walls(geometry, pose, position, radius, bounds, skin, order, old):
    """Particles near walls and their candidates, with the contacts of `old` handed on; `order` as in `hand_on_memory`."""
    chunks, count = len(bounds) - 1, len(radius)
    counts, found = np.zeros(count, np.int32), np.zeros(chunks, np.int64)
    room = max(64, 4 * len(old.candidate) // chunks)
    while True:
        candidates = np.empty((chunks, room), np.int32)
        if chunks == 1:  # no threads, and no code for them to compile
            found[0] = near_walls(geometry, pose, position, radius, skin, 0, count, counts, candidates[0])
        else:
            near_walls_all(geometry, pose, position, radius, skin, bounds, counts, candidates, found)
        if found.max() <= room:
            break
        room = int(found.max() * 1.2) + 1
    particle = np.flatnonzero(counts).astype(np.int32)
    row_of = np.full(count, -1, np.int32)
    row_of[particle] = np.arange(len(particle))
    was = old.row_of[order[particle]]
    kept = was >= 0
    body = np.full((len(particle), MOST_TOUCHING), -1, np.int32)
    record = np.zeros((len(particle), MOST_TOUCHING, RECORD))
    body[kept], record[kept] = old.body[was[kept]], old.record[was[kept]]
    return WallList(
        particle,
        row_of,
        np.concatenate([[0], np.cumsum(counts[particle])]),
        np.concatenate([row[:size] for row, size in zip(candidates, found, strict=True)]),
        body,
        record,
        np.searchsorted(particle, bounds),
    )


def empty_walls(count):
    """No particle near a wall."""
    return WallList(
        np.empty(0, np.int32),
        np.full(count, -1, np.int32),
        np.zeros(1, np.int64),
        np.empty(0, np.int32),
        np.empty((0, MOST_TOUCHING), np.int32),
        np.empty((0, MOST_TOUCHING, RECORD)),
        np.zeros(2, np.int64),
    )
