"""The slow and obvious particle simulation: every pair and every triangle at every step, in plain numpy, one contact at a time.

A twin of the engine for small cases, written from the formulas and not from the engine's code: it knows no lists, no cells, no
blocks, no threads. Where engine and twin agree to rounding, neither list nor block has lost or doubled a contact.
"""

from itertools import combinations

import numpy as np

from wearfem.dem.contact import Contact, ElasticPlasticRolling, FrictionTwisting, HertzMindlin
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.particles import spheres
from wearfem.material import Material
from wearfem.surface import Plane, rectangle

ORE = Material("ore", 2500.0, 1e7 / 2.6, 0.3, restitution=0.4, friction=0.5, rolling_friction=0.1)
STEEL = Material("steel", 7800.0, 1e8, 0.25, restitution=0.7, friction=0.3, rolling_friction=0.05)


def scene() -> tuple[Flow, Model]:
    """Fourteen spheres of 1.5 to 5 mm on a plate and beside a wall, periodic in x, some across the border."""
    random = np.random.default_rng(11)
    low, width = 0.0, 0.05
    place = np.array(
        [(x, y, z) for z in (0.0049, 0.0125) for y in (0.0, 0.0099) for x in (0.0005, 0.0099, 0.0195, 0.0395)]
    )[:14]
    radius = random.uniform(0.0042, 0.005, 14)
    radius[[2, 6, 9]] = 0.0015, 0.0021, 0.003
    place[:, 1] += 1e-4 * np.arange(14)
    velocity = random.normal(0.0, 0.3, (14, 3)) - (0.0, 0.1, 0.4)
    particles = spheres(
        place,
        radius,
        ORE.density,
        velocity=velocity,
        angular_velocity=random.normal(0.0, 40.0, (14, 3)),
        held=np.where(np.arange(14) == 5, 2 | 8, 0),
    )
    plate = rectangle((low, -0.02), (width, 0.03), (9, 7), STEEL)
    wall = Plane((0.0, -0.0048, 0.0), (0.0, 1.0, 0.0), STEEL)
    model = Model(
        (ORE, STEEL),
        1e-5,
        Domain((low, -0.1, -0.1), (width, 0.1, 0.1), (True, False, False)),
        (Wall(plate), Wall(wall)),
        contact=Contact(HertzMindlin(), ElasticPlasticRolling(), FrictionTwisting()),
    )
    return Flow(particles), model


