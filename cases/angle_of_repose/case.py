"""Iron ore leaves a box through its front, then off a tilting plate, and heaps up in a bin: three angles.

**Source** Chen, Schott and Lodewijks, Numerical prediction on abrasive wear reduction of bulk solids handling equipment using
bionic design, section 3.5: Figure 2, Tables 2 and 3.

Printed: materials, sizes, feed, tilting speeds, the shortening of time by ten, the angles. Not printed and chosen here: the lengths
below, the width, the times between the stages, how the angles were read, and the rolling model.
"""

import math
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from wearfem.case import Case, Figure, Outcome, Stage, Window
from wearfem.dem.contact import ConstantTorque, Contact, ElasticPlasticRolling, HertzMindlin
from wearfem.dem.feed import Inlet, uniform_sizes
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.motion import rotation
from wearfem.dem.particles import spheres
from wearfem.errors import UserError
from wearfem.material import Interaction, Material
from wearfem.slope import Line, Profile, fit_line, free_surface
from wearfem.surface import Plane, Surface
from wearfem.units import GPa, MPa, degree, kg, mm, second

# Chosen. The hinge of the plate, its front edge, is at x = 0, z = 0; y runs across.
BOX_LENGTH = 150 * mm  # of the plate, from the wall behind to the gate
BOX_HEIGHT = 250 * mm  # of the wall behind, which tilts with the plate, and of the gate
BIN = (-300 * mm, 500 * mm)  # where the bin's ends stand
WIDTH = 40 * mm  # periodic; printed: more than four diameters
LAST_TILT = 60 * degree  # steep enough to empty the plate

FILL, RELEASE, SETTLE = 2.2 * second, 1.5 * second, 1.5 * second  # the last one at most
GATE_TURN = 120 * degree  # the gate swings up about its upper edge ...
GATE_TIME = 0.15 * second  # ... within this time

# Printed.
FEED_RATE, FEED_TIME, FEED_SPEED = 1.5 * kg / second, 1.85 * second, 1.0
DIAMETER = (3 * mm, 8 * mm)
TILT_SPEED = {1: 1.8 * degree, 2: 13.1 * degree}  # [rad/s]
REST_ENERGY = 1.8e-5  # [J] at which the third angle is read
EXPERIMENT = {
    1: ((33.8, 0.7), (35.6, 1.2), (38.9, 1.1)),
    2: ((33.7, 0.9), (37.7, 0.7), (33.3, 0.8)),
}  # [degree] and half of the 95 % interval
SIMULATION = {1: ((35.4, 0.2), (35.4, 0.7), (42.4, 1.4)), 2: ((32.7, 0.6), (37.8, 0.4), (33.8, 0.9))}

RAYLEIGH_SHARE = 0.25  # of the smallest particle's Rayleigh time, for the time step
TILT_SNAPSHOTS = 30  # every 2 degrees
FLOWING = (0.9, 0.3)  # share of the pile still on the plate while the second angle is read

ROLLING = {"constant_torque": ConstantTorque(), "elastic_plastic": ElasticPlasticRolling()}


