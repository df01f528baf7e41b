"""Iron ore falls onto a curved steel chute and slides down it, until the chute is worn out.

**Source** Chen, Schott and Lodewijks, Numerical prediction on abrasive wear reduction of bulk solids handling equipment using bionic
design, sections 2 to 4: Figure 1, Tables 1 and 3.

Printed: materials, sizes of the ore, feed, radius, width and slope of the sides, the borders of the zones, the angle at which the ore comes
on, its velocity there, the coefficient of wear. Not printed and chosen here: where exactly the ore comes on, the length of the straight
end, the thickness of the chute and its limit. See README.md.

Frame: x along, y across, z up, the arc's centre at the origin. An angle on the chute is counted from the horizontal through the centre:
0 where the chute falls straight down, 90 degrees at its bottom.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import asin, cos, pi, sin, sqrt, tan
from pathlib import Path

import numpy as np

from wearfem.case import Figure, LifeCase, Stop, Window
from wearfem.cycle import Particles, worn_to
from wearfem.dem.contact import ConstantTorque, Contact, HertzMindlin
from wearfem.dem.feed import Inlet, uniform_sizes
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.particles import spheres
from wearfem.history import History
from wearfem.liner.block import Hexahedra, block, mapped
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import SolidMesh
from wearfem.loads import FacetLoads
from wearfem.material import Interaction, Material
from wearfem.surface import Surface
from wearfem.units import GPa, MPa, day, degree, kg, mm, second
from wearfem.wear.laws import Archard

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
LAYERS = 2  # of elements through the thickness
STEP_SHARE = 0.25  # of the smallest particle's Rayleigh time
WARM_UP = 0.6  # [s] from the first particle to a steady stream

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
            interactions=(Interaction(stone, STEEL, restitution=0.4, friction=0.46, rolling_friction=0.3),),
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


def case(
    *,
    slice_width: float = 60 * mm,
    shear_modulus: float = 65 * MPa,
    coarsening: float = 1.5,
    time_step: float = 0.0,
    mesh_size: float = 10 * mm,
    smoothing_length: float = 30 * mm,
    window: float = 1.0 * second,
    tolerance: float = 0.05,
    limit_thickness: float = 8 * mm,
    frozen: bool = False,
    stop: float = 1e12,
    seed: int = 1,
) -> LifeCase:
    """The life of the chute."""
    stream = Stream(
        shear_modulus,
        coarsening,
        slice_width,
        time_step or STEP_SHARE * rayleigh_time(coarsening, shear_modulus),
        seed,
    )
    liner = Liner(strip(slice_width, mesh_size) if slice_width else trough(mesh_size), STEEL)
    return LifeCase(
        name="transfer_chute",
        flow=stream.nothing,
        sampler=Particles(stream.model),
        liner=liner,
        wear_law=Archard(SPECIFIC_WEAR_RATE),
        goal=worn_to(liner, limit_thickness, tolerance=tolerance),
        window=Window(window, 20),
        warm_up=WARM_UP,
        throughput_rate=FEED_RATE,
        smoothing_length=smoothing_length,
        particle_radius=stream.radii[0],
        stop=Stop(service_time=stop),
        frozen=frozen,
    )
