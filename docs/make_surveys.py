"""What a diagnosis says of the shipped surveys of real readings, as on the screen: python docs/make_surveys.py

Types the command of each README, some minutes each; what it prints is kept in `told.json` beside the README, from which
docs/print_pages.py takes it.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from wearfem import __version__
from wearfem.errors import in_a_sentence

ROOT = Path(__file__).parents[1]
SURVEYS = {
    "conveyor_belt": ("--progress", "cumulative_tonnage", "--limit", "24*mm"),
    "metal_sliding_wear": ("--limit", "90*um"),
}


def told(name: str) -> str:
    """What is shipped; as on the screen."""
    kept = json.loads((ROOT / "cases" / name / "told.json").read_text())
    return "\n".join(["```", *kept["screen"], "```"])


def conveyor_belt() -> str:
    return told("conveyor_belt")


def metal_sliding_wear() -> str:
    return told("metal_sliding_wear")


def belt_in_short() -> str:
    """What forecasts of the belt were worth, in a line"""
    tested = json.loads((ROOT / "cases" / "conveyor_belt" / "told.json").read_text())["back_test"]
    errors = [f"{model['name']} {model['rmse']:.2f} mm" for model in tested["models"]]
    return f"({', '.join(errors)}, over {len(tested['occasions'])} inspections)"


def main() -> None:
    for name, options in SURVEYS.items():
        with tempfile.TemporaryDirectory() as folder:
            words = ["diagnose", f"cases/{name}/measured/survey.csv", *options, "--out", folder]
            done = subprocess.run(
                [sys.executable, "-m", "wearfem.cli", *words],
                cwd=ROOT,
                text=True,
                check=True,
                stdout=subprocess.PIPE,
            )
            told = json.loads((Path(folder) / "forecast.json").read_text())
        lines = [line for line in done.stdout.splitlines() if not line.startswith("wrote ")]
        kept = {"version": __version__, "screen": lines, "back_test": told["back_test"]}
        (ROOT / "cases" / name / "told.json").write_text(json.dumps(kept, indent=1) + "\n")
        print(done.stdout, flush=True)


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