class Twin:
    """The state of the slow simulation; `step` takes one time step. For the laws and kinds of walls of `scene`."""

    def __init__(self, flow: Flow, model: Model) -> None:
        p = flow.particles
        self.x, self.v, self.w = p.position.copy(), p.velocity.copy(), p.angular_velocity.copy()
        self.radius, self.mass, self.kind = p.radius, p.mass, p.material
        self.free = np.array([[not held & 1 << k for k in range(3)] for held in p.held], float)
        self.turns = np.array([not held & 8 for held in p.held], float)[:, None]
        self.force, self.torque = np.zeros_like(self.x), np.zeros_like(self.x)
        self.model, self.dt, self.period = model, model.time_step, model.period
        self.pairs: dict = {}
        self.walls: list[list] = [[] for _ in self.x]

    def step(self) -> None:
        """Half a kick, drift, forces with the velocity predicted for the end of the step, half a kick."""
        a = (self.force / self.mass[:, None] + np.array(self.model.gravity)) * self.free
        alpha = self.torque / (0.4 * self.mass * self.radius**2)[:, None] * self.turns
        self.v = self.v + 0.5 * self.dt * a
        self.w = self.w + 0.5 * self.dt * alpha
        self.x = self.x + self.dt * self.v
        v, w = self.v + 0.5 * self.dt * a, self.w + 0.5 * self.dt * alpha
        self.force, self.torque = np.zeros_like(self.x), np.zeros_like(self.x)
        self.between_particles(v, w)
        self.with_walls(v, w)
        a = (self.force / self.mass[:, None] + np.array(self.model.gravity)) * self.free
        alpha = self.torque / (0.4 * self.mass * self.radius**2)[:, None] * self.turns
        self.v = self.v + 0.5 * self.dt * a
        self.w = self.w + 0.5 * self.dt * alpha

    def between_particles(self, v, w) -> None:
        """All pairs, each once."""
        touched = {}
        for i, j in combinations(range(len(self.x)), 2):
            apart = self.x[i] - self.x[j]
            for k in range(3):
                if self.period[k]:
                    apart[k] -= self.period[k] * round(apart[k] / self.period[k])
            distance = np.sqrt(apart @ apart)
            overlap = self.radius[i] + self.radius[j] - distance
            if overlap <= 0:
                continue
            n = apart / distance
            whole = self.radius[i] + self.radius[j]
            arm_i = self.radius[i] - overlap * self.radius[j] / whole
            arm_j = self.radius[j] - overlap * self.radius[i] / whole
            at_i, at_j = v[i] + np.cross(w[i], -arm_i * n), v[j] + np.cross(w[j], arm_j * n)
            size = self.radius[i] * self.radius[j] / whole
            mass = self.mass[i] * self.mass[j] / (self.mass[i] + self.mass[j])
            spin = 0.5 * (w[i] + w[j]) @ n
            force, couple, touched[i, j] = self.contact(
                size, mass, self.kind[i], self.kind[j], overlap, n, at_i - at_j, w[i] - w[j], spin, self.pairs.get((i, j))
            )  # fmt: skip
            self.force[i] += force
            self.force[j] -= force
            self.torque[i] += np.cross(-arm_i * n, force) + couple
            self.torque[j] += np.cross(arm_j * n, -force) - couple
        self.pairs = touched

    def with_walls(self, v, w) -> None:
        """All particles with all triangles, their periodic copies, and all planes."""
        for i, x in enumerate(self.x):
            found = []
            for body, wall in enumerate(self.model.walls):
                kind = self.model.materials.index(wall.shape.material)
                if isinstance(wall.shape, Plane):
                    n = np.array(wall.shape.normal)
                    height = (x - np.array(wall.shape.point)) @ n
                    places = [x - height * n]
                else:
                    shifts = [m * self.period[0] * np.array([1.0, 0.0, 0.0]) for m in (-1, 0, 1)]
                    home = np.floor(x[0] / self.period[0]) * self.period[0] * np.array([1.0, 0.0, 0.0])
                    copies = [corner + home + s for corner in wall.shape.corner for s in shifts]
                    near = [copy for copy in copies if not out_of_reach(copy, x, self.radius[i])]
                    places = [nearest_point(copy, x) for copy in near]
                for place in places:
                    overlap = self.radius[i] - np.linalg.norm(x - place)
                    if overlap > 0:
                        found.append((overlap, place, (x - place) / np.linalg.norm(x - place), body, kind))
            kept = []
            for (overlap, place, n, body, kind), share in zip(
                found, shares(found, self.radius[i]), strict=True
            ):
                if share == 0.0:
                    continue
                old = [c for c in self.walls[i] if c[0] == body and c[2] @ n > 0.5]
                old = min(old, key=lambda c: np.linalg.norm(c[1] - place), default=None)
                if old is not None and np.linalg.norm(old[1] - place) > 0.5 * self.radius[i]:
                    old = None
                arm = self.radius[i] - overlap
                speed = v[i] + np.cross(w[i], -arm * n)
                force, couple, memory = self.contact(
                    self.radius[i], self.mass[i], self.kind[i], kind, overlap, n, speed, w[i], 0.5 * w[i] @ n,
                    None if old is None else old[3],
                )  # fmt: skip
                self.force[i] += share * force
                self.torque[i] += share * (np.cross(-arm * n, force) + couple)
                kept.append((body, place, n, memory))
            self.walls[i] = kept

    def contact(self, size, mass, one, other, overlap, n, velocity, turning, spin, memory):
        """Force and couple on the particle; memory: tangential displacement and rolled and twisted angles half a step ahead, stiffness."""
        a, b = self.model.materials[one], self.model.materials[other]
        modulus = 1 / (
            (1 - a.poisson_ratio) / (2 * a.shear_modulus) + (1 - b.poisson_ratio) / (2 * b.shear_modulus)
        )
        shear = 1 / ((2 - a.poisson_ratio) / a.shear_modulus + (2 - b.poisson_ratio) / b.shear_modulus)
        beta = self.model.table.damping_ratio[one, other]
        friction, rolling = np.sqrt(a.friction * b.friction), np.sqrt(a.rolling_friction * b.rolling_friction)
        dt = self.dt
        patch = np.sqrt(size * overlap)
        k_n, k_t = 2 * modulus * patch, 8 * shear * patch
        elastic = 4 / 3 * modulus * np.sqrt(size) * overlap**1.5
        load = max(0.0, elastic - 2 * np.sqrt(5 / 6) * beta * np.sqrt(k_n * mass) * (velocity @ n))
        slide = velocity - velocity @ n * n
        roll = turning - turning @ n * n
        s, r, twist, k_before = memory or (np.zeros(3), np.zeros(3), 0.0, 0.0)
        keep = min(1.0, k_before / k_t)

        def carried(vector):
            turned = vector + spin * dt * np.cross(n, vector)
            flat = turned - turned @ n * n
            length = np.linalg.norm(flat)
            return flat * (np.linalg.norm(vector) / length) if length else flat

        s = keep * carried(s) + 0.5 * dt * slide
        s, shove = slip(s, k_t, 2 * np.sqrt(5 / 6) * beta * np.sqrt(k_t * mass), slide, friction * load)
        k_r = 2.25 * elastic / overlap * (rolling * size) ** 2
        r = keep * carried(r) + 0.5 * dt * roll
        damping = 2 * 0.3 * np.sqrt(1.4 * mass * size**2 * k_r)
        r, resistance = slip(r, k_r, damping, roll, rolling * load * size)
        k_s = 0.5 * k_t * patch**2
        along = turning @ n
        angle = twist + 0.5 * dt * along
        most = 2 / 3 * patch * friction * load
        angle = min(max(angle, -most / k_s), most / k_s)
        ahead = (s + 0.5 * dt * slide, r + 0.5 * dt * roll, angle + 0.5 * dt * along, k_t)
        return load * n + shove, resistance - k_s * angle * n, ahead


