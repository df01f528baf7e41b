"""The time loop: drift, list, forces, kick, compiled from one end of a window to the other."""

import math
from typing import NamedTuple

import numpy as np

from wearfem.dem.contact import Contact
from wearfem.dem.motion import POSE, TURNING, VELOCITY, move, pose_at
from wearfem.dem.neighbours import chunk_bounds
from wearfem.dem.pairs import DISSIPATED, LANES, MEMORY, ROWS, collect_remote, pair_forces
from wearfem.dem.tally import add_entries
from wearfem.dem.walls import new_scratch, wall_forces
from wearfem.jit import compiled, inlined, kernel, law_method, parallel, prange

# Why the loop stopped.
DONE, LIST_PAIRS, LIST_WALLS, NOT_A_NUMBER, TOO_MANY_ENTRIES = range(5)

# Work and losses since the start [J], columns of the ledger.
EXTERNAL_WORK, WALL_WORK, SLIP_LOSS, STIFFNESS_LOSS, DAMPING_LOSS, ROLLING_LOSS = range(6)
LEDGER = 6

WORK = 8  # per chunk: external work, two largest squared speeds, four losses at walls, wall work


class Constants(NamedTuple):
    """Numbers of a model that do not change in a window."""

    gravity: np.ndarray  # (3,) [m/s2]
    time_step: float  # [s]
    pair_skin: float  # [m] margin of the pair list
    wall_skin: float  # [m] margin of the wall list
    low: np.ndarray  # (3,) [m] corner of the domain
    period: np.ndarray  # (3,) [m] 0 where not periodic
    origin: float  # [s] time at `origin_step`
    origin_step: int  # step at which this time step came into use


@inlined
def time_at(constants, step):
    """The time [s] after so many steps."""
    return constants.origin + (step - constants.origin_step) * constants.time_step


@compiled
def wrap(particles, packed, row_of, walls, low, period):
    """Bring particles back into a periodic domain, and the contact points they remember with them."""
    for i in range(len(particles.radius)):
        for k in range(3):
            if period[k] > 0.0:
                turns = math.floor((particles.position[i, k] - low[k]) / period[k])
                if turns != 0.0:
                    shift = -turns * period[k]
                    particles.position[i, k] += shift
                    packed[i, k] += shift
                    row = row_of[i]
                    if row >= 0:
                        for m in range(walls.body.shape[1]):
                            if walls.body[row, m] >= 0:
                                walls.record[row, m, k] += shift


@compiled
def middle_velocity(velocity, drift):
    """Fill `drift` with the middle of the range of velocities, which bounds all of them best."""
    for k in range(3):
        drift[k] = 0.5 * (velocity[:, k].min() + velocity[:, k].max())


@compiled
def largest_shift(position, reference, relative):
    """Largest distance moved [m]; `relative`: apart from the middle of all shifts."""
    middle = np.zeros(3)
    if relative:
        for k in range(3):
            low, high = np.inf, -np.inf
            for i in range(len(position)):
                shift = position[i, k] - reference[i, k]
                low, high = min(low, shift), max(high, shift)
            middle[k] = 0.5 * (low + high)
    most = 0.0
    for i in range(len(position)):
        x = position[i, 0] - reference[i, 0] - middle[0]
        y = position[i, 1] - reference[i, 1] - middle[1]
        z = position[i, 2] - reference[i, 2] - middle[2]
        most = max(most, x * x + y * y + z * z)
    return math.sqrt(most)


@compiled
def body_speed(geometry, pose):
    """A bound on the speed [m/s] of any point of any surface."""
    most = 0.0
    for body in range(len(geometry.extent)):
        if geometry.moves[body]:
            p = pose[body]
            speed = math.sqrt(p[VELOCITY] ** 2 + p[VELOCITY + 1] ** 2 + p[VELOCITY + 2] ** 2)
            turning = math.sqrt(p[TURNING] ** 2 + p[TURNING + 1] ** 2 + p[TURNING + 2] ** 2)
            most = max(most, speed + turning * geometry.extent[body])
    return most


@kernel
def _finish_and_begin(particles, packed, pairs, drift, constants, work, bounds, chunk, finish, begin):
    if finish:
        collect_remote(particles.wrench, pairs, chunk)
    low, high = bounds[chunk], bounds[chunk + 1]
    move(
        particles,
        packed,
        constants.gravity,
        drift,
        constants.time_step,
        low,
        high,
        finish,
        begin,
        work[chunk],
    )


@parallel
def _finish_and_begin_all(particles, packed, pairs, drift, constants, work, bounds, finish, begin):
    for chunk in prange(len(bounds) - 1):
        _finish_and_begin(
            particles, packed, pairs, drift, constants, work, bounds, np.int64(chunk), finish, begin
        )


class Workspace(NamedTuple):
    """Working memory of all chunks."""

    buffers: np.ndarray  # (chunks, ROWS * LANES)
    kinds: np.ndarray  # (chunks, LANES)
    lanes: np.ndarray  # (chunks, 2 * LANES) uint32
    work: np.ndarray  # (chunks, WORK)


@kernel
def _forces(
    force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, scratch, constants, chunk
):  # fmt: skip
    contact = Contact(force, rolling, twisting)
    dt = constants.time_step
    pair_forces(
        contact, table, packed, wrench, pairs, chunk, space.buffers[chunk], space.kinds[chunk], space.lanes[chunk],
        constants.period, dt,
    )  # fmt: skip
    wall_forces(
        contact, custom, table, geometry, pose, packed, wrench, walls, tally, chunk, scratch, space.work, dt
    )  # fmt: skip


