"""A steady stream over the arc of a chute: what it tells, and the closed form of a stream that slides as a block beside it."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wearfem.dem.flow import Flow
from wearfem.liner.chute import CurvedChute, angle_of, facet_angle, share_between
from wearfem.loads import FacetLoads
from wearfem.surface import Surface
from wearfem.units import degree
from wearfem.verification.chute_theory import normal_force, speed, wear_rate
from wearfem.wear.sampling import Measured, ratio

BLOCK = 0.05  # [s] over which loads are summed for their standard error
SNAPSHOT = 0.02  # [s]
BINS = 12  # of the stretch, for the speed of the stream
BAND = 1 * degree  # on both sides of an angle, where the stream's speed is taken
REACH = 0.3  # [m] above the arc, within which particles are part of the stream


@dataclass(frozen=True)
class Stretch:
    """A stretch of a chute's arc, and the ore that comes over it."""

    shape: CurvedChute
    begin: float  # [rad]
    end: float  # [rad]
    feed_rate: float  # [kg/s] on the whole width
    share: float = 1.0  # [-] part of the width that is simulated

    @property
    def exit(self) -> float:
        """[rad] where the stream leaves it: `BAND` before its end"""
        return self.end - BAND


@dataclass(frozen=True)
class Passage:
    """A steady stream over a stretch; forces are those of the whole width."""

    normal_force: Measured  # [N]
    friction: Measured  # [-] mu_e: force along the chute over normal force
    entry_speed: Measured  # [m/s] of the stream's mass where the stretch begins
    exit_speed: Measured  # [m/s] of the stream's mass where it leaves
    sliding: Measured  # [m/s] at which ore slides over the chute, weighted by normal force
    speed: Measured  # [m/s] of the stream's mass, weighted by the same force
    centre: float  # [m] of the stream's mass above the chute

    @property
    def slip(self) -> Measured:
        """[-] speed at which ore slides over the chute, over that of the stream"""
        return self.sliding.over(self.speed)


def passage(on: Stretch, surface: Surface, loads: FacetLoads, snapshots: Sequence[Flow]) -> Passage:
    """What loads (by block) and snapshots of the same time tell of a stream over `surface`."""
    share, angle = share_between(surface, on.begin, on.end), facet_angle(surface)
    normal = loads.normal_impulse @ share
    dragged = np.einsum("bfi,fi,f->b", loads.tangential_impulse, on.shape.down(angle), share)
    seen = [_moving(flow, on.shape) for flow in snapshots]

    def mean_speed(low: float, high: float) -> Measured:
        inside = [((a >= low) & (a < high), v, m) for a, v, m, _ in seen]
        return ratio(
            np.array([m[i] @ v[i] for i, v, m in inside]), np.array([m[i].sum() for i, _, m in inside])
        )

    edges = np.linspace(on.begin, on.end, BINS + 1)
    part = [mean_speed(low, high) for low, high in pairwise(edges)]
    force = np.bincount(np.digitize(angle, edges[1:-1]), loads.normal_impulse.sum(axis=0) * share, BINS)
    weight = force / force.sum()
    within = [((a >= on.begin) & (a < on.end), m, h) for a, _, m, h in seen]
    height = [(m[i] @ h[i], m[i].sum()) for i, m, h in within]
    return Passage(
        normal_force=ratio(normal / on.share, loads.duration),
        friction=ratio(dragged, normal),
        entry_speed=mean_speed(on.begin - BAND, on.begin + BAND),
        exit_speed=mean_speed(on.exit - BAND, on.exit + BAND),
        sliding=ratio(loads.load_distance @ share, normal),
        speed=Measured(
            float(weight @ [one.value for one in part]),
            float(np.linalg.norm(weight * [one.error for one in part])),
        ),
        centre=float(np.divide(*np.sum(height, axis=0))),
    )


def _moving(flow: Flow, shape: CurvedChute) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Angle [rad], speed down the chute [m/s], mass [kg] and height above the chute [m] of the particles near the arc"""
    p = flow.particles
    height = shape.radius - np.hypot(p.position[:, 0], p.position[:, 2])
    near = height < REACH
    angle = angle_of(p.position[near])
    return angle, (p.velocity[near] * shape.down(angle)).sum(axis=1), p.mass[near], height[near]


@dataclass(frozen=True)
class Theory:
    """A stretch in closed form, at the friction, entry speed and radius of a stream; standard errors are those of the former two."""

    wear: Measured  # [m3/s] of a stream that slides as a block
    normal_force: Measured  # [N]
    exit_speed: Measured  # [m/s]


def theory(stream: Passage, on: Stretch, specific_wear_rate: float) -> Theory:
    """The stretch in closed form, with R that of the stream's centre of mass."""

    def told(friction: float, entry: float) -> np.ndarray:
        start = {
            "friction": friction, "radius": on.shape.radius - stream.centre, "start_angle": on.begin, "start_speed": entry,
        }  # fmt: skip
        worn = wear_rate(
            on.begin, on.end, mass_rate=on.feed_rate, specific_wear_rate=specific_wear_rate, **start
        )
        return np.array(
            [
                worn,
                normal_force(on.begin, on.end, mass_rate=on.feed_rate, **start),
                speed(on.exit, **start),
            ]
        )

    mu, v = stream.friction, stream.entry_speed
    middle = told(mu.value, v.value)
    by_friction = told(mu.value + mu.error, v.value) - middle
    by_speed = told(mu.value, v.value + v.error) - middle
    return Theory(*map(Measured, middle.tolist(), np.hypot(by_friction, by_speed).tolist()))
