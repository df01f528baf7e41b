"""What a study leaves: one row a run, as JSON when it is done, then as a table in CSV and HDF5, pictures and converged answers.

rows/<run>.json       keywords, figures, status and seconds of one run, written when it ends
results.csv           all rows, one a line; figures carry their unit in the name, keywords are in SI
results.h5            the same, one dataset a column, units as attributes
pictures/<figure>.png each figure over each keyword that varies
converged.json        observed orders and converged answers, where a keyword is a size
"""

import csv
import io
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import isnan, nan
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.case import Figure
from wearfem.convergence import Converged, converged
from wearfem.errors import UserError
from wearfem.record import figure_list, hdf5_file, whole_file, write_json
from wearfem.report import draw_lines, picture

ROWS = "rows"
SEED = "seed"  # the keyword over which converged answers take the mean
MOST_LINES = 8  # in one picture; more become dots


@dataclass(frozen=True)
class Row:
    """One run of a study."""

    run: str  # name of its folder below `runs`
    settings: Mapping[str, Any]  # all keywords [SI]
    status: str  # `done` or `failed`
    seconds: float  # [s] of wall time, of a resumed run since it was last resumed
    figures: tuple[Figure, ...] = ()
    problem: str = ""  # why it failed

    def figure(self, name: str) -> float:
        """The value of a figure; not a number where this run has none."""
        return next((figure.value for figure in self.figures if figure.name == name), nan)


@dataclass(frozen=True)
class Answer:
    """What one figure tends to as one keyword goes to zero, the other keywords being as they are."""

    figure: str
    unit: str
    size: str  # the keyword
    others: Mapping[str, Any]  # keywords that vary beside it
    answer: Converged


def write_row(folder: Path, row: Row) -> None:
    """Write `rows/<run>.json`."""
    (folder / ROWS).mkdir(exist_ok=True)
    write_json(folder / ROWS / f"{row.run}.json", asdict(row) | {"figures": figure_list(row.figures)})


def read_rows(folder: Path) -> tuple[Row, ...]:
    """All rows that a study folder holds, sorted by the keywords that vary."""
    rows = [_read_row(file) for file in sorted((folder / ROWS).glob("*.json"))]
    names = varied(rows)
    return tuple(sorted(rows, key=lambda row: [_rank(row.settings.get(name)) for name in names]))


def _read_row(file: Path) -> Row:
    try:
        told = json.loads(file.read_text(encoding="utf-8"))
        return Row(**told | {"figures": read_figures(told["figures"])})
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{file} cannot be read ({error}): remove it, and its run is made again") from error


def read_figures(told: Iterable[dict[str, Any]]) -> tuple[Figure, ...]:
    """Figures as `figures.json` holds them; null is what was not a number."""
    return tuple(
        Figure(
            **{name: item for name, item in one.items() if name != "verdict"}
            | {"value": _number(one["value"])}
        )
        for one in told
    )


def _number(value: Any) -> float:
    return nan if value is None else float(value)


def _rank(value: Any) -> tuple[int, Any]:
    return (0, value) if isinstance(value, int | float) else (1, str(value))


def varied(rows: Sequence[Row]) -> list[str]:
    """The keywords that are not the same in all rows."""
    names = rows[0].settings if rows else {}
    return [name for name in names if len({repr(row.settings.get(name)) for row in rows}) > 1]


def figures_of(rows: Sequence[Row]) -> dict[str, str]:
    """Unit by name of all figures of all rows, in the order of the cases."""
    return {figure.name: figure.unit for row in rows for figure in row.figures}


def write_results(folder: Path, rows: Sequence[Row], sizes: Sequence[str] = ()) -> tuple[Answer, ...]:
    """Write tables and pictures of all rows, and the converged answers for the keywords that are sizes."""
    found = answers(rows, sizes)
    write_csv(folder / "results.csv", rows)
    write_hdf5(folder / "results.h5", rows)
    if found:
        write_json(folder / "converged.json", found)
    draw_figures(folder / "pictures", rows, found)
    return found


def columns(rows: Sequence[Row]) -> dict[str, tuple[str, list[Any]]]:
    """Unit and values by name: the run, its status and seconds, the keywords, the figures, the problem."""
    table: dict[str, tuple[str, list[Any]]] = {
        "run": ("", [row.run for row in rows]),
        "status": ("", [row.status for row in rows]),
        "seconds": ("s", [row.seconds for row in rows]),
    }
    changing = varied(rows)
    keywords = dict.fromkeys([*changing, *(name for row in rows for name in row.settings)])
    for name in keywords:
        table[name] = ("SI", [row.settings.get(name) for row in rows])
    for name, unit in figures_of(rows).items():
        table[f"{name} [{unit}]"] = (unit, [row.figure(name) for row in rows])
    table["problem"] = ("", [row.problem for row in rows])
    return table


def write_csv(path: Path, rows: Sequence[Row]) -> None:
    """One row a line; what a run does not have is empty."""
    table, text = columns(rows), io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table)
    for values in zip(*(values for _, values in table.values()), strict=True):
        writer.writerow("" if value is None or value != value else value for value in values)
    with whole_file(path) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8")


