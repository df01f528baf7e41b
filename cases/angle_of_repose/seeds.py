"""The six angles over several seeds of the feed, beside the published ones: `python cases/angle_of_repose/seeds.py --seeds 3`.

Without `--set` they are those of the case as it is, and are kept in `seeds.json`, from which docs/print_pages.py takes them.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from scipy.stats import t as student

from wearfem import __version__
from wearfem.case import load_case
from wearfem.errors import in_a_sentence
from wearfem.run import run_stages
from wearfem.settings import parse_settings

RESULTS = Path(__file__).parent / "seeds.json"
FREE = """\
Free, because not printed: lengths of box and bin, height of the fall, width, times between the stages, how the angles were read.
Changed: shear modulus (printed 65 GPa). Materials, friction, restitution, rolling friction, sizes and feed are as printed;
nothing was adjusted to meet the angles."""


def interval(values: list[float]) -> tuple[float, float]:
    """Mean and half of its 95 % interval (Student's t over seeds; not a number for one seed)."""
    count = len(values)
    spread = float(np.std(values, ddof=1)) if count > 1 else float("nan")
    return float(np.mean(values)), float(student.ppf(0.975, max(count - 1, 1))) * spread / count**0.5


def three_angles(settings: dict) -> list:
    """The figures of the three angles of one run."""
    case = load_case(Path(__file__).parent, settings)
    figures = [figure for figure in case.measure(run_stages(case)) if figure.tolerance]
    print(settings, *(f"{figure.value:.2f}" for figure in figures), flush=True)
    return figures


def verdict(ours: tuple[float, float], theirs: tuple[float, float]) -> str:
    """Whether two intervals meet."""
    apart = abs(ours[0] - theirs[0]) - theirs[1] - (ours[1] if ours[1] == ours[1] else 0.0)
    if apart <= 0.0:
        return "meets"
    return f"outside: {apart:.1f} {'below' if ours[0] < theirs[0] else 'above'}"


def table(rows: list[dict] | None = None) -> str:
    """The angles beside the published ones, of what is shipped or of `rows`; Markdown."""
    lines = [
        "| | experiment | their simulation | ours | against the experiment |",
        "|---|---|---|---|---|",
    ]
    for row in rows or json.loads(RESULTS.read_text())["rows"]:
        cells = [
            f"{mean:.1f} +- {half:.1f}"
            for mean, half in (row["published"], row["their_simulation"], row["ours"])
        ]
        told = verdict(row["ours"], row["published"])
        lines.append(f"| experiment {row['experiment']}, phi {row['angle']} | {' | '.join([*cells, told])} |")
    return "\n".join(lines)


def main() -> None:
    """Run both experiments for every seed and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3, help="how many")
    parser.add_argument("--set", action="append", default=[], metavar="K=V", help="a keyword of the case")
    given = parser.parse_args()
    settings, rows = parse_settings(given.set), []
    for experiment in (1, 2):
        runs = [
            three_angles({**settings, "experiment": experiment, "seed": 1 + k}) for k in range(given.seeds)
        ]
        for number, figures in enumerate(zip(*runs, strict=True)):
            rows.append(
                {
                    "experiment": experiment,
                    "angle": number + 1,
                    "ours": interval([figure.value for figure in figures]),
                    "published": [figures[0].expected, figures[0].tolerance],
                    "their_simulation": [
                        float(word) for word in figures[0].source.split("simulation ")[1].split(" +- ")
                    ],
                }
            )
    print(table(rows))
    print(FREE)
    if not settings:
        RESULTS.write_text(
            json.dumps({"version": __version__, "seeds": given.seeds, "rows": rows}, indent=1) + "\n"
        )


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
