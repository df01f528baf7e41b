"""Iron ore falls onto a curved steel chute and slides down it, until the chute is worn out.

**Source** Chen, Schott and Lodewijks, Numerical prediction on abrasive wear reduction of bulk solids handling equipment using bionic
design, sections 2 to 4: Figure 1, Tables 1 and 3.

Printed: materials, sizes of the ore, feed, radius, width and slope of the sides, the borders of the zones, the angle at which the ore comes
on, its velocity there, the coefficient of wear. Not printed and chosen here: where exactly the ore comes on, the length of the straight
end, the thickness of the chute and its limit. See README.md.

Frame: x along, y across, z up, the arc's centre at the origin. An angle on the chute is counted from the horizontal through the centre:
0 where the chute falls straight down, 90 degrees at its bottom.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import asin, cos, pi, sin, sqrt, tan
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.case import Figure, LifeCase, Stop, Window
from wearfem.cycle import Particles, worn_to
from wearfem.dem.contact import ConstantTorque, Contact, HertzMindlin
from wearfem.dem.feed import Inlet, uniform_sizes
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.particles import spheres
from wearfem.history import History
from wearfem.liner.block import Hexahedra, block, mapped
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.mesh import SolidMesh
from wearfem.loads import FacetLoads
from wearfem.material import Interaction, Material
from wearfem.report import draw_lines, picture
from wearfem.surface import Surface
from wearfem.units import GPa, MPa, day, degree, kg, kilotonne, mm, second
from wearfem.verification.chute_theory import normal_force, speed, wear_rate
from wearfem.wear.laws import Archard
from wearfem.wear.sampling import standard_error

# Printed.
RADIUS = 2.0  # [m] of the arc
WIDTH = 0.2  # [m] of the chute's bottom, for which rates are told
SLOPE = 45 * degree  # of the sides
SIDE = 0.2  # [m] width of a side (s1, s2)
FEED_RATE = 27.78 * kg / second  # on the whole width
VELOCITY = (0.2, 0.0, -5.33)  # [m/s] of the ore where it comes on
DIAMETER = (3 * mm, 8 * mm)
SHEAR_MODULUS = 65 * GPa  # of the ore
TIME_STEP = 1.5e-6  # [s]
FRICTION = 0.46  # [-] of the ore on the chute
SPECIFIC_WEAR_RATE = 3.0e-13  # [m2/N]
ONSET = 28.36 * degree  # where the ore first meets the chute
INLET_LENGTH = 0.1  # [m] along x
ZONE_2 = (35.34 * degree, 64.15 * degree)
ARC_DROP = 1.8  # [m] h3: a drop of 2 m x sin(64.16 degrees), so the arc ends where zone 2 does
PUBLISHED = (
    0.97e-10,
    1.72e-10,
    0.48e-10,
)  # [m3/s] worn off zones 1, 2, 3; powers of ten of 1 and 3 are lost in print

# Chosen.
ARC_BEGIN = 20 * degree  # above it nothing touches the chute
ARC_END = asin(ARC_DROP / RADIUS)
STRAIGHT = 0.5  # [m] of chute after the arc
THICKNESS = 20 * mm
NINETY = 1.645  # [-] standard deviations within which 90 % lie
DRAWN = 5.0  # [-] how much thicker the chute is drawn than it is
LAYERS = 1  # of elements through the thickness, which a slice as wide as several facets are long needs to keep its shape
WARM_UP = 0.5  # [s] from the first particle to a steady stream
BLOCK = 0.05  # [s] over which loads are summed for their standard error
BINS = 12  # of zone 2, for the speed of the stream
BAND = 1 * degree  # on both sides of an angle, where the stream's speed is taken
EXIT = ZONE_2[1] - BAND  # where the stream leaves zone 2
REACH = 0.3  # [m] above the arc, within which particles are part of the stream

STEEL = Material("steel", 7932.0, 78 * GPa, 0.3)


def ore(shear_modulus: float) -> Material:
    """Sishen iron ore, Table 3."""
    return Material(
        "ore", 4865.0, shear_modulus, 0.24, restitution=0.45, friction=0.41, rolling_friction=0.22
    )


@dataclass(frozen=True)
class Stream:
    """The ore, and how much of the chute it is followed on: a slice, periodic across, or the whole chute with its sides."""

    shear_modulus: float  # [Pa]
    coarsening: float  # [-] factor on all diameters
    slice_width: float  # [m] periodic across; 0 for the whole chute with its sides
    time_step: float  # [s]
    seed: int
    rolling_friction: float = 0.3  # [-] of the ore on the chute

    @property
    def radii(self) -> tuple[float, float]:
        """[m] smallest, largest"""
        return 0.5 * self.coarsening * DIAMETER[0], 0.5 * self.coarsening * DIAMETER[1]

    @property
    def share(self) -> float:
        """[-] part of the width that is simulated"""
        return self.slice_width / WIDTH if self.slice_width else 1.0

    @property
    def across(self) -> tuple[float, float]:
        """[m] y where the chute's bottom begins and ends"""
        return (0.0, self.slice_width) if self.slice_width else (-0.5 * WIDTH, 0.5 * WIDTH)

    @property
    def nothing(self) -> Flow:
        """No particle yet"""
        return Flow(spheres(np.zeros((0, 3)), 0.0, ore(self.shear_modulus).density))

    @property
    def inlet(self) -> Inlet:
        """A box above the chute, as near as the largest particle allows to where the ore first meets it.

        Across a slice the box reaches over both ends by a mean radius, so that centres are spread over the whole period.
        """
        smallest, largest = self.radii
        x, z = -RADIUS * cos(ONSET), -RADIUS * sin(ONSET) + 2.0 * largest
        low, high = self.across
        beyond = 0.5 * (smallest + largest) if self.slice_width else 0.0
        return Inlet(
            (x, low - beyond, z),
            (x + INLET_LENGTH, high + beyond, z + 4.0 * largest),
            self.share * FEED_RATE,
            uniform_sizes(smallest, largest),
            velocity=VELOCITY,
            seed=self.seed,
        )

    def model(self, surface: Surface) -> Model:
        """The ore's world around the worn face as it is."""
        stone = ore(self.shear_modulus)
        largest = self.radii[1]
        low, high = self.across
        reach = 0.0 if self.slice_width else SIDE * cos(SLOPE)
        x, z = surface.point[:, 0], surface.point[:, 2]
        return Model(
            materials=(stone, STEEL),
            interactions=(Interaction(stone, STEEL, 0.4, FRICTION, self.rolling_friction),),
            time_step=self.time_step,
            domain=Domain(
                (x.min() - 0.05, low - reach, z.min() - 0.05),
                (x.max() + largest, high + reach, 0.0),
                (False, bool(self.slice_width), False),
                outlet=True,
            ),
            walls=(Wall(surface),),
            contact=Contact(HertzMindlin(), ConstantTorque()),
            inlets=(self.inlet,),
        )


