"""What each shortcut of the default does to the stream and its wear: the new chute, one keyword changed a row.

    python cases/transfer_chute/shortcuts.py [--only NAME ...] [--seconds 2] [--json FILE]

Rows after the sizes of ore change one keyword of `ore 16 mm`.

Every row lets the ore run for 0.6 s, then samples a steady stream, and tells rates of wear by zone, friction, speeds and the closed form
at these, each with its standard error over blocks of 50 ms. All rows together take half an hour of one core; `published slice` alone
takes six minutes of it and more.

    python cases/transfer_chute/shortcuts.py --worn RUN

tells of the stream over the chute at the end of a run's life, beside that over the new one with the same keywords.

With `--json` each row is written when it is done, and those that the file holds already are not run again.
"""

import argparse
import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wearfem.case import LifeCase, load_any_case
from wearfem.dem.flow import Flow
from wearfem.history import read_history
from wearfem.liner.liner import Liner
from wearfem.proofs.transfer_chute import watched

CASE = Path(__file__).parent
STEADY = 0.6  # [s] after which the stream is steady

BASE = {"coarsening": 2.0, "slice_width": 0.07}
FINE = {"coarsening": 1.0, "slice_width": 0.035}
ROWS: dict[str, Mapping[str, Any]] = {
    "default, ore 20 mm": {},
    "ore 24 mm": {"coarsening": 3.0, "slice_width": 0.105},
    "ore 16 mm": BASE,
    "ore 12 mm": {"coarsening": 1.5, "slice_width": 0.0525},
    "ore 8 mm": FINE,
    "modulus 16 MPa": BASE | {"shear_modulus": 16.25e6},
    "modulus 650 MPa": BASE | {"shear_modulus": 650e6},
    "modulus 65 GPa": BASE | {"shear_modulus": 65e9, "time_step_share": 0.8},
    "time step halved": BASE | {"time_step_share": 0.125},
    "slice twice as wide": BASE | {"slice_width": 0.14},
    "whole chute with its sides": BASE | {"slice_width": 0.0, "mesh_size": 20e-3},
    "mesh 5 mm": BASE | {"mesh_size": 5e-3},
    "other seed": BASE | {"seed": 2},
    "without rolling": BASE | {"rolling_friction": 1.0},
    "ore 8 mm without rolling": FINE | {"rolling_friction": 1.0},
    "published slice": FINE | {"shear_modulus": 65e9, "time_step_share": 0.8},
}  # fmt: skip


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
        "zone 2 over closed form [-]": (seen.wear[1].over(closed.wear), 1.0),
        "sliding over stream speed [-]": (passage.slip, 1.0),
        "normal force over closed form [-]": (passage.normal_force.over(closed.normal_force), 1.0),
        "exit speed over closed form [-]": (passage.exit_speed.over(closed.exit_speed), 1.0),
        "mu_e [-]": (passage.friction, 1.0),
        "entry speed [m/s]": (passage.entry_speed, 1.0),
    }
    return {
        "settings": dict(settings),
        "seconds": seconds,
        "figures": {name: (factor * one.value, factor * one.error) for name, (one, factor) in told.items()},
        "particles": seen.flow.particles.count,
        "time step [s]": seen.time_step,
        "centre of the stream [mm]": 1e3 * passage.centre,
        "core time [s]": time.process_time() - begun,
    }


def line(name: str, row: Mapping[str, Any]) -> str:
    """A row as text."""
    numbers = " ".join(f"{value:7.4f} +- {error:6.4f} " for value, error in row["figures"].values())
    return (
        f"{name:<20}{row['particles']:>7}{row['time step [s]']:>10.2e} {numbers}{row['core time [s]']:>8.0f}"
    )


def main() -> None:
    """Run the rows and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--only", nargs="+", choices=ROWS, default=list(ROWS), metavar="NAME", help=f"of: {', '.join(ROWS)}"
    )
    parser.add_argument("--seconds", type=float, default=2.0, help="of steady stream")
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--worn", type=Path, metavar="RUN", help="a run folder of this case")
    given = parser.parse_args()
    if given.worn:
        state = read_history(given.worn).state
        settings = json.loads((given.worn / "manifest.json").read_text())["settings"]
        rows = {
            "new": told(settings, given.seconds),
            "worn": told(settings, given.seconds, state.now.liner, state.flow),
        }
        print("row, particles, time step [s], " + ", ".join(rows["new"]["figures"]) + ", core time [s]")
        for name, row in rows.items():
            print(line(name, row), flush=True)
        return
    done = json.loads(given.json.read_text()) if given.json and given.json.exists() else {}
    for name in given.only:
        if name not in done:
            done[name] = told(ROWS[name], given.seconds)
            if given.json:
                given.json.write_text(json.dumps(done, indent=1))
        if name == given.only[0]:
            print("row, particles, time step [s], " + ", ".join(done[name]["figures"]) + ", core time [s]")
        print(line(name, done[name]), flush=True)


if __name__ == "__main__":
    main()
