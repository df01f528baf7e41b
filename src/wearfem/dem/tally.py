"""What wall contacts leave on the facets: sufficient statistics, so that wear laws need no second particle run. [PLUG]

A contact leaves an entry in its chunk's list; after the step the entries are added up in a fixed order.
"""

import math
from typing import NamedTuple

import numpy as np

from wearfem.jit import inlined, kernel, law_method


@law_method
def amount(self, normal_force, tangential_force, slip_speed, approach_speed, time_step): ...


class NoTally(NamedTuple):
    """Nothing beyond the standard statistics."""

    factor: float = 0.0

    def amount(self, normal_force, tangential_force, slip_speed, approach_speed, time_step):
        return 0.0


# Columns of the sums of a facet.
NORMAL, TANGENTIAL, FRICTION_WORK, LOAD_DISTANCE, SLIP, TIME, CONTACTS, CUSTOM = 0, 1, 4, 5, 6, 7, 8, 9
SUMS = 10

ENTRIES_PER_ROW = 8  # that a particle may leave in a step on average, joints of triangles included
MOST_ENTRIES = 256  # that one particle may leave

# Classes. Normal force: two to a decade. Impact: 10 degrees each, and a decade of speed each.
FORCE_CLASSES, LOWEST_FORCE = 24, 1e-6  # [N]
ANGLE_CLASSES = 9
SPEED_CLASSES, LOWEST_SPEED = 5, 1e-3  # [m/s]

# Sums of a class of impacts: kinetic energy E, and its moments in angle a [rad] and logarithm of speed l.
ENERGY, ANGLE, ANGLE_SQUARED, LOG_SPEED, LOG_SPEED_SQUARED, ANGLE_LOG_SPEED = 0, 1, 2, 3, 4, 5
MOMENTS = 6  # E, E a, E a^2, E l, E l^2, E a l

# Columns of an entry after the sums: of an impact its energy, angle and logarithm of speed.
IMPACT_ENERGY, IMPACT_ANGLE, IMPACT_LOG_SPEED = SUMS, SUMS + 1, SUMS + 2
COLUMNS = SUMS + 3


def force_edges() -> np.ndarray:
    """(FORCE_CLASSES + 1,) [N] class borders; the first and last class take all that is beyond."""
    return LOWEST_FORCE * 10.0 ** (0.5 * np.arange(FORCE_CLASSES + 1))


def speed_edges() -> np.ndarray:
    """(SPEED_CLASSES + 1,) [m/s] class borders; the first and last class take all that is beyond."""
    return LOWEST_SPEED * 10.0 ** np.arange(SPEED_CLASSES + 1)


@inlined
def half_decade(value, lowest, classes):
    """Class of a positive value, two to a decade from `lowest`."""
    return min(max(int(2.0 * math.log10(max(value, lowest) / lowest)), 0), classes - 1)


@inlined
def decade(value, lowest, classes):
    """Class of a positive value, one to a decade from `lowest`."""
    return min(max(int(math.log10(max(value, lowest) / lowest)), 0), classes - 1)


class Tally(NamedTuple):
    """Sums over the running time block, and the entries of the running step by chunk."""

    sums: np.ndarray  # (f, SUMS): N s, N s x 3, J, N m, m, s, count, custom
    force_time: np.ndarray  # (f, FORCE_CLASSES) [s] in contact, by normal force
    force_slip: np.ndarray  # (f, FORCE_CLASSES) [m] slid, by normal force
    impact: np.ndarray  # (f, ANGLE_CLASSES, SPEED_CLASSES, MOMENTS) first touches
    entry: np.ndarray  # (entries, COLUMNS) sums of a step, and its impact
    where: np.ndarray  # (entries, 4) int32: facet, force class, angle class, speed class
    filled: np.ndarray  # (chunks,) int64, entries in use
    start: np.ndarray  # (chunks + 1,) int64, first entry of a chunk


def empty_tally(facets: int) -> Tally:
    """A tally of zeros for this many facets; room for entries is made when particles are listed."""
    return Tally(
        np.zeros((facets, SUMS)),
        np.zeros((facets, FORCE_CLASSES)),
        np.zeros((facets, FORCE_CLASSES)),
        np.zeros((facets, ANGLE_CLASSES, SPEED_CLASSES, MOMENTS)),
        np.zeros((0, COLUMNS)),
        np.zeros((0, 4), np.int32),
        np.zeros(0, np.int64),
        np.zeros(1, np.int64),
    )


def with_room(tally, chunk_rows):
    """The same sums, with room for the entries of a step; `chunk_rows` (chunks + 1,): first wall row of each chunk."""
    chunks = len(chunk_rows) - 1
    start = ENTRIES_PER_ROW * chunk_rows + MOST_ENTRIES * np.arange(chunks + 1)
    if start[chunks] <= len(tally.entry):
        return Tally(
            tally.sums, tally.force_time, tally.force_slip, tally.impact, tally.entry, tally.where,
            np.zeros(chunks, np.int64), start,
        )  # fmt: skip
    return Tally(
        tally.sums,
        tally.force_time,
        tally.force_slip,
        tally.impact,
        np.zeros((start[chunks], COLUMNS)),
        np.zeros((start[chunks], 4), np.int32),
        np.zeros(chunks, np.int64),
        start,
    )


@kernel
def add_entries(tally):
    """Add the entries of a step to the sums, chunk by chunk, so that the result does not depend on threads."""
    for chunk in range(len(tally.filled)):
        for k in range(tally.start[chunk], tally.start[chunk] + tally.filled[chunk]):
            facet, force = tally.where[k, 0], tally.where[k, 1]
            for c in range(SUMS):
                tally.sums[facet, c] += tally.entry[k, c]
            tally.force_time[facet, force] += tally.entry[k, TIME]
            tally.force_slip[facet, force] += tally.entry[k, SLIP]
            energy = tally.entry[k, IMPACT_ENERGY]
            if energy > 0.0:
                a, v = tally.where[k, 2], tally.where[k, 3]
                angle, speed = tally.entry[k, IMPACT_ANGLE], tally.entry[k, IMPACT_LOG_SPEED]
                tally.impact[facet, a, v, ENERGY] += energy
                tally.impact[facet, a, v, ANGLE] += energy * angle
                tally.impact[facet, a, v, ANGLE_SQUARED] += energy * angle * angle
                tally.impact[facet, a, v, LOG_SPEED] += energy * speed
                tally.impact[facet, a, v, LOG_SPEED_SQUARED] += energy * speed * speed
                tally.impact[facet, a, v, ANGLE_LOG_SPEED] += energy * angle * speed
        tally.filled[chunk] = 0