def rayleigh_time(coarsening: float, shear_modulus: float) -> float:
    """[s] of the smallest particle: pi R sqrt(rho/G) / (0.1631 nu + 0.8766)"""
    stone = ore(shear_modulus)
    slowness = sqrt(stone.density / shear_modulus) / (0.1631 * stone.poisson_ratio + 0.8766)
    return pi * 0.5 * coarsening * DIAMETER[0] * slowness


def strip(width: float, size: float) -> SolidMesh:
    """A slice of the chute's bottom from y = 0 to `width` [m], one element across: what wears it is the same all over the width."""
    length = RADIUS * (ARC_END - ARC_BEGIN) + STRAIGHT
    flat = block(
        (0, 0, -THICKNESS), (length, width, 0), (round(length / size), 1, LAYERS), Hexahedra, name="chute"
    )
    return mapped(flat, bent)


def trough(size: float) -> SolidMesh:
    """The whole chute: a bottom between two sides that rise by 45 degrees, plates that meet in a mitre."""
    length = RADIUS * (ARC_END - ARC_BEGIN) + STRAIGHT
    half = 0.5 * WIDTH
    bottom, side = round(WIDTH / size), round(SIDE / size)
    across = np.concatenate(
        [
            np.linspace(-half - SIDE, -half, side + 1)[:-1],
            np.linspace(-half, half, bottom + 1),
            np.linspace(half, half + SIDE, side + 1)[1:],
        ]
    )
    cells = (round(length / size), len(across) - 1, LAYERS)
    flat = block((0, 0, -THICKNESS), (length, cells[1], 0), cells, Hexahedra, name="chute")
    knot = (-half - SIDE, -half, half, half + SIDE)
    reach, rise = half + SIDE * cos(SLOPE), SIDE * sin(SLOPE)
    inner = np.array([(-reach, rise), (-half, 0.0), (half, 0.0), (reach, rise)])
    mitre = THICKNESS * tan(0.5 * SLOPE)
    out, down = THICKNESS * sin(SLOPE), THICKNESS * cos(SLOPE)
    outer = inner + [(-out, -down), (-mitre, -THICKNESS), (mitre, -THICKNESS), (out, -down)]

    def folded(position: np.ndarray) -> np.ndarray:
        """The flat plate with its sides turned up."""
        s = across[position[:, 1].round().astype(int)]
        back = (-position[:, 2] / THICKNESS)[:, None]
        face, rear = (
            np.column_stack([np.interp(s, knot, line[:, k]) for k in range(2)]) for line in (inner, outer)
        )
        return bent(np.column_stack([position[:, 0], face + back * (rear - face)]))

    return mapped(flat, folded)


