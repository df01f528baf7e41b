"""Forces between particles and surfaces, and the loads that they leave on the facets.

Storeys as in pairs.py: `respond` (scalars), `wall_forces_on` (one particle), `wall_forces` (one chunk).
"""

import math
from typing import NamedTuple

import numpy as np

from wearfem.dem.contact import Kinematics, Memory, Pair, respond
from wearfem.dem.geometry import LEVEL, RIM, lies_below, share_overlap, touching_point, well_inside
from wearfem.dem.motion import ORIGIN, PIVOT, TURNING, VELOCITY, into_body, into_world, point_into_body
from wearfem.dem.tally import (
    ANGLE_CLASSES,
    CONTACTS,
    CUSTOM,
    FORCE_CLASSES,
    FRICTION_WORK,
    IMPACT_ANGLE,
    IMPACT_ENERGY,
    IMPACT_LOG_SPEED,
    LOAD_DISTANCE,
    LOWEST_FORCE,
    LOWEST_SPEED,
    MOST_ENTRIES,
    NORMAL,
    SLIP,
    SPEED_CLASSES,
    TANGENTIAL,
    TIME,
    decade,
    half_decade,
)
from wearfem.dem.wall_list import DIRECTION, ITEM, MEMORY, MOST_TOUCHING, POINT, RECORD, SHARE
from wearfem.jit import compiled, inlined, kernel
from wearfem.vector import cross, dot, norm, tangent

MOST_CANDIDATES = 48  # triangles and planes that one sphere may overlap at once

# Columns of a candidate: overlap, then point and normal in the world frame, then in the body's.
OVERLAP, AT, ALONG = 0, 7, 10


@inlined
def touching_candidates(geometry, pose, walls, row, x, y, z, radius, found, item):
    """Fill `found` with the candidates that the sphere overlaps, and `item` with their numbers; returns how many.

    The triangle of the last contact comes first. Once the sphere's foot lies well inside a triangle, those of the same body that
    rise nowhere above its plane are passed over: they would be dropped as parts of the same flat or convex neighbourhood.
    Where triangles are so small that there is no room for all, the deepest are kept.
    """
    triangles = len(geometry.corner)
    begin, end = walls.candidate_start[row], walls.candidate_start[row + 1]
    hint = int(walls.record[row, 0, ITEM]) if walls.body[row, 0] >= 0 else -1
    count, flat = 0, -1
    body, bx, by, bz = -1, x, y, z
    for k in range(begin - 1, end):
        one = hint if k < begin else walls.candidate[k]
        if one < 0 or (one == hint and k >= begin):
            continue
        owner = geometry.body[one]
        if owner != body:
            body = owner
            bx, by, bz = point_into_body(pose, body, x, y, z)
        if flat >= 0 and one < triangles and geometry.body[item[flat]] == body:
            px, py, pz = found[flat, AT], found[flat, AT + 1], found[flat, AT + 2]
            nx, ny, nz = found[flat, ALONG], found[flat, ALONG + 1], found[flat, ALONG + 2]
            if lies_below(geometry, one, px, py, pz, nx, ny, nz, 0.5 * LEVEL * radius):
                continue
        overlap, px, py, pz, nx, ny, nz = touching_point(geometry, one, bx, by, bz, radius)
        if overlap > 0.0:
            place = count
            if count == MOST_CANDIDATES:
                place = 0
                for a in range(1, count):
                    if found[a, OVERLAP] < found[place, OVERLAP]:
                        place = a
                if overlap <= found[place, OVERLAP] or place == flat:
                    continue
            else:
                count += 1
            item[place] = one
            found[place, OVERLAP] = overlap
            found[place, AT], found[place, AT + 1], found[place, AT + 2] = px, py, pz
            found[place, ALONG], found[place, ALONG + 1], found[place, ALONG + 2] = nx, ny, nz
            if flat < 0 and one < triangles and well_inside(geometry, one, px, py, pz, 2.0 * RIM * radius):
                flat = place
    return count


@inlined
def candidates_into_world(geometry, pose, found, item, count):
    """Add contact points and normals in the world frame, where candidates of different bodies can be compared."""
    for a in range(count):
        b = geometry.body[item[a]]
        x, y, z = into_world(pose, b, found[a, AT], found[a, AT + 1], found[a, AT + 2])
        found[a, 1], found[a, 2], found[a, 3] = (
            x + pose[b, ORIGIN],
            y + pose[b, ORIGIN + 1],
            z + pose[b, ORIGIN + 2],
        )
        x, y, z = into_world(pose, b, found[a, ALONG], found[a, ALONG + 1], found[a, ALONG + 2])
        found[a, 4], found[a, 5], found[a, 6] = x, y, z


