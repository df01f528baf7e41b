"""What a maintenance planner asks of a life: when it ends and how surely, how much is left where, and what to beware of."""

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.case import LifeCase, load_any_case
from wearfem.cycle import CycleReport
from wearfem.errors import UserError
from wearfem.history import History
from wearfem.life import words
from wearfem.liner.mesh import WEAR, LinerMesh, find_facets
from wearfem.record import file_hash
from wearfem.wear.jump import Goal, Life, end_of_life
from wearfem.wear.metal import in_plain_depths
from wearfem.wear.sampling import depth_at, passage

REST = "rest of the worn face"
UNEXPLAINED = 0.2  # of the first thickness, by which a facet may measure thinner than its wear explains, as curved faces do
CONFIDENCE = 0.9  # of the intervals, where the case that would name another is gone


def case_of_run(begun: Mapping[str, Any]) -> LifeCase | None:
    """The case that was run, from its manifest; None where it is gone, is not what it was, or is no life."""
    settings = {name: _as_set(value) for name, value in begun["settings"].items() if value is not None}
    try:
        if any(file_hash(Path(file)) != digest for file, digest in begun["sha256"].items()):
            return None
        case = load_any_case(Path(begun["folder"]), settings)
    except UserError:
        return None
    return case if isinstance(case, LifeCase) else None


def _as_set(value: Any) -> Any:
    """A setting as `--set` gives it: JSON knows no tuples."""
    return tuple(_as_set(item) for item in value) if isinstance(value, list) else value


@dataclass(frozen=True)
class End:
    """An end of life with its interval. Beyond the last sample the last rate is taken to stay."""

    time: float  # [s] of service
    half: float  # [s] half the interval
    throughput: float  # [kg] at `time`; not a number where the case counts none

    @property
    def interval(self) -> tuple[float, float]:
        """[s] from and to; never before the first second"""
        return max(self.time - self.half, 0.0), self.time + self.half


@dataclass(frozen=True)
class Zone:
    """A part of the worn face."""

    name: str
    facet: np.ndarray  # (k,) of `mesh.wear`
    area: float  # [m2]
    deepest: float  # [m] worn off since the liner was new
    volume: float  # [m3] depth times present area, summed
    least_thickness: float  # [m]; NaN where none is measured
    rate: float  # [m/s] largest of the last sample
    end: End | None  # None where nothing is judged or nothing wears


def end_of(life: Life, history: History, number: int, confidence: float) -> End:
    """The end of life as it was told after a sample.

        half = |bias| + z hypot(noise, left s / r)

    with z deviations for the confidence, the time `left` to run and the standard error s of the present rate r of the facet that
    fails first: the interval of the line that the run prints after each cycle.

    Parameters
    ----------
    life
        As told.
    history
        Of the run.
    number
        Of the sample, from 0.
    confidence
        [-] that the interval holds the end, as far as sampling and jumps go.
    """
    rate, error = history.rate[number][life.facet], history.error[number][life.facet]
    left = max(life.time - float(history.service_time[number]), 0.0)
    noise = float(np.hypot(life.noise, left * error / rate)) if rate > 0.0 else life.noise
    half = abs(life.bias) + deviations(confidence) * noise
    return End(life.time, half, throughput_at(history, life.time))


def deviations(confidence: float) -> float:
    """Standard deviations within which a normal error lies with `confidence`"""
    return Goal(np.ones(1), confidence=confidence).deviations


def throughput_at(history: History, time: float) -> float:
    """[kg] that has passed at a service time [s]; not a number where the case counts none"""
    passed = float(history.throughput[-1] - history.throughput[0])
    if not passed > 0.0:
        return float("nan")
    rate = passed / float(history.service_time[-1] - history.service_time[0])
    return float(history.throughput[0]) + rate * (time - float(history.service_time[0]))


def lag_of(history: History) -> np.ndarray:
    """(c, f) [m] by which each sampled shape stood behind the depth that is known since: the next jump makes up for it.

    Zero for cycles on another mesh than the present one.
    """
    kept = [report for report in history.reports if report.kept]
    return np.array([_behind(report, depth) for report, depth in zip(kept, history.depth, strict=True)])


def _behind(report: CycleReport, depth: np.ndarray) -> np.ndarray:
    return depth - report.depth if len(report.depth) == len(depth) else np.zeros_like(depth)


def corrected_thickness(history: History) -> np.ndarray:
    """(c, f) [m] left at each cycle: as measured on its shape, less what that stood behind; NaN where none is measured.

    On a mesh that has changed the history has corrected it already.
    """
    left = np.where(np.isfinite(history.thickness), history.thickness, np.nan)
    one_mesh = all(len(report.depth) == len(history.area) for report in history.reports if report.kept)
    return left - lag_of(history) if one_mesh else left


def corrected_volume(history: History) -> np.ndarray:
    """(c,) [m3] worn off: what the mesh lost, and what its shape stood behind, times the present areas"""
    return history.worn_volume + lag_of(history) @ history.area


def thickness_at(history: History, time: float) -> np.ndarray:
    """(f,) [m] left at a service time [s], NaN where none is measured.

    Thickness and depth together stay but for the geometry of measuring, a straight line between the shapes through which the liner came
    (`passage`); the depth is that of the end of life. Beyond the last cycle what the flow does is taken to stay.
    """
    samples = in_plain_depths(history.samples, history.metal)
    served, _ = passage(samples)
    worn = depth_at(samples, time)
    if history.metal is not None:
        worn = history.metal.depth_of(worn)
    whole = corrected_thickness(history) + history.depth - history.depth[0]
    return np.maximum([np.interp(time, served, facet) for facet in whole.T] - worn, 0.0)


