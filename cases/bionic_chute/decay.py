"""How the saving fades while the convexes wear away: `python cases/bionic_chute/decay.py RUN`, RUN a folder for the life.

The chute is filled with ore once; then it lives in coupled cycles, each over the convexes as they are by then, until the time to stop. The
same chute with its convexes kept as new is the first cycle, told for ever. On the upper half of zone 2, as in trends.py, whose smooth
chute is what the wear is compared with. Goes on where it was stopped. `--table` only reads the folder and writes `decay.json`.
"""

import argparse
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import t as student

from wearfem import __version__
from wearfem.case import LifeCase, Stop, Window, load_any_case
from wearfem.cycle import CycleReport, Worn
from wearfem.errors import UserError, in_a_sentence
from wearfem.history import cycles_of, read_cycle
from wearfem.life import live
from wearfem.liner.liner import wear_surface
from wearfem.units import hour, mm
from wearfem.wear.sampling import Sample, standard_error

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "decay.json"
WIDE = float(student.ppf(0.95, 7))  # standard errors in half of a 90 % interval, of eight blocks
FILL, WARM_UP, WINDOW, BLOCKS = 0.35, 0.1, 0.1, 8  # [s], [s], [s], [-]


@dataclass(frozen=True)
class Moment:
    """The chute at one moment of its service."""

    service_time: float  # [s]
    throughput: float  # [kg]
    rate: float  # [m3/s] worn off the upper half of zone 2, whole width
    error: float  # [m3/s] its standard error
    convex_height: float  # [m] mean of the tops over the mean of the matrix
    matrix_worn: float  # [m] mean
    convex_share: float  # [-] of the wear
    by_place: list[float]  # [m/s] depth rate by place on a tile: `alike` of the strip
    version: str = __version__


def filled(case: LifeCase) -> LifeCase:
    """The case with ore on the chute from the beginning."""
    flow, _ = case.sampler.sample(case.flow, wear_surface(case.liner), Window(FILL))
    return replace(case, flow=flow)


def moment(case: LifeCase, report: CycleReport, worn: Worn, sample: Sample) -> Moment:
    """What a cycle saw."""
    where, mesh, new = case.measure.where, worn.liner.mesh, case.liner.mesh
    matrix = (where.height == 0.0) & (mesh.thickness < new.thickness)
    blocks = (sample.rate * report.loads.area) @ where.zone_2 / where.share
    rate = float(where.volume_rate(report.loads).mean())
    alike = case.effects[0].alike
    depth_rate = case.wear_law.depth_rate(report.loads)[0]
    area = report.loads.area * where.zone_2
    return Moment(
        report.service_time,
        report.throughput,
        rate,
        float(standard_error(blocks[:, None])[0]),
        where.convex_height(mesh),
        float((new.thickness - mesh.thickness)[matrix].mean()) if matrix.any() else 0.0,
        float(where.volume_rate(report.loads, where.on_convex).mean()) / rate,
        (np.bincount(alike, depth_rate * area) / np.bincount(alike, area)).tolist(),
    )


def moments(case: LifeCase, run: Path) -> list[Moment]:
    """All cycles of a run folder whose sample was trusted."""
    found, worn = [], Worn(case.liner, case.liner.depth, np.asarray(case.goal.allowed_depth))
    for number in range(1, cycles_of(run) + 1):
        state, report = read_cycle(run, number)
        if report.kept:
            found.append(moment(case, report, worn, state.kept.samples[-1]))
        worn = state.now
    return found


def read() -> list[Moment]:
    """What is shipped."""
    return [Moment(**row) for row in json.loads(RESULTS.read_text())]


def smooth_rate() -> float:
    """[m3/s] of the upper half of zone 2 without convexes: mean over the seeds of trends.py"""
    rows = json.loads((FOLDER / "trends.json").read_text())
    smooth = [row for row in rows if row["settings"].get("convexes") is False]
    return float(
        np.mean([np.mean(row["upper"]) for row in smooth if row["settings"]["span"] == "upper half"])
    )


