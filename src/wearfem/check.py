"""Is a case ready to run? Time step, mesh, overlap, memory and time, told in sentences before anything runs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wearfem.case import Stage, load_case
from wearfem.progress import clock
from wearfem.record import require_writable, write_json
from wearfem.settings import Value

if TYPE_CHECKING:
    from wearfem.dem.flow import Flow

RAYLEIGH_SHARE = 0.4  # of the Rayleigh time, above which a time step is worth a warning [-]
COLLISION_STEPS = 20  # below which an impact is resolved poorly [-]
OVERLAP_SHARE = 0.01  # of the radius, above which particles are too soft [-]
BYTES_PER_PARTICLE = 1000.0  # state, contacts and neighbours: a round estimate [B]
PARTICLE_STEPS_PER_SECOND = 5e6  # on two cores: a round estimate, which `wearfem bench` measures [1/s]


@dataclass(frozen=True)
class Facts:
    """What the checker looks at in one stage.

    Parameters
    ----------
    stage
        The name of the stage.
    time_step, duration
        Of the stage [s].
    count
        Particles at the start.
    smallest_radius, largest_radius
        Of the particles [m].
    rayleigh_time
        The shortest of all particles [s]; see `rayleigh_time`.
    effective_modulus
        The largest of all pairs [Pa]: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
    density
        Of the particles, the largest [kg/m3].
    speed
        The largest approach speed to be expected [m/s].
    force
        The largest steady force on one contact [N].
    shortest_edge, longest_edge
        Of the triangles that particles touch [m]; None where there are none.
    """

    stage: str
    time_step: float
    duration: float
    count: int
    smallest_radius: float
    largest_radius: float
    rayleigh_time: float
    effective_modulus: float
    density: float
    speed: float
    force: float
    shortest_edge: float | None = None
    longest_edge: float | None = None


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
    case = load_case(case_folder, settings)
    found = tuple(finding for stage in case.stages for finding in findings(facts_of(case.flow, stage)))
    for finding in found:
        print(f"{case.name}: {finding.stage}: {'WARNING: ' if finding.warning else ''}{finding.sentence}")
    print(summary(found))
    if json_file:
        write_json(json_file, [asdict(finding) for finding in found])
    return found


def facts_of(flow: "Flow", stage: Stage) -> Facts:
    """The facts of a stage, with the flow as it is at the start of the case.

    The largest speed is that of the fastest particle after a fall through the height of everything that there is.
    """
    from wearfem.material import pair_table

    particles, model = flow.particles, stage.model
    radius = particles.radius
    corner = np.concatenate([surface.corner for surface in model.surfaces] or [np.empty((0, 3, 3))])
    edge = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)
    places = np.concatenate([particles.position, corner.reshape(-1, 3)])
    gravity = float(np.linalg.norm(model.gravity))
    start = float(np.linalg.norm(particles.velocity, axis=1).max(initial=0.0))
    weight = particles.mass * gravity + np.linalg.norm(particles.applied_force, axis=1)
    material = [model.materials[number] for number in particles.material]
    return Facts(
        stage=stage.name,
        time_step=model.time_step,
        duration=stage.window.duration,
        count=len(radius),
        smallest_radius=float(radius.min()),
        largest_radius=float(radius.max()),
        rayleigh_time=min(
            rayleigh_time(r, m.density, m.shear_modulus, m.poisson_ratio)
            for r, m in zip(radius, material, strict=True)
        ),
        effective_modulus=float(pair_table(model.materials).effective_modulus.max()),
        density=max(m.density for m in material),
        speed=math.sqrt(start**2 + 2.0 * gravity * float(np.ptp(places, axis=0).max())),
        force=float(weight.max()),
        shortest_edge=float(edge.min()) if len(edge) else None,
        longest_edge=float(edge.max()) if len(edge) else None,
    )


def summary(found: Sequence[Finding]) -> str:
    """The last line of a check."""
    warnings = sum(finding.warning for finding in found)
    if not warnings:
        return "ready to run"
    return f"{warnings} warning{'s' if warnings > 1 else ''}; it will run, but read them first"


def findings(facts: Facts) -> tuple[Finding, ...]:
    """Everything that can be said about a stage before it runs."""
    radius, modulus = facts.smallest_radius, facts.effective_modulus
    mass = facts.density * 4.0 / 3.0 * math.pi * radius**3
    impact = impact_overlap(mass, facts.speed, radius, modulus)
    overlap = max(impact, static_overlap(facts.force, radius, modulus))
    found = [_time_step(facts)]
    if facts.speed > 0:
        found.append(_collision_steps(facts, impact))
    found.append(_overlap(facts, overlap))
    if facts.shortest_edge is not None and facts.longest_edge is not None:
        found.append(_mesh(facts, facts.shortest_edge, facts.longest_edge, overlap))
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


def _overlap(facts: Facts, overlap: float) -> Finding:
    share = overlap / facts.smallest_radius
    sentence = f"the largest overlap to expect is {overlap:.2g} m, {share:.2%} of the smallest radius"
    warning = share > OVERLAP_SHARE
    if warning:
        sentence += f"; above {OVERLAP_SHARE:.0%} a stiffer material is better"
    return Finding(facts.stage, "overlap over radius", share, "-", warning, sentence)


def _mesh(facts: Facts, shortest: float, longest: float, overlap: float) -> Finding:
    lower, upper = 2.0 * math.sqrt(facts.largest_radius * overlap), facts.smallest_radius
    sentence = f"the triangles have edges of {shortest:.2g} to {longest:.2g} m; the rule asks for {lower:.2g} to {upper:.2g} m"
    if longest > upper:
        sentence += ", so they are too coarse to show where the smallest particles wear"
    elif shortest < lower:
        sentence += ", so the smallest are finer than a contact and show noise"
    return Finding(facts.stage, "longest edge", longest, "m", longest > upper or shortest < lower, sentence)


def _memory(facts: Facts) -> Finding:
    size = facts.count * BYTES_PER_PARTICLE
    sentence = f"{facts.count} particles at the start need about {max(size / 1e6, 1.0):.0f} MB"
    return Finding(facts.stage, "memory", size, "B", False, sentence)


def _time(facts: Facts) -> Finding:
    steps = math.ceil(facts.duration / facts.time_step)
    seconds = steps * max(facts.count, 1) / PARTICLE_STEPS_PER_SECOND
    sentence = f"{steps} time steps take about {clock(seconds)} on two cores, inlets apart"
    return Finding(facts.stage, "time to run", seconds, "s", False, sentence)