@inlined
def matching_record(geometry, walls, row, body, found, a, radius, taken):
    """The old contact that candidate a continues: the nearest that moves alike and faces the same way; -1 for a new contact."""
    best, nearest = -1, 0.25 * radius * radius
    for k in range(MOST_TOUCHING):
        was = walls.body[row, k]
        if was >= 0 and not taken[k] and geometry.frame[was] == geometry.frame[body]:
            square, same = 0.0, 0.0
            for c in range(3):
                apart = found[a, AT + c] - walls.record[row, k, POINT + c]
                square += apart * apart
                same += found[a, ALONG + c] * walls.record[row, k, DIRECTION + c]
            if square < nearest and same > 0.5:
                best, nearest = k, square
    return best


class Scratch(NamedTuple):
    """Working memory of one chunk's wall contacts."""

    found: (
        np.ndarray
    )  # (MOST_CANDIDATES, 13): overlap, point and normal in the world frame, then in the body's
    item: np.ndarray  # (MOST_CANDIDATES,) int32
    share: np.ndarray  # (MOST_CANDIDATES,)
    record: np.ndarray  # (MOST_TOUCHING, RECORD)
    body: np.ndarray  # (MOST_TOUCHING,) int32
    taken: np.ndarray  # (MOST_TOUCHING,) bool


@inlined
def wall_touch(packed, i, geometry, pose, body, found, a):
    """How particle i moves against candidate a, in the body's frame, where the surface is at rest."""
    ux = packed[i, 0] - pose[body, PIVOT]
    uy = packed[i, 1] - pose[body, PIVOT + 1]
    uz = packed[i, 2] - pose[body, PIVOT + 2]
    ox, oy, oz = pose[body, TURNING], pose[body, TURNING + 1], pose[body, TURNING + 2]
    vx, vy, vz = into_body(
        pose,
        body,
        packed[i, 3] - pose[body, VELOCITY] - (oy * uz - oz * uy),
        packed[i, 4] - pose[body, VELOCITY + 1] - (oz * ux - ox * uz),
        packed[i, 5] - pose[body, VELOCITY + 2] - (ox * uy - oy * ux),
    )
    wx, wy, wz = into_body(pose, body, packed[i, 6] - ox, packed[i, 7] - oy, packed[i, 8] - oz)
    overlap, nx, ny, nz = found[a, OVERLAP], found[a, ALONG], found[a, ALONG + 1], found[a, ALONG + 2]
    arm = packed[i, 9] - overlap
    touch = Kinematics(
        overlap,
        nx,
        ny,
        nz,
        vx - arm * (wy * nz - wz * ny),
        vy - arm * (wz * nx - wx * nz),
        vz - arm * (wx * ny - wy * nx),
        wx,
        wy,
        wz,
        0.5 * (wx * nx + wy * ny + wz * nz),
    )
    return touch, vx * vx + vy * vy + vz * vz


@inlined
def _work_of_wall(pose, body, found, a, px, py, pz, gx, gy, gz, mx, my, mz):
    """Power [W] that a moving wall gives: force times its velocity at the contact, couple times its turning."""
    ox, oy, oz = pose[body, TURNING], pose[body, TURNING + 1], pose[body, TURNING + 2]
    x, y, z = px - pose[body, PIVOT], py - pose[body, PIVOT + 1], pz - pose[body, PIVOT + 2]
    power = gx * (pose[body, VELOCITY] + oy * z - oz * y)
    power += gy * (pose[body, VELOCITY + 1] + oz * x - ox * z)
    power += gz * (pose[body, VELOCITY + 2] + ox * y - oy * x)
    bx, by, bz = into_world(pose, body, mx, my, mz)
    return power + bx * ox + by * oy + bz * oz


@inlined
def _same_place(geometry, found, item, a, b, radius):
    """Whether candidates a and b are one point on the joint of two triangles, which then share its loads."""
    if a == b:
        return True
    if geometry.body[item[a]] != geometry.body[item[b]] or geometry.facet[item[b]] < 0:
        return False
    dx, dy, dz = (
        found[a, AT] - found[b, AT],
        found[a, AT + 1] - found[b, AT + 1],
        found[a, AT + 2] - found[b, AT + 2],
    )
    return dx * dx + dy * dy + dz * dz < 1e-18 * radius * radius