@dataclass(frozen=True)
class Lost:
    """What the upper half of zone 2 has lost up to each moment, and what it would have lost with its convexes as they were new."""

    moving: np.ndarray  # (c,) [m3] trapezoid rule
    moving_error: np.ndarray  # (c,) [m3] standard error, samples taken as independent
    kept: np.ndarray  # (c,) [m3]
    kept_error: np.ndarray  # (c,) [m3]


def lost(found: list[Moment]) -> Lost:
    """From the rates of the samples."""
    time, rate, error = (
        np.array([getattr(one, name) for one in found]) for name in ("service_time", "rate", "error")
    )
    weight = np.zeros((len(time), len(time)))  # of each sample in what is lost up to each moment [s]
    for k in range(1, len(time)):
        step = time[k] - time[k - 1]
        weight[k] = weight[k - 1]
        weight[k, k - 1 : k + 1] += 0.5 * step
    return Lost(weight @ rate, np.sqrt(weight**2 @ error**2), rate[0] * time, error[0] * time)


def table() -> str:
    """The saving against throughput, and what is lost with and without the change of the geometry; Markdown."""
    found, smooth = read(), smooth_rate()
    so_far = lost(found)
    lines = [
        "| throughput | convexes left | matrix worn | wear saved | lost so far | lost, convexes kept as new |",
        "|---|---|---|---|---|---|",
        "| kt | mm | mm | % | cm3 | cm3 |",
    ]
    for k, one in enumerate(found):
        saved, half = (100.0 * (1.0 - one.rate / smooth), 100.0 * WIDE * one.error / smooth)
        lines.append(
            f"| {1e-6 * one.throughput:.2f} | {1e3 * one.convex_height:.3f} | {1e3 * one.matrix_worn:.4f} | {saved:.1f} +- {half:.1f} "
            f"| {_cm3(so_far.moving[k], so_far.moving_error[k])} | {_cm3(so_far.kept[k], so_far.kept_error[k])} |"
        )
    return "\n".join(lines)


def _cm3(volume: float, error: float) -> str:
    """A volume [m3] with its 90 % interval from a standard error"""
    return f"{1e6 * volume:.2f} +- {1e6 * WIDE * error:.2f}"


def change_is_real() -> str:
    """What is lost up to the end, with and without the change of the geometry; a sentence."""
    found = read()
    so_far, end = lost(found), found[-1]
    moving, kept = (
        _cm3(so_far.moving[-1], so_far.moving_error[-1]),
        _cm3(so_far.kept[-1], so_far.kept_error[-1]),
    )
    hours = so_far.moving[-1] / found[0].rate / hour
    return (
        f"up to {1e-6 * end.throughput:.2f} kt zone 2's upper half lost {moving} cm3, with the convexes kept as new it would have "
        f"lost {kept} cm3. What is lost in {end.service_time / hour:.0f} h would take {hours:.0f} h"
    )


def when_new() -> str:
    """What the convexes save before any has worn; words."""
    first, smooth = read()[0], smooth_rate()
    return f"{100.0 * (1.0 - first.rate / smooth):.1f} +- {100.0 * WIDE * first.error / smooth:.1f} %"


def main() -> None:
    """Live, then tell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path, metavar="RUN")
    parser.add_argument("--stop", type=float, default=250.0, metavar="HOURS", help="of service")
    parser.add_argument(
        "--minor-radius", type=float, default=2.0, metavar="MM", help="height of the convexes"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--table", action="store_true", help="run nothing")
    given = parser.parse_args()
    settings = {"seed": given.seed, "minor_radius": given.minor_radius * mm}
    case = load_any_case(FOLDER, settings)
    stop = Stop(service_time=given.stop * hour)
    case = replace(case, warm_up=WARM_UP, window=Window(WINDOW, BLOCKS), stop=stop)
    if not given.table:
        given.run.mkdir(parents=True, exist_ok=True)
        live(case if cycles_of(given.run) else filled(case), given.run, quiet=True)
    found = moments(case, given.run)
    if not found:
        raise UserError(f"{given.run} holds no life: give the folder that decay.py has lived in")
    RESULTS.write_text(json.dumps([asdict(one) for one in found], indent=1) + "\n")
    print(table())
    print(f"{change_is_real()}.")


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
