"""Is a case ready to run? Time step, mesh, overlap, memory and time, told in sentences before anything runs."""

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wearfem.case import Case, LifeCase, Stage, Window, load_any_case
from wearfem.errors import UserError
from wearfem.progress import clock
from wearfem.record import require_writable, write_json
from wearfem.settings import Value

if TYPE_CHECKING:
    from wearfem.dem.flow import Flow, Model

RAYLEIGH_SHARE = 0.4  # of the Rayleigh time, above which a time step is worth a warning [-]
COLLISION_STEPS = 20  # below which an impact is resolved poorly [-]
OVERLAP_SHARE = 0.05  # of the radius: beyond it Hertz's law is not valid and particles are too soft [-]
PERIODIC_DIAMETERS = (
    4.0  # of the largest particle, that a periodic width must exceed (Derakhshani et al. 2016) [-]
)
PAIRS_PER_PARTICLE = 8.0  # listed in a dense bed with the usual margin [-]
SPEED = 8e6  # particle-steps a second and core in a dense bed; `wearfem bench` measures it [1/s]
STEP_TIME = 2e-6  # of a step apart from its particles [s]


@dataclass(frozen=True)
class Mesh:
    """The edges of one surface [m]."""

    name: str
    shortest_edge: float
    longest_edge: float


@dataclass(frozen=True)
class Facts:
    """What the checker looks at in one stage.

    Parameters
    ----------
    stage
        The name of the stage.
    time_step, duration
        Of the stage [s].
    start_count, count
        Particles at the start of the stage, and at its end with all that inlets feed.
    smallest_radius, largest_radius
        Of the particles, those of inlets too [m].
    rayleigh_time
        The shortest of all particles [s]; see `rayleigh_time`.
    effective_modulus
        The smallest of all pairs that a particle has a part in [Pa]: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
    density
        Of the particles, the largest [kg/m3].
    speed
        The largest approach speed to be expected [m/s].
    force
        The largest steady force on one contact [N].
    bytes_per_particle
        Of the arrays that a particle fills in a dense bed [B].
    meshes
        The surfaces with triangles.
    wears
        Whether the case has a wear law, so that triangles must show where.
    periodic_width
        The smallest of the periodic widths [m]; None where nothing is periodic.
    """

    stage: str
    time_step: float
    duration: float
    start_count: int
    count: int
    smallest_radius: float
    largest_radius: float
    rayleigh_time: float
    effective_modulus: float
    density: float
    speed: float
    force: float
    bytes_per_particle: float
    meshes: tuple[Mesh, ...] = ()
    wears: bool = True
    periodic_width: float | None = None


@dataclass(frozen=True)
class Finding:
    """One thing that was checked: its number [unit], whether it deserves a warning, and a sentence."""

    stage: str
    name: str
    value: float
    unit: str
    warning: bool
    sentence: str


def rayleigh_time(radius: float, density: float, shear_modulus: float, poisson_ratio: float) -> float:
    """Time of a Rayleigh wave around a sphere [s]: pi R sqrt(rho/G) / (0.1631 nu + 0.8766).

    **Source** Li, Xu and Thornton, Powder Technology 160 (2005) 219-228. **Valid for** homogeneous elastic spheres.
    """
    return math.pi * radius * math.sqrt(density / shear_modulus) / (0.1631 * poisson_ratio + 0.8766)


def static_overlap(force: float, radius: float, effective_modulus: float) -> float:
    """Hertz overlap under a steady force [m]: (3 F / (4 E* sqrt(R)))^(2/3).

    **Source** Johnson, Contact Mechanics (1985), eq. 4.23.
    """
    return (0.75 * force / (effective_modulus * math.sqrt(radius))) ** (2.0 / 3.0)


