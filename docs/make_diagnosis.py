"""Measure what a diagnosis is worth: python docs/make_diagnosis.py [PROCESSES [DESIGN ...]]

Makes the trials that docs/diagnosis_trials.csv lacks (all of them take hours of one core; a killed run goes on where it was), of the
designs named ("noise" "noise of neighbours") or of all, and draws docs/pictures/diagnosis_degrades.png. With 0 for PROCESSES nothing is
tried, and it is drawn from the trials that there are. Then `python docs/print_pages.py` puts the figures into the pages.
"""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.proofs import diagnosis
from wearfem.proofs._trials import NOISES, READINGS, Row, designs, measure, read
from wearfem.proofs.diagnosis import degraded, plants

DOCS = Path(__file__).parent
TRIALS = DOCS / "diagnosis_trials.csv"
GREEN, GREY, RED = "#2e7d4f", "#c9c9c9", "#b3352b"


def main() -> None:
    """Measure, draw, and say so."""
    processes = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    known = {design.name: design for design in designs()}
    asked = sys.argv[2:] or list(known)
    if missing := set(asked) - set(known):
        sys.exit(f"there is no design {', '.join(sorted(missing))}; there are {', '.join(known)}")
    if processes:
        for row in measure(TRIALS, [known[name] for name in asked], processes):
            print(
                row.design,
                row.trial.plant,
                row.trial.seed,
                row.trial.verdict,
                *row.trial.named,
                f"{row.seconds:.1f} s",
                flush=True,
            )
    draw()
    print("\n\n".join([confusion(), figures(), by_kind(), by_kind_again(), degrading()]))


# What the pages print, from what is stored.


