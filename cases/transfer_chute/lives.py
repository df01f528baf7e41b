"""Whole lives of the chute with and without its change of shape: python cases/transfer_chute/lives.py RUNS [--only NAME ...]

Each life is run into RUNS/NAME unless it is there already (a stopped one goes on: `wearfem resume RUNS/NAME`), some minutes each. What
the pages say of them is kept in `lives.json` with the version that measured it; docs/print_pages.py puts it there.
"""

import argparse
import json
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import asdict, dataclass, replace
from io import StringIO
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.case import load_any_case, parts_of
from wearfem.errors import in_a_sentence
from wearfem.foretell import Asked, forecast_run
from wearfem.history import read_history
from wearfem.life import line
from wearfem.liner.chute import facet_angle
from wearfem.liner.liner import wear_surface
from wearfem.run import run_case
from wearfem.units import day, kilotonne, mm

CASE = Path(__file__).parent
RESULTS = CASE / "lives.json"
FROZEN = {"frozen": True, "tolerance": 0.025}  # costs little, since nothing bounds the jumps
ORE_16 = {"coarsening": 2.0, "slice_width": 70 * mm, "window": 0.5}
SHARP = {"smoothing_length": 10 * mm}
LIVES: dict[str, Mapping[str, Any]] = {
    "default": {},
    "default, frozen": FROZEN,
    "seed 2": {"seed": 2},
    "seed 2, frozen": {"seed": 2, **FROZEN},
    "ore of 16 mm": ORE_16,
    "ore of 16 mm, frozen": ORE_16 | FROZEN,
    "10 mm of smoothing": SHARP,
    "10 mm of smoothing, frozen": SHARP | FROZEN | {"tolerance": 0.04},
    "until 45 d": {"stop": 45 * day},
}


@dataclass(frozen=True)
class Told:
    """What is kept of a life."""

    settings: dict[str, Any]
    life: float  # [d]
    half: float  # [d] of its 90 % interval
    commit: str  # of wearfem
    straight: float = nan  # [d] had the new chute's rate stayed
    ore: float = nan  # [kt]
    angle: float = nan  # [degree] that is worn out first
    arc_deepest: float = nan  # [mm] lost by zone 2 at the end of life
    cycles: int = 0
    flow: float = nan  # [s] sampled
    lines: tuple[str, ...] = ()  # as printed: first cycle, last two, and how it ended
    foretold: tuple[
        str, ...
    ] = ()  # by `wearfem forecast RUN --next-stop "60*day"`, until the depth that the case allows


def told(run: Path, settings: Mapping[str, Any]) -> Told:
    """What a run folder tells."""
    manifest = json.loads((run / "manifest.json").read_text())
    case, history = load_any_case(CASE, settings), read_history(run)
    angle = np.degrees(facet_angle(wear_surface(history.state.now.liner)))
    low, high = np.degrees(parts_of(CASE).ZONE_2)
    zone_2 = (angle > low) & (angle < high)
    *reports, end = history.reports
    going = replace(history.state, ended="")
    first, *_, before = (line(report, case, 0.0, going, resumed=1) for report in reports)
    last = line(end, case, 0.0, history.state)
    return Told(
        settings=dict(settings),
        life=history.life[-1].time / day,
        half=history.reports[-1].end_error(case.goal.deviations) / day,
        straight=float((history.allowed_depth / history.rate[0]).min()) / day,
        ore=history.life[-1].time * case.throughput_rate / kilotonne,
        angle=float(angle[history.life[-1].facet]),
        arc_deepest=1e3 * float(history.depth[-1][zone_2].max()),
        cycles=len(history.reports),
        flow=history.simulated,
        lines=(first, before, last, f"ended: {history.ended}"),
        commit=manifest["git_commit"],
        foretold=foretold(run) if history.ended == "service time" else (),
    )