def write_hdf5(path: Path, rows: Sequence[Row]) -> None:
    """One dataset a column, all as long as the table; numbers as float64, all else as text. `/` in a name becomes `per`."""
    with hdf5_file(path) as file:
        for name, (unit, values) in columns(rows).items():
            numbers = all(
                value is None or isinstance(value, int | float) and not isinstance(value, bool)
                for value in values
            )
            data = [_number(value) for value in values] if numbers else [str(value) for value in values]
            kind = np.float64 if numbers else file_text()
            file.create_dataset(name.replace("/", " per "), data=np.array(data, dtype=kind)).attrs["unit"] = (
                unit
            )


def file_text() -> Any:
    """The HDF5 type of a text of any length."""
    import h5py

    return h5py.string_dtype("utf-8")


def size_of(name: str, value: Any) -> float:
    """A keyword as a size: a whole number counts parts, so that its size is 1/number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0:
        raise UserError(
            f"{name} was to be taken as a size, but it has the value {value!r}: a size is a number above 0"
        )
    return 1.0 / value if isinstance(value, int) else value


def answers(rows: Sequence[Row], sizes: Sequence[str]) -> tuple[Answer, ...]:
    """The converged answer of each figure, for each keyword that is a size and each setting of the others.

    Runs that differ in `seed` alone are samples of one result: their mean is taken, with its standard error as noise.
    """
    done = [row for row in rows if row.status == "done"]
    found = []
    for size in sizes:
        others = [name for name in varied(done) if name not in (size, SEED)]
        groups: dict[str, list[Row]] = {}
        for row in done:
            groups.setdefault(repr([row.settings[name] for name in others]), []).append(row)
        for group in groups.values():
            for name, unit in figures_of(group).items():
                answer = _answer(group, size, name)
                if answer is not None:
                    same = {other: group[0].settings[other] for other in others}
                    found.append(Answer(name, unit, size, same, answer))
    return tuple(found)


def _answer(group: Sequence[Row], size: str, figure: str) -> Converged | None:
    """The converged answer of one figure; None with fewer than three sizes."""
    samples: dict[float, list[float]] = {}
    for row in group:
        if not isnan(row.figure(figure)):
            samples.setdefault(size_of(size, row.settings[size]), []).append(row.figure(figure))
    if len(samples) < 3:
        return None
    mean = [float(np.mean(values)) for values in samples.values()]
    if min(len(values) for values in samples.values()) < 2:
        return converged(list(samples), mean)
    error = [float(np.std(values, ddof=1) / np.sqrt(len(values))) for values in samples.values()]
    return converged(list(samples), mean, error if min(error) > 0.0 else None)


def answer_lines(found: Sequence[Answer]) -> list[str]:
    """The converged answers as lines of text."""
    lines = []
    for one in found:
        told = one.answer
        where = f" ({settings_words(one.others)})" if one.others else ""
        noise = f", noise {told.noise:.2g}" if told.noise > 0.0 else ""
        if not told.told:
            text = f"no converged answer: {told.reason}"
        elif told.reason:
            text = f"{told.value:.6g} {one.unit}{noise}: {told.reason}"
        else:
            text = f"{told.value:.6g} {one.unit}, order {told.order:.3g}, the finest is within {told.error:.2g} {one.unit}{noise}"
        lines.append(f"{one.figure} as {one.size} goes to zero{where}: {text}")
    return lines


def settings_words(settings: Mapping[str, Any]) -> str:
    """`mesh=0.006, law=constant`."""
    return ", ".join(
        f"{name}={value:.6g}" if isinstance(value, float) else f"{name}={value}"
        for name, value in settings.items()
    )


def draw_figures(folder: Path, rows: Sequence[Row], found: Sequence[Answer] = ()) -> None:
    """One picture a figure: over each keyword that varies, a line for each setting of the others, or dots if those are many."""
    done = [row for row in rows if row.status == "done"]
    names = varied(done)
    if not names:
        return
    folder.mkdir(exist_ok=True)
    for figure, unit in figures_of(done).items():
        with picture(folder / f"{re.sub(r'[^A-Za-z0-9]+', '_', figure).strip('_')}.png", len(names)) as axes:
            for one, name in zip(axes, names, strict=True):
                _draw(
                    one, done, name, [other for other in names if other != name], f"{figure} [{unit}]", figure
                )
                for answer in found:
                    if (answer.figure, answer.size) == (figure, name) and answer.answer.told:
                        one.axhline(answer.answer.value, linestyle="--", linewidth=0.8, color="0.5")


def _draw(axes: Any, rows: Sequence[Row], name: str, others: Sequence[str], label: str, figure: str) -> None:
    """A figure over one keyword."""
    lines: dict[str, list[Row]] = {}
    for row in rows:
        lines.setdefault(settings_words({other: row.settings[other] for other in others}), []).append(row)
    if len(lines) > MOST_LINES:
        lines = {"": list(rows)}
        style = "o"
    else:
        style = "o-"
    for words, line in lines.items():
        in_order = sorted(line, key=lambda row: _rank(row.settings[name]))
        x = [row.settings[name] for row in in_order]
        numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in x)
        unit = " [SI]" if numbers and any(isinstance(value, float) for value in x) else ""
        y = np.array([row.figure(figure) for row in in_order])
        draw_lines(
            axes,
            np.array(x if numbers else [str(value) for value in x]),
            {words: y},
            f"{name}{unit}",
            label,
            style,
        )
    if len(lines) > 1:
        axes.legend(frameon=False, fontsize="small")
