"""What each shortcut of the default does to the stream and its wear: the new chute, one keyword changed a row.

    python cases/transfer_chute/shortcuts.py [--only NAME ...]
    python cases/transfer_chute/shortcuts.py --worn RUN

Every row lets the ore run for 0.6 s, then samples a steady stream, and tells rates of wear by zone, friction, speeds and the closed form at
these, each with its standard error over blocks of 50 ms. All rows together take half an hour of one core. Rows are kept in
`shortcuts.json`; those that it holds are not run again unless they are named. `--worn` tells of the stream over the chute at the end of a
run's life, beside that over the new one with the same keywords.
"""

import argparse
import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wearfem import __version__
from wearfem.case import LifeCase, load_any_case, parts_of
from wearfem.dem.flow import Flow
from wearfem.errors import in_a_sentence
from wearfem.history import read_history
from wearfem.liner.liner import Liner
from wearfem.proofs.transfer_chute import watched
from wearfem.record import whole_file

CASE = Path(__file__).parent
RESULTS = CASE / "shortcuts.json"
STEADY = 0.6  # [s] after which the stream is steady

BASE = {"coarsening": 2.0, "slice_width": 0.07}
FINE = {"coarsening": 1.0, "slice_width": 0.035}
STIFF = {"shear_modulus": 65e9, "time_step_share": 0.8}
ROWS: dict[str, tuple[Mapping[str, Any], float]] = {  # keywords, seconds of steady stream
    "ore of 24 mm": ({"coarsening": 3.0, "slice_width": 0.105}, 1.0),
    "ore of 20 mm, the default": ({}, 1.0),
    "ore of 16 mm": (BASE, 1.0),
    "ore of 12 mm": ({"coarsening": 1.5, "slice_width": 0.0525}, 1.0),
    "ore of 8 mm, as printed": (FINE, 1.0),
    "8 mm and 65 GPa, the published slice": (FINE | STIFF, 0.4),
    "16 mm, modulus 16 MPa": (BASE | {"shear_modulus": 16.25e6}, 1.0),
    "16 mm, modulus 650 MPa": (BASE | {"shear_modulus": 650e6}, 1.0),
    "16 mm, modulus 65 GPa": (BASE | STIFF, 0.6),
    "16 mm, time step halved": (BASE | {"time_step_share": 0.125}, 1.0),
    "16 mm, slice twice as wide": (BASE | {"slice_width": 0.14}, 1.0),
    "16 mm, mesh 5 mm": (BASE | {"mesh_size": 5e-3}, 1.0),
    "16 mm, other seed": (BASE | {"seed": 2}, 1.0),
    "16 mm, balls cannot roll": (BASE | {"rolling_friction": 1.0}, 1.0),
    "8 mm, balls cannot roll": (FINE | {"rolling_friction": 1.0}, 0.5),
    "16 mm, the whole chute with its sides": (BASE | {"slice_width": 0.0, "mesh_size": 20e-3}, 0.5),
}
NEW, WORN = "new", "worn"  # rows of the chute at the end of a life
WEAR = tuple(f"zone {zone} [1e-10 m3/s]" for zone in (1, 2, 3))
OVER, SLIP = "zone 2 over closed form [-]", "sliding over stream speed [-]"
PRESSED, ENTRY = "normal force over closed form [-]", "entry speed [m/s]"
EXIT = "exit speed over closed form [-]"


def told(
    settings: Mapping[str, Any], seconds: float, liner: Liner | None = None, start: Flow | None = None
) -> dict[str, Any]:
    """What a stream tells with these keywords [SI]: numbers with their standard errors, by name.

    It runs over the new chute from an empty one, or over `liner` from the flow `start`.
    """
    case = load_any_case(CASE, settings)
    assert isinstance(case, LifeCase)
    begun = time.process_time()
    seen = watched(case, seconds, STEADY, liner, start)
    passage, closed = seen.passage, seen.theory
    told = {
        **{f"zone {zone} [1e-10 m3/s]": (one, 1e10) for zone, one in enumerate(seen.wear, 1)},
        "zone 2, closed form [1e-10 m3/s]": (closed.wear, 1e10),
        OVER: (seen.wear[1].over(closed.wear), 1.0),
        SLIP: (passage.slip, 1.0),
        PRESSED: (passage.normal_force.over(closed.normal_force), 1.0),
        EXIT: (passage.exit_speed.over(closed.exit_speed), 1.0),
        "mu_e [-]": (passage.friction, 1.0),
        ENTRY: (passage.entry_speed, 1.0),
    }
    return {
        "settings": dict(settings),
        "seconds": seconds,
        "figures": {name: (factor * one.value, factor * one.error) for name, (one, factor) in told.items()},
        "particles": seen.flow.particles.count,
        "time step [s]": seen.time_step,
        "centre of the stream [mm]": 1e3 * passage.centre,
        "core time [s]": time.process_time() - begun,
        "source": f"wearfem {__version__}",
    }


def read() -> dict[str, Any]:
    """What is shipped."""
    return json.loads(RESULTS.read_text()) if RESULTS.exists() else {}


