"""How often forecasts of a plate under real particles hold: 20 lives, written to docs/particle_lives.json, which the pages print.

python docs/make_particle_lives.py [--lives 20] [--first 9001]

The plate is small (`wearfem.proofs._balls`) and foretold at 30 d of some 70. Where it ends is told by brute force, 24 equal steps with
2 s of flow each, without jumps and forecasts, on three seeds before the first: their mean is taken for the truth, their spread is told.
Some 25 minutes of one core; what is done is kept, and gone on with.
"""

import argparse
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from wearfem import __version__
from wearfem.errors import in_a_sentence
from wearfem.proofs.forecast import UnderParticles, ends_under_particles, under_particles
from wearfem.units import day

RESULTS = Path(__file__).parent / "particle_lives.json"
BRUTE = 3  # lives by brute force


def main() -> None:
    """Follow the lives, foretell them, write down what was told."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--lives", type=int, default=20)
    parser.add_argument("--first", type=int, default=9001, help="seed")
    parser.add_argument("--anew", action="store_true", help="forget what is there")
    wish = parser.parse_args()
    kept: dict[str, Any] = {"version": __version__, "first": wish.first, "ends": [], "lives": []}
    if RESULTS.exists() and not wish.anew:
        before = json.loads(RESULTS.read_text())
        kept = before if (before["version"], before["first"]) == (__version__, wish.first) else kept
    for seed in range(wish.first - BRUTE + len(kept["ends"]), wish.first):
        kept["ends"] += ends_under_particles([seed])
        _keep(kept)
        print(f"brute force, seed {seed}: {kept['ends'][-1] / day:.2f} d", flush=True)
    for seed in range(wish.first + len(kept["lives"]), wish.first + wish.lives):
        kept["lives"].append(asdict(under_particles(seed, float(np.mean(kept["ends"])))))
        _keep(kept)
        told = ", ".join(f"{time / day:.2f}" for time in kept["lives"][-1]["quantile"])
        print(f"seed {seed}: {told} d", flush=True)
    print(count())


def _keep(kept: Mapping[str, Any]) -> None:
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n")


def count() -> str:
    """How many hold, and how far off the middles are; words"""
    kept = json.loads(RESULTS.read_text())
    lives = [UnderParticles(**one) for one in kept["lives"]]
    ends, middle = np.array(kept["ends"]) / day, np.array([one.quantile[1] for one in lives]) / day
    within = sum(0.1 < one.rank < 0.9 for one in lives)
    off, error = middle / ends.mean() - 1.0, middle.std(ddof=1) / np.sqrt(len(middle)) / ends.mean()
    return (
        f"{within} of {len(lives)} lives (seeds {lives[0].seed} to {lives[-1].seed}) have the end by brute force, {ends.mean():.1f} d "
        f"({', '.join(f'{end:.1f}' for end in ends)} on {len(ends)} seeds), in the 80 % interval; their middles are {middle.mean():.1f} d "
        f"in the mean, {100.0 * off.mean():+.1f} +- {100.0 * error:.1f} % beside it"
    )


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
