"""Two bodies let fly at each other in the engine: the rig of the impact proofs and tests.

Spheres meet a wall 1e9 times stiffer than they are, with Poisson ratio 0, for the rigid plane of the theory. The time step is
1/500 of the elastic contact's duration, several times finer than users need, so that what is left of a difference is the law's and
not the step's: errors of the step are below 1e-5 for elastic and 4e-3 for strongly damped impacts, whose force begins with a
jump or as d^(1/4) within a step. First touch falls between two steps.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.spatial import Delaunay

from wearfem.dem.contact import Contact, HertzMindlin, LinearSpringDashpot
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.particles import spheres
from wearfem.dem.sample import Stepper, advance
from wearfem.material import Material
from wearfem.surface import Plane, Surface, rectangle
from wearfem.verification import impact_theory as theory
from wearfem.verification.impact_tests import Variant
from wearfem.verification.impact_theory import ContactPair, NormalImpact, Sphere
from wearfem.verification.rigid_impact import Impact, Rebound, rigid_rebound, slip_velocity

STEPS = 500  # time steps in the duration of the elastic contact
STIFFER = 1e9  # modulus of a rigid wall over that of the sphere
PHASE = 0.37  # part of a step before first touch: neither on a step nor halfway
UPRIGHT = np.eye(3)

Cut = Callable[
    [float, Material], Surface
]  # a flat wall at height 0 cut into triangles, for a sphere's radius [m]


def grid(cell: float, turn: float = 0.0, mirrored: bool = False) -> Cut:
    """Squares of `cell` radii cut along one diagonal, the other one if `mirrored`, turned by `turn` [rad]; a vertex at the origin."""

    def cut(radius: float, material: Material) -> Surface:
        half = math.ceil(1.5 / cell)
        end = half * cell * radius
        flat = rectangle((-end, -end), (end, end), (2 * half, 2 * half), material)
        point = flat.point * (-1.0 if mirrored else 1.0, 1.0, 1.0)
        sine, cosine = math.sin(turn), math.cos(turn)
        point = point @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        return Surface(point, flat.triangle[:, ::-1] if mirrored else flat.triangle, material)

    return cut


def scattered(edge: float, seed: int) -> Cut:
    """Delaunay triangles between random points about `edge` radii apart, slivers among them; a vertex at the origin."""

    def cut(radius: float, material: Material) -> Surface:
        random = np.random.default_rng(seed)
        inner = random.uniform(-1.5, 1.5, (int((3.0 / edge) ** 2), 2))
        flat = np.concatenate([inner, [[0, 0], [-2, -2], [2, -2], [2, 2], [-2, 2]]]) * radius
        triangle = Delaunay(flat).simplices
        a, b, c = np.moveaxis(flat[triangle], 1, 0)
        turned = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
        triangle = np.where(turned[:, None], triangle[:, ::-1], triangle)
        return Surface(np.column_stack([flat, np.zeros(len(flat))]), triangle, material)

    return cut


MESH = grid(0.5, turn=0.3)  # edges and a vertex within the contact's reach, none along the motion


@dataclass(frozen=True)
class Rig:
    """Two bodies to be let fly at each other in the engine.

    Parameters
    ----------
    variant
        The two bodies.
    friction, restitution
        Of their contact [-].
    law
        Of the contact's force.
    cut
        How a wall is cut into triangles; None for an endless plane.
    frame
        (3, 3) rows: directions of the tangent, of the side, and of the normal from body 2 to body 1.
    spot
        Where on the wall the sphere touches first, along tangent and side [m].
    steps
        Time steps in the duration of the elastic contact.
    """

    variant: Variant
    friction: float
    restitution: float
    law: Any = HertzMindlin()
    cut: Cut | None = None
    frame: np.ndarray = field(default_factory=lambda: UPRIGHT)
    spot: tuple[float, float] = (0.0, 0.0)
    steps: int = STEPS

    @property
    def pair(self) -> ContactPair:
        """Constants of the contact."""
        return theory.contact_pair(self.variant.first, self.variant.second)

    @property
    def damping(self) -> float:
        """Damping ratio [-] of a contact that never pulls."""
        return theory.damping_ratio_without_tension(self.restitution)

    def expected(self, speed: float) -> NormalImpact:
        """The normal impact in closed form."""
        if isinstance(self.law, LinearSpringDashpot):
            return theory.linear_impact(self.pair, speed, self.law.stiffness, self.damping, False)
        return theory.damped_hertz_impact(self.pair, speed, self.damping, False)

    def set_up(self, impact: Impact) -> tuple[Flow, Model, float]:
        """The bodies just before they touch, their world, and the time [s] until they are apart again."""
        first, second = self.variant.first, self.variant.second
        speed = impact.approach_speed
        time_step = replace(self, restitution=1.0).expected(speed).duration / self.steps
        early = PHASE * time_step
        mine = self._material("sphere", first)
        if isinstance(second, Sphere):
            other, bodies = self._material("partner", second), [first, second]
            walls: tuple[Wall, ...] = ()
            share = first.mass / (first.mass + second.mass)
            normal = [-(1.0 - share) * speed, share * speed]
            height = [first.radius - early * normal[0], -second.radius - early * normal[1]]
        else:
            stiff = Sphere(first.radius, first.density, STIFFER * first.elastic_modulus, 0.0)
            other, bodies, normal = self._material("wall", stiff), [first], [-speed]
            height = [first.radius + early * speed]
            walls = (Wall(self._wall(other)),)
        along = impact.tangential_velocity
        place = [[self.spot[0] - along[k] * early, self.spot[1], z] for k, z in enumerate(height)]
        velocity = [[along[k], 0.0, v] for k, v in enumerate(normal)]
        spin = [[0.0, -impact.angular_velocity[k], 0.0] for k in range(len(bodies))]
        particles = spheres(
            np.array(place) @ self.frame,
            np.array([body.radius for body in bodies]),
            np.array([body.density for body in bodies]),
            velocity=np.array(velocity) @ self.frame,
            angular_velocity=np.array(spin) @ self.frame,
            material=np.arange(len(bodies)),
        )
        end = 20.0 * max(body.radius for body in bodies)
        domain = Domain((-end, -end, -end), (end, end, end))
        model = Model(
            (mine, other), time_step, domain, walls, contact=Contact(self.law), gravity=(0.0, 0.0, 0.0)
        )
        return Flow(particles), model, early + 1.05 * self.expected(speed).duration

    def _material(self, name: str, body: Sphere) -> Material:
        shear_modulus = body.elastic_modulus / (2.0 * (1.0 + body.poisson_ratio))
        return Material(
            name, body.density, shear_modulus, body.poisson_ratio, self.restitution, self.friction
        )

    def _wall(self, material: Material) -> Surface | Plane:
        if self.cut is None:
            x, y, z = self.frame[2]
            return Plane((0.0, 0.0, 0.0), (x, y, z), material)
        flat = self.cut(self.variant.first.radius, material)
        return replace(flat, point=flat.point @ self.frame)

    def velocities(self, impact: Impact) -> tuple[np.ndarray, np.ndarray]:
        """Velocities [m/s] and angular velocities [rad/s] after the impact, (bodies, 3) each, along tangent, side and normal."""
        particles = advance(*self.set_up(impact)).particles
        order = np.argsort(particles.ident)
        return particles.velocity[order] @ self.frame.T, particles.angular_velocity[order] @ self.frame.T

    def rebound(self, impact: Impact) -> Rebound:
        """The motion after the impact; it counts as sliding where it does for rigid bodies."""
        first, second = self.variant.first, self.variant.second
        velocity, spin = (np.vstack([rows, np.zeros(3)]) for rows in self.velocities(impact))
        after = Rebound(
            separation_speed=float(velocity[0, 2] - velocity[1, 2]),
            tangential_velocity=(float(velocity[0, 0]), float(velocity[1, 0])),
            angular_velocity=(-float(spin[0, 1]), -float(spin[1, 1])),
            slip_velocity=0.0,
            tangential_impulse=first.mass * float(velocity[0, 0] - impact.tangential_velocity[0]),
            sliding=rigid_rebound(first, second, impact, self.friction, self.restitution).sliding,
        )
        return replace(after, slip_velocity=slip_velocity(first, second, after))

    def watch(self, impact: Impact) -> NormalImpact:
        """A normal impact, looked at after every step."""
        flow, model, duration = self.set_up(impact)
        stepper = Stepper(flow, model)
        rows = []
        for _ in range(math.ceil(duration / model.time_step)):
            stepper.advance(1)
            p = stepper.particles
            order = np.argsort(p.ident)
            height, speed = p.position[order] @ self.frame[2], p.velocity[order] @ self.frame[2]
            push = p.force[order[0]] @ self.frame[2]
            if len(order) == 1:
                rows.append((stepper.time, p.radius[0] - height[0], speed[0], push))
            else:
                rows.append((stepper.time, p.radius.sum() - height[0] + height[1], speed[0] - speed[1], push))
        time, overlap, parting, force = np.array(rows).T
        last = int(np.flatnonzero(force > 0.0)[-1])
        if self.restitution == 1.0:  # apart where the surfaces are: back along the free flight
            end = time[-1] + overlap[-1] / parting[-1]
        else:  # apart where the force ends: on along its last two values
            end = time[last] + model.time_step * force[last] / (force[last - 1] - force[last])
        return NormalImpact(
            end - PHASE * model.time_step, force.max(), overlap.max(), parting[-1] / impact.approach_speed
        )
