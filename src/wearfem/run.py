"""One run of a case: stage by stage or cycle by cycle, then its figures, all written to a run folder."""

from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.case import Case, Figure, LifeCase, Outcome, StageOutcome, load_any_case
from wearfem.errors import UserError
from wearfem.progress import clock, progress
from wearfem.record import (
    RunFolder,
    check_same,
    figure_list,
    hdf5_file,
    manifest,
    now,
    read_manifest,
    require_writable,
    sweep,
    write_json,
    write_loads,
    write_surface,
)
from wearfem.settings import Value
from wearfem.wear.laws import WearLaw, worn_depth


def run_case(
    case_folder: Path,
    settings: Mapping[str, Value],
    out: Path | None = None,
    json_file: Path | None = None,
    quiet: bool = False,
) -> tuple[Figure, ...]:
    """Run a case, print its figures and write everything down.

    Parameters
    ----------
    case_folder
        The folder with the `case.py`.
    settings
        Keywords of the case [SI].
    out
        The run folder to make; without it the first free one of `runs/<case>`, `runs/<case>-2`, ...
    json_file
        Where else to write the figures.
    quiet
        Show no progress.
    """
    started = now()
    if json_file:
        require_writable(json_file)
    case = load_any_case(case_folder, settings)
    if isinstance(case, Case):
        check_first_stage(case)
    folder = RunFolder.create(out) if out else RunFolder.create_free(case.name)
    folder.write_manifest(case, started)
    print(f"{case.name}: writing to {folder.path}", flush=True)
    if isinstance(case, LifeCase):
        return _live(case, folder, started, json_file, quiet)

    outcome = run_stages(case, quiet)
    figures = case.measure(outcome)
    with hdf5_file(folder.path / "loads.h5") as file:
        for stage in outcome.stages:
            write_loads(file.create_group(stage.stage.name), stage.loads)
    if case.wear_law is not None:
        write_worn_surface(folder.path / "surface.vtkhdf", case.wear_law, outcome.stages[-1])
    if case.draw:
        case.draw(outcome, folder.path)
    return _finish(case, folder, figures, started, json_file)


def resume_run(run: Path, json_file: Path | None = None, quiet: bool = False) -> tuple[Figure, ...]:
    """Go on with the life in a run folder, from its last whole cycle, to the same bits as if it had never stopped.

    Parameters
    ----------
    run
        The run folder.
    json_file, quiet
        As in `run_case`.

    Raises
    ------
    UserError
        for a folder that is no run, a run that is finished or of a case in stages, and where the case, one of its files or the version
        of wearfem is not the one that began it.
    """
    if json_file:
        require_writable(json_file)
    case, begun = case_of_run(run)
    if begun["finished"] is not None:
        raise UserError(
            f"the run in {run} is finished ({begun['finished']}): there is nothing to resume; with another keyword, such as a later stop, "
            "run the case again"
        )
    sweep(run)
    print(f"{case.name}: going on in {run}", flush=True)
    return _live(case, RunFolder(run), datetime.fromisoformat(begun["started"]), json_file, quiet)


def case_of_run(run: Path) -> tuple[LifeCase, dict[str, Any]]:
    """The case that a run folder is a life of, with the run's keywords, and what the folder says of itself.

    Raises
    ------
    UserError
        for a folder that is no run or of a case in stages, and where the case, one of its files or the version of wearfem is not the one
        that began it.
    """
    begun = read_manifest(run)
    # null stands for what JSON cannot say, an infinite default: no setting is infinite
    settings = {name: _as_set(value) for name, value in begun["settings"].items() if value is not None}
    case = load_any_case(Path(begun["folder"]), settings)
    if not isinstance(case, LifeCase):
        raise UserError(
            f"{run} is a run of {case.name}, a case in stages, which is run anew: use wearfem run"
        )
    check_same(run, begun, manifest(case, now()))
    return case, begun


def live_to_the_end(case: LifeCase, path: Path, quiet: bool = False) -> None:
    """Live the life of a case in a run folder, new or begun by the same case; nothing is done twice.

    Parameters
    ----------
    case
        From a folder.
    path
        The run folder.
    quiet
        Show no progress within a cycle.
    """
    from wearfem.life import live

    if (path / "manifest.json").exists():
        begun = read_manifest(path)
        check_same(path, begun, manifest(case, now()))
        if begun["finished"] is not None:
            return
        sweep(path)
        folder, started = RunFolder(path), datetime.fromisoformat(begun["started"])
    else:
        folder, started = RunFolder.create(path), now()
        folder.write_manifest(case, started)
    folder.write_figures(case.measure(live(case, path, quiet)))
    folder.write_manifest(case, started, now())