def bent(flat: np.ndarray) -> np.ndarray:
    """Positions (n, 3) [m] along, across and above the flat chute's face, where they are in the bent one."""
    along, across, above = flat.T
    angle = np.minimum(ARC_BEGIN + along / RADIUS, ARC_END)
    rest = along - RADIUS * (angle - ARC_BEGIN)
    inward = RADIUS - above
    return np.column_stack(
        [
            -inward * np.cos(angle) + rest * np.sin(angle),
            across,
            -inward * np.sin(angle) - rest * np.cos(angle),
        ]
    )


def angle_of(position: np.ndarray) -> np.ndarray:
    """(n,) [rad] on the chute of positions (n, 3) [m]; on the straight end it goes on, so zones are told by it."""
    return np.arctan2(-position[:, 2], -position[:, 0])


def facet_angle(surface: Surface) -> np.ndarray:
    """(f,) [rad] of the facets' centres"""
    centre = surface.corner.mean(axis=1) * surface.area[:, None]
    total = np.column_stack([np.bincount(surface.facet, c, surface.facet_count) for c in centre.T])
    return angle_of(total / surface.facet_area[:, None])


def in_zone(angle: np.ndarray, zone: int) -> np.ndarray:
    """Which angles [rad] lie in zone 1 (the ore comes on), 2 (it slides down the arc) or 3 (the straight end)."""
    return np.digitize(angle, ZONE_2) == zone - 1


def zone_share(surface: Surface, zone: int) -> np.ndarray:
    """(f,) [-] the part of each facet that lies in a zone, by angle: borders cut facets"""
    low, high = (-np.inf, *ZONE_2, np.inf)[zone - 1 : zone + 1]
    corner = angle_of(surface.corner.reshape(-1, 3)).reshape(-1, 3)
    first, last = np.full(surface.facet_count, np.inf), np.full(surface.facet_count, -np.inf)
    np.minimum.at(first, surface.facet, corner.min(axis=1))
    np.maximum.at(last, surface.facet, corner.max(axis=1))
    return np.clip(np.minimum(last, high) - np.maximum(first, low), 0.0, None) / (last - first)


# What a stream tells, beside the closed form.


@dataclass(frozen=True)
class Measured:
    """A mean and its standard error."""

    value: float
    error: float = 0.0

    def over(self, other: "Measured") -> "Measured":
        """The quotient of two that do not depend on one another."""
        quotient = self.value / other.value
        return Measured(
            quotient, abs(quotient) * float(np.hypot(self.error / self.value, other.error / other.value))
        )


@dataclass(frozen=True)
class Passage:
    """A steady stream over one geometry; forces and rates are those of the whole width."""

    wear: tuple[Measured, ...]  # [m3/s] of zones 1, 2, 3
    normal_force: Measured  # [N] on zone 2
    friction: Measured  # [-] mu_e of zone 2: force along the chute over normal force
    entry_speed: Measured  # [m/s] of the stream's mass where zone 2 begins
    exit_speed: Measured  # [m/s] of the stream's mass before zone 2 ends, at `EXIT`
    sliding: Measured  # [m/s] at which ore slides over zone 2, weighted by normal force
    speed: Measured  # [m/s] of the stream's mass over zone 2, weighted by the same force
    centre: float  # [m] of the stream's mass in zone 2 above the chute

    @property
    def slip(self) -> Measured:
        """[-] speed at which ore slides over the chute, over that of the stream"""
        return self.sliding.over(self.speed)


