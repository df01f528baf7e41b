"""Readings, what the model lacks by them, and the error before and after: python cases/stream_on_plate/improved.py [DIR]

Types the commands below, some minutes, into a folder DIR (else one that is thrown away); what they print is kept in `improved.json`,
from which docs/print_pages.py takes it.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from wearfem import __version__
from wearfem.errors import in_a_sentence

CASE = Path(__file__).parent
RESULTS = CASE / "improved.json"
RUN = "run cases/stream_on_plate --set noise=0.05 --set tolerance=0.005 --set seed=42 --set stop=500*day --out {}/stream"
WHOLE = "run cases/stream_on_plate --set noise=0 --quiet --out {0}/{1} --json {0}/{1}.json"
IMPROVE = "improve cases/stream_on_plate/measured/survey.csv --run {0}/stream --out {0}/better"


def typed(command: str, *places: object) -> str:
    """What a command prints."""
    words = command.format(*places).split()
    done = subprocess.run(
        [sys.executable, "-m", "wearfem.cli", *words],
        cwd=CASE.parents[1],
        text=True,
        check=True,
        stdout=subprocess.PIPE,
    )
    return done.stdout


def whole(place: Path, name: str, other: str = "") -> list[dict[str, Any]]:
    """The figures of a life to its end."""
    typed(WHOLE + other, place, name)
    return json.loads((place / f"{name}.json").read_text())


def told(screen: str) -> list[str]:
    """The lines of `improve` after its runs: what the survey says, and the errors before and after."""
    lines = screen.splitlines()
    begin = max(number for number, line in enumerate(lines) if line.startswith("read "))
    return [line for line in lines[begin:] if not line.startswith("wrote ")]


def screen() -> list[str]:
    """What is shipped."""
    return json.loads(RESULTS.read_text())["screen"]


def shape() -> str:
    """What the change of shape does to a whole life; Markdown."""
    moving, frozen = (
        {row["name"]: row["value"] for row in rows} for rows in json.loads(RESULTS.read_text())["lives"]
    )
    lines = ["| | geometry moving | kept as new |", "|---|---|---|"]
    angles = (
        f"{one['flattest angle of impact']:.0f} to {one['steepest angle of impact']:.0f}"
        for one in (moving, frozen)
    )
    lines.append(f"| angle of impact at the end of life, without noise [degree] | {' | '.join(angles)} |")
    name = "rate there over that of the new plate"
    lines.append(
        f"| rate at the deepest place, end over beginning [-] | {moving[name]:.2f} | {frozen[name]:.2f} |"
    )
    return "\n".join(lines)


def suspect() -> str:
    """What the model lacks by the readings; as on the screen."""
    lines = screen()
    begin = next(number for number, line in enumerate(lines) if line.startswith("model as it is"))
    end = next(number for number, line in enumerate(lines) if line.startswith("added"))
    return "\n".join(["```", *lines[begin : end + 1], "```"])


def errors() -> str:
    """The error before and after; as on the screen."""
    lines = screen()
    begin = next(number for number, line in enumerate(lines) if line.startswith("error (root mean square)"))
    return "\n".join(["```", *lines[begin:], "```"])


def main() -> None:
    """Run both, keep what they say."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else Path(folder)
        typed(RUN, place)
        lines = [line.replace(str(place), "runs") for line in told(typed(IMPROVE, place))]
        lives = [whole(place, "moving"), whole(place, "frozen", " --set frozen=true")]
    kept = {"version": __version__, "lives": lives, "screen": lines}
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
