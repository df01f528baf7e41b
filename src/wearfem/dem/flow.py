"""The particles' side of a case: `Model` (what does not change in a window) and `Flow` (what does)."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from wearfem.dem.contact import Contact
from wearfem.dem.feed import Inlet
from wearfem.dem.motion import STILL, Motion
from wearfem.dem.pairs import PairList
from wearfem.dem.particles import Particles
from wearfem.dem.steps import LEDGER
from wearfem.dem.tally import NoTally
from wearfem.dem.wall_list import WallList
from wearfem.errors import UserError
from wearfem.material import Interaction, Material, pair_table
from wearfem.surface import Plane, Surface


@dataclass(frozen=True)
class Wall:
    """A surface or plane with its motion."""

    shape: Surface | Plane
    motion: Motion = STILL


@dataclass(frozen=True)
class Domain:
    """The box that particles stay in. Across a periodic axis they come back on the other side.

    A particle that crosses another side has left: it is taken out where `outlet` is set, else it is an error.
    """

    low: tuple[float, float, float]  # [m]
    high: tuple[float, float, float]  # [m]
    periodic: tuple[bool, bool, bool] = (False, False, False)
    outlet: bool = False

    def __post_init__(self) -> None:
        if not (np.asarray(self.low) < np.asarray(self.high)).all():
            raise UserError(
                f"The domain runs from {self.low} to {self.high} m; each end must lie above its beginning."
            )


@dataclass(frozen=True)
class Model:
    """Everything about the particles' world that stays the same during a window.

    Raises
    ------
    UserError
        for a time step over the stable limit, a domain too narrow to be periodic, or materials that are not named.
    """

    materials: tuple[Material, ...]  # numbered in this order; `Particles.material` refers to it
    time_step: float  # [s]
    domain: Domain
    walls: tuple[Wall, ...] = ()
    interactions: tuple[Interaction, ...] = ()
    contact: Contact = field(default_factory=Contact)
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)  # [m/s2]
    inlets: tuple[Inlet, ...] = ()
    tally: Any = NoTally()
    pair_skin: float | None = None  # [m] margin of the list of pairs; None adapts it to the flow
    wall_skin: float | None = None  # [m] margin of the list of walls; None chooses

    def __post_init__(self) -> None:
        if not self.time_step > 0.0:
            raise UserError(f"The time step is {self.time_step!r} s; it must be above 0.")
        for wall in self.walls:
            if wall.shape.material not in self.materials:
                raise UserError(
                    f"{wall.shape.name} is made of {wall.shape.material.name}, which is not among the model's materials "
                    f"({', '.join(m.name for m in self.materials)}); add it to `materials`."
                )
            if isinstance(wall.shape, Plane) and wall.motion.rate:
                raise UserError(f"{wall.shape.name} is an endless plane and cannot turn; use a surface.")

    @property
    def marks(self) -> tuple[str, ...]:
        """What the walls are, to notice when they change between windows."""
        return tuple(wall.shape.mark for wall in self.walls)

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """The triangulated walls, in order; their facets are numbered one surface after the other."""
        return tuple(wall.shape for wall in self.walls if isinstance(wall.shape, Surface))

    @property
    def facet_count(self) -> int:
        """Number of facets of all surfaces."""
        return sum(surface.facet_count for surface in self.surfaces)

    @cached_property
    def table(self):
        """Contact constants of all pairs of materials."""
        return pair_table(self.materials, self.interactions)

    @property
    def period(self) -> np.ndarray:
        """(3,) [m] 0 along axes that are not periodic"""
        size = np.asarray(self.domain.high, float) - np.asarray(self.domain.low, float)
        return np.where(self.domain.periodic, size, 0.0)

    def rayleigh_time(self, particles: Particles) -> float:
        """Shortest Rayleigh time [s] of the particles: pi R sqrt(rho/G) / (0.1631 nu + 0.8766)."""
        density = particles.mass / (4.0 / 3.0 * np.pi * particles.radius**3)
        shear = np.array([m.shear_modulus for m in self.materials])[particles.material]
        poisson = np.array([m.poisson_ratio for m in self.materials])[particles.material]
        return float(
            (np.pi * particles.radius * np.sqrt(density / shear) / (0.1631 * poisson + 0.8766)).min()
        )


@dataclass(frozen=True)
class Flow:
    """The particles at one time, with all that a restart to the bit needs."""

    particles: Particles
    step: int = 0  # time steps since the start
    time: float = 0.0  # [s]
    time_step: float = 0.0  # [s] of the last window; 0 before the first
    origin: float = (
        0.0  # [s] time when this time step came into use: times are counted from there, not added up
    )
    origin_step: int = 0  # steps since the start at that time
    ledger: np.ndarray = field(default_factory=lambda: np.zeros(LEDGER))  # [J] see steps.py
    pairs: PairList | None = None
    walls: WallList | None = None
    marks: tuple[str, ...] = ()  # of the surfaces and planes that `walls` refers to
    packed: np.ndarray | None = None  # (n, PACKED)
    pair_reference: np.ndarray = field(
        default_factory=lambda: np.zeros((0, 3))
    )  # (n, 3) [m] positions when pairs were listed
    wall_reference: np.ndarray = field(
        default_factory=lambda: np.zeros((0, 3))
    )  # (n, 3) [m] positions when walls were listed
    drift: np.ndarray = field(
        default_factory=lambda: np.zeros(3)
    )  # [m/s] common velocity since pairs were listed
    travel: np.ndarray = field(default_factory=lambda: np.zeros(3))  # [m] apart from drift, in all, of bodies
    pair_skin: float = 0.0  # [m] margin that the pairs were listed with; 0 before
    listed_step: int = 0  # at which pairs were listed
    fed: tuple[float, ...] = ()  # [kg] by inlet
    left_mass: float = 0.0  # [kg] through outlets
    next_ident: int = 0

    @property
    def kinetic_energy(self) -> float:
        """Sum of m v^2 / 2 + I w^2 / 2 [J]"""
        p = self.particles
        return float(
            0.5 * (p.mass[:, None] * p.velocity**2).sum()
            + 0.5 * (p.inertia[:, None] * p.angular_velocity**2).sum()
        )
