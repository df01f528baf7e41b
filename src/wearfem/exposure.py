"""What a run of the model says of the points of a survey: how fast each wears along the life, and in which state.

Points are put onto the worn face as it was when new. They go with their facet while the mesh stays the same, and to the nearest place
of the next mesh where it was made anew. Fields are told straight between facets: the value of the facet plus its gradient, by least
squares over the facets around that face the same way, times the distance from its middle.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wearfem.cycle import CycleReport
from wearfem.errors import UserError, in_words
from wearfem.history import cycles_of, read_cycle, read_sampled
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.transfer import nearest_point
from wearfem.record import read_manifest
from wearfem.surface import Surface
from wearfem.survey.columns import UNITS, column
from wearfem.survey.course import Course, Sampling, at_own_pace
from wearfem.survey.survey import Survey
from wearfem.wear.effect import Effect
from wearfem.wear.effects import Corrosion
from wearfem.wear.features import FROM_LOADS, features
from wearfem.wear.sampling import Sample, lag_products, noise_density

LEAST_PACE = 0.02  # [-] of the factor: slower, and the rate divided by it tells nothing
ALIKE = 0.87  # cosine of 30 degrees: facets that face the same way
SCALES = (("mm", 1e-3), ("cm", 1e-2), ("km", 1e3))  # by which coordinates are mistaken for metres


@dataclass(frozen=True)
class PutIn:
    """What a run has beside the case whose exposure is asked: its wear law scaled, and effects."""

    factor: float  # [-]
    effects: tuple[Effect, ...] = ()

    def pace(self, report: CycleReport, liner: Liner) -> np.ndarray:
        """(f,) [-] by which the run wears faster than the case; what only adds is left out. Where that is next to nothing, `LEAST_PACE`"""
        pace = np.full((1, len(liner.depth)), self.factor)
        for effect in self.effects:
            if not isinstance(effect, Corrosion):
                pace = effect.modify(pace, report.loads, liner)
        return np.maximum(pace[0], LEAST_PACE * self.factor)

    @property
    def addition(self) -> float:
        """[m/s] of depth"""
        return sum(effect.addition() for effect in self.effects if isinstance(effect, Corrosion))


@dataclass(frozen=True)
class Foot:
    """Where a point stands on a worn face, and how fields are told there."""

    facet: int
    weight: np.ndarray  # (3,) of the corners of its triangle
    triangle: int
    near: np.ndarray  # (k,) facets around
    offset: np.ndarray  # (3,) [m] from the middle of the facet
    slope: np.ndarray  # (3, k) [1/m] gradient by differences to the facets around

    def gradient(self, field: np.ndarray) -> np.ndarray:
        """(3,) [by m] of a facet field (f,), along the face"""
        return self.slope @ (field[self.near] - field[self.facet])

    def value(self, field: np.ndarray) -> float:
        """Of a facet field (f,) that is nowhere below 0"""
        return max(float(field[self.facet] + self.offset @ self.gradient(field)), 0.0)

    def values(self, fields: np.ndarray) -> np.ndarray:
        """(b,) of facet fields (b, f)"""
        own = fields[:, self.facet]
        return own + (fields[:, self.near] - own[:, None]) @ (self.offset @ self.slope)


def exposed_by_run(
    survey: Survey, run: Path, tolerance: float | None = None, put_in: PutIn | None = None
) -> Survey:
    """The survey with the course of a run at its points: then a coefficient is a factor on the run's own wear.

    Parameters
    ----------
    survey
        With `x_m, y_m, z_m`, in the frame of the case, and a depth or thickness over a mass that has passed or a time in service.
    run
        The folder of a life that `wearfem run` has begun.
    tolerance
        [m] that points may lie off the worn face; by default the size of the facet, or the wear there if that is more.
    put_in
        What the run has beside the case; then the course is that of the case's own wear along the shapes that the run went through.

    Raises
    ------
    UserError
        for a survey or a run that cannot be laid over each other, with the reason.
    """
    if "position" not in survey.feature:
        raise UserError(
            f"{survey.source} has no x_m, y_m, z_m, so the run {run} cannot tell what its points saw; add them"
        )
    if UNITS[survey.measured_unit][2] != "m":
        raise UserError(
            f"{survey.source} has {survey.measured_name}, and a run tells depths at points; give depth_mm or thickness_mm"
        )
    read_manifest(run)
    told = [read_sampled(run, number) for number in range(1, cycles_of(run) + 1)]
    kept = [(liner, report) for liner, report in told if report.kept]
    if not kept:
        raise UserError(
            f"{run} has no cycle: give the folder of a life (a case with a liner that wears) that has begun"
        )
    place = np.array(
        [survey.feature["position"][survey.life == i][0] for i in range(len(survey.life_point))]
    )  # (l, 3)
    feet = put_on(place, kept[0][0], run, survey, tolerance, float(kept[-1][1].depth.max()))
    put_in = put_in or PutIn(1.0)
    rate, state, pace = [], [], []
    worn, steep = np.zeros(len(place)), np.zeros((len(place), 3))
    mesh = kept[0][0].mesh
    before = None
    for liner, report in kept:
        if liner.mesh.wear.shape != mesh.wear.shape or (liner.mesh.wear != mesh.wear).any():
            assert before is not None  # the first mesh is its own
            feet = _feet(before, wear_surface(liner))
        mesh = liner.mesh
        surface = wear_surface(liner)
        before = np.array([foot.weight @ surface.corner[foot.triangle] for foot in feet])
        faster = put_in.pace(report, liner)
        own = np.maximum(report.rate - put_in.addition, 0.0) / faster
        rate.append([foot.value(own) for foot in feet])
        pace.append([foot.value(faster) for foot in feet])
        known = features(FROM_LOADS, report.loads, liner)
        state.append([[foot.value(known[name]) for foot in feet] for name in FROM_LOADS])
        steep += [foot.gradient(report.rate) for foot in feet]
        worn += rate[-1]
    progress, unit = _progress(survey, run, [report for _, report in kept])
    last, _ = read_cycle(run, cycles_of(run))
    assert last.kept is not None  # there is a cycle that was kept
    course = Course(
        progress,
        np.array(rate).T * unit,
        {
            name: np.array(state)[:, i].T
            for i, name in enumerate(FROM_LOADS)
            if np.ptp(np.array(state)[:, i]) > 0.0
        },
        np.divide(steep, worn[:, None], out=np.zeros_like(steep), where=worn[:, None] > 0.0),
        _moves(kept),
        sampling=sampling(last.kept.samples, feet),
    )
    course = replace(course, notes=_notes(survey, run, course, kept))
    if (
        put_in.addition > 0.0
    ):  # what is added keeps no pace with wear: the course stays on the run's own service
        course = replace(course, follows_shape=False)
    elif put_in != PutIn(1.0):
        course = at_own_pace(course, np.array(pace).T)
    return replace(survey, course=course, exposure_known=True)


def sampling(samples: Sequence[Sample], feet: Sequence[Foot]) -> Sampling:
    """How well samples know their rates at points: the scatter of their blocks, and how long these remember one another.

    The noise of a flow is taken to be that of all samples together, relative to the mean of each: one alone has a few dozen blocks, from
    which no covariance of as many points can be told.
    """
    at = [np.stack([foot.values(sample.rate) for foot in feet], axis=1) for sample in samples]  # (b, l) each
    mean = [one.mean(axis=0) for one in at]
    off = [
        np.divide(one - m, m, out=np.zeros_like(one), where=m > 0.0) for one, m in zip(at, mean, strict=True)
    ]
    squares = np.sum([one.T @ one for one in off], axis=0)
    density = noise_density([lag_products(one) for one in off], squares, samples[0].block)
    part = np.broadcast_to(np.eye(len(samples)), (len(feet), len(samples), len(samples)))
    return Sampling(density, np.array([sample.window for sample in samples]), part)


def put_on(
    place: np.ndarray, liner: Liner, run: Path, survey: Survey, tolerance: float | None, deepest: float
) -> list[Foot]:
    """Points (l, 3) [m] on the worn face when new; refused where they lie further off than the tolerance."""
    surface = wear_surface(liner)
    feet = _feet(place, surface)
    foot = np.array([f.weight @ surface.corner[f.triangle] for f in feet])
    off = np.linalg.norm(foot - place, axis=1)
    corner = surface.corner[[f.triangle for f in feet]]
    size = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1)
    allowed = np.maximum(size, deepest) if tolerance is None else np.full(len(off), tolerance)
    if not (off > allowed).any():
        return feet
    worst = int(np.argmax(off - allowed))
    low, high = surface.point.min(axis=0), surface.point.max(axis=0)
    spans = in_words([f"{axis} {a:.4g} to {b:.4g} m" for axis, a, b in zip("xyz", low, high, strict=True)])
    advice = (
        "compare the frame of the survey with that of the case, and see that they are of the same machine"
    )
    for name, factor in SCALES:
        again = factor * place
        wide = np.ptp(again, axis=0).max() > 0.1 * (high - low).max()
        if wide and (np.linalg.norm(_places(again, surface) - again, axis=1) <= allowed).all():
            advice = f"they would lie on it if x_m, y_m, z_m were in {name}: give them in m"
    raise UserError(
        f"{survey.source} has {int((off > allowed).sum())} of {len(off)} plates further off the worn face of {run} than "
        f"{allowed[worst]:.3g} m, point {survey.point_names[survey.life_point[worst]]} by {off[worst]:.3g} m; "
        f"the face spans {spans}; {advice}"
    )


def _places(place: np.ndarray, surface: Surface) -> np.ndarray:
    triangle, weight = nearest_point(place, surface.point, surface.triangle)
    return np.einsum("pk,pki->pi", weight, surface.corner[triangle])


def _feet(place: np.ndarray, surface: Surface) -> list[Foot]:
    """Where points (p, 3) [m] stand on a surface: at its nearest place"""
    triangle, weight = nearest_point(place, surface.point, surface.triangle)
    area = surface.facet_area

    def by_facet(value: np.ndarray) -> np.ndarray:
        total = np.stack(
            [np.bincount(surface.facet, surface.area * v, surface.facet_count) for v in value.T], axis=1
        )
        return total / area[:, None]

    middle, normal = by_facet(surface.corner.mean(axis=1)), by_facet(surface.normal)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    feet = []
    for t, w in zip(triangle, weight, strict=True):
        own = int(surface.facet[t])
        touched = np.isin(surface.triangle, surface.triangle[surface.facet == own]).any(axis=1)
        near = np.setdiff1d(surface.facet[touched], own)
        near = near[normal[near] @ normal[own] > ALIKE]
        apart = middle[near] - middle[own]
        apart = apart - np.outer(apart @ normal[own], normal[own])  # along the face
        slope = np.linalg.pinv(apart, rcond=0.05) if len(near) else np.zeros((3, 0))
        feet.append(Foot(own, w, int(t), near, w @ surface.corner[t] - middle[own], slope))
    return feet


def _progress(survey: Survey, run: Path, reports: Sequence[CycleReport]) -> tuple[np.ndarray, float]:
    """Service at the samples in the unit of the survey, and what turns m/s into m by that unit"""
    told = column(survey.progress_name)
    counted = UNITS[told.unit][2] if told.unit else ""
    seconds = np.array([report.service_time for report in reports])
    mass = np.array([report.throughput for report in reports])
    if counted == "s":
        return seconds / told.factor, told.factor
    if counted != "kg":
        raise UserError(
            f"{survey.source} counts service by {survey.progress_name}, and {run} tells time and throughput: give time_h, tonnage_kt or "
            "another column with such a unit in its name"
        )
    done = reports[-1]
    if len(reports) > 1 and done.throughput > mass[0]:
        by_second = (done.throughput - mass[0]) / (done.service_time - seconds[0])
    else:
        raise UserError(
            f"{run} counts no throughput (its throughput_rate is 0, or it has one cycle only); give time_h in {survey.source}"
        )
    return mass / told.factor, told.factor / by_second


def _moves(kept: Sequence[tuple[Liner, CycleReport]]) -> bool:
    """Whether the surface moved from the first sample to the last"""
    first, last = kept[0][0].mesh, kept[-1][0].mesh
    return first.node.shape != last.node.shape or bool((first.node != last.node).any())


def _notes(
    survey: Survey, run: Path, course: Course, kept: Sequence[tuple[Liner, CycleReport]]
) -> tuple[str, ...]:
    unit, progress = survey.progress_unit, course.progress
    served = survey.progress - survey.life_start[survey.life]
    notes = [
        f"exposure and state from {run}: {len(kept)} samples up to {progress[-1]:.4g} {unit}; the coefficient is a factor on its wear"
    ]
    if served.max() > 1.02 * progress[-1]:
        notes.append(
            f"readings go on to {served.max():.4g} {unit}; beyond {progress[-1]:.4g} {unit} the run's last rate is taken"
        )
    every = np.full((len(course.rate), 1), served.max())
    noise = np.sqrt(np.square(course.own_errors(0.0 * every, every)).sum(axis=2))
    if noise.max(initial=0.0) > 0.002:
        notes.append(
            f"the run's own sampling: its wear at these points is known to {100 * np.median(noise):.2g} % (standard error, the worst "
            f"point to {100 * noise.max():.2g} %); the intervals hold that"
        )
    if not _moves(kept):
        notes.append(
            "the run keeps its shape: what changes with depth may be the shape that wears, and no effect of the material"
        )
    return tuple(notes)