def foretold(run: Path) -> tuple[str, ...]:
    """The first part of what a forecast prints."""
    with redirect_stdout(StringIO()) as screen:
        forecast_run(run, Asked(next_stop="60*day"))
    lines = screen.getvalue().splitlines()
    begin = next(number for number, text in enumerate(lines) if text.startswith("until "))
    return tuple(lines[begin : lines.index("", begin)])


def read() -> dict[str, Told]:
    """What is shipped."""
    return {name: Told(**row) for name, row in json.loads(RESULTS.read_text()).items()}


def table() -> str:
    """Lives with and without the change of shape; Markdown."""
    lines = ["| | shape changes | shape stays as new | difference |", "|---|---|---|---|"]
    done = read()
    for name in LIVES:
        if name in done and f"{name}, frozen" in done:
            one, other = done[name], done[f"{name}, frozen"]
            both = float(np.hypot(one.half, other.half))
            apart = other.life - one.life
            within = "" if apart > both else ": within its interval"
            lines.append(f"| {name} | {_days(one)} | {_days(other)} | {apart:.1f} +- {both:.1f} d{within} |")
    return "\n".join(lines)


def shortens() -> str:
    """By how much the change of shape shortens lives, and how often beyond the interval; words."""
    done = read()
    pairs = [(done[name], done[f"{name}, frozen"]) for name in LIVES if f"{name}, frozen" in done]
    apart = [100.0 * (1.0 - one.life / other.life) for one, other in pairs]
    beyond = sum(other.life - one.life > np.hypot(one.half, other.half) for one, other in pairs)
    return f"by {min(apart):.0f} to {max(apart):.0f} %, by more than the interval of the difference in {beyond} pairs of {len(pairs)}"


def sharp() -> str:
    """With 10 mm of smoothing"""
    return _days(read()["10 mm of smoothing"])


def _days(one: Told) -> str:
    return f"{one.life:.1f} +- {one.half:.1f} d"


def life() -> str:
    """Of the default."""
    return _days(read()["default"])


def ends() -> str:
    """How the default's life ends; words."""
    one = read()["default"]
    return f"**{_days(one)}** (90 %), {one.ore:.0f} kt, at {one.angle:.0f} degrees; {one.cycles} cycles, {one.flow:.1f} s of flow"


def ahead() -> str:
    """What a forecast at 45 d says; as on the screen."""
    return "\n".join(["```", *read()["until 45 d"].foretold, "```"])


def screen() -> str:
    """What the default prints, shortened."""
    first, *rest = read()["default"].lines
    return "\n".join(["```", first, "...", *rest, "```"])


def findings() -> str:
    """What the default tells a plant engineer; Markdown."""
    one, frozen = read()["default"], read()["default, frozen"]
    return "\n".join(
        [
            f"- **{one.life:.1f} days, {one.ore:.0f} kt** of ore, within {one.half:.1f} days (90 %). A straight line from the new",
            f"  chute says {one.straight:.1f} days, and a shape that stays as new {_days(frozen)}: the chute wears faster as it wears.",
            f"- **Where**: at {one.angle:.0f} degrees, where the ore falls on. The arc below has lost up to",
            f"  {one.arc_deepest:.1f} mm by then.",
        ]
    )


def main() -> None:
    """Run what is missing, keep what is told, print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", type=Path, metavar="RUNS")
    parser.add_argument(
        "--only",
        nargs="+",
        choices=LIVES,
        default=list(LIVES),
        metavar="NAME",
        help=f"of: {', '.join(LIVES)}",
    )
    given = parser.parse_args()
    done = {name: asdict(one) for name, one in read().items()} if RESULTS.exists() else {}
    for name in given.only:
        run = given.runs / name.replace(",", "").replace(" ", "_")
        if not (run / "figures.json").exists():
            run_case(CASE, LIVES[name], run, quiet=True)
        done[name] = asdict(told(run, LIVES[name]))
        RESULTS.write_text(json.dumps({name: done[name] for name in LIVES if name in done}, indent=1) + "\n")
    print(table())


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