def _as_set(value: Any) -> Any:
    """A setting as `--set` gives it: JSON knows no tuples."""
    return tuple(_as_set(item) for item in value) if isinstance(value, list) else value


def _live(
    case: LifeCase, folder: RunFolder, started: datetime, json_file: Path | None, quiet: bool
) -> tuple[Figure, ...]:
    """Live the life of a case to its end, then measure it."""
    from wearfem.life import live  # here, so that a mistake in the case is told before all is loaded

    history = live(case, folder.path, quiet)
    figures = case.measure(history)
    if case.draw:
        case.draw(history, folder.path)
    return _finish(case, folder, figures, started, json_file)


def _finish(
    case: Case | LifeCase,
    folder: RunFolder,
    figures: Sequence[Figure],
    started: datetime,
    json_file: Path | None,
) -> tuple[Figure, ...]:
    """Write the figures down and print them."""
    folder.write_figures(figures)
    if json_file:
        write_json(json_file, figure_list(figures))
    finished = now()
    folder.write_manifest(case, started, finished)

    print(figure_table(figures))
    for note in case.notes:
        print(f"note: {note}")
    print(f"wrote {folder.path} in {clock((finished - started).total_seconds())}")
    return tuple(figures)


def check_first_stage(case: Case) -> None:
    """Refuse, before anything is written, what is known to go wrong at the first step."""
    from wearfem.dem.start import check_start

    check_start(case.flow, case.stages[0].model)


def run_stages(case: Case, quiet: bool = False) -> Outcome:
    """Lead the flow of a case through its stages."""
    from wearfem.dem.sample import (
        sample,  # here, so that a mistake in the case is told before numba is loaded
    )

    flow, outcomes = case.flow, []
    for stage in case.stages:
        with progress(stage.window.duration, f"{case.name}: {stage.name}", quiet) as bar:
            flow, loads, snapshots = sample(flow, stage.model, stage.window, stage.until, bar.update)
        outcomes.append(StageOutcome(stage, flow, loads, snapshots))
    return Outcome(tuple(outcomes))


def write_worn_surface(path: Path, law: WearLaw, outcome: StageOutcome) -> None:
    """Write all surfaces of a stage, each where it was at time zero, with what the stage did to them by facet."""
    surfaces, loads = outcome.stage.model.surfaces, outcome.loads
    points = np.cumsum([0, *(len(surface.point) for surface in surfaces)])
    facets = np.cumsum([0, *(surface.facet_count for surface in surfaces)])
    facet = np.concatenate([s.facet + first for s, first in zip(surfaces, facets, strict=False)])
    time = loads.duration.sum()
    by_facet = {
        "depth [m]": worn_depth(law, loads),
        "wear volume [m3]": worn_depth(law, loads) * loads.area,
        "mean pressure [Pa]": loads.normal_impulse.sum(axis=0)
        / np.where(loads.area > 0, loads.area, np.inf)
        / time,
        "load distance [N m]": loads.load_distance.sum(axis=0),
        "friction work [J]": loads.friction_work.sum(axis=0),
        "impact energy [J]": loads.impact_energy.sum(axis=(0, 2, 3)),
    }
    write_surface(
        path,
        np.concatenate([surface.point for surface in surfaces]),
        np.concatenate([s.triangle + first for s, first in zip(surfaces, points, strict=False)]),
        {"facet": facet} | {name: value[facet] for name, value in by_facet.items()},
    )


def figure_table(figures: Sequence[Figure]) -> str:
    """The figures as lines of text in columns."""
    rows: list[tuple[str, ...]] = [("figure", "value", "expected", "tolerance", "verdict", "source")]
    for figure in figures:
        numbers = [
            "" if number is None else f"{number:.6g} {figure.unit}"
            for number in (figure.value, figure.expected, figure.tolerance)
        ]
        rows.append((figure.name, *numbers, figure.verdict, figure.source))
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)