def impact_overlap(mass: float, speed: float, radius: float, effective_modulus: float) -> float:
    """Largest Hertz overlap of an elastic impact on a wall [m]: (15 m v^2 / (16 E* sqrt(R)))^(2/5).

    **Source** Johnson, Contact Mechanics (1985), eq. 11.23.
    """
    return (15.0 * mass * speed**2 / (16.0 * effective_modulus * math.sqrt(radius))) ** 0.4


def impact_duration(overlap: float, speed: float) -> float:
    """How long an elastic Hertz impact lasts [s]: 2.9433 delta_max / v.

    **Source** Johnson, Contact Mechanics (1985), eq. 11.24.
    """
    return 2.9432750 * overlap / speed


def check_case(
    case_folder: Path, settings: Mapping[str, Value], json_file: Path | None = None
) -> tuple[Finding, ...]:
    """Check a case without running it, and print what was found.

    Parameters
    ----------
    case_folder
        The folder with the `case.py`.
    settings
        Keywords of the case [SI].
    json_file
        Where else to write the findings.
    """
    if json_file:
        require_writable(json_file)
    case = load_any_case(case_folder, settings)
    if isinstance(case, LifeCase):
        case = first_sample(case)
    found = tuple(finding for facts in case_facts(case) for finding in findings(facts))
    told = set()
    for finding in found:  # what holds for several stages is told once
        if finding.sentence not in told:
            print(f"{case.name}: {finding.stage}: {'WARNING: ' if finding.warning else ''}{finding.sentence}")
        told.add(finding.sentence)
    print(summary(found))
    if json_file:
        write_json(json_file, [asdict(finding) for finding in found])
    return found


def first_sample(case: LifeCase) -> Case:
    """The first sample of a life as a case in stages: warm-up and window, over the liner as it is at the start."""
    from wearfem.cycle import Particles
    from wearfem.liner.liner import wear_surface

    if not isinstance(case.sampler, Particles):
        raise UserError(
            f"{case.name} takes its loads from a formula and moves no particles: there is nothing to check, run it"
        )
    model = case.sampler.model(wear_surface(case.liner))
    stage = Stage("first sample", model, Window(case.warm_up + case.window.duration))
    return Case(case.name, case.flow, (stage,), case.wear_law, lambda outcome: (), case.notes)


def case_facts(case: Case) -> tuple[Facts, ...]:
    """The facts of each stage of a case: the particles at its start and those that inlets will have fed by its end."""
    facts: list[Facts] = []
    time, count = case.flow.time, case.flow.particles.count
    for stage in case.stages:
        end = time + stage.window.duration
        fed = sum(_fed_count(inlet, stage.model, time, end) for inlet in stage.model.inlets)
        bodies = _bodies(case.flow, stage.model)
        if bodies:
            counts = (count, count + fed)
            facts.append(_facts(case, stage.name, stage.model, stage.window.duration, counts, bodies))
        time, count = end, count + fed
    return tuple(facts)


@dataclass(frozen=True)
class Body:
    """A kind of particle that a stage has to reckon with: one that is there, or the ends of an inlet's sizes."""

    radius: float  # [m]
    mass: float  # [kg]
    material: Any
    speed: float  # [m/s] at the start
    force: float  # [N] applied, gravity apart


def _bodies(flow: "Flow", model: "Model") -> list[Body]:
    p = flow.particles
    speed, force = np.linalg.norm(p.velocity, axis=1), np.linalg.norm(p.applied_force, axis=1)
    bodies = [
        Body(float(r), float(m), model.materials[k], float(v), float(f))
        for r, m, k, v, f in zip(p.radius, p.mass, p.material, speed, force, strict=True)
    ]
    for inlet in model.inlets:
        material = model.materials[inlet.material]
        for radius in (inlet.sizes.smallest, inlet.sizes.largest):
            mass = material.density * 4.0 / 3.0 * math.pi * radius**3
            bodies.append(Body(radius, mass, material, float(np.linalg.norm(inlet.velocity)), 0.0))
    return bodies