def keep(rows: Mapping[str, Any]) -> None:
    """Write rows down beside those that are there."""
    with whole_file(RESULTS) as beside:
        beside.write_text(json.dumps(read() | rows, indent=1) + "\n")


def table() -> str:
    """Rates and speeds on the new chute, row by row; Markdown."""
    lines = [
        "| | zone 1 | zone 2 | zone 3 | zone 2 over closed form | sliding over stream speed | core time |",
        "|---|---|---|---|---|---|---|",
        "| | 1e-10 m3/s | 1e-10 m3/s | 1e-10 m3/s | - | - | s |",
    ]
    rows = read()
    for name in ROWS:
        if name in rows:
            cells = [_told(rows[name], figure) for figure in (*WEAR, OVER, SLIP)]
            lines.append(f"| {' | '.join([name, *cells])} | {rows[name]['core time [s]']:.0f} |")
    return "\n".join(lines)


def _told(row: Mapping[str, Any], figure: str) -> str:
    value, error = row["figures"][figure]
    return f"{value:.3f} +- {error:.3f}"


def times_slip() -> str:
    """How nearly the closed form, times the ratio of sliding to stream speed, is met; words."""
    off = {
        name: 100.0 * abs(row["figures"][OVER][0] / row["figures"][SLIP][0] - 1.0)
        for name, row in read().items()
        if name in ROWS
    }
    sides = off.pop("16 mm, the whole chute with its sides")
    return (
        f"within {max(off.values()):.1f} % in every row of a slice, {off['8 mm and 65 GPa, the published slice']:.1f} % in the published "
        f"one; between sides within {sides:.1f} %"
    )


def costs() -> str:
    """What the size of the ore costs; words."""
    rows = read()
    fine, coarse = (
        rows[name]["figures"]
        for name in ("8 mm and 65 GPa, the published slice", "ore of 20 mm, the default")
    )
    change = [100.0 * (coarse[zone][0] / fine[zone][0] - 1.0) for zone in WEAR]
    return ", ".join(
        f"{abs(one):.0f} % {'more' if one > 0.0 else 'less'} wear in zone {zone}"
        for zone, one in enumerate(change, 1)
    )


def beside_the_paper() -> str:
    """Rates of the zones as printed, in the published slice and by default; Markdown."""
    rows, printed = read(), parts_of(CASE).PUBLISHED
    lines = ["| zone | published DEM | published slice here | default here |", "|---|---|---|---|"]
    for zone, (name, rate) in enumerate(zip(WEAR, printed, strict=True), 1):
        ours = (
            rows[row]["figures"][name][0]
            for row in ("8 mm and 65 GPa, the published slice", "ore of 20 mm, the default")
        )
        lines.append(
            f"| {zone} | {1e10 * rate:.2f}e-10 m3/s | {' | '.join(f'{one:.3f}e-10' for one in ours)} |"
        )
    return "\n".join(lines)


def published_slice() -> str:
    """Zone 2 over the closed form"""
    return _told(read()["8 mm and 65 GPa, the published slice"], OVER)


def cannot_roll() -> str:
    """The same for balls that cannot roll"""
    rows = read()
    return f"{_told(rows['8 mm, balls cannot roll'], OVER)} with ore of 8 mm, {_told(rows['16 mm, balls cannot roll'], OVER)} with 16 mm"


def worn() -> str:
    """The stream over a worn chute beside that over the new one; Markdown."""
    rows = read()
    lines = ["| | new chute | worn chute |", "|---|---|---|"]
    for figure, words in (
        (ENTRY, "speed on entering zone 2 [m/s]"),
        (PRESSED, "normal force on zone 2, over the closed form's at the same entry speed [-]"),
        *((name, f"wear of {name}") for name in WEAR),
    ):
        lines.append(f"| {words} | {_told(rows[NEW], figure)} | {_told(rows[WORN], figure)} |")
    return "\n".join(lines)


def worn_zones() -> str:
    """By how much zone 1 wears more and zone 2 less at the end of a life; words."""
    rows = read()
    one, two = (
        100.0 * (rows[WORN]["figures"][zone][0] / rows[NEW]["figures"][zone][0] - 1.0) for zone in WEAR[:2]
    )
    return f"wears {one:.0f} % more than when new, the arc {-two:.0f} % less"


def main() -> None:
    """Run what is missing, keep it, print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=ROWS, metavar="NAME", help=f"of: {', '.join(ROWS)}")
    parser.add_argument("--worn", type=Path, metavar="RUN", help="a run folder of this case")
    given = parser.parse_args()
    if given.worn:
        state = read_history(given.worn).state
        settings = json.loads((given.worn / "manifest.json").read_text())["settings"]
        keep({NEW: told(settings, 1.0), WORN: told(settings, 1.0, state.now.liner, state.flow)})
        print(worn())
        return
    for name in given.only or [name for name in ROWS if name not in read()]:
        keep({name: told(*ROWS[name])})
        print(f"{name}: done", flush=True)
    print(table())


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