def trials(design: str) -> list[Row]:
    """The trials of a design that there are"""
    return [row for row in read(TRIALS) if row.design == design]


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table in Markdown"""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def confusion() -> str:
    """The confusion matrix at 0.1 mm, 40 points and 8 occasions: what was planted, and what was said"""
    rows = diagnosis.confusion(
        [row.trial for row in sorted(trials("whole"), key=lambda row: plants().NAMES.index(row.trial.plant))]
    )
    return table(["planted", "right", "said, and how often"], rows)


def figures() -> str:
    """What is asked beside what was found"""
    apart = plants().SEPARABLE
    whole, hard, given = trials("whole"), trials("hard"), trials("given")
    shared = trials("noise of places and dates")
    looked = [row for row in read(TRIALS) if not row.design.startswith("given")]
    separable = [row for row in whole if row.trial.plant in apart]
    lines = [
        ("0.1 mm, 40 points, 8 occasions: the verdict that the plant deserves", "", share(whole, right)),
        ("of these the separable plants: right effect named", "95 %", share(separable, right)),
        ("error on held-out readings over the gauge's, the same", "1.15", spread(separable, "error_over_noise")),
        ("on those held-out readings that the fitted ones tell", "1.15", spread(separable, "decided_over_noise")),
        ("90 % intervals of parameters that hold the truth, right effects given", "85 to 95 %", held(given)),
        ("the same where the effects were looked for, all designs", "85 to 95 %", held(looked)),
        ("0.3 mm, 24 points, 5 occasions: named, or told with doubt", "80 %", share(hard, lambda r: right(r) or doubted(r))),
        ("of these another effect named as found", "", share(hard, wrong)),
        ("on held-out readings that the fitted ones tell, over the gauge's", "", spread(hard, "decided_over_noise")),
        ("pure noise, 0.1 mm, 40 x 8: anything physical named", "under 5 %", share(trials("noise"), named)),
        ("the same, places differ by 3 %, the book errs by 2 %, campaigns by 0.1 mm", "under 5 %", share(shared, named)),
        ("the same where neighbours err alike in a campaign (0.2 mm over 0.8 m)", "under 5 %", share(trials("noise of neighbours"), named)),
        ("the same where points are elsewhere than told (4 cm together, 1 cm each)", "under 5 %", share(trials("points elsewhere"), named)),
    ]  # fmt: skip
    return table(["what", "asked", "found"], [line for line in lines if line[2]])


def seeds() -> str:
    """Which plants were tried: design, how many diagnoses, least and largest seed, and the code that made them"""
    told: dict[str, list[Row]] = {}
    for row in read(TRIALS):
        told.setdefault(row.design, []).append(row)
    rows = [
        (
            name,
            len(own),
            f"{min(r.trial.seed for r in own)} to {max(r.trial.seed for r in own)}",
            ", ".join(sorted({r.code for r in own})),
        )
        for name, own in told.items()
    ]
    return table(["design", "diagnoses", "seeds", "hash of the code"], rows)


def by_kind(design: str = "given") -> str:
    """Intervals that hold the truth, parameter by parameter"""
    kinds: dict[str, list[bool]] = {}
    for row in trials(design):
        for name, inside in row.trial.covered:
            kinds.setdefault(name, []).append(inside)
    return table(
        ["parameter", "90 % intervals that hold the truth"],
        [(name, f"{sum(all_)} of {len(all_)} ({np.mean(all_):.0%})") for name, all_ in kinds.items()],
    )


def by_kind_again() -> str:
    """The same of those that stood out, on seeds that were drawn afterwards"""
    return by_kind("given again")


def degrading() -> str:
    """How naming degrades with noise and with fewer readings"""
    rows = []
    for name in [*(f"{noise:g} mm" for noise in NOISES), *(f"{p} x {o}" for p, o in READINGS[:-1])]:
        own = [row.trial for row in trials(name)]
        if own:
            found = degraded(own)
            counts = [round(len(own) * part) for part in (found.named, found.refused, found.wrong)]
            rows.append((f"{name}, 24 x 6" if name.endswith("mm") else f"0.1 mm, {name}", len(own), *counts))
    return table(
        ["design", "plants", "right effect named", "refused or called adequate", "another effect named"], rows
    )


def right(row: Row) -> bool:
    return row.trial.right


def named(row: Row) -> bool:
    return bool(row.trial.named)


def doubted(row: Row) -> bool:
    return row.trial.verdict in ("cannot_tell", "unexplained")


def wrong(row: Row) -> bool:
    return not row.trial.right and row.trial.verdict == "effect_found"


def share(rows: Sequence[Row], true: Callable[[Row], bool]) -> str:
    return f"{sum(map(true, rows))} of {len(rows)}" if rows else ""


def held(rows: Sequence[Row]) -> str:
    inside = [held for row in rows if row.trial.right for _, held in row.trial.covered]
    return f"{sum(inside)} of {len(inside)} ({np.mean(inside):.1%})" if inside else ""


def spread(rows: Sequence[Row], what: str) -> str:
    """Median and largest of a ratio, of those named rightly"""
    return spread_of([getattr(row.trial, what) for row in rows if row.trial.right], "{:.2f}")


def spread_of(values: Sequence[float], how: str) -> str:
    return f"median {how.format(np.median(values))}, largest {how.format(max(values))}" if values else ""


# The picture.


def draw() -> None:
    """What a diagnosis says as noise grows and readings get fewer"""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 2, figsize=(11.0, 4.0), constrained_layout=True, sharey=True)
    bars(panels[0], [f"{noise:g} mm" for noise in NOISES])
    bars(panels[1], [*(f"{p} x {o}" for p, o in READINGS[:-1]), "0.1 mm"], last="24 x 6")
    panels[0].set_xlabel("gauge error (24 points, 6 occasions; liners lose 5 to 25 mm)")
    panels[1].set_xlabel("points x occasions (gauge error 0.1 mm)")
    panels[0].set_ylabel("share of plants with one effect, or two [%]")
    handles, words = panels[0].get_legend_handles_labels()
    figure.legend(handles, words, frameon=False, loc="outside upper center", ncols=3)
    target = DOCS / "pictures" / "diagnosis_degrades.png"
    figure.savefig(target, dpi=140)
    print(f"wrote {target}")


def bars(panel: Any, names: list[str], last: str = "") -> None:
    own = {name: [row.trial for row in trials(name)] for name in names}
    found = [degraded(own[name]) for name in names if own[name]]
    bottom = [0.0] * len(found)
    for name, colour, words in (
        ("named", GREEN, "right effect named"),
        ("refused", GREY, "refused: cannot tell, unexplained, or called adequate"),
        ("wrong", RED, "another effect named"),
    ):
        height = [100.0 * getattr(one, name) for one in found]
        panel.bar(range(len(found)), height, bottom=bottom, color=colour, label=words, width=0.7)
        bottom = [b + h for b, h in zip(bottom, height, strict=True)]
    labels = [name for name in names if own[name]]
    panel.set_xticks(range(len(found)), [*labels[:-1], last or labels[-1]])
    panel.set_ylim(0.0, 100.0)
    panel.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main()
