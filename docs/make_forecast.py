"""How often forecasts hold: 336 lives whose end is known, written to docs/forecast.json, which the pages print. Some minutes.

python docs/make_forecast.py [--lives 336] [--first 90000]

`--first` is the first seed: take one that nothing was developed on. Kinds, noises and parts of the life at which it is foretold are those
of `wearfem.proofs.forecast`.
"""

import argparse
import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from wearfem import __version__
from wearfem.errors import in_a_sentence
from wearfem.proofs.forecast import KINDS, PARTS, Told, inside, told

RESULTS = Path(__file__).parent / "forecast.json"
WORDS = {
    "constant": ("constant", "the case"),
    "hardness_gradient": ("hardness gradient", "the case"),
    "running_in": ("running-in", "the case"),
    "unknown hardness": ("hardness gradient", "not the case"),
    "power": ("loads rise or fall by a power of depth", "the case"),
    "bulge": ("loads swell and shrink again", "the case"),
    "settling": ("loads settle", "the case"),
}
WAYS = {
    "middle": "middle of the draws",
    "straight_line": "straight line",
    "frozen": "frozen geometry",
    "last_rate": "last rate",
}


def main() -> None:
    """Follow the lives, foretell them, write down what was told."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--lives", type=int, default=336)
    parser.add_argument("--first", type=int, default=90000)
    wish = parser.parse_args()
    found = [asdict(one) for one in told(wish.lives, wish.first)]
    RESULTS.write_text(
        json.dumps({"wearfem": __version__, "first": wish.first, "told": found}, indent=0) + "\n"
    )
    print(f"wrote {RESULTS}\n{whole()}\n{kinds()}\n{errors()}")


def read() -> list[Told]:
    """What was told, of each life"""
    return [Told(**one) for one in json.loads(RESULTS.read_text())["told"]]


def share(found: list[Told]) -> str:
    """Of the truths inside, with one deviation of the count"""
    part = inside(found)
    return f"{100.0 * part:.0f} +- {100.0 * np.sqrt(part * (1.0 - part) / len(found)):.0f} %"


def whole() -> str:
    """All lives; a sentence"""
    found = read()
    rank = np.array([one.rank for one in found])
    first = json.loads(RESULTS.read_text())["first"]
    return (
        f"of {len(found)} lives (seeds {first} to {first + len(found) - 1}) {share(found)} end inside the 80 % interval, "
        f"{np.mean(rank <= 0.1):.0%} before it and {np.mean(rank >= 0.9):.0%} after".replace(
            "%", " %"
        ).replace("  %", " %")
    )


def sentence() -> str:
    """All lives, in plain words"""
    found = read()
    knows = [one for one in found if one.kind in ("constant", "hardness_gradient", "running_in")]
    other = [one for one in found if one not in knows]
    early, late = ([one for one in found if one.part == part] for part in PARTS)
    off = [[100.0 * np.sqrt(np.mean([(getattr(one, way) - 1.0) ** 2 for one in some])) for way in ("middle", "straight_line")]
           for some in (early, late)]  # fmt: skip
    return (
        f"Of {len(found)} synthetic lives {share(found)} ended in the 80 % interval: {share(knows)} where the case knows all that changes "
        f"the rate, {share(other)} where it does not. At {100.0 * PARTS[0]:.0f} % of a life the middle was off by {off[0][0]:.0f} % "
        f"(straight line {off[0][1]:.0f} %), at {100.0 * PARTS[1]:.0f} % by {off[1][0]:.0f} % (straight line {off[1][1]:.0f} %)"
    )


def kinds() -> str:
    """By kind, told early and late; a table"""
    early, late = (f"{100.0 * part:.0f} % of the life" for part in PARTS)
    lines = [
        f"| kind | the forecast knows | inside 80 % | told at {early} | told at {late} | middle beside the end |",
        "|---|---|---|---|---|---|",
    ]
    for kind in KINDS:
        some = [one for one in read() if one.kind == kind]
        parts = [share([one for one in some if one.part == part]) for part in PARTS]
        off = 100.0 * (np.array([one.middle for one in some]) - 1.0)
        mean = f"{off.mean():+.1f} +- {off.std() / np.sqrt(len(off)):.1f} %"
        lines.append(f"| {' | '.join([*WORDS[kind], share(some), *parts, mean])} |")
    return "\n".join(lines)


def errors() -> str:
    """Errors of the middle beside what planners use; a table"""
    lines = [f"| told at | {' | '.join(WAYS.values())} |", "|---" * (1 + len(WAYS)) + "|"]
    for part in PARTS:
        some = [one for one in read() if one.part == part]
        rms = [float(np.sqrt(np.mean([(getattr(one, way) - 1.0) ** 2 for one in some]))) for way in WAYS]
        lines.append(
            f"| {100.0 * part:.0f} % of the life | {' | '.join(f'{100.0 * one:.1f} %' for one in rms)} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