def case(
    *,
    experiment: Literal[1, 2] = 1,
    speed_up: float = 10.0,
    seed: int = 1,
    shear_modulus: float = 10 * MPa,
    rolling: Literal["constant_torque", "elastic_plastic"] = "constant_torque",
    coarsening: float = 1.0,
    drop: float = 200 * mm,
) -> Case:
    """The three angles of repose of Experiment 1 (1.8 degrees a second) or 2 (13.1).

    Parameters
    ----------
    experiment
        Which of the two tilting speeds.
    speed_up
        How much faster than in the experiment the plate tilts; the published simulations used 10.
    seed
        Of the feed.
    shear_modulus
        Of the ore [Pa]. The true 65 GPa would need 80 times as many time steps.
    rolling
        Constant torque is what the program of the published simulations has; the elastic-plastic model lets heaps come to rest.
    coarsening
        Factor on all particle diameters, for a quick look; the width grows where particles would be too large for it.
    drop
        From the plate down to the bottom of the bin [m]; not printed, chosen.
    """
    ore = Material("ore", 4865.0, shear_modulus, 0.24, restitution=0.45, friction=0.41, rolling_friction=0.22)
    steel = Material("steel", 7932.0, 78 * GPa, 0.3)
    acrylic = Material("acrylic", 1136.0, 11 * GPa, 0.4)
    smallest, largest = (0.5 * coarsening * diameter for diameter in DIAMETER)
    width = max(WIDTH, 8.0 * largest)
    tilting = speed_up * TILT_SPEED[experiment]
    tilt_time = LAST_TILT / tilting
    tilt_start = FILL + RELEASE
    rayleigh = (
        math.pi * smallest * math.sqrt(ore.density / shear_modulus) / (0.1631 * ore.poisson_ratio + 0.8766)
    )

    def sheet(start: tuple[float, float], end: tuple[float, float], material: Material, name: str) -> Surface:
        """A rectangle across the whole width, from one (x, z) to another; ore is on its left."""
        (a, b), (c, d) = start, end
        point = np.array([[a, 0.0, b], [c, 0.0, d], [c, width, d], [a, width, b]])
        return Surface(point, np.array([[0, 1, 2], [0, 2, 3]]), material, name=name)

    turn = rotation(tilting, axis=(0.0, 1.0, 0.0), start=tilt_start, stop=tilt_start + tilt_time)
    gate_up = rotation(
        -GATE_TURN / GATE_TIME,
        axis=(0.0, 1.0, 0.0),
        centre=(0.0, 0.0, BOX_HEIGHT),
        start=FILL,
        stop=FILL + GATE_TIME,
    )
    model = Model(
        materials=(ore, steel, acrylic),
        interactions=(
            Interaction(ore, steel, restitution=0.4, friction=0.46, rolling_friction=0.3),
            Interaction(ore, acrylic, restitution=0.5, friction=0.24, rolling_friction=0.22),
        ),
        time_step=RAYLEIGH_SHARE * rayleigh,
        domain=Domain(
            (BIN[0] - 10 * mm, 0.0, -drop - 10 * mm),
            (BIN[1] + 10 * mm, width, 600 * mm),
            (False, True, False),
        ),
        walls=(
            Wall(sheet((-BOX_LENGTH, 0.0), (0.0, 0.0), steel, "plate"), turn),
            Wall(sheet((-BOX_LENGTH, BOX_HEIGHT), (-BOX_LENGTH, 0.0), acrylic, "wall behind"), turn),
            Wall(sheet((0.0, 0.0), (0.0, BOX_HEIGHT), acrylic, "gate"), gate_up),
            Wall(Plane((0.0, 0.0, -drop), (0.0, 0.0, 1.0), steel, "bottom of the bin")),
            Wall(Plane((BIN[0], 0.0, 0.0), (1.0, 0.0, 0.0), acrylic, "rear end of the bin")),
            Wall(Plane((BIN[1], 0.0, 0.0), (-1.0, 0.0, 0.0), acrylic, "front end of the bin")),
        ),
        contact=Contact(HertzMindlin(), ROLLING[rolling]),
        inlets=(
            Inlet(
                (-BOX_LENGTH + 2 * mm, 0.0, BOX_HEIGHT),
                (-2 * mm, width, BOX_HEIGHT + 50 * mm),
                FEED_RATE * width / WIDTH,
                uniform_sizes(smallest, largest),
                velocity=(0.0, 0.0, -FEED_SPEED),
                seed=seed,
                stop=FEED_TIME,
            ),
        ),
        pair_skin=0.4
        * (smallest + largest),  # wide margins: a few fast particles would have all lists made anew
        wall_skin=0.4 * (smallest + largest),
    )
    stages = (
        Stage("fill", model, Window(FILL)),
        Stage("release", model, Window(RELEASE)),
        Stage("tilt", model, Window(tilt_time, snapshots=TILT_SNAPSHOTS)),
        Stage("settle", model, Window(SETTLE, block_count=30), until=_at_rest),
    )
    setup = Setup(experiment, width, smallest + largest, tilting, tilt_start, drop)
    return Case(
        name="angle_of_repose",
        flow=Flow(spheres(np.zeros((0, 3)), 0.0, ore.density)),
        stages=stages,
        wear_law=None,
        measure=lambda outcome: _figures(setup, outcome),
        notes=(
            "the lengths of box and bin, the width and the way the angles were read are not printed: they are chosen here",
            f"the ore's shear modulus is {shear_modulus:.3g} Pa instead of 65 GPa, and the plate tilts {speed_up:g} times faster "
            "than in the experiment",
            "the intervals are those of the fits of this one run; `seeds.py` gives intervals over runs",
        ),
        draw=lambda outcome, folder: _draw(setup, outcome, folder),
    )


