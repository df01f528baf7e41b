"""Forces between particles: the touching pairs of the Verlet list, in blocks that fill the processor's vectors.

Storeys: `respond` (scalars, contact.py), `pair_block` (one block of lanes), `pair_forces` (one chunk of particles). A chunk is a
fixed range of particles chosen by their number alone, so results do not depend on the number of threads. Forces on a
partner in another chunk wait in `remote` until its own chunk collects them, in an order that is fixed too.

Pairs are first sifted: those that touch are collected until a block is full, then gathered, computed and scattered. So a listed
pair that does not touch costs less than one that does, and lists may be made with a generous margin.
"""

import math
from typing import NamedTuple

import numpy as np

from wearfem.dem.contact import Kinematics, Memory, Pair, respond
from wearfem.jit import inlined, kernel
from wearfem.vector import nearest

LANES = 64  # contacts in a block

# Rows of a block's working buffer, LANES numbers each.
APART, CLOSING, SPIN, PARTNER_SPIN = 0, 3, 6, 9  # three rows each
RADIUS, PARTNER_RADIUS, MASS, PARTNER_MASS, CONSTANTS = 12, 13, 14, 15, 16
FORCE, TORQUE, PARTNER_TORQUE = 21, 24, 27  # three rows each
DISSIPATED = 30  # [W] slip, change of stiffness, dashpots, rolling: summed over the steps
MEMORY = 34  # MEMORY_ROWS rows: what the contacts remember
ROWS = 42
FAR, SPECK = 1e9, 1e-9  # [m] distance and radii of the two particles of a lane that is not in use

# Columns of the packed copy of a particle that contacts read.
PACKED = 12  # position, velocity, angular velocity, radius, mass, material

MEMORY_ROWS = 8  # at most: displacement 3, stiffness 1, rolling 3, twisting 1
STIFFNESS = 3  # column of a pair's memory


class PairList(NamedTuple):
    """Pairs of particles that may touch before the list is made anew, by chunk; a chunk's room need not be full."""

    first: np.ndarray  # (p,) uint32, particle (unsigned: numba then skips its check for negative indices)
    second: np.ndarray  # (p,) uint32, partner
    memory: (
        np.ndarray
    )  # (p, rows) see contact.Memory; the stiffness, column STIFFNESS, is 0 for a pair that does not touch
    pair_start: np.ndarray  # (chunks,) int64, first pair of a chunk
    pair_end: np.ndarray  # (chunks,) int64, one past the last pair of a chunk
    row_start: np.ndarray  # (n,) int64, first pair of a particle
    row_count: np.ndarray  # (n,) int32, number of its pairs
    slot: np.ndarray  # (p,) int32, place in `remote` of a pair whose partner lives in another chunk, else -1
    remote: np.ndarray  # (slots, 6) [N, N m] for such partners
    inbox_start: np.ndarray  # (chunks + 1,) int64
    inbox: np.ndarray  # (slots, 2) int32, for the chunk that owns them: slot, particle


@inlined
def memory_rows(contact):
    """Numbers that a contact of this law remembers; a constant to the compiler."""
    return 4 + contact.rolling.memory_size() + contact.twisting.memory_size()


