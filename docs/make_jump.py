"""What jumps promise and cost, written to docs/jump.json, which the pages print, and drawn in docs/pictures/jump_cost.png. Some minutes.

python docs/make_jump.py [--first 6000] [--no-picture]

`--first` is the first of twenty seeds of the table: take one that nothing was developed on.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from wearfem import __version__
from wearfem.proofs import jump
from wearfem.proofs._plants import (
    alike,
    beyond_threshold,
    by_equal_jumps,
    by_jumps,
    by_multiplier,
    gradient,
    growing,
    layered,
    oscillating,
    seen_through_noise,
)

RESULTS = Path(__file__).parent / "jump.json"
BLUE, ORANGE, GREY, BLACK = "#1f5f99", "#c8641b", "#9a9a9a", "#222222"
SEEDS = 20


def main() -> None:
    """The table, then the picture."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--first", type=int, default=6000)
    parser.add_argument("--no-picture", action="store_true")
    wish = parser.parse_args()
    rows = [row(plant, wish.first) for plant in plants()]
    RESULTS.write_text(
        json.dumps({"wearfem": __version__, "first": wish.first, "rows": rows}, indent=1) + "\n"
    )
    print(f"wrote {RESULTS}\n{table()}\n{counts()}", flush=True)
    if not wish.no_picture:
        picture()


def plants() -> list[Any]:
    """Every plant with little and with much noise, two that nothing was developed on, and equal facets"""
    fresh = [
        seen_through_noise(make(), noise) for make in (beyond_threshold, oscillating) for noise in jump.NOISES
    ]
    return [*jump.noisy_plants(), *fresh, seen_through_noise(alike(), 0.2)]


def row(plant: Any, first: int) -> dict[str, Any]:
    """Twenty lives of a plant: promise, error and cost"""
    lives = [by_jumps(plant, plant.goal, seed) for seed in range(first, first + SEEDS)]
    true = np.array([lived.life / plant.life - 1.0 for lived in lives])
    told = np.array([lived.told.error() / plant.life for lived in lives if lived.told])
    smoothed = float(np.sqrt(np.square(plant.spread).sum(axis=1).mean())) if len(plant.spread) else 1.0
    found = {
        "plant": plant.name,
        "noise": round(plant.noise * smoothed, 3),
        "told_over_true": float(np.sqrt(np.mean(told**2) / np.mean(true**2))),
        "mean": float(true.mean()),
        "error": float(np.quantile(np.abs(true), 0.9)),
        "cost": float(np.mean([lived.cost for lived in lives]) / jump.floor(plant)),
        "warm_up": float(np.mean([lived.warm_up for lived in lives]) / jump.floor(plant)),
        "samples": float(np.mean([lived.cycles for lived in lives])),
        "rejected": float(np.mean([lived.rejected for lived in lives])),
    }
    print(found, flush=True)
    return found


def rows() -> list[dict[str, Any]]:
    """As written down"""
    return json.loads(RESULTS.read_text())["rows"]


def seeds() -> str:
    """In words"""
    first = json.loads(RESULTS.read_text())["first"]
    return f"seeds {first} to {first + SEEDS - 1}"


def table() -> str:
    """Markdown"""
    lines = [
        "| plant | noise | error told / true (rms) | mean error | 90 % within | cost / floor | of it warm-ups | samples | rejected |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {one['plant']} | {one['noise']:g} | {one['told_over_true']:.2f} | {one['mean']:+.2%} | {one['error']:.2%} | {one['cost']:.2f} "
        f"| {one['warm_up']:.2f} | {one['samples']:.1f} | {one['rejected']:.1f} |".replace("%", " %")
        for one in rows()
    ]
    return "\n".join(lines)


def counts() -> str:
    """How many rows keep what is asked; a sentence"""
    found = rows()
    bold = [one for one in found if not 0.5 < one["told_over_true"] < 2.0]
    dear = [one for one in found if one["cost"] >= 2.0]
    return (
        f"The promise is within a factor 2 of the true error in {len(found) - len(bold)} rows of {len(found)}"
        f"{_but(bold, 'told_over_true')}, "
        f"and the cost under twice the floor in {len(found) - len(dear)}{_but(dear, 'cost')}"
    )


def _but(missed: list[dict[str, Any]], name: str) -> str:
    """Which rows do not, in brackets"""
    words = ", ".join(f"{one['plant']} with noise {one['noise']:g}: {one[name]:.2f}" for one in missed)
    return f" (not {words})" if words else ""


def picture() -> None:
    """Error of the end of life over simulated seconds, for jumps and for constant multipliers."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    makers = (gradient, growing, layered)
    figure, panels = plt.subplots(1, 3, figsize=(13.2, 4.4), constrained_layout=True, sharey=True)
    for panel, make in zip(panels, makers, strict=True):
        draw(panel, seen_through_noise(make(), 0.3))
    panels[0].set_ylabel("error that 90 % of lives stay within [%]")
    panels[0].legend(frameon=False, fontsize=8)
    target = Path(__file__).parent / "pictures" / "jump_cost.png"
    figure.savefig(target, dpi=140)
    print(f"wrote {target}")


def draw(panel, plant) -> None:
    floor = jump.floor(plant)
    creeping = jump.sweep(plant, lambda m, s: by_multiplier(plant, m, s), jump.multipliers(plant), SEEDS)
    stepping = jump.sweep(
        plant, lambda m, s: by_equal_jumps(plant, m, floor / 8.0, s), jump.multipliers(plant), SEEDS
    )
    ours = []
    for tolerance in (0.06, 0.04, 0.02, 0.012):
        goal = replace(plant.goal, tolerance=tolerance)
        ours.append(jump.price([by_jumps(plant, goal, seed) for seed in range(SEEDS)], plant))
    for prices, colour, mark, name in (
        (creeping, GREY, "s-", "constant multiplier, geometry creeps"),
        (stepping, ORANGE, "^-", "constant multiplier, equal jumps"),
        (ours, BLUE, "o-", "wearfem, tolerance 6, 4, 2, 1.2 %"),
    ):
        panel.loglog(
            *np.array([(p.cost, 100.0 * p.error) for p in prices]).T,
            mark,
            color=colour,
            label=name,
            markersize=4,
        )
    panel.plot(ours[2].cost, 100.0 * ours[2].error, "o", color=BLUE, markersize=9)
    panel.axvline(floor, color=BLACK, linewidth=0.8, linestyle="--", label="statistical floor for 2 %")
    panel.axhline(2.0, color=BLACK, linewidth=0.8, linestyle=":")
    panel.set(title=f"{plant.name}, {SEEDS} lives a point", xlabel="simulated flow [s]")
    panel.spines[["top", "right"]].set_visible(False)
    print(
        plant.name,
        "floor",
        round(floor),
        [(round(p.cost), round(p.error, 4)) for p in (*creeping, *stepping, *ours)],
        flush=True,
    )


if __name__ == "__main__":
    main()