@compiled
def _forces_of_chunk(
    force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, constants, chunk
):  # fmt: skip
    _forces(
        force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, new_scratch(),
        constants, chunk,
    )  # fmt: skip


@parallel
def _forces_all(
    force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, constants, chunks
):  # fmt: skip
    for chunk in prange(chunks):
        _forces_of_chunk(
            force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, constants,
            np.int64(chunk),
        )  # fmt: skip


@law_method
def finish_and_begin(self, particles, packed, pairs, drift, constants, work, bounds, finish, begin):
    """Kicks and drift of all particles, by one chunk or by many."""


@law_method
def forces(
    self, force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, scratch, constants
):  # fmt: skip
    """Forces on all particles, by one chunk or by many."""


class OneChunk(NamedTuple):
    """Few particles: no threads, and no code for them to compile."""

    chunk: int = 0

    def finish_and_begin(self, particles, packed, pairs, drift, constants, work, bounds, finish, begin):
        """Kicks and drift of all particles."""
        _finish_and_begin(particles, packed, pairs, drift, constants, work, bounds, self.chunk, finish, begin)

    def forces(
        self, force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, scratch, constants
    ):  # fmt: skip
        """Forces on all particles."""
        _forces(
            force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, scratch,
            constants, self.chunk,
        )  # fmt: skip


class ManyChunks(NamedTuple):
    """Many particles: chunks are shared out among the threads."""

    chunks: int

    def finish_and_begin(self, particles, packed, pairs, drift, constants, work, bounds, finish, begin):
        """Kicks and drift of all particles."""
        _finish_and_begin_all(particles, packed, pairs, drift, constants, work, bounds, finish, begin)

    def forces(
        self, force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, scratch, constants
    ):  # fmt: skip
        """Forces on all particles."""
        _forces_all(
            force, rolling, twisting, custom, table, geometry, pose, packed, wrench, pairs, walls, tally, space, constants,
            self.chunks,
        )  # fmt: skip


@compiled
def step_on(
    drive, contact, custom, table, geometry, bodies, particles, packed, pairs, walls, drift, tally, constants, clock, travel, ledger,
    steps, listing,
):  # fmt: skip
    """Take up to `steps` time steps, as long as the lists are valid; returns steps begun and why it stopped.

    A step whose drift makes the lists stale stops before its forces (`LIST_PAIRS`, `LIST_WALLS`); called again with `listing`
    and new lists it goes on there. All arrays are changed in place. `drive` is `OneChunk` or `ManyChunks`, as `chunk_bounds` says.
    """
    bounds = chunk_bounds(len(particles.radius))
    chunks = len(bounds) - 1
    body_count = len(geometry.extent)
    dt = constants.time_step
    pose = np.zeros((max(body_count, 1), POSE))
    buffers, kinds = np.ones((chunks, ROWS * LANES)), np.full((chunks, LANES), -1.0)
    buffers[:, DISSIPATED * LANES : MEMORY * LANES] = 0.0
    lanes = np.zeros((chunks, 2 * LANES), np.uint32)
    work = np.zeros((chunks, WORK))
    space, scratch = Workspace(buffers, kinds, lanes, work), new_scratch()
    force, rolling, twisting = contact.force, contact.rolling, contact.twisting
    status, begun = DONE, 0
    for body in range(body_count):
        pose_at(bodies, body, time_at(constants, clock[0]), pose[body])
    while True:
        if not listing:
            finish, begin = begun > 0 or clock[1] > 0, begun < steps
            drive.finish_and_begin(particles, packed, pairs, drift, constants, work, bounds, finish, begin)
            clock[1] = 0
            if not begin:
                break
            begun += 1
            clock[0] += 1
            for body in range(body_count):
                if geometry.moves[body]:
                    pose_at(bodies, body, time_at(constants, clock[0]), pose[body])
            fastest, fastest_apart = 0.0, 0.0
            for chunk in range(chunks):
                fastest, fastest_apart = max(fastest, work[chunk, 1]), max(fastest_apart, work[chunk, 2])
            if not fastest < np.inf:
                status = NOT_A_NUMBER
                break
            travel[0] += dt * math.sqrt(fastest_apart)
            travel[1] += dt * math.sqrt(fastest)
            travel[2] += dt * body_speed(geometry, pose)
            if travel[0] > 0.5 * constants.pair_skin:
                status = LIST_PAIRS
                break
            if travel[1] + travel[2] > constants.wall_skin:
                status = LIST_WALLS
                break
        listing = False
        drive.forces(
            force, rolling, twisting, custom, table, geometry, pose, packed, particles.wrench, pairs, walls, tally, space, scratch,
            constants,
        )  # fmt: skip
        clock[1] = 1
        for chunk in range(chunks):
            if tally.filled[chunk] < 0:
                status = TOO_MANY_ENTRIES
        if status == TOO_MANY_ENTRIES:
            break
        add_entries(tally)
    for chunk in range(chunks):
        ledger[EXTERNAL_WORK] += work[chunk, 0]
        ledger[WALL_WORK] += work[chunk, 7]
        for loss in range(4):
            base = (DISSIPATED + loss) * LANES
            ledger[SLIP_LOSS + loss] += work[chunk, 3 + loss] + buffers[chunk, base : base + LANES].sum() * dt
    return begun, status
