"""Motion: the order of the time integration, momentum, angular momentum, and an energy ledger that closes."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from wearfem.dem.contact import (
    ConstantTorque,
    Contact,
    ElasticPlasticRolling,
    FrictionTwisting,
    HertzMindlin,
    NoRolling,
)
from wearfem.dem.energy import energy
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.motion import rotation
from wearfem.dem.particles import HELD, spheres
from wearfem.dem.sample import advance
from wearfem.material import Material
from wearfem.proof import Claim
from wearfem.proofs.seams import LOAD, ORE, RADIUS, SPACE, fan, hertz_force, resting_overlap
from wearfem.surface import Plane, Surface

ELASTIC = replace(ORE, name="elastic", restitution=1.0)
STICKY = replace(ORE, name="sticky", friction=100.0)
ROLLING_LAWS = {
    "without rolling resistance": Contact(HertzMindlin(), NoRolling()),
    "with constant torque": Contact(HertzMindlin(), ConstantTorque()),
    "with elastic-plastic rolling and twisting": Contact(
        HertzMindlin(), ElasticPlasticRolling(), FrictionTwisting()
    ),
}


def floor(material: Material) -> tuple[Wall, ...]:
    """The plane z = 0."""
    return (Wall(Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), material)),)


def observed_order(value: Callable[[float], np.ndarray], time_step: float) -> float:
    """Richardson: log2 of |x(dt) - x(dt/2)| / |x(dt/2) - x(dt/4)|."""
    coarse, middle, fine = (value(time_step / 2**k) for k in range(3))
    return float(math.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)))


def after_impact(time_step: float) -> np.ndarray:
    """Height [m] and velocity [m/s] x 1 ms of an elastic sphere that has hit a plane, the contact included from end to end."""
    sphere = spheres(np.array((0.0, 0.0, RADIUS + 1e-4)), RADIUS, ORE.density, velocity=(0.0, 0.0, -0.5))
    flow = advance(Flow(sphere), Model((ELASTIC,), time_step, SPACE, floor(ELASTIC)), 0.004)
    return np.array([flow.particles.position[0, 2], 1e-3 * flow.particles.velocity[0, 2]])


def swing(time_step: float) -> np.ndarray:
    """Place [m] of a sphere that stays in contact, swings up and down and sideways on its tangential spring, damped."""
    overlap = 1.3 * resting_overlap(LOAD, material=STICKY)
    sphere = spheres(
        np.array((0.0, 0.0, RADIUS - overlap)),
        RADIUS,
        ORE.density,
        applied_force=(0.2 * LOAD, 0.0, -LOAD),
        held=HELD["rotation"],
    )
    sphere.wrench[0, 2] = hertz_force(overlap)
    model = Model((STICKY,), time_step, SPACE, floor(STICKY), gravity=(0.0, 0.0, 0.0))
    return advance(Flow(sphere), model, 0.0032).particles.position[0] - (0.0, 0.0, RADIUS)


def colliding_cloud(count: int = 300, duration: float = 0.05) -> tuple[float, float, float]:
    """Change of momentum and of angular momentum of spheres that collide in a cloud, relative to the sums of their sizes; and
    the part of the energy that was lost, which tells that they did collide.
    """
    random = np.random.default_rng(7)
    place = np.stack(np.unravel_index(np.arange(count), (7, 7, 7)), axis=1) - 3.0
    particles = spheres(
        0.011 * place,
        random.uniform(2e-3, 5e-3, count),
        ORE.density,
        velocity=random.normal(0.0, 0.5, (count, 3)) - 8.0 * 0.011 * place,
        angular_velocity=random.normal(0.0, 100.0, (count, 3)),
    )
    law = Contact(HertzMindlin(), ElasticPlasticRolling(), FrictionTwisting())
    model = Model((ORE,), 1e-5, SPACE, contact=law, gravity=(0.0, 0.0, 0.0))
    start = Flow(particles)
    end = advance(start, model, duration)

    def momenta(flow: Flow) -> tuple[np.ndarray, np.ndarray]:
        p = flow.particles
        linear = p.mass[:, None] * p.velocity
        return linear, np.cross(p.position, linear) + p.inertia[:, None] * p.angular_velocity

    (before, turning), (after, turned) = momenta(start), momenta(end)
    shift = np.linalg.norm(after.sum(axis=0) - before.sum(axis=0)) / np.linalg.norm(before, axis=1).sum()
    twist = np.linalg.norm(turned.sum(axis=0) - turning.sum(axis=0)) / np.linalg.norm(turning, axis=1).sum()
    return float(shift), float(twist), 1.0 - end.kinetic_energy / start.kinetic_energy


def tumbling_bed(contact: Contact, time_step: float = 1e-5, duration: float = 1.0) -> tuple[float, float]:
    """What the ledger of a drum with 140 spheres does not account for, and all that was dissipated [J]."""
    ring, length, count = 0.05, 0.05, 48
    rough = Material("rough ore", 2500.0, 1e7 / 2.6, 0.3, 0.5, 0.5, 0.1)
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    rim = np.stack([ring * np.cos(angle), 0.0 * angle, ring * np.sin(angle)], axis=1)
    k = np.arange(count)
    after = (k + 1) % count
    near, far = np.stack([k, after, count + after], axis=1), np.stack([k, count + after, count + k], axis=1)
    shell = Surface(np.concatenate([rim, rim + (0.0, length, 0.0)]), np.concatenate([near, far]), rough)
    walls = (
        Wall(shell, rotation(6.0, axis=(0.0, 1.0, 0.0))),
        Wall(Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), rough)),
        Wall(Plane((0.0, length, 0.0), (0.0, -1.0, 0.0), rough)),
    )
    across = np.arange(-0.03, 0.031, 0.011)
    place = np.array([(x, y, z) for x in across for y in (0.01, 0.02, 0.03, 0.04) for z in across])
    place = place[np.hypot(place[:, 0], place[:, 2]) < 0.04]
    radius = np.random.default_rng(1).uniform(0.003, 0.005, len(place))
    flow = Flow(spheres(place, radius, rough.density))
    model = Model((rough,), time_step, Domain((-0.1,) * 3, (0.1,) * 3), walls, contact=contact)
    start = energy(flow, model)
    end = energy(advance(flow, model, duration), model)
    return end.gap_since(start), end.dissipated


def oblique_gains(count: int = 200) -> np.ndarray:
    """(n,) change of energy, relative to the energy before, of elastic spheres that hit a plane at random angles with random spin."""
    random = np.random.default_rng(12)
    angle, around = np.radians(random.uniform(2.0, 88.0, count)), random.uniform(0.0, 2.0 * np.pi, count)
    speed = random.uniform(0.2, 1.0, count)
    flat = np.stack([np.cos(around), np.sin(around)], axis=1) * (speed * np.sin(angle))[:, None]
    particles = spheres(
        np.stack([0.03 * (np.arange(count) - count / 2), 0.0 * angle, np.full(count, RADIUS + 1e-6)], axis=1),
        RADIUS,
        ORE.density,
        velocity=np.column_stack([flat, -speed * np.cos(angle)]),
        angular_velocity=random.normal(0.0, 100.0, (count, 3)),
    )
    space = Domain((-20.0,) * 3, (20.0,) * 3)
    model = Model((ELASTIC,), 1e-6, space, floor(ELASTIC), gravity=(0.0, 0.0, 0.0))

    def energies(flow: Flow) -> np.ndarray:
        p = flow.particles
        order = np.argsort(p.ident)
        moving = p.mass * (p.velocity**2).sum(axis=1) + p.inertia * (p.angular_velocity**2).sum(axis=1)
        return 0.5 * moving[order]

    start = Flow(particles)
    end = advance(start, model, 0.02)
    gone = (end.particles.position[:, 2] > RADIUS)[np.argsort(end.particles.ident)]
    return (energies(end) / energies(start) - 1.0)[gone]


def turntable(surface: Surface, rate: float = 10.0) -> float:
    """Turning rate [rad/s] of the circle in which a sphere rolls on a turntable of `rate`: 2/7 of it (Earnshaw 1844)."""
    rough = replace(surface, material=STICKY)
    arm, speed = RADIUS - resting_overlap(LOAD), 0.05
    away = 0.04
    # No slip at the start: v + w x (-arm e_z) = rate e_z x position
    spin = np.array([0.0, speed, 0.0]) - np.array([0.0, rate * away, 0.0])
    sphere = spheres(
        np.array((away, 0.0, arm)),
        RADIUS,
        ORE.density,
        velocity=(0.0, speed, 0.0),
        angular_velocity=np.cross((0.0, 0.0, 1.0), spin) / arm,
        applied_force=(0.0, 0.0, -LOAD),
    )
    model = Model((STICKY,), 1e-5, SPACE, (Wall(rough, rotation(rate)),), gravity=(0.0, 0.0, 0.0))
    duration = 0.5
    end = advance(Flow(sphere), model, duration).particles.velocity[0]
    return math.atan2(-end[0], end[1]) / duration


def claims() -> Iterator[Claim]:
    """Second order in the time step, momenta to rounding, energy that is accounted for and never made."""
    verlet = "velocity Verlet is second order"
    order = observed_order(after_impact, 2e-5)
    yield Claim("observed order of an elastic impact", verlet, 2.0, order, "-", 0.1, False, "20, 10 and 5 us")
    order = observed_order(swing, 2e-5)
    yield Claim("observed order of a damped swing", verlet, 2.0, order, "-", 0.1, False, "20, 10 and 5 us")
    shift, twist, lost = colliding_cloud()
    newton = f"Newton's third law, 300 spheres that lost {100 * lost:.0f} % of their energy"
    yield Claim("change of momentum in collisions", newton, 0.0, shift, "-", 1e-13, False, "rounding")
    yield Claim("change of angular momentum in collisions", newton, 0.0, twist, "-", 1e-12, False, "rounding")
    gains = oblique_gains()
    yield Claim(
        "largest gain of energy in 200 elastic oblique impacts",
        "friction takes, nothing gives",
        0.0,
        max(0.0, float(gains.max())),
        "-",
        1e-6,
        False,
        "of the energy before; truncation at 1 us",
    )
    yield Claim(
        "mean change of energy in them",
        "shown",
        0.0,
        float(gains.mean()),
        "-",
        math.inf,
        False,
        "slip and micro-slip of the spring law",
    )
    arm = 1.0 - resting_overlap(LOAD) / RADIUS
    yield Claim(
        "a sphere on a turntable of 10 rad/s circles at",
        "rigid rolling at R less the overlap, 2/7 of 10 rad/s without (Earnshaw 1844)",
        10.0 / (1.0 + arm**2 / 0.4),
        turntable(fan(24)),
        "rad/s",
        1e-4,
        True,
        "a mesh that turns under the sphere",
    )
    for name, contact in ROLLING_LAWS.items():
        gap, dissipated = tumbling_bed(contact)
        yield Claim(
            f"energy of a tumbling bed over 1 s, {name}: not accounted for",
            "conservation of energy",
            0.0,
            gap / dissipated,
            "-",
            1e-3,
            False,
            "of the energy dissipated, 10 us",
        )
