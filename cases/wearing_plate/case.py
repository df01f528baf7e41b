"""A simply exposed plate: bulk material slides over it until it has lost what it may. Its life is known in closed form.

With the rate r0 = k p v of a new plate and the depth D that it may lose:

    constant            d = r0 t                                  life = D / r0
    hardness_gradient   d' = r0 / (1 - g d)                       life = (D - g D^2 / 2) / r0
    running_in          d' = r0 (1 + A exp(-d/s))                 life = (D + s ln((1 + A exp(-D/s)) / (1 + A))) / r0

**Source** Archard's law with k = K/H; the effects are `HardnessGradient` and `RunningIn`. The lives are integrals of 1/r over depth.
"""

from dataclasses import dataclass
from math import cos, pi, radians, sin, sqrt
from typing import Any, Literal

import numpy as np

from wearfem.case import Figure, LifeCase, Stop, Window
from wearfem.cycle import Particles
from wearfem.formula import FormulaFlow, Sliding
from wearfem.history import History
from wearfem.liner.block import Tetrahedra, block
from wearfem.liner.liner import Liner
from wearfem.material import Interaction, Material
from wearfem.surface import Plane, Surface
from wearfem.units import MPa, day, kPa, mm
from wearfem.wear.effects import HardnessGradient, RunningIn
from wearfem.wear.jump import Goal
from wearfem.wear.laws import Archard

GRADIENT = 0.05 / mm  # g: hardness falls by half over the depth allowed
EXCESS, RUN_IN = 1.0, 2 * mm  # A, s: twice the rate when new, forgotten after some millimetres
SLOPE = 40.0  # [degree] of the plate under particles, above the angle of friction
ORE_FRICTION = 0.3  # [-] of ore on plate
FEED_SPEED = 1.0  # [m/s] of particles along the plate where they come on


