"""Ore on a curved chute beside the closed form of its stream: speed, normal force and wear, and what sets them apart."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import cos, degrees, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from wearfem.case import LifeCase, Window, load_any_case, parts_of
from wearfem.cycle import Particles
from wearfem.dem.flow import Flow
from wearfem.dem.particles import spheres
from wearfem.dem.sample import sample
from wearfem.liner.chute import angle_of, share_between
from wearfem.liner.liner import Liner, wear_surface
from wearfem.proof import Claim
from wearfem.proofs._chute_stream import BLOCK, SNAPSHOT, Passage, Stretch, Theory, passage, theory
from wearfem.verification.chute_theory import GRAVITY, speed, wear_rate
from wearfem.wear.sampling import Measured

CASE = Path(__file__).parents[3] / "cases" / "transfer_chute"
PAPER = "Chen, Schott and Lodewijks"
COARSE = {"coarsening": 3.0, "slice_width": 0.105}
SLIDING = {"coarsening": 2.0, "slice_width": 0.07, "rolling_friction": 1.0}
FRICTION = 0.46  # [-] of ore on the chute
START = radians(30.0)  # where a single ball begins to slide


def claims() -> Iterator[Claim]:
    """The closed form by itself; one ball, then a stream, that slide without rolling, as it has it; coarse ore that rolls as printed."""
    yield from closed_form()
    yield from one_ball()
    yield from stream(seconds=0.6, noise=0.007, **SLIDING)
    yield from stream(seconds=0.8, noise=0.01, **COARSE)


def closed_form() -> Iterator[Claim]:
    """The speed law beside its equation of motion solved by steps, and the numbers in print"""
    chute = parts_of(CASE)
    begin, end = chute.ZONE_2
    given = {"friction": 0.47, "radius": 2.0, "start_angle": chute.ONSET, "start_speed": 5.34}

    def slope(angle: float, square: Any) -> Any:
        """d(v^2)/dtheta from gravity and friction, not from the closed form"""
        pressing = square / 2.0 + GRAVITY * sin(angle)
        return 2.0 * 2.0 * (GRAVITY * cos(angle) - 0.47 * pressing)

    by_steps = solve_ivp(slope, (chute.ONSET, end), [5.34**2], rtol=1e-11, atol=1e-11).y[0, -1] ** 0.5
    yield Claim(
        "speed where zone 2 ends, as printed inputs give it", "equation of motion, Runge-Kutta", by_steps, speed(end, **given), "m/s",
        1e-8, True, "the accuracy asked of Runge-Kutta",
    )  # fmt: skip
    printed = wear_rate(begin, end, mass_rate=27.78, specific_wear_rate=3e-13, **given)
    yield Claim(
        "wear rate of zone 2, as printed inputs give it", f"{PAPER}, section 4.2", 1.68e-10, printed, "m3/s", 0.01, True,
        "their K = -4.68 m2/s2 is -4.55 when computed from their own numbers; their eq. 9 lacks + 3 mu cos(theta), which they used",
    )  # fmt: skip


def one_ball() -> Iterator[Claim]:
    """One ball that cannot roll slides down the arc: a stream that is a block, on facets of 10 and 2.5 mm"""
    chute, radius, first = parts_of(CASE), 8e-3, 4.0
    exit_angle = zone_2().exit
    given = {
        "friction": FRICTION,
        "radius": chute.RADIUS - radius,
        "start_angle": START,
        "start_speed": first,
    }
    mass = 4865.0 * 4.0 / 3.0 * np.pi * radius**3
    worn = wear_rate(*chute.ZONE_2, mass_rate=mass, specific_wear_rate=3e-13, **given)
    for size, tolerance, note in (
        (
            10e-3,
            5e-3,
            "facets are chords: at a joint the ball meets the next one 0.29 degrees askew, loses speed and hops",
        ),
        (2.5e-3, 1e-3, "a twentieth of the 2 % asked of streams: what joints of 0.07 degrees may cost"),
    ):
        found = slid(size, radius, first)
        yield Claim(
            f"speed of a ball that slides, at {degrees(exit_angle):.2f} degrees, facets of {1e3 * size:g} mm", "closed form",
            speed(exit_angle, **given), found[0], "m/s", tolerance, True, note,
        )  # fmt: skip
        yield Claim(
            f"wear of zone 2 by a ball that slides, facets of {1e3 * size:g} mm", "closed form", worn, found[1], "m3", tolerance,
            True, note,
        )  # fmt: skip


def slid(mesh_size: float, radius: float, first: float) -> tuple[float, float]:
    """Speed [m/s] at the end of zone 2 and wear [m3] of zone 2 by a ball that begins to slide before it at `first` [m/s]"""
    case, zone = chute_case(mesh_size=mesh_size, **SLIDING), zone_2()
    surface = wear_surface(case.liner)
    assert isinstance(case.sampler, Particles)
    model = case.sampler.model(surface)
    path = zone.shape.radius - radius
    place = np.array([[-path * cos(START), 0.035, -path * sin(START)]])
    ball = spheres(
        place, radius, model.materials[0].density, velocity=(first * sin(START), 0.0, -first * cos(START))
    )
    _, loads, seen = sample(Flow(ball), replace(model, inlets=()), Window(0.4, 1, 400))
    angle = np.array([angle_of(flow.particles.position)[0] for flow in seen if flow.particles.count])
    moving = np.array([np.linalg.norm(flow.particles.velocity) for flow in seen if flow.particles.count])
    return float(np.interp(zone.exit, angle, moving)), 3e-13 * float(
        loads.load_distance[0] @ share_between(surface, zone.begin, zone.end)
    )


def stream(seconds: float, noise: float, **settings: Any) -> Iterator[Claim]:
    """A stream of ore over the new chute.

    Parameters
    ----------
    seconds
        Of steady stream that are sampled.
    noise
        [-] standard error of a rate that this leaves, which tolerances allow for.
    settings
        Keywords of the case [SI].
    """
    case = chute_case(**settings)
    seen = watched(case, seconds, case.warm_up)
    told, theory, slices = seen.passage, seen.theory, stream_of(case)
    ore = f"ore of {2e3 * slices.radii[0]:g} to {2e3 * slices.radii[1]:g} mm"
    allowed = 0.02 + 2.0 * noise
    reason = f"2 % is asked; twice the standard error of {100.0 * noise:g} % beside it"
    mass = float(seen.flow.particles.mass.sum())
    yield Claim(
        f"mass of {ore} fed", "what is on the chute and what has left it", seen.flow.fed[0], mass + seen.flow.left_mass, "kg", 1e-12, True,
        "rounding of a sum",
    )  # fmt: skip
    yield Claim(
        f"mu_e of zone 2, {ore}", "friction of ore on the chute: all of it slides", FRICTION, told.friction.value, "-", 0.01, True,
        f"few contacts roll or have just begun; standard error {told.friction.error:.1g}",
    )  # fmt: skip
    yield Claim(
        "speed of the stream where it leaves zone 2", "closed form at the measured entry speed and mu_e", theory.exit_speed.value,
        told.exit_speed.value, "m/s", allowed, True, reason,
    )  # fmt: skip
    yield Claim(
        "normal force on zone 2", "closed form at the measured entry speed and mu_e", theory.normal_force.value, told.normal_force.value,
        "N", allowed, True, reason,
    )  # fmt: skip
    slip, rolls = told.slip.value, slices.rolling_friction < FRICTION
    if rolls:
        limit, why = (
            np.inf,
            f"balls that roll slide at {slip:.3f} of the stream's speed, and larger balls at less",
        )
    else:
        limit, why = allowed, f"balls that cannot roll slide at {slip:.3f} of the stream's speed; {reason}"
    yield Claim(
        f"wear rate of zone 2 over that of the closed form, {ore}, {'that rolls' if rolls else 'that cannot roll'}", "2 % asked", 1.0,
        seen.wear[1].over(theory.wear).value, "-", limit, True, why,
    )  # fmt: skip
    yield Claim(
        "wear rate of zone 2", "closed form x sliding over stream speed, both measured", theory.wear.value * slip, seen.wear[1].value,
        "m3/s", allowed, True, reason,
    )  # fmt: skip
    if not rolls:
        return
    for zone, (one, printed) in enumerate(zip(seen.wear, parts_of(CASE).PUBLISHED, strict=True), 1):
        yield Claim(
            f"wear rate of zone {zone}, {ore}", f"{PAPER}, section 4.1", printed, one.value, "m3/s", np.inf, True,
            f"standard error {one.error:.1g}; why it is not met: cases/transfer_chute/README.md",
        )  # fmt: skip


@dataclass(frozen=True)
class Watched:
    """A steady stream, what it tells, and the closed form of zone 2 at its friction and entry speed."""

    flow: Flow  # at the end
    time_step: float  # [s]
    wear: tuple[Measured, ...]  # [m3/s] of zones 1, 2, 3, on the whole width
    passage: Passage  # of zone 2
    theory: Theory  # of zone 2


def stream_of(case: LifeCase) -> Any:
    """The stream of the chute's case; its class stands in the case's file, which no type checker follows"""
    measure: Any = case.measure
    return measure.stream


def watched(
    case: LifeCase, seconds: float, warm_up: float, liner: Liner | None = None, start: Flow | None = None
) -> Watched:
    """The case's stream over the new chute from an empty one, or over `liner` from the flow `start`, after `warm_up` [s], for `seconds`."""
    chute, stream = parts_of(CASE), stream_of(case)
    surface = wear_surface(liner or case.liner)
    model = stream.model(surface)
    flow, _, _ = sample(start or case.flow, model, Window(warm_up))
    window = Window(seconds, round(seconds / BLOCK), round(seconds / SNAPSHOT))
    flow, loads, snapshots = sample(flow, model, window)
    zone = replace(zone_2(), feed_rate=stream.feed_rate, share=stream.share)
    seen = passage(zone, surface, loads, snapshots)
    wear = chute.zone_wear(case.wear_law.depth_rate(loads), surface, stream)
    return Watched(flow, model.time_step, wear, seen, theory(seen, zone, case.settings["specific_wear_rate"]))


def zone_2() -> Stretch:
    """Zone 2 of the case, with the printed feed."""
    chute = parts_of(CASE)
    begin, end = chute.ZONE_2
    return Stretch(chute.CHUTE, begin, end, chute.FEED_RATE)


def chute_case(**settings: Any) -> LifeCase:
    """The case with its keywords."""
    case = load_any_case(CASE, settings)
    assert isinstance(case, LifeCase)
    return case