def _fed_count(inlet: Any, model: "Model", begin: float, end: float) -> int:
    """How many particles an inlet lets in between two times [s]."""
    radius = inlet.sizes.draw(4096, np.random.default_rng(0))
    mean = model.materials[inlet.material].density * 4.0 / 3.0 * math.pi * float((radius**3).mean())
    return round((inlet.due(end) - inlet.due(begin)) / mean)


def _facts(
    case: Case, name: str, model: "Model", duration: float, counts: tuple[int, int], bodies: Sequence[Body]
) -> Facts:
    """The facts of one stage.

    The largest speed is that of the fastest particle after a fall through the height of everything that there is, or that
    of a wall where that is larger. The largest steady force is a particle's own weight and applied force, or its part of all weight
    resting on the ground plan of the walls, which is a pressure over the square of its diameter.
    """
    meshes = tuple(_mesh_of(surface) for surface in model.surfaces)
    places = _places(case.flow, model)
    gravity = np.asarray(model.gravity, float)
    pull = float(np.linalg.norm(gravity))
    height = float(np.ptp(places @ gravity / pull)) if pull > 0.0 and len(places) else 0.0
    falling = math.sqrt(max(body.speed for body in bodies) ** 2 + 2.0 * pull * height)
    largest = max(body.radius for body in bodies)
    single = max(body.mass * pull + body.force for body in bodies)
    mean_mass = float(np.mean([body.mass for body in bodies]))
    size = np.asarray(model.domain.high) - np.asarray(model.domain.low)
    ground = np.where(model.domain.periodic, size, np.ptp(places, axis=0) if len(places) else size)
    area = float(np.prod(np.delete(np.maximum(ground, 2.0 * largest), int(np.argmax(np.abs(gravity))))))
    pressed = counts[1] * mean_mass * pull / area * (2.0 * largest) ** 2
    number = {material: k for k, material in enumerate(model.materials)}
    kinds = sorted({number[body.material] for body in bodies})
    touched = {number[wall.shape.material] for wall in model.walls} | set(kinds)
    period = model.period[model.period > 0.0]
    return Facts(
        stage=name,
        time_step=model.time_step,
        duration=duration,
        start_count=counts[0],
        count=counts[1],
        smallest_radius=min(body.radius for body in bodies),
        largest_radius=largest,
        rayleigh_time=min(
            rayleigh_time(
                body.radius,
                body.mass / (4.0 / 3.0 * math.pi * body.radius**3),
                body.material.shear_modulus,
                body.material.poisson_ratio,
            )
            for body in bodies
        ),
        effective_modulus=float(model.table.effective_modulus[np.ix_(kinds, sorted(touched))].min()),
        density=max(body.mass / (4.0 / 3.0 * math.pi * body.radius**3) for body in bodies),
        speed=max(falling, *(_wall_speed(wall) for wall in model.walls), 0.0),
        force=max(single, pressed),
        bytes_per_particle=bytes_per_particle(model),
        meshes=meshes,
        wears=case.wear_law is not None,
        periodic_width=float(period.min()) if len(period) else None,
    )


def _places(flow: "Flow", model: "Model") -> np.ndarray:
    """(k, 3) [m] particles, corners of surfaces and of inlets, and points of planes"""
    return np.concatenate(
        [
            flow.particles.position,
            *(np.array([inlet.low, inlet.high], float) for inlet in model.inlets),
            *(np.array(wall.shape.point, float).reshape(-1, 3) for wall in model.walls),
        ]
    )


def _mesh_of(surface: Any) -> Mesh:
    corner = surface.corner
    edge = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)
    return Mesh(surface.name, float(edge.min()), float(edge.max()))


