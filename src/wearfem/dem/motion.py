"""How rigid surfaces move, and how particles do: poses of bodies, and velocity Verlet."""

import math
from typing import NamedTuple

import numpy as np

from wearfem.errors import UserError
from wearfem.jit import compiled, inlined, kernel


class Motion(NamedTuple):
    """A prescribed rigid motion: a turn about an axis, then a shift that is steady, vibrating and tabulated at once.

    shift(t) = velocity t + amplitude sin(2 pi frequency t + phase) + path(t),
    turn(t) = rate (clip(t, start, stop) - start) about `axis` through `centre`: it rests before `start` and stays where it was at `stop`.
    """

    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m/s]
    amplitude: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m] of the vibration, with its direction
    frequency: float = 0.0  # [Hz]
    phase: float = 0.0  # [rad]
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)  # of the rotation
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m]
    rate: float = 0.0  # [rad/s]
    start: float = 0.0  # [s] of the turning
    stop: float = math.inf  # [s] of the turning
    path: np.ndarray | None = (
        None  # (k, 4): time [s], shift x, y, z [m]; linear between rows, still before and after
    )

    @property
    def moves(self) -> bool:
        """Whether this is a motion at all."""
        return bool(any(self.velocity) or any(self.amplitude) or self.rate or self.path is not None)


STILL = Motion()


def alike(one: Motion, other: Motion) -> bool:
    """Whether two motions are the same, so that bodies with them stay where they are to one another."""
    steady = one._replace(path=None) == other._replace(path=None)
    if one.path is None or other.path is None:
        return steady and one.path is other.path
    return steady and np.array_equal(one.path, other.path)


def rotation(
    rate: float, *, axis=(0.0, 0.0, 1.0), centre=(0.0, 0.0, 0.0), start: float = 0.0, stop: float = math.inf
) -> Motion:
    """Steady turning at `rate` [rad/s] about `axis` through `centre` [m], from `start` to `stop` [s]."""
    if not stop > start:
        raise UserError(f"A rotation from {start} to {stop} s was given; it must stop after its start.")
    return Motion(rate=rate, axis=axis, centre=centre, start=start, stop=stop)


def translation(velocity: tuple[float, float, float]) -> Motion:
    """Steady motion at `velocity` [m/s]."""
    return Motion(velocity=velocity)


def vibration(amplitude: tuple[float, float, float], frequency: float, phase: float = 0.0) -> Motion:
    """Shaking along `amplitude` [m] at `frequency` [Hz]."""
    return Motion(amplitude=amplitude, frequency=frequency, phase=phase)


def along_path(path: np.ndarray) -> Motion:
    """Motion through the shifts of a table (k, 4): time [s], x, y, z [m]."""
    path = np.asarray(path, float)
    if path.ndim != 2 or path.shape[1] != 4 or len(path) < 2 or not (np.diff(path[:, 0]) > 0).all():
        raise UserError(
            f"A path of shape {path.shape} was given; it must have four columns (time, x, y, z), two rows or more, and "
            "times that increase."
        )
    return Motion(path=path)


class Bodies(NamedTuple):
    """The motions of all rigid bodies as arrays; a body is a surface or a plane with its motion."""

    constant: (
        np.ndarray
    )  # (b, 17): velocity 3, amplitude 3, frequency, phase, axis 3 (unit), centre 3, rate, start, stop
    path: np.ndarray  # (k, 4) tables of all bodies, one after the other
    path_start: np.ndarray  # (b + 1,) int64


def bodies(motions: list[Motion]) -> Bodies:
    """Pack motions for the kernels."""
    constant = np.zeros((len(motions), 17))
    tables, start = [np.zeros((0, 4))], [0]
    for row, motion in zip(constant, motions, strict=True):
        length = math.sqrt(sum(c * c for c in motion.axis))
        if length == 0.0:
            raise UserError("A rotation about the axis (0, 0, 0) was given; the axis must have a direction.")
        row[0:3], row[3:6] = motion.velocity, motion.amplitude
        row[6], row[7] = motion.frequency, motion.phase
        row[8:11] = np.asarray(motion.axis) / length
        row[11:14], row[14:17] = motion.centre, (motion.rate, motion.start, motion.stop)
        tables.append(motion.path if motion.path is not None else np.zeros((0, 4)))
        start.append(start[-1] + len(tables[-1]))
    return Bodies(constant, np.concatenate(tables), np.array(start))


# Columns of a pose: where a body is and how it moves at one time.
ORIGIN, ROTATION, VELOCITY, TURNING, PIVOT = 0, 3, 12, 15, 18
POSE = 21