def case(
    *,
    law: Literal["constant", "hardness_gradient", "running_in"] = "hardness_gradient",
    loads: Literal["formula", "particles"] = "formula",
    tolerance: float = 0.02,
    noise: float = 0.2,
    memory: float = 0.5,
    delay: float = 1.0,
    seed: int = 1,
    allowed_depth: float = 10 * mm,
    cells: int = 8,
    jumps: int = 0,
    stop: float = 1e12,
) -> LifeCase:
    """The life of the plate.

    Parameters
    ----------
    law
        What the rate depends on beside the load; see above.
    loads
        By formula, or of a few hundred particles that slide down the plate (coarse: 8 mm balls that do not roll).
    tolerance
        Within which the life is to be known, 90 times out of 100.
    noise, memory, delay
        Of the loads by formula, block by block [-], from block to block [-], after the geometry has changed [s].
    seed
        Of the noise, or of the feed of particles.
    allowed_depth
        D [m] of 20 mm thickness.
    cells
        Of the mesh along the plate.
    jumps
        Equal jumps in the life at least; 0 lets the controller choose.
    stop
        Service time [s] at which to stop, where it comes before the end of life.
    """
    size = (200 * mm, 100 * mm) if loads == "formula" else (200 * mm, 40 * mm)
    steel = Material("steel", 7850.0, 5 * MPa, 0.3, restitution=0.4, friction=ORE_FRICTION)
    mesh = block((0, 0, -20 * mm), (*size, 0), (cells, max(cells // 2, 1), 4), Tetrahedra, name="plate")
    liner = Liner(mesh, steel)
    effects = {
        "constant": (),
        "hardness_gradient": (HardnessGradient(GRADIENT),),
        "running_in": (RunningIn(EXCESS, RUN_IN),),
    }[law]
    common = {
        "name": "wearing_plate",
        "liner": liner,
        "goal": Goal(np.full(len(mesh.wear), allowed_depth), tolerance=tolerance),
        "effects": effects,
        "longest_jump": 1.0001 * life(law, allowed_depth, 1e-9) / jumps if jumps else np.inf,
        "stop": Stop(service_time=stop),
    }
    if loads == "formula":
        flow = Sliding(10 * kPa, 1.0, noise=noise, memory=memory, delay=delay, seed=seed)
        rate = 1e-13 * flow.pressure * flow.speed
        return LifeCase(
            flow=FormulaFlow(),
            sampler=flow,
            wear_law=Archard(1e-13),
            window=Window(10.0, 40),
            warm_up=3.0 * delay,
            throughput_rate=100.0,
            measure=lambda history: figures(history, law, allowed_depth, rate),
            **common,
        )
    balls = Balls(seed, size[0], size[1], steel)
    return LifeCase(
        flow=balls.nothing(),
        sampler=Particles(balls.model),
        wear_law=Archard(balls.coefficient(1e-9)),
        window=Window(0.5, 20),
        warm_up=0.5,
        throughput_rate=balls.feed,
        smoothing_length=20 * mm,
        particle_radius=balls.radius,
        measure=lambda history: particle_figures(history, balls),
        notes=(
            "8 mm balls of 5 MPa shear modulus that do not roll: a check of the coupling, not of any ore",
        ),
        **common,
    )


def life(law: str, depth: float, rate: float) -> float:
    """[s] in which a plate that wears at `rate` when new loses `depth`"""
    if law == "constant":
        return depth / rate
    if law == "hardness_gradient":
        return (depth - 0.5 * GRADIENT * depth**2) / rate
    grown = (1.0 + EXCESS * np.exp(-depth / RUN_IN)) / (1.0 + EXCESS)
    return float((depth + RUN_IN * np.log(grown)) / rate)


def depth_at(law: str, time: Any, rate: float) -> Any:
    """[m] lost after `time` [s]: the lives above, solved for the depth"""
    if law == "constant":
        return rate * time
    if law == "hardness_gradient":
        return (1.0 - np.sqrt(1.0 - 2.0 * GRADIENT * rate * time)) / GRADIENT
    full = (1.0 + EXCESS) * np.exp(rate * time / RUN_IN) - EXCESS  # of exp(d/s) + A = (1 + A) exp(r0 t/s)
    return RUN_IN * np.log(full)


def figures(history: History, law: str, allowed: float, rate: float) -> tuple[Figure, ...]:
    told = history.life[-1]
    true = life(law, allowed, rate)
    promised = history.reports[-1].end_error(1.645)
    end = told.time / day
    if history.ended == "end of life":
        life_told = Figure("end of life", end, "d", true / day, "integral of 1/r over depth", promised / day)
    else:
        life_told = Figure("end of life, at the last rate", end, "d")
    return (
        life_told,
        Figure("promised at 90 %", promised / day, "d"),
        Figure("cycles", len(history.reports), "-"),
        Figure("samples rejected", history.rejected, "-"),
        Figure("flow sampled", history.simulated, "s"),
        Figure("flow sampled over life", history.simulated / told.time, "-"),
    )


@dataclass(frozen=True)
class Balls:
    """A few hundred balls that slide down the plate without rolling: fed at one end, gone at the other."""

    seed: int
    length: float  # [m]
    width: float  # [m] periodic
    steel: Material
    radius: float = 4 * mm
    feed: float = 0.8  # [kg/s]

    @property
    def ore(self) -> Material:
        return Material("ore", 2500.0, 5 * MPa, 0.3, restitution=0.4, friction=0.3, rolling_friction=1.0)

    def nothing(self) -> Any:
        from wearfem.dem.flow import Flow
        from wearfem.dem.particles import spheres

        return Flow(spheres(np.zeros((0, 3)), 0.0, self.ore.density))

    def model(self, surface: Surface) -> Any:
        """Around the worn face. Gravity is turned instead of the plate: balls slide along x."""
        from wearfem.dem.contact import ConstantTorque, Contact, HertzMindlin
        from wearfem.dem.feed import Inlet, uniform_sizes
        from wearfem.dem.flow import Domain, Model, Wall

        ore, slope, r = self.ore, radians(SLOPE), self.radius
        rayleigh = pi * 0.9 * r * sqrt(ore.density / ore.shear_modulus) / (0.1631 * 0.3 + 0.8766)
        return Model(
            materials=(ore, self.steel),
            interactions=(Interaction(ore, self.steel, 0.4, ORE_FRICTION, 1.0),),
            time_step=0.2 * rayleigh,
            domain=Domain(
                (-0.05, 0.0, -30 * mm), (self.length, self.width, 60 * mm), (False, True, False), outlet=True
            ),
            walls=(
                Wall(surface),
                Wall(Plane((0.0, 0.0, -20 * mm), (0.0, 0.0, 1.0), self.steel, "floor")),
            ),
            contact=Contact(HertzMindlin(), ConstantTorque()),
            gravity=(9.81 * sin(slope), 0.0, -9.81 * cos(slope)),
            inlets=(
                Inlet(
                    (1 * mm, 0.0, 0.5 * mm),
                    (1 * mm + 4 * r, self.width, 0.5 * mm + 6 * r),
                    self.feed,
                    uniform_sizes(0.9 * r, 1.1 * r),
                    velocity=(FEED_SPEED, 0.0, 0.0),
                    seed=self.seed,
                ),
            ),
        )

    def expected(self) -> float:
        """[N m/s] sum of normal force times sliding speed: each ball presses with m g cos on its whole way down."""
        return self.feed * 9.81 * cos(radians(SLOPE)) * (self.length - 1 * mm - 2 * self.radius)

    def coefficient(self, rate: float) -> float:
        """[m2/N] with which the plate as a whole wears at this rate [m/s]"""
        return rate * self.length * self.width / self.expected()


def particle_figures(history: History, balls: Balls) -> tuple[Figure, ...]:
    first = history.reports[0].loads
    seen = float(first.load_distance.sum() / first.duration.sum())
    told = history.life[-1]
    return (
        Figure(
            "load distance rate, new plate", seen, "N m/s", balls.expected(), "m g cos(slope) x length x feed",
            0.1 * balls.expected(),
        ),
        Figure("end of life", told.time / day, "d"),
        Figure("promised at 90 %", history.reports[-1].end_error(1.645) / day, "d"),
        Figure("cycles", len(history.reports), "-"),
        Figure("flow sampled", history.simulated, "s"),
    )  # fmt: skip