@inlined
def pair_block(contact, buffer, period, time_step):
    """All lanes of one block: forces and torques into `buffer`, memory kept in place. No branches: lanes apart get zeros."""
    rolling = contact.rolling.memory_size()
    twisting = contact.twisting.memory_size()
    lx, ly, lz = period[0], period[1], period[2]
    ix = 1.0 / lx if lx > 0.0 else 0.0
    iy = 1.0 / ly if ly > 0.0 else 0.0
    iz = 1.0 / lz if lz > 0.0 else 0.0
    for q in range(LANES):
        dx, dy, dz = buffer[q], buffer[LANES + q], buffer[2 * LANES + q]
        dx -= lx * nearest(dx * ix)
        dy -= ly * nearest(dy * iy)
        dz -= lz * nearest(dz * iz)
        radius, partner_radius = buffer[RADIUS * LANES + q], buffer[PARTNER_RADIUS * LANES + q]
        mass, partner_mass = buffer[MASS * LANES + q], buffer[PARTNER_MASS * LANES + q]
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        gap = radius + partner_radius - distance
        touches = gap > 0.0
        overlap = gap if touches else 1e-30
        inverse = 1.0 / distance
        nx, ny, nz = dx * inverse, dy * inverse, dz * inverse
        share = 1.0 / (radius + partner_radius)
        arm = radius - overlap * partner_radius * share
        partner_arm = partner_radius - overlap * radius * share
        ax, ay, az = buffer[SPIN * LANES + q], buffer[(SPIN + 1) * LANES + q], buffer[(SPIN + 2) * LANES + q]
        bx = buffer[PARTNER_SPIN * LANES + q]
        by = buffer[(PARTNER_SPIN + 1) * LANES + q]
        bz = buffer[(PARTNER_SPIN + 2) * LANES + q]
        ox, oy, oz = arm * ax + partner_arm * bx, arm * ay + partner_arm * by, arm * az + partner_arm * bz
        touch = Kinematics(
            overlap,
            nx,
            ny,
            nz,
            buffer[CLOSING * LANES + q] - (oy * nz - oz * ny),
            buffer[(CLOSING + 1) * LANES + q] - (oz * nx - ox * nz),
            buffer[(CLOSING + 2) * LANES + q] - (ox * ny - oy * nx),
            ax - bx,
            ay - by,
            az - bz,
            0.5 * ((ax + bx) * nx + (ay + by) * ny + (az + bz) * nz),
        )
        pair = Pair(
            radius * partner_radius * share,
            mass * partner_mass / (mass + partner_mass),
            buffer[CONSTANTS * LANES + q],
            buffer[(CONSTANTS + 1) * LANES + q],
            buffer[(CONSTANTS + 2) * LANES + q],
            buffer[(CONSTANTS + 3) * LANES + q],
            buffer[(CONSTANTS + 4) * LANES + q],
        )
        held = Memory(
            buffer[MEMORY * LANES + q],
            buffer[(MEMORY + 1) * LANES + q],
            buffer[(MEMORY + 2) * LANES + q],
            buffer[(MEMORY + 3) * LANES + q],
            buffer[(MEMORY + 4) * LANES + q] if rolling > 0 else 0.0,
            buffer[(MEMORY + 5) * LANES + q] if rolling > 0 else 0.0,
            buffer[(MEMORY + 6) * LANES + q] if rolling > 0 else 0.0,
            buffer[(MEMORY + 4 + rolling) * LANES + q] if twisting > 0 else 0.0,
        )
        answer, kept = respond(contact, pair, touch, held, time_step)
        on = 1.0 if touches else 0.0
        fx, fy, fz = answer.fx * on, answer.fy * on, answer.fz * on
        normal_force = answer.normal_force * on
        mx, my, mz = answer.mx * on, answer.my * on, answer.mz * on
        tx, ty, tz = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
        buffer[FORCE * LANES + q] = normal_force * nx + fx
        buffer[(FORCE + 1) * LANES + q] = normal_force * ny + fy
        buffer[(FORCE + 2) * LANES + q] = normal_force * nz + fz
        buffer[TORQUE * LANES + q] = mx - arm * tx
        buffer[(TORQUE + 1) * LANES + q] = my - arm * ty
        buffer[(TORQUE + 2) * LANES + q] = mz - arm * tz
        buffer[PARTNER_TORQUE * LANES + q] = -mx - partner_arm * tx
        buffer[(PARTNER_TORQUE + 1) * LANES + q] = -my - partner_arm * ty
        buffer[(PARTNER_TORQUE + 2) * LANES + q] = -mz - partner_arm * tz
        buffer[DISSIPATED * LANES + q] += answer.slip_power * on
        buffer[(DISSIPATED + 1) * LANES + q] += answer.stiffness_power * on
        buffer[(DISSIPATED + 2) * LANES + q] += answer.damping_power * on
        buffer[(DISSIPATED + 3) * LANES + q] += answer.rolling_power * on
        buffer[MEMORY * LANES + q] = kept.sx * on
        buffer[(MEMORY + 1) * LANES + q] = kept.sy * on
        buffer[(MEMORY + 2) * LANES + q] = kept.sz * on
        buffer[(MEMORY + 3) * LANES + q] = kept.stiffness * on
        if rolling > 0:
            buffer[(MEMORY + 4) * LANES + q] = kept.rx * on
            buffer[(MEMORY + 5) * LANES + q] = kept.ry * on
            buffer[(MEMORY + 6) * LANES + q] = kept.rz * on
        if twisting > 0:
            buffer[(MEMORY + 4 + rolling) * LANES + q] = kept.twist * on


