"""Seams: what particles feel on a surface, and the wear that they leave, do not depend on how it is cut into triangles."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

from wearfem.case import Window
from wearfem.dem.contact import Contact, HertzMindlin
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.particles import HELD, spheres
from wearfem.dem.sample import Stepper, advance, sample
from wearfem.material import Material
from wearfem.proof import Claim
from wearfem.surface import Plane, Surface, rectangle

ORE = Material("ore", 2500.0, 1e7 / 2.6, 0.3, restitution=0.5, friction=0.5)
SLIPPERY = replace(ORE, name="slippery", friction=0.0)
ELASTIC = replace(SLIPPERY, name="elastic", restitution=1.0)
RADIUS = 5e-3  # [m]
LOAD = 0.02  # [N] 1.6 times the weight of such a sphere
TIME_STEP = 1e-5  # [s] 2 % of the Rayleigh time
SETTLING = 0.2  # [s] some 40 times the time in which a contact's swing falls to a third
SPACE = Domain((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
DRAGGED = HELD["x"] | HELD["y"] | HELD["rotation"]
HELD_FAST = HELD["x"] | HELD["y"] | HELD["z"] | HELD["rotation"]


@dataclass(frozen=True)
class Trace:
    """What one sphere felt, step by step."""

    position: np.ndarray  # (s, 3) [m]
    velocity: np.ndarray  # (s, 3) [m/s]
    force: np.ndarray  # (s, 3) [N] of all contacts
    contacts: np.ndarray  # (s,) with walls


def wall_contacts(stepper: Stepper) -> int:
    """How many contacts particles have with walls."""
    walls = stepper.walls
    return 0 if walls is None else int((walls.body >= 0).sum())


def watch(flow: Flow, model: Model, steps: int) -> Trace:
    """Follow the only sphere of a flow."""
    stepper, rows = Stepper(flow, model), []
    for _ in range(steps):
        stepper.advance(1)
        p = stepper.particles
        touching = wall_contacts(stepper)
        rows.append(np.concatenate([p.position[0], p.velocity[0], p.force[0], [float(touching)]]))
    table = np.array(rows)
    return Trace(table[:, 0:3], table[:, 3:6], table[:, 6:9], table[:, 9])


def hertz_force(overlap: float, radius: float = RADIUS, material: Material = ORE) -> float:
    """4/3 E* sqrt(R) d^(3/2) [N] of a sphere on a plane of its own material, E* = G / (1 - nu)."""
    return (
        4.0
        / 3.0
        * material.shear_modulus
        / (1.0 - material.poisson_ratio)
        * math.sqrt(radius * overlap)
        * overlap
    )


def resting_overlap(load: float, radius: float = RADIUS, material: Material = ORE) -> float:
    """Overlap [m] at which `hertz_force` is `load`."""
    return (load / hertz_force(1.0, radius, material)) ** (2.0 / 3.0)


# ------------------------------------------------------------------------------------------------ plates


def plate(cells: int, parts: int = 1, *, seed: int | None = None, material: Material = ORE) -> Surface:
    """A square plate of 0.2 m in `cells` x `cells` facets, each of `parts` x `parts` squares of two triangles.

    With a seed, diagonals are drawn, and points and triangles are numbered at random.
    """
    whole = rectangle((-0.1, -0.1), (0.1, 0.1), (cells * parts, cells * parts), material)
    triangle = whole.triangle.copy()
    row, column = np.divmod(np.arange(len(triangle)) // 2, cells * parts)
    facet = row // parts * cells + column // parts
    if seed is None:
        return replace(whole, facet=facet)
    random = np.random.default_rng(seed)
    flipped = np.repeat(random.random(len(triangle) // 2) < 0.5, 2)
    a, b, c, d = triangle[0::2, 0], triangle[0::2, 1], triangle[0::2, 2], triangle[1::2, 2]
    other = np.stack([a, b, d, b, c, d], axis=1).reshape(-1, 3)
    triangle[flipped] = other[flipped]
    number, order = random.permutation(len(whole.point)), random.permutation(len(triangle))
    point = np.empty_like(whole.point)
    point[number] = whole.point
    return Surface(point, number[triangle][order], material, facet[order])


def scattered_plate(count: int, seed: int) -> Surface:
    """The same square as the Delaunay triangles of random points: thin and small ones among them."""
    random = np.random.default_rng(seed)
    edge = np.array([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)])
    point = np.concatenate([edge, random.uniform(-0.1, 0.1, (count, 2))])
    triangle = Delaunay(point).simplices
    u, v = point[triangle[:, 1]] - point[triangle[:, 0]], point[triangle[:, 2]] - point[triangle[:, 0]]
    inverted = u[:, 0] * v[:, 1] < u[:, 1] * v[:, 0]
    triangle[inverted] = triangle[inverted][:, [0, 2, 1]]
    return Surface(np.column_stack([point, np.zeros(len(point))]), triangle, ORE)


def fan(count: int) -> Surface:
    """A disc cut like a cake: all triangles meet at the origin."""
    angle = 2.0 * np.pi * np.arange(count) / count
    rim = 0.1 * np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    k = np.arange(count)
    return Surface(
        np.concatenate([np.zeros((1, 3)), rim]), np.stack([0 * k, 1 + k, 1 + (k + 1) % count], axis=1), ORE
    )


def patchwork() -> tuple[Surface, ...]:
    """The square as two surfaces side by side, one coarse and one fine: joints are T-joints between different surfaces."""
    return (
        rectangle((-0.1, -0.1), (0.0, 0.1), (1, 1), ORE, name="coarse"),
        rectangle((0.0, -0.1), (0.1, 0.1), (7, 13), ORE, name="fine"),
    )


PLATES: dict[str, tuple[Surface, ...]] = {
    "two triangles": (plate(1),),
    "squares of 5 mm": (plate(40),),
    "squares of 5 mm, diagonals and numbers at random": (plate(40, seed=1),),
    "400 random points": (scattered_plate(400, seed=2),),
    "40 triangles at one vertex": (fan(40),),
    "two surfaces with T-joints": patchwork(),
}

# Where a sphere starts and which way it goes: across at an angle, along a joint, along a diagonal, through a vertex.
WAYS: dict[str, tuple[tuple[float, float], tuple[float, float]]] = {
    "at an angle": ((-0.0071, -0.0043), (0.9, 0.37)),
    "along a joint": ((-0.0073, 0.0), (1.0, 0.0)),
    "along a diagonal": ((-0.0073, -0.0073), (1.0, 1.0)),
    "through a vertex": ((-0.00625, -0.0025), (1.0, 0.4)),
}


def on_the_plate(
    shapes: Sequence[Surface | Plane],
    start: tuple[float, float],
    way: tuple[float, float],
    *,
    speed: float,
    rolling: bool,
    time_step: float = TIME_STEP,
) -> tuple[Flow, Model]:
    """A sphere pressed on a plate by `LOAD`, come to rest, then dragged at `speed` [m/s] without turning, or rolling freely."""
    overlap = resting_overlap(LOAD)
    along = np.array([*way, 0.0]) / math.hypot(*way)
    sphere = spheres(
        np.array((*start, RADIUS - overlap)),
        RADIUS,
        ORE.density,
        applied_force=(0.0, 0.0, -LOAD),
        held=DRAGGED,
    )
    walls = tuple(Wall(shape) for shape in shapes)
    model = Model((ORE,), time_step, SPACE, walls, gravity=(0.0, 0.0, 0.0))
    flow = advance(Flow(sphere), model, SETTLING)
    turning = rolling * speed / (RADIUS - overlap) * np.cross((0.0, 0.0, 1.0), along)
    moving = flow.particles._replace(
        velocity=np.array([speed * along]),
        angular_velocity=np.array([turning]),
        held=np.array([0 if rolling else DRAGGED], np.uint8),
    )
    return replace(flow, particles=moving), model


def dragged(shapes: Sequence[Surface | Plane], start: tuple[float, float], way: tuple[float, float]) -> Trace:
    """15 mm of sliding in 1500 steps."""
    return watch(*on_the_plate(shapes, start, way, speed=1.0, rolling=False), 1500)


def rolled(shapes: Sequence[Surface | Plane], start: tuple[float, float], way: tuple[float, float]) -> Trace:
    """15 mm of rolling in 1500 steps."""
    return watch(*on_the_plate(shapes, start, way, speed=1.0, rolling=True), 1500)


def farthest(values: np.ndarray, expected: float) -> float:
    """The value that lies farthest from what is expected."""
    return float(values[np.argmax(np.abs(values - expected))])


# ------------------------------------------------------------------------------------------------- loads


def block_wear(surface: Surface, load: float, speed: float, duration: float) -> tuple[float, float]:
    """Load times distance [N m] that a block left on a surface, all facets together, and load x speed x duration.

    The block is four spheres of two sizes that are dragged at one speed without turning, and carry equal parts of the load.
    """
    radius = np.array([5e-3, 5e-3, 4e-3, 4e-3])
    place = np.array([(-0.03, -0.03), (-0.03, 0.01), (0.01, -0.03), (0.011, 0.011)])
    height = radius - [resting_overlap(load / 4.0, r) for r in radius]
    sphere = spheres(
        np.column_stack([place, height]),
        radius,
        ORE.density,
        applied_force=(0.0, 0.0, -load / 4.0),
        held=DRAGGED,
    )
    model = Model((ORE,), TIME_STEP, SPACE, (Wall(surface),), gravity=(0.0, 0.0, 0.0))
    flow = advance(Flow(sphere), model, SETTLING)
    velocity = np.tile((0.8 * speed, 0.6 * speed, 0.0), (4, 1))
    moving = replace(flow, particles=flow.particles._replace(velocity=velocity))
    _, loads, _ = sample(moving, model, Window(duration))
    steps = round(duration / TIME_STEP)
    return float(loads.load_distance.sum()), load * speed * steps * TIME_STEP


def thrown_loads(surface: Surface, turn: Rotation | None = None, duration: float = 0.1) -> np.ndarray:
    """(5, f) loads by facet of a spinning sphere that is thrown on a plate, hops, slides and rolls; all in a frame turned by `turn`.

    Normal impulse, friction work, load times distance, time in contact, first touches.
    """
    frame = turn or Rotation.identity()
    sphere = spheres(
        frame.apply((-0.0413, -0.0291, RADIUS + 2e-4)),
        RADIUS,
        ORE.density,
        velocity=frame.apply((0.9, 0.5, -0.2)),
        angular_velocity=frame.apply((10.0, -20.0, 30.0)),
    )
    turned = replace(surface, point=frame.apply(surface.point))
    model = Model((ORE,), TIME_STEP, SPACE, (Wall(turned),), gravity=tuple(frame.apply((0.0, 0.0, -9.81))))
    _, loads, _ = sample(Flow(sphere), model, Window(duration))
    return np.concatenate(
        [
            loads.normal_impulse,
            loads.friction_work,
            loads.load_distance,
            loads.contact_time,
            loads.contact_count,
        ]
    )


def apart(loads: np.ndarray, reference: np.ndarray) -> float:
    """Largest difference of any load on any facet, relative to the sum of that load over all facets."""
    return float((np.abs(loads - reference) / reference.sum(axis=1, keepdims=True)).max())


# ---------------------------------------------------------------------------------- corners, edges, vertices


def valley(tilt: float, parts: int = 1, material: Material = SLIPPERY, size: float = 0.2) -> Surface:
    """Two plates that meet at x = 0, y along the joint, each rising from it by `tilt` [degrees]; a ridge if negative."""
    flat = plate(2, parts, material=material)
    x, y, _ = size / 0.2 * flat.point.T
    slope = math.radians(tilt)
    return replace(
        flat,
        point=np.column_stack([x * math.cos(slope), y, np.abs(x) * math.sin(slope)]),
        facet=(flat.corner[:, :, 0].mean(axis=1) > 0.0).astype(int),
    )


def forces_in_groove(tilt: float, load: float = LOAD) -> np.ndarray:
    """(2,) [N] normal force of each side of a valley on a sphere that came to rest in it, pressed down by `load`."""
    away = (RADIUS - resting_overlap(load)) / math.cos(math.radians(tilt))
    sphere = spheres(np.array((0.0, 3e-4, away)), RADIUS, ORE.density, applied_force=(0.0, 0.0, -load))
    model = Model((SLIPPERY,), TIME_STEP, SPACE, (Wall(valley(tilt)),), gravity=(0.0, 0.0, 0.0))
    settled = advance(Flow(sphere), model, 0.3)
    _, loads, _ = sample(settled, model, Window(0.001))
    return loads.normal_impulse[0] / loads.duration[0]


def across_joint(tilt: float, steps: int, parts: int = 1, size: float = 0.2) -> np.ndarray:
    """(s, 3) [N] force on a sphere led over the joint of a valley at one height, where it is pressed in by the depth of `LOAD`."""
    depth, reach = resting_overlap(LOAD), 2e-3
    height = (RADIUS - depth) / math.cos(math.radians(tilt))
    duration = steps * TIME_STEP
    sphere = spheres(
        np.array((-0.4 * reach, 3e-4, height)),
        RADIUS,
        ORE.density,
        velocity=(reach / duration, 0.0, 0.0),
        held=HELD_FAST,
    )
    walls = (Wall(valley(tilt, parts, ELASTIC, size)),)
    model = Model((ELASTIC,), TIME_STEP, SPACE, walls, contact=Contact(HertzMindlin()))
    return watch(Flow(sphere), model, steps).force


def largest_jump_ratio(tilt: float, parts: int = 1) -> float:
    """Largest change of force from step to step, with steps half as long over the same way: 1/2 where force is continuous."""
    coarse, fine = (
        np.linalg.norm(np.diff(across_joint(tilt, steps, parts), axis=0), axis=1).max()
        for steps in (2000, 4000)
    )
    return float(fine / coarse)


def stiffening(tilt: float) -> float:
    """Force of a valley on a sphere in its joint over that of a plane at the same depth, along the upward direction."""
    depth = resting_overlap(LOAD)
    height = (RADIUS - depth) / math.cos(math.radians(tilt))
    sphere = spheres(np.array((0.0, 3e-4, height)), RADIUS, ORE.density, held=HELD_FAST)
    model = Model((ELASTIC,), TIME_STEP, SPACE, (Wall(valley(tilt, 1, ELASTIC)),))
    return float(watch(Flow(sphere), model, 1).force[0, 2] / LOAD)


def leaves_edge_at(speed: float = 0.05) -> tuple[float, float]:
    """Angle from the vertical [degrees] at which a sphere that rolls over a square edge leaves it, computed and by theory.

    Without slip, 7/10 v^2 grows by g R (1 - cos), and the edge holds until v^2 = g R cos: cos = 10/17 + 7/17 v0^2 / (g R).
    """
    rough = replace(ORE, name="rough", friction=50.0, shear_modulus=1e10)
    top = rectangle((-0.05, -0.05), (0.0, 0.05), (3, 5), rough)
    side = Surface(
        np.array([(0, -0.05, 0), (0, 0.05, 0), (0, 0.05, -0.1), (0, -0.05, -0.1)], float),
        np.array([(0, 2, 1), (0, 3, 2)]),
        rough,
        name="side",
    )
    weight = 4.0 / 3.0 * math.pi * RADIUS**3 * ORE.density * 9.81
    overlap = resting_overlap(weight, material=rough)
    arm = RADIUS - overlap
    sphere = spheres(
        np.array((-0.002, 0.0037, arm)),
        RADIUS,
        ORE.density,
        velocity=(speed, 0.0, 0.0),
        angular_velocity=(0.0, speed / arm, 0.0),
    )
    stepper = Stepper(Flow(sphere), Model((rough,), 4e-7, SPACE, (Wall(top), Wall(side))))
    angle = 0.0
    while angle < 89.0 and wall_contacts(stepper) or stepper.time < 1e-3:
        stepper.advance(50)
        x, _, z = stepper.particles.position[0]
        angle = math.degrees(math.atan2(x, z))
    return angle, math.degrees(math.acos(10.0 / 17.0 + 7.0 / 17.0 * speed**2 / (9.81 * arm)))


# ------------------------------------------------------------------------------------------------ claims


def claims() -> Iterator[Claim]:
    """Joints that nothing feels, loads that do not know the triangles, corners with the right number of contacts."""
    slid = [dragged(shapes, *way) for shapes in PLATES.values() for way in WAYS.values()]
    where = f"{len(PLATES)} plates x {len(WAYS)} ways"
    pressing = np.concatenate([t.force[:, 2] for t in slid])
    rubbing = np.concatenate([np.hypot(*t.force[100:, :2].T) for t in slid])
    contacts = np.concatenate([t.contacts for t in slid])
    free = [rolled(shapes, *way) for shapes in PLATES.values() for way in WAYS.values()]
    balance, limit = "balance of forces", "Coulomb"
    yield Claim(
        f"normal force on a sphere dragged over joints, farthest of {where}",
        balance,
        LOAD,
        farthest(pressing, LOAD),
        "N",
        1e-6,
        True,
    )
    yield Claim(
        "its friction, farthest after 100 steps",
        limit,
        0.5 * LOAD,
        farthest(rubbing, 0.5 * LOAD),
        "N",
        1e-6,
        True,
    )
    yield Claim(
        "its contacts in a step, farthest", "one plane", 1.0, farthest(contacts, 1.0), "-", 0.0, False
    )
    yield Claim(
        "normal force on a sphere rolling over joints, farthest",
        balance,
        LOAD,
        farthest(np.concatenate([t.force[:, 2] for t in free]), LOAD),
        "N",
        1e-6,
        True,
    )
    yield Claim(
        "its speed after 15 mm, farthest",
        "pure rolling needs no friction",
        1.0,
        farthest(np.array([math.hypot(*t.velocity[-1, :2]) for t in free]), 1.0),
        "m/s",
        1e-9,
        True,
    )
    worn, expected = block_wear(scattered_plate(400, seed=2), 0.08, 0.5, 0.05)
    yield Claim(
        "load times distance left by a block of known load on 400 random points",
        "F s",
        expected,
        worn,
        "N m",
        1e-12,
        True,
    )
    reference = thrown_loads(plate(8))
    for what, loads in (
        ("triangles of a fifth of the size", thrown_loads(plate(8, 5))),
        ("other diagonals and numbering", thrown_loads(plate(8, 3, seed=3))),
        (
            "a turned frame",
            thrown_loads(plate(8), Rotation.random(random_state=np.random.default_rng(4))),
        ),
    ):
        yield Claim(
            f"loads of a thrown sphere by facet: change by {what}",
            "same physics",
            0.0,
            apart(loads, reference),
            "-",
            1e-9,
            False,
            "of the sum over facets",
        )
    for tilt in (15.0, 30.0, 45.0, 60.0):
        side = LOAD / (2.0 * math.cos(math.radians(tilt)))
        yield Claim(
            f"force of each side of a V-groove, sides rising by {tilt:g} degrees",
            "F / (2 cos)",
            side,
            farthest(forces_in_groove(tilt), side),
            "N",
            1e-6,
            True,
        )
    for tilt in (0.1, 0.5, 1.0, 2.5, 10.0):
        yield Claim(
            f"largest change of force over a joint of {2 * tilt:g} degrees, at half the step",
            "a continuous force: 1/2",
            0.5,
            largest_jump_ratio(tilt),
            "-",
            0.02,
            False,
        )
    yield Claim(
        "force in a joint of 0.2 degrees over that on a plane",
        "no double stiffness",
        1.0,
        stiffening(0.1),
        "-",
        2e-3,
        True,
    )
    for tilt in (0.5, 1.0, 2.5):
        yield Claim(
            f"force in a joint of {2 * tilt:g} degrees over that on a plane",
            "1 for one patch, 2 for two",
            2.0,
            stiffening(tilt),
            "-",
            math.inf,
            False,
            "two Hertz patches part as the angle grows",
        )
    angle, theory = leaves_edge_at()
    yield Claim(
        "a sphere rolls over a square edge and leaves it at",
        "energy and balance of forces, no slip",
        theory,
        angle,
        "degree",
        0.01,
        True,
        "elastic contacts lag behind",
    )