def slip(u, stiffness, damping, velocity, limit):
    """Displacement and force of a spring that slips at `limit`, with as much of its dashpot as the limit leaves."""
    pull = stiffness * np.linalg.norm(u)
    if pull > limit:
        u = u * (limit / pull)
    spring, dash = stiffness * u, damping * velocity
    a, b, c = dash @ dash, 2 * spring @ dash, spring @ spring - limit**2
    part = 0.0
    if a > 0:
        part = min(1.0, max(0.0, (-b + np.sqrt(max(b * b - 4 * a * c, 0.0))) / (2 * a)))
    return u, -spring - part * dash


def out_of_reach(corner, x, radius):
    """Whether the box around a triangle is farther than a radius."""
    return (corner.min(axis=0) > x + radius).any() or (corner.max(axis=0) < x - radius).any()


def nearest_point(corner, x):
    """The nearest point of a triangle: the foot on its plane if that is inside, else the nearest of those on its edges."""
    a, b, c = corner
    inside = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), x - a, rcond=None)[0]
    if inside.min() >= 0 and inside.sum() <= 1:
        return a + inside[0] * (b - a) + inside[1] * (c - a)
    on_edges = []
    for p, q in ((a, b), (b, c), (c, a)):
        part = np.clip((x - p) @ (q - p) / ((q - p) @ (q - p)), 0, 1)
        on_edges.append(p + part * (q - p))
    return min(on_edges, key=lambda point: np.linalg.norm(point - x))


def shares(found, radius):
    """Part of its overlap that each candidate (overlap, point, normal, ...) has: by trying all sets of acting ones."""
    deep = sorted(range(len(found)), key=lambda a: (-found[a][0], a))
    left = []
    for rank, a in enumerate(deep):
        above = [(found[a][1] - found[b][1]) @ found[b][2] > 1e-9 * radius for b in deep[:rank]]
        if all(above):
            left.append(a)
    result = np.zeros(len(found))
    overlap = np.array([found[a][0] for a in left])
    common = np.eye(len(left))
    for p, q in combinations(range(len(left)), 2):
        one, other = found[left[p]], found[left[q]]
        apart = ((one[1] - other[1]) ** 2).sum() / (4 * radius * max(one[0], other[0]))
        common[p, q] = common[q, p] = max(0, one[2] @ other[2]) * max(0, 1 - apart)
    for count in range(len(left), 0, -1):
        for acting in map(list, combinations(range(len(left)), count)):
            part = np.zeros(len(left))
            part[acting] = np.linalg.solve(common[np.ix_(acting, acting)], overlap[acting])
            if (part >= 0).all() and (common @ part >= overlap - 1e-15).all():
                result[left] = part / overlap
                return result
    return result