@inlined
def sift(packed, pairs, begin, end, period, lane, count):
    """Append to `lane` those of the pairs [begin, end) that touch, without branching on it; returns the new count.

    What the others remember is forgotten: pairs that come apart are few, so these branches are foreseen.
    """
    lx, ly, lz = period[0], period[1], period[2]
    ix = 1.0 / lx if lx > 0.0 else 0.0
    iy = 1.0 / ly if ly > 0.0 else 0.0
    iz = 1.0 / lz if lz > 0.0 else 0.0
    first, second, slot, memory = pairs.first, pairs.second, pairs.slot, pairs.memory
    for k in range(end - begin):
        q = np.uint32(begin + k)
        i, j = first[q], second[q]
        dx, dy, dz = packed[i, 0] - packed[j, 0], packed[i, 1] - packed[j, 1], packed[i, 2] - packed[j, 2]
        dx -= lx * nearest(dx * ix)
        dy -= ly * nearest(dy * iy)
        dz -= lz * nearest(dz * iz)
        reach = packed[i, 9] + packed[j, 9]
        touches = dx * dx + dy * dy + dz * dz < reach * reach
        lane[count] = q
        count += np.uint32(touches)
        if memory[q, STIFFNESS] * (0.0 if touches else 1.0) != 0.0:  # one test, not two: it is foreseen
            for row in range(memory.shape[1]):
                memory[q, row] = 0.0
        if slot[q] >= 0:
            for c in range(6):
                pairs.remote[slot[q], c] = 0.0
    return count


@inlined
def gather(table, packed, pairs, rows, lane, count, buffer, kind, period):
    """Copy what one block's contacts read and remember into its lanes; lanes beyond `count` hold two specks far apart."""
    materials = len(table.friction)
    for k in range(count):
        q = lane[k]
        i, j = pairs.first[q], pairs.second[q]
        buffer[k] = packed[i, 0] - packed[j, 0]
        buffer[LANES + k] = packed[i, 1] - packed[j, 1]
        buffer[2 * LANES + k] = packed[i, 2] - packed[j, 2]
        buffer[CLOSING * LANES + k] = packed[i, 3] - packed[j, 3]
        buffer[(CLOSING + 1) * LANES + k] = packed[i, 4] - packed[j, 4]
        buffer[(CLOSING + 2) * LANES + k] = packed[i, 5] - packed[j, 5]
        buffer[SPIN * LANES + k] = packed[i, 6]
        buffer[(SPIN + 1) * LANES + k] = packed[i, 7]
        buffer[(SPIN + 2) * LANES + k] = packed[i, 8]
        buffer[PARTNER_SPIN * LANES + k] = packed[j, 6]
        buffer[(PARTNER_SPIN + 1) * LANES + k] = packed[j, 7]
        buffer[(PARTNER_SPIN + 2) * LANES + k] = packed[j, 8]
        buffer[RADIUS * LANES + k] = packed[i, 9]
        buffer[PARTNER_RADIUS * LANES + k] = packed[j, 9]
        buffer[MASS * LANES + k] = packed[i, 10]
        buffer[PARTNER_MASS * LANES + k] = packed[j, 10]
        for row in range(rows):
            buffer[(MEMORY + row) * LANES + k] = pairs.memory[q, row]
        pairing = packed[i, 11] * materials + packed[j, 11]
        if kind[k] != pairing:
            kind[k] = pairing
            one, other = int(packed[i, 11]), int(packed[j, 11])
            buffer[CONSTANTS * LANES + k] = table.effective_modulus[one, other]
            buffer[(CONSTANTS + 1) * LANES + k] = table.effective_shear_modulus[one, other]
            buffer[(CONSTANTS + 2) * LANES + k] = table.damping_ratio[one, other]
            buffer[(CONSTANTS + 3) * LANES + k] = table.friction[one, other]
            buffer[(CONSTANTS + 4) * LANES + k] = table.rolling_friction[one, other]
    for k in range(count, LANES):
        buffer[k] = 0.5 * period[0] if period[0] > 0.0 else FAR
        buffer[LANES + k], buffer[2 * LANES + k] = 0.0, 0.0
        buffer[RADIUS * LANES + k], buffer[PARTNER_RADIUS * LANES + k] = SPECK, SPECK