def passage(stream: Stream, surface: Surface, loads: FacetLoads, snapshots: Sequence[Flow]) -> Passage:
    """What loads (by block) and snapshots of the same time tell of a stream over `surface`."""
    share, angle = zone_share(surface, 2), facet_angle(surface)
    normal = loads.normal_impulse @ share
    dragged = np.einsum("bfi,fi,f->b", loads.tangential_impulse, along(angle), share)
    seen = [_moving(flow) for flow in snapshots]

    def mean_speed(low: float, high: float) -> Measured:
        inside = [((a >= low) & (a < high), v, m) for a, v, m, _ in seen]
        return ratio(
            np.array([m[i] @ v[i] for i, v, m in inside]), np.array([m[i].sum() for i, _, m in inside])
        )

    edges = np.linspace(*ZONE_2, BINS + 1)
    part = [mean_speed(low, high) for low, high in pairwise(edges)]
    force = np.bincount(np.digitize(angle, edges[1:-1]), loads.normal_impulse.sum(axis=0) * share, BINS)
    weight = force / force.sum()
    height = [(m @ h, m.sum()) for m, h in ((m[in_zone(a, 2)], h[in_zone(a, 2)]) for a, _, m, h in seen)]
    return Passage(
        wear=zone_wear(Archard(SPECIFIC_WEAR_RATE).depth_rate(loads), surface, stream),
        normal_force=ratio(normal / stream.share, loads.duration),
        friction=ratio(dragged, normal),
        entry_speed=mean_speed(ZONE_2[0] - BAND, ZONE_2[0] + BAND),
        exit_speed=mean_speed(EXIT - BAND, EXIT + BAND),
        sliding=ratio(loads.load_distance @ share, normal),
        speed=Measured(
            float(weight @ [one.value for one in part]),
            float(np.linalg.norm(weight * [one.error for one in part])),
        ),
        centre=float(np.divide(*np.sum(height, axis=0))),
    )


def zone_wear(rate: np.ndarray, surface: Surface, stream: Stream) -> tuple[Measured, ...]:
    """Volume rates [m3/s] of the three zones of the whole width from depth rates (b, f) [m/s] by block."""
    volume = rate * surface.facet_area / stream.share
    zones = (volume @ zone_share(surface, zone) for zone in (1, 2, 3))
    return tuple(Measured(float(one.mean()), float(standard_error(one[:, None])[0])) for one in zones)


def ratio(top: np.ndarray, bottom: np.ndarray) -> Measured:
    """Sum of `top` (b,) over sum of `bottom` (b,) for consecutive blocks; its standard error to first order."""
    value = float(top.sum() / bottom.sum())
    residual = (top - value * bottom) / bottom.mean()
    return Measured(value, float(standard_error(residual[:, None])[0]))


def along(angle: np.ndarray) -> np.ndarray:
    """(n, 3) unit vectors down the chute at angles (n,) [rad] of places on it"""
    turned = np.minimum(angle, ARC_END)
    return np.column_stack([np.sin(turned), np.zeros_like(turned), -np.cos(turned)])


def _moving(flow: Flow) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Angle [rad], speed down the chute [m/s], mass [kg] and height above the chute [m] of the particles near the arc"""
    p = flow.particles
    height = RADIUS - np.hypot(p.position[:, 0], p.position[:, 2])
    near = height < REACH
    angle = angle_of(p.position[near])
    return angle, (p.velocity[near] * along(angle)).sum(axis=1), p.mass[near], height[near]


@dataclass(frozen=True)
class Theory:
    """Zone 2 in closed form, at the friction, entry speed and radius of a stream; standard errors are those of the former two."""

    wear: Measured  # [m3/s] of a stream that slides as a block
    normal_force: Measured  # [N]
    exit_speed: Measured  # [m/s] at `EXIT`


def theory(stream: Passage) -> Theory:
    """Zone 2 in closed form, with R that of the stream's centre of mass."""

    def told(friction: float, entry: float) -> np.ndarray:
        start = {
            "friction": friction, "radius": RADIUS - stream.centre, "start_angle": ZONE_2[0], "start_speed": entry,
        }  # fmt: skip
        worn = wear_rate(*ZONE_2, mass_rate=FEED_RATE, specific_wear_rate=SPECIFIC_WEAR_RATE, **start)
        return np.array([worn, normal_force(*ZONE_2, mass_rate=FEED_RATE, **start), speed(EXIT, **start)])

    mu, v = stream.friction, stream.entry_speed
    middle = told(mu.value, v.value)
    by_friction = told(mu.value + mu.error, v.value) - middle
    by_speed = told(mu.value, v.value + v.error) - middle
    return Theory(*map(Measured, middle.tolist(), np.hypot(by_friction, by_speed).tolist()))


# The case.


