"""One run of a case: stage by stage, then its figures, all written to a run folder."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from wearfem.case import Case, Figure, Outcome, StageOutcome, load_case
from wearfem.progress import clock, progress
from wearfem.record import (
    RunFolder,
    figure_list,
    hdf5_file,
    now,
    require_writable,
    write_json,
    write_loads,
)
from wearfem.settings import Value


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
    case = load_case(case_folder, settings)
    folder = RunFolder.create(out) if out else RunFolder.create_free(case.name)
    folder.write_manifest(case, started)
    print(f"{case.name}: writing to {folder.path}", flush=True)

    outcome = run_stages(case, quiet)
    figures = case.measure(outcome)
    with hdf5_file(folder.path / "loads.h5") as file:
        for stage in outcome.stages:
            write_loads(file.create_group(stage.stage.name), stage.loads)
    if case.draw:
        case.draw(outcome, folder.path)
    folder.write_figures(figures)
    if json_file:
        write_json(json_file, figure_list(figures))
    finished = now()
    folder.write_manifest(case, started, finished)

    print(figure_table(figures))
    for note in case.notes:
        print(f"note: {note}")
    print(f"wrote {folder.path} in {clock((finished - started).total_seconds())}")
    return figures


def run_stages(case: Case, quiet: bool = False) -> Outcome:
    """Lead the flow of a case through its stages."""
    from wearfem.dem.sample import (
        sample,
    )  # here, so that a mistake in the case is told before numba is loaded

    flow, outcomes = case.flow, []
    for stage in case.stages:
        with progress(stage.window.duration, f"{case.name}: {stage.name}", quiet) as bar:
            flow, loads, snapshots = sample(flow, stage.model, stage.window, stage.until, bar.update)
        outcomes.append(StageOutcome(stage, flow, loads, snapshots))
    return Outcome(tuple(outcomes))


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