@inlined
def scatter(wrench, pairs, rows, lane, count, buffer):
    """Add one block's forces and torques to its particles, or leave them in `remote` for a partner elsewhere."""
    for k in range(count):
        q = lane[k]
        i, j = pairs.first[q], pairs.second[q]
        fx, fy, fz = (
            buffer[FORCE * LANES + k],
            buffer[(FORCE + 1) * LANES + k],
            buffer[(FORCE + 2) * LANES + k],
        )
        tx = buffer[PARTNER_TORQUE * LANES + k]
        ty = buffer[(PARTNER_TORQUE + 1) * LANES + k]
        tz = buffer[(PARTNER_TORQUE + 2) * LANES + k]
        wrench[i, 0] += fx
        wrench[i, 1] += fy
        wrench[i, 2] += fz
        wrench[i, 3] += buffer[TORQUE * LANES + k]
        wrench[i, 4] += buffer[(TORQUE + 1) * LANES + k]
        wrench[i, 5] += buffer[(TORQUE + 2) * LANES + k]
        for row in range(rows):
            pairs.memory[q, row] = buffer[(MEMORY + row) * LANES + k]
        slot = pairs.slot[q]
        if slot < 0:
            wrench[j, 0] -= fx
            wrench[j, 1] -= fy
            wrench[j, 2] -= fz
            wrench[j, 3] += tx
            wrench[j, 4] += ty
            wrench[j, 5] += tz
        else:
            remote = pairs.remote
            remote[slot, 0], remote[slot, 1], remote[slot, 2] = -fx, -fy, -fz
            remote[slot, 3], remote[slot, 4], remote[slot, 5] = tx, ty, tz


@kernel
def pair_forces(contact, table, packed, wrench, pairs, chunk, buffer, kind, lane, period, time_step):
    """Add the contact forces of one chunk's pairs to `wrench`; partners elsewhere get theirs through `pairs.remote`.

    `buffer` (ROWS * LANES,), `kind` (LANES,) and `lane` (2 * LANES,) are the chunk's own working memory: `lane` holds the numbers
    of touching pairs, `kind` says which pair of materials the constants in a lane belong to, so that they are looked up only
    where it changes.
    """
    rows = memory_rows(contact)
    begin, end, count = pairs.pair_start[chunk], pairs.pair_end[chunk], np.uint32(0)
    while begin < end or count > 0:
        upto = min(begin + LANES, end)
        count = sift(packed, pairs, begin, upto, period, lane, count)
        begin = upto
        if count >= LANES or begin == end:
            full = min(count, np.uint32(LANES))
            gather(table, packed, pairs, rows, lane, full, buffer, kind, period)
            pair_block(contact, buffer, period, time_step)
            scatter(wrench, pairs, rows, lane, full, buffer)
            for k in range(full, count):
                lane[k - full] = lane[k]
            count = np.uint32(count - full)


@kernel
def collect_remote(wrench, pairs, chunk):
    """Add to the particles of one chunk what pairs of other chunks did to them."""
    for k in range(pairs.inbox_start[chunk], pairs.inbox_start[chunk + 1]):
        slot, j = pairs.inbox[k, 0], pairs.inbox[k, 1]
        for c in range(6):
            wrench[j, c] += pairs.remote[slot, c]