@compiled
def pose_at(bodies, body, time, pose):
    """Fill `pose` (POSE,): world x = origin + rotation X, velocity of the pivot [m/s], angular velocity [rad/s], pivot [m]."""
    c = bodies.constant[body]
    angle = 2.0 * math.pi * c[6] * time + c[7]
    swing, swing_rate = math.sin(angle), 2.0 * math.pi * c[6] * math.cos(angle)
    turn = c[14] * (min(max(time, c[15]), c[16]) - c[15])
    rate = c[14] if c[15] <= time < c[16] else 0.0
    sine, cosine = math.sin(turn), math.cos(turn)
    x, y, z = c[8], c[9], c[10]
    versine = 1.0 - cosine
    pose[ROTATION + 0] = cosine + x * x * versine
    pose[ROTATION + 1] = x * y * versine - z * sine
    pose[ROTATION + 2] = x * z * versine + y * sine
    pose[ROTATION + 3] = y * x * versine + z * sine
    pose[ROTATION + 4] = cosine + y * y * versine
    pose[ROTATION + 5] = y * z * versine - x * sine
    pose[ROTATION + 6] = z * x * versine - y * sine
    pose[ROTATION + 7] = z * y * versine + x * sine
    pose[ROTATION + 8] = cosine + z * z * versine
    for k in range(3):
        pose[VELOCITY + k] = c[k] + c[3 + k] * swing_rate
        pose[TURNING + k] = c[8 + k] * rate
        pose[PIVOT + k] = c[11 + k] + c[k] * time + c[3 + k] * swing
    begin, end = bodies.path_start[body], bodies.path_start[body + 1]
    if end > begin:
        row = begin + np.searchsorted(bodies.path[begin:end, 0], time, side="right") - 1
        inside = begin <= row < end - 1
        row = min(max(row, begin), end - 2)
        span = bodies.path[row + 1, 0] - bodies.path[row, 0]
        part = min(max((time - bodies.path[row, 0]) / span, 0.0), 1.0)
        for k in range(3):
            step = bodies.path[row + 1, 1 + k] - bodies.path[row, 1 + k]
            pose[PIVOT + k] += bodies.path[row, 1 + k] + part * step
            if inside:
                pose[VELOCITY + k] += step / span
    for k in range(3):
        turned = 0.0
        for m in range(3):
            turned += pose[ROTATION + 3 * k + m] * c[11 + m]
        pose[ORIGIN + k] = pose[PIVOT + k] - turned


@inlined
def into_body(pose, b, x, y, z):
    """R^T v: a vector of the world frame in the frame of body b."""
    return (
        pose[b, ROTATION] * x + pose[b, ROTATION + 3] * y + pose[b, ROTATION + 6] * z,
        pose[b, ROTATION + 1] * x + pose[b, ROTATION + 4] * y + pose[b, ROTATION + 7] * z,
        pose[b, ROTATION + 2] * x + pose[b, ROTATION + 5] * y + pose[b, ROTATION + 8] * z,
    )


@inlined
def into_world(pose, b, x, y, z):
    """R v: a vector of the frame of body b in the world frame."""
    return (
        pose[b, ROTATION] * x + pose[b, ROTATION + 1] * y + pose[b, ROTATION + 2] * z,
        pose[b, ROTATION + 3] * x + pose[b, ROTATION + 4] * y + pose[b, ROTATION + 5] * z,
        pose[b, ROTATION + 6] * x + pose[b, ROTATION + 7] * y + pose[b, ROTATION + 8] * z,
    )


@inlined
def point_into_body(pose, b, x, y, z):
    """A point of the world frame in the frame of body b."""
    return into_body(pose, b, x - pose[b, ORIGIN], y - pose[b, ORIGIN + 1], z - pose[b, ORIGIN + 2])


@kernel
def move(particles, packed, gravity, drift, time_step, low, high, finish, begin, work):
    """Velocity Verlet for particles [low, high): finish a step with new forces, begin the next, or both in one pass.

    Kick half, drift, and a predicted velocity at the new time for the contact laws:
    v += a dt/2; x += v dt; packed v = v + a dt/2. `work[0]` += work of gravity and applied forces [J]; `work[1]` and
    `work[2]` are the largest squared velocities [m2/s2], at rest and relative to `drift`; infinite if one is not a number.
    """
    half = 0.5 * time_step
    external, fastest, fastest_apart = 0.0, 0.0, 0.0
    for i in range(low, high):
        mass, radius, held = particles.mass[i], particles.radius[i], particles.held[i]
        inverse, spin_inverse = 1.0 / mass, 1.0 / (0.4 * mass * radius * radius)
        square, apart = 0.0, 0.0
        for k in range(3):
            given = gravity[k] * mass + particles.applied_force[i, k]
            a = (particles.wrench[i, k] + given) * inverse
            alpha = particles.wrench[i, 3 + k] * spin_inverse
            if held != 0:
                if held & (1 << k):
                    a = 0.0
                if held & 8:
                    alpha = 0.0
            v, w = particles.velocity[i, k], particles.angular_velocity[i, k]
            if finish:
                v += half * a
                w += half * alpha
            if begin:
                v += half * a
                w += half * alpha
                particles.position[i, k] += time_step * v
                packed[i, k] = particles.position[i, k]
                packed[i, 3 + k] = v + half * a
                packed[i, 6 + k] = w + half * alpha
                particles.wrench[i, k] = 0.0
                particles.wrench[i, 3 + k] = 0.0
                external += given * v * time_step
                square += v * v
                apart += (v - drift[k]) * (v - drift[k])
            particles.velocity[i, k] = v
            particles.angular_velocity[i, k] = w
        if begin:
            packed[i, 9] = radius
            packed[i, 10] = mass
            packed[i, 11] = particles.material[i]
            fastest, fastest_apart = max(fastest, square), max(fastest_apart, apart)
            if not square < np.inf:
                fastest = np.inf
    work[0] += external
    work[1], work[2] = fastest, fastest_apart