@inlined
def _leave_loads(
    custom,
    geometry,
    tally,
    chunk,
    found,
    item,
    count,
    a,
    touch,
    answer,
    fresh,
    energy,
    part,
    radius,
    time_step,
):
    """Enter what contact a did to its facet; on a joint, equal parts for each triangle there."""
    approach = -dot(touch.vx, touch.vy, touch.vz, touch.nx, touch.ny, touch.nz)
    sx, sy, sz = tangent(touch.vx, touch.vy, touch.vz, touch.nx, touch.ny, touch.nz)
    sliding = norm(sx, sy, sz)
    pressing = answer.normal_force * part
    friction = norm(answer.fx, answer.fy, answer.fz) * part
    force_class = half_decade(pressing, LOWEST_FORCE, FORCE_CLASSES)
    angle, log_speed, angle_class, speed_class = 0.0, 0.0, 0, 0
    if fresh:
        angle = math.atan2(max(approach, 0.0), sliding)
        speed = max(math.sqrt(sliding * sliding + approach * approach), LOWEST_SPEED)
        log_speed = math.log(speed)
        angle_class = min(int(math.degrees(angle) * ANGLE_CLASSES / 90.0), ANGLE_CLASSES - 1)
        speed_class = decade(speed, LOWEST_SPEED, SPEED_CLASSES)
    ties = 1
    if count > 1:
        ties = 0
        for b in range(count):
            ties += _same_place(geometry, found, item, a, b, radius)
    portion = part / ties
    for b in range(count):
        if _same_place(geometry, found, item, a, b, radius):
            e = tally.start[chunk] + tally.filled[chunk]
            tally.filled[chunk] += 1
            tally.entry[e, NORMAL] = answer.normal_force * time_step * portion
            tally.entry[e, TANGENTIAL] = -answer.fx * time_step * portion
            tally.entry[e, TANGENTIAL + 1] = -answer.fy * time_step * portion
            tally.entry[e, TANGENTIAL + 2] = -answer.fz * time_step * portion
            tally.entry[e, FRICTION_WORK] = answer.slip_power * time_step * portion
            tally.entry[e, LOAD_DISTANCE] = answer.normal_force * sliding * time_step * portion
            tally.entry[e, SLIP] = answer.slip * portion
            tally.entry[e, TIME] = time_step * portion
            tally.entry[e, CONTACTS] = portion if fresh else 0.0
            tally.entry[e, CUSTOM] = custom.amount(pressing, friction, sliding, approach, time_step) / ties
            tally.entry[e, IMPACT_ENERGY] = energy * portion
            tally.entry[e, IMPACT_ANGLE], tally.entry[e, IMPACT_LOG_SPEED] = angle, log_speed
            tally.where[e, 0] = geometry.facet[item[b]]
            tally.where[e, 1], tally.where[e, 2], tally.where[e, 3] = force_class, angle_class, speed_class


