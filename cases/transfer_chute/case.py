"""Iron ore falls onto a curved steel chute and slides down it, until the chute is worn out.

**Source** Chen, Schott and Lodewijks, Numerical prediction on abrasive wear reduction of bulk solids handling equipment using bionic
design, sections 2 to 4: Figure 1, Tables 1 and 3.

Printed: materials, sizes of the ore, feed, radius, width and slope of the sides, the borders of the zones, the angle at which the ore comes
on, its velocity there, the coefficient of wear. Not printed and chosen here: where exactly the ore comes on, the length of the straight
end, the thickness of the chute and its limit. See README.md.

To make it yours, copy the folder, and change the numbers below and the defaults of `case()`; the frame is that of `CurvedChute`.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import asin, cos, pi, sin, sqrt
from pathlib import Path

import numpy as np

from wearfem.case import Figure, LifeCase, Stop, Window
from wearfem.cycle import Particles, worn_to
from wearfem.dem.contact import ConstantTorque, Contact, HertzMindlin
from wearfem.dem.feed import Inlet, uniform_sizes
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.particles import spheres
from wearfem.history import History
from wearfem.liner.block import with_group
from wearfem.liner.chute import CurvedChute, angle_of, facet_angle, share_between
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.mesh import SolidMesh
from wearfem.material import Interaction, Material
from wearfem.report import draw_lines, picture
from wearfem.report_particles import draw_side
from wearfem.surface import Surface
from wearfem.units import GPa, MPa, day, degree, kg, kilotonne, mm, second
from wearfem.wear.laws import Archard
from wearfem.wear.sampling import Measured, mean_of

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
ARC_END = asin(0.9)  # 64.16 degrees, where zone 2 ends: h3 is a drop of 1.8 m of 2 m
PUBLISHED = (0.97e-10, 1.72e-10, 0.48e-10)  # [m3/s] worn off zones 1, 2, 3; powers of ten partly lost

# Chosen.
ARC_BEGIN = 20 * degree  # above it nothing touches the chute
STRAIGHT = 0.5  # [m] of chute after the arc
THICKNESS = 20 * mm
NINETY = 1.645  # [-] standard deviations within which 90 % lie
DRAWN = 5.0  # [-] how much thicker the chute is drawn than it is
WARM_UP = 0.5  # [s] from the first particle to a steady stream
BLOCK = 0.05  # [s] over which loads are summed for their standard error

CHUTE = CurvedChute(RADIUS, ARC_BEGIN, ARC_END, STRAIGHT, THICKNESS, WIDTH, SIDE, SLOPE)
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
    feed_rate: float = FEED_RATE  # [kg/s] on the whole width

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
            self.share * self.feed_rate,
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


def case(
    *,
    throughput: float = FEED_RATE,
    specific_wear_rate: float = SPECIFIC_WEAR_RATE,
    limit_thickness: float = 8 * mm,
    stop: float = 1e12,
    slice_width: float = 85 * mm,
    shear_modulus: float = 65 * MPa,
    coarsening: float = 2.5,
    rolling_friction: float = 0.3,
    time_step_share: float = 0.25,
    mesh_size: float = 10 * mm,
    smoothing_length: float = 30 * mm,
    tolerance: float = 0.05,
    window: float = 0.4 * second,
    longest_jump: float = 1e12,
    frozen: bool = False,
    seed: int = 1,
) -> LifeCase:
    """The life of the chute under 100 tonnes of ore an hour.

    As published: `slice_width=0`, `shear_modulus=65*GPa`, `coarsening=1`, `mesh_size=6*mm`, and `time_step_share=0.8`, since the printed
    1.5e-6 s is 107 % of the smallest particle's Rayleigh time, which a run refuses.

    Parameters
    ----------
    throughput
        Of ore on the whole width of 0.2 m [kg/s].
    specific_wear_rate
        Volume worn off by force and sliding distance [m2/N]; printed: 3.0e-13. `calibrate` tells it from readings.
    limit_thickness
        At which the chute, 20 mm thick when new, is worn out [m].
    stop
        Service time [s] at which to stop, where it comes before the end of life.
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
    tolerance
        Within which its life is to be known [-], 90 times out of 100.
    window
        Of steady flow that a first sample takes [s].
    longest_jump
        In service time [s], whatever else would allow.
    frozen
        Leave the shape as it is new: what the change of shape does to the life shows by comparison.
    seed
        Of the feed.
    """
    step = time_step_share * rayleigh_time(coarsening, shear_modulus)
    stream = Stream(shear_modulus, coarsening, slice_width, step, seed, rolling_friction, throughput)
    mesh = CHUTE.slice(slice_width, mesh_size) if slice_width else CHUTE.trough(mesh_size)
    liner = Liner(with_zones(mesh), STEEL)
    return LifeCase(
        name=Path(__file__).parent.name,
        flow=stream.nothing,
        sampler=Particles(stream.model),
        liner=liner,
        wear_law=Archard(specific_wear_rate),
        goal=worn_to(liner, limit_thickness, tolerance=tolerance),
        window=Window(window, max(10, round(window / BLOCK))),
        warm_up=WARM_UP,
        throughput_rate=throughput,
        smoothing_length=smoothing_length,
        particle_radius=stream.radii[0],
        longest_jump=longest_jump,
        stop=Stop(service_time=stop),
        frozen=frozen,
        measure=Measure(stream, liner),
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


def zones() -> Iterator[tuple[str, float, float]]:
    """Where the ore comes on (1), slides down the arc (2) and along the straight end (3): name and borders [rad]"""
    for number, (low, high) in enumerate(pairwise((-math.inf, *ZONE_2, math.inf)), 1):
        yield f"zone {number}", low, high


def with_zones(mesh: SolidMesh) -> SolidMesh:
    """The mesh with its zones as groups, so that reports and forecasts tell each by itself."""
    for name, low, high in zones():
        mesh = with_group(
            mesh,
            name,
            lambda centre, low=low, high=high: (angle_of(centre) >= low) & (angle_of(centre) < high),
        )
    return mesh


def zone_wear(rate: np.ndarray, surface: Surface, stream: Stream) -> tuple[Measured, ...]:
    """Volume rates [m3/s] of the zones of the whole width, from depth rates (b, f) [m/s] by block."""
    volume = rate * surface.facet_area / stream.share
    return tuple(mean_of(volume @ share_between(surface, low, high)) for _, low, high in zones())


@dataclass(frozen=True)
class Measure:
    """The figures of a life."""

    stream: Stream
    new: Liner

    def __call__(self, history: History) -> tuple[Figure, ...]:
        """The life, and the rates of wear of the new and of the worn chute."""
        told, worn = history.life[-1], wear_surface(history.state.now.liner)
        # Else all rates are told on the facets of another mesh.
        kept = worn.facet_count == len(self.new.mesh.wear)
        first = zone_wear(history.samples[0].rate, wear_surface(self.new) if kept else worn, self.stream)
        last = zone_wear(history.samples[-1].rate, worn, self.stream)
        straight = float((history.allowed_depth / history.rate[0]).min())
        end = "end of life" if history.ended == "end of life" else "end of life, at the last rate"
        rows = [
            Figure(end, told.time / day, "d"),
            Figure("half of its 90 % interval", history.reports[-1].end_error(NINETY) / day, "d"),
            Figure("ore until then", told.time * self.stream.feed_rate / kilotonne, "kt"),
            Figure("end of life, had the first rate stayed", straight / day, "d"),
            Figure(
                "place that is worn out first", float(np.degrees(facet_angle(worn)[told.facet])), "degree"
            ),
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
    angle = facet_angle(surface)
    middle, y = np.median(surface.point[:, 1]), surface.corner[:, :, 1]
    row = np.unique(surface.facet[(y.min(axis=1) <= middle) & (y.max(axis=1) > middle)])
    row = row[np.argsort(angle[row])]
    thickness = history.thickness[:, row]
    with picture(folder / "chute.png", 2, size=(7.0, 5.6)) as (side, along_it):
        draw_side(side, flow.particles, surface, row, thickness[-1], whole=THICKNESS, drawn=DRAWN)
        shown = np.unique(np.linspace(0, len(thickness) - 1, 6).round().astype(int))
        lines = {f"{history.service_time[k] / day:.0f} d": 1e3 * thickness[k] for k in shown}
        draw_lines(
            along_it, np.degrees(angle[row]), lines, "angle on the chute [degree]", "thickness left [mm]"
        )
        for border, zone in zip(np.degrees((ARC_BEGIN, *ZONE_2)), (1, 2, 3), strict=True):
            along_it.axvline(border, color="0.6", linewidth=0.7)
            along_it.annotate(
                f" zone {zone}", (border, 1e3 * THICKNESS), va="bottom", fontsize=8, color="0.4"
            )