def case(
    *,
    slice_width: float = 85 * mm,
    shear_modulus: float = 65 * MPa,
    coarsening: float = 2.5,
    rolling_friction: float = 0.3,
    time_step_share: float = 0.25,
    mesh_size: float = 10 * mm,
    smoothing_length: float = 30 * mm,
    limit_thickness: float = 8 * mm,
    tolerance: float = 0.05,
    window: float = 0.4 * second,
    longest_jump: float = 1e12,
    frozen: bool = False,
    stop: float = 1e12,
    seed: int = 1,
) -> LifeCase:
    """The life of the chute under 100 tonnes of ore an hour.

    As published: `slice_width=0`, `shear_modulus=65*GPa`, `coarsening=1`, `mesh_size=6*mm`, and `time_step_share=0.8`, since the printed
    1.5e-6 s is 107 % of the smallest particle's Rayleigh time, which a run refuses.

    Parameters
    ----------
    slice_width
        Of the slice that is simulated [m], periodic across: the bottom without its sides. 0: the whole chute, 0.2 m wide, with its sides.
    shear_modulus
        Of the ore [Pa]; printed: 65 GPa. A softer ore needs fewer time steps.
    coarsening
        Factor on the diameters of the ore, 3 to 8 mm. Coarser ore is fewer particles.
    rolling_friction
        Of the ore on the chute [-]; printed: 0.3. From the sliding friction 0.46 on, balls slide without rolling.
    time_step_share
        Time step over the smallest particle's Rayleigh time [-].
    mesh_size
        Length of the facets along the chute [m]; printed: 6 mm. A slice has one facet across.
    smoothing_length
        Over which the rate of wear is evened out [m].
    limit_thickness
        At which the chute, 20 mm thick when new, is worn out [m].
    tolerance
        Within which its life is to be known [-], 90 times out of 100.
    window
        Of steady flow that a first sample takes [s].
    longest_jump
        In service time [s], whatever else would allow.
    frozen
        Leave the shape as it is new: what the change of shape does to the life shows by comparison.
    stop
        Service time [s] at which to stop, where it comes before the end of life.
    seed
        Of the feed.
    """
    step = time_step_share * rayleigh_time(coarsening, shear_modulus)
    stream = Stream(shear_modulus, coarsening, slice_width, step, seed, rolling_friction)
    liner = Liner(strip(slice_width, mesh_size) if slice_width else trough(mesh_size), STEEL)
    return LifeCase(
        name="transfer_chute",
        flow=stream.nothing,
        sampler=Particles(stream.model),
        liner=liner,
        wear_law=Archard(SPECIFIC_WEAR_RATE),
        goal=worn_to(liner, limit_thickness, tolerance=tolerance),
        window=Window(window, max(10, round(window / BLOCK))),
        warm_up=WARM_UP,
        throughput_rate=FEED_RATE,
        smoothing_length=smoothing_length,
        particle_radius=stream.radii[0],
        longest_jump=longest_jump,
        stop=Stop(service_time=stop),
        frozen=frozen,
        measure=lambda history: figures(history, stream, liner),
        notes=shortcuts(stream, step),
        draw=draw,
    )


def shortcuts(stream: Stream, step: float) -> tuple[str, ...]:
    """What differs from the published simulation, in sentences."""
    notes = []
    if stream.slice_width:
        notes.append(
            f"a slice {stream.slice_width / mm:g} mm wide, periodic across, stands for the bottom; the sides are left out"
        )
    if stream.shear_modulus != SHEAR_MODULUS:
        notes.append(f"the ore's shear modulus is {stream.shear_modulus / MPa:g} MPa instead of 65 GPa")
    if stream.coarsening != 1.0:
        small, large = (2.0 * radius / mm for radius in stream.radii)
        notes.append(f"the ore is {small:g} to {large:g} mm instead of 3 to 8 mm")
    if abs(step / TIME_STEP - 1.0) > 0.05:
        notes.append(f"the time step is {step:.3g} s instead of 1.5e-6 s")
    return (
        *notes,
        "what each of these does to the rates, and the smoothing length to the life, is measured: see the README of the case",
    )


