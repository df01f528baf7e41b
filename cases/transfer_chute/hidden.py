"""The loop closed on the chute: plants with something in them that the case does not have, found from their surveys and put into the case.

    python cases/transfer_chute/hidden.py [--only hardness_gradient-1 ...] [--out DIR]

Each plant is a run of its own, with another coefficient, another seed, and samples long enough that its readings carry next to no
sampling noise; it is read at 40 places on 8 occasions with a gauge of 0.1 mm, until 11 of 12 mm are gone. Then the case as it is known
is run and diagnosed, and what is found is put in, run and fitted again, as `wearfem improve` does. A plant takes some half an hour of
one core; what is there is gone on with. Results are kept in `hidden.json`; `--table` prints them and runs nothing.
"""

import argparse
import json
from pathlib import Path
from typing import Any

from wearfem.errors import UserError, in_a_sentence, in_words
from wearfem.improve import Improvement
from wearfem.proofs.closed_loop import CHUTE, closed
from wearfem.survey.diagnose import parameters_of
from wearfem.survey.words import parameter_in_words

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "hidden.json"
ERRORS = (
    "straight line",
    "coefficient alone",
    "diagnosed, not repeated",
    "in the loop",
    "run's own sampling",
)  # [mm]
PLANTS = (
    ("hardness_gradient", 1),
    ("case_hardened", 2),
    ("ore_change", 3),
    ("nothing", 4),
    ("case_hardened", 5),
    ("hardness_gradient", 6),
)


def row(done: Improvement, hidden: str, seed: int) -> dict[str, Any]:
    """What came out, errors in mm on readings never fitted"""
    found = done.diagnosis
    fitted = done.last.put_in.fitted
    at, told = 1, []
    for i, suspect in enumerate(fitted.suspects if fitted else ()):
        parameters = parameters_of(fitted, i, at)
        at += len(suspect.free)
        told.append(
            f"{suspect.name}: "
            + ", ".join(parameter_in_words(n, p, found.survey) for n, p in parameters.items() if p.interval)
        )
    return {
        "hidden": hidden,
        "seed": seed,
        "verdict": found.verdict,
        "named": [effect.name for effect in found.effects],
        "put in": [effect.name for effect in done.effects],
        "cannot be told from": sorted({other for effect in found.effects for other in effect.indistinguishable_from}),
        "run's own sampling": done.own_sampling,
        "straight line": found.straight_line.heldout_rmse,
        "as given": done.as_given.heldout_rmse,
        "coefficient alone": done.coefficient_alone.heldout_rmse,
        "diagnosed, not repeated": found.improved.heldout_rmse,
        "in the loop": done.improved.heldout_rmse,
        "readings": int(done.held.sum()),
        "factor": done.last.put_in.factor,
        "found": told,
        "agreed": done.agreed,
        "last change": done.last.change,
        "runs": 1 + len(done.rounds),
        "left": done.again and done.again.verdict,
    }  # fmt: skip


def read() -> list[dict[str, Any]]:
    """What is kept"""
    return json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else []


def table() -> str:
    """What came out so far, as Markdown"""
    names = "hidden", "seed", "verdict", *ERRORS, "found", "runs"
    lines = [f"| {' | '.join(names)} |", "|" + "---|" * len(names)]
    for one in read():
        errors = " | ".join(f"{one[name]:.3f}" for name in ERRORS)
        found = "; ".join([f"factor {one['factor']:.3f}", *one["found"]])
        name, verdict = one["hidden"].replace("_", " "), one["verdict"].replace("_", " ")
        lines.append(f"| {name} | {one['seed']} | {verdict} | {errors} | {found} | {one['runs']} |")
    return "\n".join(lines)


def plant(asked: str) -> tuple[str, int]:
    """What is hidden and the seed, from `hardness_gradient-1`"""
    hidden, _, seed = asked.rpartition("-")
    if hidden not in CHUTE.hidden or not seed.isdigit():
        raise UserError(
            f"--only was given {asked}: give one of {in_words(list(CHUTE.hidden), 'or')} with a seed, such as ore_change-3"
        )
    return hidden, int(seed)


def main() -> None:
    """Run what is missing, print what there is."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--only", nargs="*", metavar="NAME-SEED", help="plants, of those above or with other seeds"
    )
    parser.add_argument("--out", type=Path, default=Path("runs/hidden"), help="where the runs lie")
    parser.add_argument("--table", action="store_true", help="run nothing")
    given = parser.parse_args()
    rows = read()
    asked = [plant(one) for one in given.only] if given.only else PLANTS
    for hidden, seed in () if given.table else asked:
        done, _ = closed(given.out / f"{hidden}-{seed}", hidden, seed, again=True, site=CHUTE)
        rows = [one for one in rows if (one["hidden"], one["seed"]) != (hidden, seed)]
        rows = sorted([*rows, row(done, hidden, seed)], key=lambda one: one["seed"])
        RESULTS.write_text(json.dumps(rows, indent=1) + "\n")
    print(table())


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
