"""Iron ore leaves a box through its front: what stays comes to rest at a slope, beside the published one."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wearfem.case import Window
from wearfem.dem.contact import Contact, ElasticPlasticRolling, HertzMindlin
from wearfem.dem.feed import packing, uniform_sizes
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.particles import spheres
from wearfem.dem.sample import sample
from wearfem.material import Interaction, Material
from wearfem.proof import Claim
from wearfem.slope import fit_line, free_surface
from wearfem.surface import Plane, rectangle

ORE = Material("ore", 4865.0, 1e7, 0.24, restitution=0.45, friction=0.41, rolling_friction=0.22)
STEEL = Material("steel", 7932.0, 78e9, 0.3)
SIZES = uniform_sizes(3e-3, 8e-3)  # radii: twice the published sizes, for speed
WIDTH, BOX = 0.064, 0.15  # [m] periodic; length of the box
TIME_STEP = 5e-5  # [s] 22 % of the smallest particle's Rayleigh time


def claims() -> Iterator[Claim]:
    """A quarter of a minute: a column of ore settles in a box, then one side is taken away."""
    floor = Wall(rectangle((0.0, 0.0), (BOX, WIDTH), (1, 1), STEEL, name="floor"))
    behind = Wall(Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), STEEL, "wall behind"))
    gate = Wall(Plane((BOX, 0.0, 0.0), (-1.0, 0.0, 0.0), STEEL, "gate"))
    model = Model(
        materials=(ORE, STEEL),
        interactions=(Interaction(ORE, STEEL, restitution=0.4, friction=0.46, rolling_friction=0.3),),
        time_step=TIME_STEP,
        domain=Domain((-0.02, 0.0, -0.1), (0.6, WIDTH, 0.7), (False, True, False), outlet=True),
        contact=Contact(HertzMindlin(), ElasticPlasticRolling()),
        walls=(floor, behind, gate),
    )
    radius, position = packing(
        (0.0, 0.0, 0.0), (BOX, WIDTH, 0.65), SIZES, mass=2.5, density=ORE.density, seed=1
    )
    column, _, _ = sample(Flow(spheres(position, radius, ORE.density)), model, Window(0.5, block_count=10))
    opened = replace(model, walls=(floor, behind))
    heap, _, _ = sample(column, opened, Window(2.0, block_count=20), until=_rests)
    p = heap.particles
    yield Claim(
        "the mass is kept",
        "what was packed, left in the box and fallen out of it",
        float((ORE.density * 4.0 / 3.0 * np.pi * radius**3).sum()),
        float(p.mass.sum()) + heap.left_mass,
        "kg",
        1e-12,
        True,
        "rounding of a sum",
    )
    yield Claim(
        "a heap of spheres that resist rolling comes to rest",
        "kinetic energy over that of the fall, 0 at rest",
        0.0,
        heap.kinetic_energy
        / float((radius**3 * position[:, 2]).sum() * ORE.density * 4.0 / 3.0 * np.pi * 9.81),
        "-",
        1e-4,
        False,
        "a last sphere may still be falling",
    )
    surface = free_surface(
        p.position[:, 0],
        p.position[:, 1],
        p.position[:, 2],
        p.radius,
        cell=SIZES.smallest + SIZES.largest,
        width=WIDTH,
    )
    yield Claim(
        "slope of what is left in the box",
        "Chen, Schott and Lodewijks, Table 2, Experiment 1, phi 1",
        33.8,
        fit_line(surface).angle,
        "degree",
        float("inf"),
        False,
        "shown, not judged: spheres of twice the size, elastic-plastic rolling; `cases/angle_of_repose` is the whole experiment",
    )


def _rests(flow: Flow) -> bool:
    return flow.kinetic_energy < 1e-5 * float(flow.particles.mass.sum())