def _wall_speed(wall: Any) -> float:
    """A bound on the speed of a wall across itself [m/s]: sliding along makes no impact."""
    motion, normal = wall.motion, np.atleast_2d(wall.shape.normal)
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def across(velocity: Any) -> float:
        return float(np.abs(normal @ np.asarray(velocity, float)).max())

    speed = across(motion.velocity) + 2.0 * math.pi * motion.frequency * across(motion.amplitude)
    if motion.path is not None:
        steps = np.diff(motion.path[:, 1:], axis=0) / np.diff(motion.path[:, 0])[:, None]
        speed += max(across(step) for step in steps)
    if motion.rate:
        axis = np.asarray(motion.axis, float) / np.linalg.norm(motion.axis)
        velocity = motion.rate * np.cross(axis, wall.shape.corner - np.asarray(motion.centre))
        speed += float(np.abs((velocity * normal[:, None]).sum(axis=2)).max())
    return speed


def bytes_per_particle(model: "Model") -> float:
    """Of all arrays that a particle of a dense bed fills [B]: its state, its rows and its pairs, each twice while a window runs."""
    from wearfem.dem.neighbours import empty_pairs
    from wearfem.dem.pairs import LANES, PACKED, memory_rows
    from wearfem.dem.particles import spheres

    state = sum(array.nbytes for array in spheres(np.zeros((1, 3)), 1.0, 1.0))
    rows = 8.0 * (PACKED + 3 + 3)  # packed copy and the two references
    one_block = empty_pairs(0, 1, LANES, memory_rows(model.contact))
    pair = (
        one_block.first.nbytes + one_block.second.nbytes + one_block.memory.nbytes + one_block.slot.nbytes
    ) / LANES
    return 2.0 * (state + rows + PAIRS_PER_PARTICLE * pair)


def summary(found: Sequence[Finding]) -> str:
    """The last line of a check."""
    warnings = len({finding.sentence for finding in found if finding.warning})
    if not warnings:
        return "ready to run"
    return f"{warnings} warning{'s' if warnings > 1 else ''}; it will run, but read them first"


def findings(facts: Facts) -> tuple[Finding, ...]:
    """Everything that can be said about a stage before it runs."""
    radius, modulus = facts.smallest_radius, facts.effective_modulus
    static = static_overlap(facts.force, radius, modulus)
    found = [
        _time_step(facts),
        _overlap(facts, "steady load", static, f"a steady load of {facts.force:.3g} N"),
    ]
    largest = static
    if facts.speed > 0:
        mass = facts.density * 4.0 / 3.0 * math.pi * radius**3
        impact = impact_overlap(mass, facts.speed, radius, modulus)
        largest = max(static, impact)
        found += [
            _collision_steps(facts, impact),
            _overlap(facts, "impact", impact, f"an impact at {facts.speed:.3g} m/s"),
        ]
    found += [_mesh(facts, mesh, largest) for mesh in facts.meshes]
    if facts.periodic_width is not None:
        found.append(_period(facts, facts.periodic_width))
    return (*found, _memory(facts), _time(facts))


def _time_step(facts: Facts) -> Finding:
    share = facts.time_step / facts.rayleigh_time
    sentence = f"the time step {facts.time_step:.3g} s is {share:.0%} of the Rayleigh time {facts.rayleigh_time:.4g} s"
    warning = share > RAYLEIGH_SHARE
    if warning:
        sentence += f"; below {RAYLEIGH_SHARE * facts.rayleigh_time:.2g} s is usual"
    return Finding(facts.stage, "time step over Rayleigh time", share, "-", warning, sentence)


def _collision_steps(facts: Facts, overlap: float) -> Finding:
    steps = impact_duration(overlap, facts.speed) / facts.time_step
    sentence = f"an impact at {facts.speed:.3g} m/s lasts {steps:.0f} time steps"
    warning = steps < COLLISION_STEPS
    if warning:
        sentence += f"; {COLLISION_STEPS} are needed: a time step of {facts.time_step * steps / COLLISION_STEPS:.2g} s would do"
    return Finding(facts.stage, "time steps in an impact", steps, "-", warning, sentence)