def figures(history: History, stream: Stream, new: Liner) -> tuple[Figure, ...]:
    """The life, and the rates of wear of the new and of the worn chute."""
    told, worn = history.life[-1], wear_surface(history.state.now.liner)
    kept = worn.facet_count == len(new.mesh.wear)  # else all rates are told on the facets of another mesh
    first = zone_wear(history.samples[0].rate, wear_surface(new) if kept else worn, stream)
    last = zone_wear(history.samples[-1].rate, worn, stream)
    straight = float((history.allowed_depth / history.rate[0]).min())
    rows = [
        Figure("end of life", told.time / day, "d"),
        Figure("end of life, half of its 90 % interval", told.error(NINETY) / day, "d"),
        Figure("ore until then", told.time * FEED_RATE / kilotonne, "kt"),
        Figure("end of life, had the new chute's rate stayed", straight / day, "d"),
        Figure("place that is worn out first", float(np.degrees(facet_angle(worn)[told.facet])), "degree"),
    ]
    for zone, (one, other, printed) in enumerate(zip(first, last, PUBLISHED, strict=True), 1):
        source = "Chen et al., section 4.1; see README.md for why it is not met"
        rows += [
            Figure(f"zone {zone}, new chute", 1e10 * one.value, "1e-10 m3/s", 1e10 * printed, source),
            Figure(f"zone {zone}, new chute, standard error", 1e10 * one.error, "1e-10 m3/s"),
            Figure(f"zone {zone}, worn chute", 1e10 * other.value, "1e-10 m3/s"),
            Figure(f"zone {zone}, worn chute, standard error", 1e10 * other.error, "1e-10 m3/s"),
        ]
    cost = Figure("cycles", len(history.reports), "-"), Figure("flow sampled", history.simulated, "s")
    return (*rows, *cost)


def draw(history: History, folder: Path) -> None:
    """The chute from the side with its last stream, and its thickness along itself over its life."""
    surface, flow = wear_surface(history.state.now.liner), history.state.flow
    middle = np.median(surface.point[:, 1])
    y = surface.corner[:, :, 1]
    row = np.unique(surface.facet[(y.min(axis=1) <= middle) & (y.max(axis=1) > middle)])
    row = row[np.argsort(facet_angle(surface)[row])]
    angle, thickness = np.degrees(facet_angle(surface)[row]), 1e3 * history.thickness[:, row]
    with picture(folder / "chute.png", 2, size=(7.0, 5.6)) as (side, along_it):
        _draw_side(side, flow, surface, row, thickness[-1])
        shown = np.unique(np.linspace(0, len(thickness) - 1, 6).round().astype(int))
        lines = {f"{history.service_time[k] / day:.0f} d": thickness[k] for k in shown}
        draw_lines(along_it, angle, lines, "angle on the chute [degree]", "thickness left [mm]")
        for border, zone in zip(np.degrees((ARC_BEGIN, *ZONE_2)), (1, 2, 3), strict=True):
            along_it.axvline(border, color="0.6", linewidth=0.7)
            along_it.annotate(
                f" zone {zone}", (border, 1e3 * THICKNESS), va="bottom", fontsize=8, color="0.4"
            )


def _draw_side(axes: Any, flow: Flow, surface: Surface, row: np.ndarray, thickness: np.ndarray) -> None:
    """Particles by their speed, and the chute by its thickness [mm] along a row of facets, drawn `DRAWN` times as thick as it is."""
    from matplotlib.collections import EllipseCollection, PolyCollection

    p = flow.particles
    circles = EllipseCollection(
        2e3 * p.radius, 2e3 * p.radius, np.zeros(p.count), units="xy", offsets=1e3 * p.position[:, [0, 2]],
        offset_transform=axes.transData, array=np.linalg.norm(p.velocity, axis=1), cmap="viridis", edgecolors="black", linewidths=0.1,
    )  # fmt: skip
    plates = []
    for facet, left in zip(row, thickness, strict=True):
        chosen = surface.facet == facet
        corner = 1e3 * surface.corner[chosen].reshape(-1, 3)[:, [0, 2]]
        ends = corner[[corner[:, 0].argmin(), corner[:, 0].argmax()]]
        back = ends - DRAWN * left * surface.normal[chosen][0, [0, 2]]
        plates.append(np.concatenate([ends, back[::-1]]))
    chute = PolyCollection(
        plates,
        array=thickness,
        cmap="inferno",
        edgecolors="face",
        linewidths=0.3,
        clim=(np.floor(thickness.min()), 1e3 * THICKNESS),
    )
    axes.add_collection(chute)
    axes.add_collection(circles)
    axes.autoscale_view()
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="z [mm]")
    axes.figure.colorbar(circles, ax=axes, label="speed of the ore [m/s]", shrink=0.7)
    axes.figure.colorbar(
        chute, ax=axes, label=f"thickness left [mm], drawn {DRAWN:g} times", shrink=0.7, location="left"
    )
