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
from wearfem.history import cycles_of, read_cycle
from wearfem.life import live
from wearfem.liner.liner import wear_surface
from wearfem.units import degree, hour, mm
from wearfem.wear.sampling import Sample, standard_error

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "decay.json"
MIDDLE = 0.5 * (35.34 + 64.15) * degree  # of zone 2: its upper half is in the model, as in trends.py
KEYWORDS = {"sectors": 8, "rings": 2, "rings_around": 1, "tolerance": 0.3, "worn_off": 20 * mm, "end": MIDDLE}
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
    version: str = __version__


def filled(case: LifeCase) -> LifeCase:
    """The case with ore on the chute from the beginning."""
    flow, _ = case.sampler.sample(case.flow, wear_surface(case.liner), Window(FILL))
    return replace(case, flow=flow)


def moment(case: LifeCase, report: CycleReport, worn: Worn, sample: Sample) -> Moment:
    """What a cycle saw."""
    where, mesh, new = case.measure.where, worn.liner.mesh, case.liner.mesh
    height = new.thickness - new.thickness.min()
    top, matrix = height > 0.999 * height.max(), height == 0.0
    blocks = (sample.rate * report.loads.area) @ where.zone_2 / where.share
    rate = float(where.volume_rate(report.loads).mean())
    return Moment(
        report.service_time,
        report.throughput,
        rate,
        float(standard_error(blocks[:, None])[0]),
        float(mesh.thickness[top].mean() - mesh.thickness[matrix].mean()),
        float((new.thickness - mesh.thickness)[matrix].mean()),
        float(where.volume_rate(report.loads, where.on_convex).mean()) / rate,
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


def table(found: list[Moment], smooth: float) -> None:
    """Print the saving against throughput, with and without the change of the geometry."""
    wide = float(student.ppf(0.95, BLOCKS - 1))
    print("throughput   convexes left   matrix worn    wear saved [%] (90 %)   as if kept new")
    for one in found:
        saved, half = (100.0 * (1.0 - one.rate / smooth), 100.0 * wide * one.error / smooth)
        first = 100.0 * (1.0 - found[0].rate / smooth)
        print(
            f"{1e-6 * one.throughput:7.2f} kt   {1e3 * one.convex_height:8.3f} mm   {1e3 * one.matrix_worn:8.4f} mm   "
            f"{saved:8.1f} +- {half:4.1f}          {first:8.1f}"
        )


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
    settings = {**KEYWORDS, "seed": given.seed, "minor_radius": given.minor_radius * mm}
    case = load_any_case(FOLDER, settings)
    stop = Stop(service_time=given.stop * hour)
    case = replace(case, warm_up=WARM_UP, window=Window(WINDOW, BLOCKS), stop=stop)
    if not given.table:
        given.run.mkdir(parents=True, exist_ok=True)
        live(case if cycles_of(given.run) else filled(case), given.run, quiet=True)
    found = moments(case, given.run)
    RESULTS.write_text(json.dumps([asdict(one) for one in found], indent=1) + "\n")
    smooth = [
        np.mean(row["upper"])
        for row in json.loads((FOLDER / "trends.json").read_text())
        if row["settings"].get("convexes") is False and row["settings"]["span"] == "upper half"
    ]
    table(found, float(np.mean(smooth)))


if __name__ == "__main__":
    main()