@dataclass(frozen=True)
class Setup:
    """What the measurement must know of the case."""

    experiment: int
    width: float  # [m]
    cell: float  # [m] of the profile: the mean diameter
    tilting: float  # [rad/s]
    tilt_start: float  # [s]
    drop: float  # [m]

    def tilt(self, time: float) -> float:
        """How far the plate has turned [rad]."""
        return min(max(self.tilting * (time - self.tilt_start), 0.0), LAST_TILT)


@dataclass(frozen=True)
class Tilted:
    """The pile on the plate at one moment of the tilting."""

    flow: Flow
    tilt: float  # [rad]
    share: float  # of the mass that was there when the tilting began
    line: Line  # in the frame of the plate


@dataclass(frozen=True)
class Angles:
    """The three angles of one run, and the lines that they come from."""

    pile: Line  # phi 1: left in the box when the gate is gone
    flowing: tuple[Tilted, ...]  # phi 2: while 90 to 30 % of that pile are still on the tilting plate
    heap: tuple[Line, Line]  # phi 3: front and rear flank in the bin
    half_empty: float  # [degree] tilt at which half of the pile has left

    @property
    def value(self) -> tuple[float, float, float]:
        """[degree]"""
        front, rear = self.heap
        return self.pile.angle, float(np.mean(self.surface_angles)), 0.5 * (front.angle - rear.angle)

    @property
    def surface_angles(self) -> list[float]:
        """[degree] above the horizontal, of the free surface at each moment of `flowing`"""
        return [math.degrees(moment.tilt) + moment.line.angle for moment in self.flowing]

    @property
    def half_width(self) -> tuple[float, float, float]:
        """[degree] half of the 95 % intervals of this one run: of the line, of the mean over moments, of the lines"""
        moments = self.surface_angles
        middle = (
            1.96 * float(np.std(moments, ddof=1)) / math.sqrt(len(moments)) if len(moments) > 1 else math.nan
        )
        flanks = math.hypot(*(0.5 * (line.high - line.low) for line in self.heap)) / 2.0
        return 0.5 * (self.pile.high - self.pile.low), middle, flanks


def _at_rest(flow: Flow) -> bool:
    return flow.kinetic_energy < REST_ENERGY


def _on_plate(setup: Setup, flow: Flow) -> tuple[Profile, float]:
    """The free surface on the plate in the plate's frame, and the mass there [kg]."""
    p, tilt = flow.particles, setup.tilt(flow.time)
    along = p.position[:, 0] * math.cos(tilt) - p.position[:, 2] * math.sin(tilt)
    above = p.position[:, 0] * math.sin(tilt) + p.position[:, 2] * math.cos(tilt)
    there = (along > -BOX_LENGTH) & (along < 0.0) & (above > 0.0)
    profile = free_surface(
        along[there],
        p.position[there, 1],
        above[there],
        p.radius[there],
        cell=setup.cell,
        width=setup.width,
    )
    return profile, float(p.mass[there].sum())