@inlined
def wall_forces_on(
    contact, custom, table, geometry, pose, packed, wrench, walls, tally, row, chunk, scratch, work, time_step
):  # fmt: skip
    """Contact forces of one particle with all walls."""
    i = walls.particle[row]
    found, item, share, record = scratch.found, scratch.item, scratch.share, scratch.record
    radius, mass, mine = packed[i, 9], packed[i, 10], int(packed[i, 11])
    count = touching_candidates(
        geometry, pose, walls, row, packed[i, 0], packed[i, 1], packed[i, 2], radius, found, item
    )
    acting = 0
    share[0] = 1.0
    if count > 0:
        candidates_into_world(geometry, pose, found, item, count)
        for k in range(MOST_TOUCHING):
            scratch.taken[k] = False
    if count > 1:
        share_overlap(found, count, radius, share)
    for a in range(count):
        if share[a] == 0.0 or acting == MOST_TOUCHING:
            continue
        part, body, other = share[a], geometry.body[item[a]], geometry.material[item[a]]
        touch, square = wall_touch(packed, i, geometry, pose, body, found, a)
        pair = Pair(
            radius,
            mass,
            table.effective_modulus[mine, other],
            table.effective_shear_modulus[mine, other],
            table.damping_ratio[mine, other],
            table.friction[mine, other],
            table.rolling_friction[mine, other],
        )
        k = matching_record(geometry, walls, row, body, found, a, radius, scratch.taken)
        known = k >= 0
        if known:
            scratch.taken[k] = True
        m = max(k, 0)
        held = Memory(
            walls.record[row, m, MEMORY] if known else 0.0,
            walls.record[row, m, MEMORY + 1] if known else 0.0,
            walls.record[row, m, MEMORY + 2] if known else 0.0,
            walls.record[row, m, MEMORY + 3] if known else 0.0,
            walls.record[row, m, MEMORY + 4] if known else 0.0,
            walls.record[row, m, MEMORY + 5] if known else 0.0,
            walls.record[row, m, MEMORY + 6] if known else 0.0,
            walls.record[row, m, MEMORY + 7] if known else 0.0,
        )
        answer, kept = respond(contact, pair, touch, held, time_step)
        scratch.body[acting] = body
        for c in range(3):
            record[acting, POINT + c], record[acting, DIRECTION + c] = found[a, AT + c], found[a, ALONG + c]
        record[acting, MEMORY], record[acting, MEMORY + 1], record[acting, MEMORY + 2] = (
            kept.sx,
            kept.sy,
            kept.sz,
        )
        record[acting, MEMORY + 3] = kept.stiffness
        record[acting, MEMORY + 4], record[acting, MEMORY + 5], record[acting, MEMORY + 6] = (
            kept.rx,
            kept.ry,
            kept.rz,
        )
        record[acting, MEMORY + 7], record[acting, SHARE], record[acting, ITEM] = kept.twist, part, item[a]
        acting += 1

        arm = radius - touch.overlap
        fx, fy, fz = answer.fx * part, answer.fy * part, answer.fz * part
        mx, my, mz = answer.mx * part, answer.my * part, answer.mz * part
        push = answer.normal_force * part
        tx, ty, tz = cross(touch.nx, touch.ny, touch.nz, fx, fy, fz)
        gx, gy, gz = into_world(pose, body, fx + push * touch.nx, fy + push * touch.ny, fz + push * touch.nz)
        hx, hy, hz = into_world(pose, body, mx - arm * tx, my - arm * ty, mz - arm * tz)
        wrench[i, 0] += gx
        wrench[i, 1] += gy
        wrench[i, 2] += gz
        wrench[i, 3] += hx
        wrench[i, 4] += hy
        wrench[i, 5] += hz
        work[chunk, 3] += answer.slip_power * part * time_step
        work[chunk, 4] += answer.stiffness_power * part * time_step
        work[chunk, 5] += answer.damping_power * part * time_step
        work[chunk, 6] += answer.rolling_power * part * time_step
        if geometry.moves[body]:
            power = _work_of_wall(
                pose, body, found, a, found[a, 1], found[a, 2], found[a, 3], gx, gy, gz, mx, my, mz
            )  # fmt: skip
            work[chunk, 7] += power * time_step
        if geometry.facet[item[a]] >= 0:
            energy = 0.0 if known else 0.5 * mass * square
            _leave_loads(
                custom, geometry, tally, chunk, found, item, count, a, touch, answer, not known, energy, part, radius, time_step
            )  # fmt: skip
    for k in range(MOST_TOUCHING):
        if k < acting:
            walls.body[row, k] = scratch.body[k]
            for c in range(RECORD):
                walls.record[row, k, c] = record[k, c]
        else:
            walls.body[row, k] = -1


@kernel
def wall_forces(
    contact, custom, table, geometry, pose, packed, wrench, walls, tally, chunk, scratch, work, time_step
):
    """Add the wall forces of one chunk's particles to `wrench` and their loads to the chunk's entries.

    Where there is no room for the entries of all particles, `tally.filled` becomes -1.
    """
    room = tally.start[chunk + 1] - tally.start[chunk] - MOST_ENTRIES
    for row in range(walls.chunk_start[chunk], walls.chunk_start[chunk + 1]):
        if tally.filled[chunk] > room:
            tally.filled[chunk] = -1
            break
        wall_forces_on(
            contact, custom, table, geometry, pose, packed, wrench, walls, tally, row, chunk, scratch, work, time_step
        )  # fmt: skip


@compiled
def new_scratch():
    """Working memory for the wall contacts of one chunk."""
    return Scratch(
        np.zeros((MOST_CANDIDATES, 13)),
        np.zeros(MOST_CANDIDATES, np.int32),
        np.zeros(MOST_CANDIDATES),
        np.zeros((MOST_TOUCHING, RECORD)),
        np.zeros(MOST_TOUCHING, np.int32),
        np.zeros(MOST_TOUCHING, np.bool_),
    )
