"""The forecast that docs/forecast.md shows: types its commands, keeps what the screen says in docs/plate_forecast.json. Some seconds."""

import json
import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from wearfem import __version__
from wearfem.errors import in_a_sentence

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "plate_forecast.json"
RUN = 'run cases/wearing_plate --set "stop=40*day" --quiet --out RUN'
FORECAST = 'forecast RUN --limit "11*mm" --next-stop "60*day"'
COSTS = (
    'forecast RUN --next-stop "60*day" --price 20000 --unplanned-price 50000 --hour-price 4000 --planned-hours 8 '
    "--unplanned-hours 30 --currency EUR"
)


def main() -> None:
    """Run, foretell, keep."""
    with tempfile.TemporaryDirectory() as folder:
        typed(RUN, folder)
        kept = {"version": __version__, "forecast": typed(FORECAST, folder), "costs": typed(COSTS, folder)}
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n")
    print(forecast(), costs(), sep="\n")


def typed(command: str, folder: str) -> list[str]:
    """What the screen says to a command"""
    words = [word.replace("RUN", f"{folder}/plate") for word in shlex.split(command)]
    done = subprocess.run(
        [sys.executable, "-m", "wearfem.cli", *words], cwd=ROOT, env=os.environ, capture_output=True, text=True, check=True
    )  # fmt: skip
    return done.stdout.splitlines()


def forecast() -> str:
    """The table down to the limit; as on the screen"""
    lines = json.loads(RESULTS.read_text())["forecast"]
    begin = next(number for number, line in enumerate(lines) if line.startswith("until 11 mm left"))
    return "\n".join(["```", *lines[begin : begin + 3], "```"])


def costs() -> str:
    """The costs; as on the screen"""
    lines = json.loads(RESULTS.read_text())["costs"]
    begin = next(number for number, line in enumerate(lines) if line.startswith("costs: "))
    return "\n".join(["```", *lines[begin:], "```"])


def closed_form() -> str:
    """The life of the plate in which 9 mm may go, r = r0 / (1 - g d): (D - g D^2 / 2) / r0"""
    depth, gradient, rate = 9e-3, 50.0, 1e-9
    return f"{(depth - 0.5 * gradient * depth**2) / rate / 86400.0:.1f} d"


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