def measure_angles(setup: Setup, outcome: Outcome) -> Angles:
    """The three angles of a run; each is the inclination of lines that `fit_line` puts through the free surface.

    phi 1: the pile left in the box, `RELEASE` after the gate began to open, the plate still level.
    phi 2: the surface of the pile on the tilting plate, against the horizontal, mean of the moments in which 90 to 30 % of it are left.
    phi 3: the heap in the bin once the kinetic energy is below 1.8e-5 J or `SETTLE` is over, mean of its front and rear flank.
    """
    profile, mass = _on_plate(setup, outcome["release"].flow)
    pile = fit_line(profile)
    flowing, half_empty = [], math.nan
    for flow in outcome["tilt"].snapshots:
        surface, left = _on_plate(setup, flow)
        share = left / mass
        if share < 0.5 and math.isnan(half_empty):
            half_empty = math.degrees(setup.tilt(flow.time))
        if FLOWING[1] <= share <= FLOWING[0]:
            with suppress(UserError):  # of large particles too few columns may be left for a line
                flowing.append(Tilted(flow, setup.tilt(flow.time), share, fit_line(surface)))
    p = outcome.flow.particles
    surface = free_surface(
        p.position[:, 0],
        p.position[:, 1],
        p.position[:, 2],
        p.radius,
        cell=setup.cell,
        width=setup.width,
    )
    crest = float(surface.along[np.argmax(surface.height)])
    front, rear = surface.between(crest, BIN[1]), surface.between(BIN[0], crest)
    return Angles(pile, tuple(flowing), (fit_line(front), fit_line(rear)), half_empty)


def _figures(setup: Setup, outcome: Outcome) -> tuple[Figure, ...]:
    angles = measure_angles(setup, outcome)
    names = ("phi 1, left in the box", "phi 2, on the tilting plate", "phi 3, heap in the bin")
    figures = []
    published = zip(EXPERIMENT[setup.experiment], SIMULATION[setup.experiment], strict=True)
    for name, value, half, (measured, simulated) in zip(
        names, angles.value, angles.half_width, published, strict=True
    ):
        source = f"Table 2: Experiment {measured[0]} +- {measured[1]}, their simulation {simulated[0]} +- {simulated[1]}"
        figures.append(Figure(name, value, "degree", measured[0], source, measured[1]))
        figures.append(Figure(f"{name.split(',')[0]}, half of its 95 % interval in this run", half, "degree"))
    front, rear = angles.heap
    energy = outcome.flow.kinetic_energy
    return (
        *figures,
        Figure("phi 3, front flank", front.angle, "degree"),
        Figure("phi 3, rear flank", -rear.angle, "degree"),
        Figure("tilt when half of the pile has left", angles.half_empty, "degree"),
        Figure("particles", float(outcome.flow.particles.count), "-"),
        Figure("mass", float(outcome.flow.particles.mass.sum()), "kg"),
        Figure("kinetic energy when phi 1 is read", outcome["release"].flow.kinetic_energy, "J"),
        Figure("kinetic energy when phi 3 is read", energy, "J", REST_ENERGY, "section 3.5"),
    )


def _draw(setup: Setup, outcome: Outcome, folder: Path) -> None:
    """The three moments from the side, with the fitted lines."""
    from wearfem.report_particles import Moment, draw_moments

    angles = measure_angles(setup, outcome)
    middle = angles.flowing[len(angles.flowing) // 2]
    shown = (
        (outcome["release"].flow, (angles.pile,), f"left in the box: {angles.value[0]:.1f} degrees"),
        (middle.flow, (middle.line,), f"on the tilting plate: mean {angles.value[1]:.1f} degrees"),
        (outcome.flow, angles.heap, f"heap in the bin: {angles.value[2]:.1f} degrees"),
    )
    moments = []
    for flow, lines, title in shown:
        p, tilt = flow.particles, setup.tilt(flow.time)

        def turned(point: tuple[float, float], tilt: float = tilt) -> tuple[float, float]:
            x, z = point
            return x * math.cos(tilt) + z * math.sin(tilt), z * math.cos(tilt) - x * math.sin(tilt)

        behind = (-BOX_LENGTH, BOX_HEIGHT), (-BOX_LENGTH, 0.0), (0.0, 0.0)
        walls = [(turned(a), turned(b)) for a, b in zip(behind, behind[1:], strict=False)]
        walls.append(((BIN[0], -setup.drop), (BIN[1], -setup.drop)))
        on_plate = flow is not outcome.flow
        fitted = [(turned(one.start), turned(one.end)) if on_plate else (one.start, one.end) for one in lines]
        speed = np.linalg.norm(p.velocity, axis=1)
        moments.append(Moment(title, p.position, p.radius, speed, walls, fitted))
    draw_moments(folder / "moments.png", moments)