def zones_of(mesh: LinerMesh) -> Mapping[str, np.ndarray]:
    """Facets (k,) of the worn face by zone.

    The mesh's own groups that share facets with it, and what they leave; without any, thirds along its longest axis.
    """
    found = {}
    for name, corner in mesh.group.items():
        if name != WEAR and corner.shape[1] == mesh.wear.shape[1]:
            place = np.unique(find_facets(corner, mesh.wear))
            if (place >= 0).any():
                found[name] = place[place >= 0]
    if not found:
        return _thirds(mesh)
    rest = np.setdiff1d(np.arange(len(mesh.wear)), np.concatenate(list(found.values())))
    return found | ({REST: rest} if len(rest) else {})


def _thirds(mesh: LinerMesh) -> dict[str, np.ndarray]:
    centre = mesh.node[mesh.wear].mean(axis=1)
    corner = mesh.node[np.unique(mesh.wear)]
    axis = int(np.argmax(np.ptp(corner, axis=0)))
    edge = np.linspace(corner[:, axis].min(), corner[:, axis].max(), 4)
    third = np.clip(np.searchsorted(edge, centre[:, axis], side="right") - 1, 0, 2)
    names = [
        f"third at {'xyz'[axis]} = {1e3 * a:.0f} to {1e3 * b:.0f} mm"
        for a, b in zip(edge, edge[1:], strict=False)
    ]
    return {name: np.flatnonzero(third == k) for k, name in enumerate(names) if (third == k).any()}


def least(length: np.ndarray) -> float:
    """[m] the least of those that are known; NaN where none is"""
    return float(np.fmin.reduce(length))


def wear_by_zone(history: History, confidence: float) -> tuple[Zone, ...]:
    """Each zone as it is after the last sample, with its own end of life."""
    return tuple(
        Zone(
            name=name,
            facet=facet,
            area=float(history.area[facet].sum()),
            deepest=float(history.depth[-1][facet].max()),
            volume=float(history.depth[-1][facet] @ history.area[facet]),
            least_thickness=least(corrected_thickness(history)[-1][facet]),
            rate=float(history.rate[-1][facet].max()),
            end=_end_of_zone(history, facet, confidence),
        )
        for name, facet in zones_of(history.state.now.liner.mesh).items()
    )


def _end_of_zone(history: History, facet: np.ndarray, confidence: float) -> End | None:
    """The life of a liner of which only this zone is judged."""
    allowed = np.full(len(history.area), np.inf)
    allowed[facet] = history.allowed_depth[facet]
    judged = np.isfinite(allowed)
    if not (history.rate[-1][judged] > 0.0).any():
        return None
    goal = Goal(allowed, history.area, confidence=confidence, metal=history.metal)
    life = end_of_life(history.samples, goal)
    return end_of(life, history, -1, confidence)


def warnings_of(history: History, begun: Mapping[str, Any], case: LifeCase | None, end: End) -> list[str]:
    """What a reader must know before trusting the page, each in a sentence."""
    found = []
    last, limit = float(history.service_time[-1]), 0.02 if case is None else case.goal.tolerance
    if begun["finished"] is None:
        found.append("The run is not finished: what follows is the life as far as it has been told.")
    if case is None:
        found.append(
            f"The case that was run is gone or has changed: its notes are missing here, and intervals hold {CONFIDENCE:.0%}."
        )
    if end.time > last:
        ahead = words(end.time - last)
        found.append(f"The end of life lies {ahead} beyond the last sample; the last rate is taken to stay.")
    elif end.time < last:
        found.append(
            f"The end of life was passed before the last cycle, which sampled {words(last - end.time)} after it."
        )
    if end.half > limit * end.time:
        found.append(f"The life is known within {end.half / end.time:.1%}, and {limit:.1%} was asked for.")
    if history.rejected:
        found.append(
            f"{history.rejected} of {len(history.reports)} cycles proved too bold and were taken back."
        )
    unknown = int((~np.isfinite(history.thickness[-1])).sum())
    if unknown:
        found.append(
            f"The thickness of {unknown} of {len(history.area)} facets could not be measured: they are grey."
        )
    left = corrected_thickness(history)
    strange = int((left[0] - history.depth[-1] + history.depth[0] - left[-1] > UNEXPLAINED * left[0]).sum())
    if strange:
        found.append(
            f"{strange} of {len(history.area)} facets measure thinner than their wear explains, by more than {UNEXPLAINED:.0%} of what "
            "they had: thickness is measured along the normal, which leaves by the side of the liner where a facet at its border tilts."
        )
    weak = [report for report in history.reports if report.strain and report.strain.least_reserve < 1.0]
    if weak:
        reserve = min(report.strain.least_reserve for report in weak if report.strain)
        found.append(
            f"The liner yields from cycle {weak[0].cycle} on: reserve factor {reserve:.3g}, below 1, at the least."
        )
    found += [
        f"Cycle {report.cycle}: {report.event.removesuffix('.')}."
        for report in history.reports
        if report.event
    ]
    return found + [f"The case says: {note}." for note in (case.notes if case else ())]


def mesh_hash(mesh: LinerMesh) -> str:
    """The SHA-256 of nodes, elements and groups, in hexadecimal."""
    digest = sha256(mesh.node.tobytes() + mesh.element.tobytes())
    for name in sorted(mesh.group):
        digest.update(name.encode() + mesh.group[name].tobytes())
    return digest.hexdigest()