def _overlap(facts: Facts, kind: str, overlap: float, cause: str) -> Finding:
    share = overlap / facts.smallest_radius
    sentence = f"{cause} makes an overlap of {overlap:.2g} m, {share:.2%} of the smallest radius"
    warning = share > OVERLAP_SHARE
    if warning:
        sentence += f"; Hertz's law holds to about {OVERLAP_SHARE:.0%}: a stiffer material is better"
    return Finding(facts.stage, f"overlap over radius, {kind}", share, "-", warning, sentence)


def _mesh(facts: Facts, mesh: Mesh, overlap: float) -> Finding:
    """2 sqrt(R d) < edge < R: wider than a contact circle, finer than a particle (the rule of the pin-on-disc paper)."""
    lower, upper = 2.0 * math.sqrt(facts.largest_radius * overlap), facts.smallest_radius
    coarse, fine = facts.wears and mesh.longest_edge > upper, facts.wears and mesh.shortest_edge < lower
    sentence = f"the triangles of the {mesh.name} have edges of {mesh.shortest_edge:.2g} to {mesh.longest_edge:.2g} m; "
    sentence += (
        f"the rule is {lower:.2g} to {upper:.2g} m" if facts.wears else "nothing wears, so any size will do"
    )
    if facts.wears and lower > upper:
        sentence += ", which no mesh meets: particles this soft touch over more than their radius"
    elif coarse:
        sentence += ", so they are too coarse to show where the smallest particles wear"
    elif fine:
        sentence += ", so the smallest are finer than a contact and show noise"
    return Finding(
        facts.stage, f"longest edge of the {mesh.name}", mesh.longest_edge, "m", coarse or fine, sentence
    )


def _period(facts: Facts, width: float) -> Finding:
    diameters = width / (2.0 * facts.largest_radius)
    sentence = f"the periodic width {width:.3g} m is {diameters:.3g} diameters of the largest particle"
    warning = diameters <= PERIODIC_DIAMETERS
    if warning:
        sentence += f"; more than {PERIODIC_DIAMETERS:g} are needed for a flow that does not feel it"
    return Finding(facts.stage, "periodic width over largest diameter", diameters, "-", warning, sentence)


def _memory(facts: Facts) -> Finding:
    size = facts.count * facts.bytes_per_particle
    free = _memory_there()
    fed = (
        f", {facts.count - facts.start_count} of them from inlets," if facts.count > facts.start_count else ""
    )
    sentence = f"{facts.count} particles{fed} need about {max(size / 1e6, 1.0):.0f} MB at {facts.bytes_per_particle:.0f} bytes each"
    warning = size > 0.8 * free
    if warning:
        sentence += f"; this machine has {free / 1e6:.0f} MB"
    return Finding(facts.stage, "memory", size, "B", warning, sentence)


def _memory_there() -> float:
    """Of this machine [B]; infinite where it cannot be asked."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return math.inf


def _time(facts: Facts) -> Finding:
    steps = math.ceil(facts.duration / facts.time_step)
    cores = min(os.cpu_count() or 1, _tasks(facts.count))
    mean = max(0.5 * (facts.start_count + facts.count), 1.0)
    seconds = steps * (mean / (SPEED * cores) + STEP_TIME)
    sentence = (
        f"{steps} time steps of {mean:.0f} particles on average take about {clock(seconds)} on {cores} "
        f"core{'s' if cores > 1 else ''}, if nothing ends the stage before"
    )
    return Finding(facts.stage, "time to run", seconds, "s", False, sentence)


def _tasks(count: int) -> int:
    """Threads that this many particles keep busy."""
    from wearfem.dem.neighbours import CHUNK_PARTICLES, MOST_CHUNKS

    return int(min(max(1, 2 ** math.ceil(math.log2(max(count, 1) / (1.5 * CHUNK_PARTICLES)))), MOST_CHUNKS))
