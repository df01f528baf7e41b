"""The life of a liner on disk: one whole file a cycle, from which a run goes on to the bit, and the history that they tell.

    cycles/0007.h5        the state after cycle 7 and its report
    cycles/0007.vtkhdf    the worn face that cycle 7 sampled
    samples/<hash>.h5     the rates of one sample, by their own hash: states refer to them, none is written twice
    surface.vtkhdf.series the worn faces in the order of service time, for ParaView

Every file is written beside its place and renamed when it is whole; none is ever written over.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from wearfem import __version__
from wearfem.cycle import CycleReport, State, Worn
from wearfem.errors import UserError
from wearfem.liner.breakthrough import thickness
from wearfem.liner.liner import Liner, wear_surface
from wearfem.progress import clock
from wearfem.record import hdf5_file, write_json, write_surface
from wearfem.values import read_value, write_value
from wearfem.wear.jump import Jump, Life
from wearfem.wear.metal import Metal, in_plain_depths
from wearfem.wear.sampling import Sample, corrected_depth

CYCLES, SAMPLES, SERIES = "cycles", "samples", "surface.vtkhdf.series"


@dataclass(frozen=True)
class History:
    """What a life has been so far: one row a cycle whose sample was kept, all on the facets of the present mesh."""

    service_time: np.ndarray  # (c,) [s]
    throughput: np.ndarray  # (c,) [kg]
    depth: np.ndarray  # (c, f) [m] worn off since the liner was new, by the trapezoid rule over the rates
    rate: np.ndarray  # (c, f) [m/s] mean of the sample
    error: np.ndarray  # (c, f) [m/s] standard error of it
    thickness: np.ndarray  # (c, f) [m] left
    window: np.ndarray  # (c,) [s] of steady flow sampled
    warm_up: np.ndarray  # (c,) [s] thrown away before it
    samples: tuple[Sample, ...]  # (c) with their blocks
    jump: tuple[Jump, ...]  # (c) after each sample
    life: tuple[Life, ...]  # (c) as told after each sample
    largest_von_mises: np.ndarray  # (c,) [Pa]; not a number where strength was not asked
    least_reserve: np.ndarray  # (c,) [-]; not a number where strength was not asked
    worn_volume: np.ndarray  # (c,) [m3]
    allowed_depth: np.ndarray  # (f,) [m] since the first sample, at which a facet is worn out
    metal: Metal | None  # what the case knows of it
    area: np.ndarray  # (f,) [m2]
    rejected: int  # cycles whose sample was not kept
    ended: str  # why the life ended; empty while it goes on
    reports: tuple[CycleReport, ...]  # of all cycles, in order
    state: State  # after the last cycle

    @property
    def simulated(self) -> float:
        """[s] of flow simulated, rejected samples and warm-ups too"""
        return float(sum(report.window + report.warm_up for report in self.reports))


@dataclass(frozen=True)
class Computing:
    """Where the time went that a run has computed. The first cycle may have compiled, so shares are of the later ones."""

    total: float  # [s] of all cycles
    later: float  # [s] of all cycles but the first
    flow: float  # [s] of these in which the flow was sampled: particles moved, their loads summed

    @property
    def outside(self) -> float:
        """[-] share of the later cycles that went into all else: rates, jumps, meshes, strength, files; NaN without later ones"""
        return 1.0 - self.flow / self.later if self.later > 0.0 else float("nan")

    def words(self) -> str:
        """In a line; empty where there is no later cycle"""
        if not np.isfinite(self.outside):
            return ""
        return (
            f"computing: {clock(self.total)} in cycles; all but the flow (rates, jumps, mesh, strength, files) took "
            f"{100.0 * self.outside:.2g} % of it, the first cycle left out"
        )


def computing_of(run: Path) -> Computing:
    """Where the computing time of a run went, by the clock of its cycles; not a number where a run of before did not tell"""
    spent = []
    for number in range(1, cycles_of(run) + 1):
        with h5py.File(run / CYCLES / f"{number:04d}.h5", "r") as file:
            spent.append([float(file.attrs.get(name, np.nan)) for name in ("run_time", "flow_time")])
    total, flow = np.array(spent)[:, 0], np.array(spent)[1:, 1]
    return Computing(float(total.sum()), float(total[1:].sum()), float(flow.sum()))


def write_cycle(
    run: Path,
    state: State,
    report: CycleReport,
    *,
    worn: Worn,
    run_time: float = 0.0,
    flow_time: float = 0.0,
) -> None:
    """Write down a cycle: the samples that are new, the worn face, then the state and the report in one file.

    Parameters
    ----------
    run
        The run folder.
    state, report
        What `cycle` returned.
    worn
        What the cycle sampled: `now` of the state before.
    run_time
        [s] that the cycle took, to be told and for nothing else.
    flow_time
        [s] of it in which the flow was sampled.
    """
    number = f"{report.cycle:04d}"
    place = _folder(run, CYCLES) / f"{number}.h5"
    if place.exists():
        raise UserError(
            f"{place} exists already, so another process is at work on this run: let it finish, or stop it first"
        )
    bare, samples = _without_samples(state)
    for mark, sample in samples.items():
        _write_sample(_folder(run, SAMPLES) / f"{mark}.h5", sample)
    write_worn_face(place.with_suffix(".vtkhdf"), worn, report)
    with hdf5_file(place) as file:
        file.attrs["wearfem"] = __version__
        file.attrs["run_time"] = run_time
        file.attrs["flow_time"] = flow_time
        write_value(file, "state", bare)
        write_value(file, "report", report)


def read_cycle(run: Path, number: int) -> tuple[State, CycleReport]:
    """State and report of a cycle, to the bit.

    Raises
    ------
    UserError
        for a file that is missing, cut off or damaged, or of another version.
    """
    place = run / CYCLES / f"{number:04d}.h5"
    bare, report = _read(place, lambda file: (read_value(file, "state"), read_value(file, "report")))
    return _with_samples(run, bare), report


def read_sampled(run: Path, number: int) -> tuple[Liner, CycleReport]:
    """The liner that a cycle sampled, and the report on it; of a cycle that was not kept, the liner is the one before."""
    place = run / CYCLES / f"{number:04d}.h5"
    return _read(place, lambda file: (read_value(file["state"]["kept"], "liner"), read_value(file, "report")))


def read_report(run: Path, number: int) -> CycleReport:
    """The report of a cycle."""
    return _read(run / CYCLES / f"{number:04d}.h5", lambda file: read_value(file, "report"))


def cycles_of(run: Path) -> int:
    """How many cycles a run has written; 0 for none."""
    numbers = sorted(int(path.stem) for path in (run / CYCLES).glob("*.h5") if path.stem.isdigit())
    if numbers != list(range(1, len(numbers) + 1)):
        missing = min(set(range(1, numbers[-1])) - set(numbers))
        raise UserError(
            f"{run} has the cycles up to {numbers[-1]}, but not cycle {missing}: put {missing:04d}.h5 back"
        )
    return len(numbers)


def read_history(run: Path) -> History:
    """All that a run has told so far."""
    count = cycles_of(run)
    if not count:
        raise UserError(f"{run} has no cycle yet: give the folder of a life that `wearfem run` has begun")
    state, last = read_cycle(run, count)
    reports = (*(read_report(run, number) for number in range(1, count)), last)
    return history_of(state, reports)


def history_of(state: State, reports: Sequence[CycleReport]) -> History:
    """The history of a life from its last state and the reports of all its cycles."""
    told, jump, life = [], [], []
    for report in reports:
        if report.kept:
            told.append(report)
            jump.append(report.jump)
            life.append(report.life)
        else:  # the jump that was chosen instead
            jump[-1], life[-1] = report.jump, report.life
    worn = state.now
    gained = _gained(worn, len(told))
    strain = [report.strain for report in told]
    return History(
        service_time=np.array([report.service_time for report in told]),
        throughput=np.array([report.throughput for report in told]),
        depth=worn.liner.depth - worn.receded + gained,
        rate=np.array([sample.mean for sample in worn.samples]),
        error=np.array([sample.error for sample in worn.samples]),
        thickness=_thickness(told, worn, gained),
        window=np.array([report.window for report in told]),
        warm_up=np.array([report.warm_up for report in told]),
        samples=worn.samples,
        jump=tuple(jump),
        life=tuple(life),
        largest_von_mises=np.array([one.largest_von_mises if one else np.nan for one in strain]),
        least_reserve=np.array([one.least_reserve if one else np.nan for one in strain]),
        worn_volume=np.array([report.worn_volume for report in told]),
        allowed_depth=worn.allowed_depth,
        metal=worn.metal,
        area=wear_surface(worn.liner).facet_area,
        rejected=len(reports) - len(told),
        ended=state.ended,
        reports=tuple(reports),
        state=state,
    )


def _gained(worn: Worn, cycles: int) -> np.ndarray:
    """(c, f) [m] worn off since the first sample at each service time, by the trapezoid rule over (plain) rates"""
    samples, metal = in_plain_depths(worn.samples, worn.metal), worn.metal
    plain = np.array([corrected_depth(samples[: n + 1]) for n in range(cycles)])
    return plain if metal is None else metal.depth_of(plain)


def _thickness(told: Sequence[CycleReport], worn: Worn, gained: np.ndarray) -> np.ndarray:
    """(c, f) [m] as each cycle measured it; on a mesh that has changed, what is left now and what has gone since."""
    if all(len(report.thickness) == len(worn.receded) for report in told):
        return np.array([report.thickness for report in told])
    return thickness(worn.liner.mesh) + worn.receded - gained


def write_worn_face(path: Path, worn: Worn, report: CycleReport) -> None:
    """The worn face that a cycle sampled, with what it found there, for ParaView and pyvista."""
    surface = wear_surface(worn.liner)
    loads = report.loads
    over = np.where(loads.area > 0.0, loads.area, np.inf) * loads.duration.sum()
    by_facet = {
        "depth [m]": report.depth,
        "thickness [m]": report.thickness,
        "depth rate [m/s]": report.rate,
        "standard error of the rate [m/s]": report.error,
        "mean pressure [Pa]": loads.normal_impulse.sum(axis=0) / over,
    }
    if report.strain is not None:
        by_facet["von Mises stress [Pa]"] = report.strain.von_mises
    write_surface(
        path,
        surface.point,
        surface.triangle,
        {"facet": surface.facet} | {name: value[surface.facet] for name, value in by_facet.items()},
    )


def write_series(run: Path, service_time: Sequence[float]) -> None:
    """The list of worn faces by service time [s], as ParaView reads it; the one file that every cycle writes anew."""
    files = [
        {"name": f"{CYCLES}/{number:04d}.vtkhdf", "time": time} for number, time in enumerate(service_time, 1)
    ]
    write_json(run / SERIES, {"file-series-version": "1.0", "files": files})


def service_time_of(run: Path, number: int) -> float:
    """[s] that the liner had served when a cycle sampled it"""
    place = run / CYCLES / f"{number:04d}.h5"
    return _read(place, lambda file: float(read_value(file["report"], "service_time")))


def _folder(run: Path, name: str) -> Path:
    try:
        (run / name).mkdir(exist_ok=True)
    except OSError as error:
        raise UserError(
            f"cannot make {run / name} ({error.strerror}): what is there is whole; make the folder writable and use wearfem resume"
        ) from error
    return run / name


def _read(place: Path, work: Callable[[h5py.File], Any]) -> Any:
    """What `work` reads from a file; a sentence where it cannot."""
    if not place.is_file():
        raise UserError(f"there is no file {place}: give the folder of a life that `wearfem run` has begun")
    try:
        with h5py.File(place, "r") as file:
            written = file.attrs.get("wearfem")
            if written != __version__:
                raise UserError(
                    f"{place} was written by wearfem {written}, and this is {__version__}: use that version, or run the case again"
                )
            return work(file)
    except PermissionError as error:
        raise UserError(f"{place} cannot be read (permission denied): make it readable") from error
    except (OSError, KeyError, RuntimeError, ValueError) as error:
        raise UserError(
            f"{place} is cut off or damaged ({error}): move it away, with all later cycles, and resume from the cycle before"
        ) from error


def _write_sample(place: Path, sample: Sample) -> None:
    if place.exists():
        return
    with hdf5_file(place) as file:
        file.attrs["wearfem"] = __version__
        write_value(file, "sample", sample)


def _mark(sample: Sample) -> str:
    digest = sha256(np.ascontiguousarray(sample.rate).tobytes())
    digest.update(repr((sample.rate.shape, sample.service_time, sample.block, sample.warm_up)).encode())
    if sample.depth is not None:
        digest.update(np.ascontiguousarray(sample.depth).tobytes())
    return digest.hexdigest()[:24]


def _without_samples(state: State) -> tuple[State, dict[str, Sample]]:
    """The state with the marks of its samples in their place, and the samples by mark."""
    found: dict[str, Sample] = {}

    def bare(worn: Worn | None) -> Worn | None:
        if worn is None:
            return None
        marks = [_mark(sample) for sample in worn.samples]
        found.update(zip(marks, worn.samples, strict=True))
        return replace(worn, samples=tuple(marks))  # type: ignore[arg-type]

    now = bare(state.now)
    assert now is not None
    return replace(state, now=now, kept=bare(state.kept)), found


def _with_samples(run: Path, state: State) -> State:
    """The state with its samples read back."""
    read: dict[str, Sample] = {}

    def whole(worn: Worn) -> Worn:
        for mark in worn.samples:
            key = str(mark)
            if key not in read:
                read[key] = _read(run / SAMPLES / f"{key}.h5", lambda file: read_value(file, "sample"))
        return replace(worn, samples=tuple(read[str(mark)] for mark in worn.samples))

    return replace(state, now=whole(state.now), kept=whole(state.kept) if state.kept else None)
