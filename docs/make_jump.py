"""What jumps promise and cost, written to docs/jump.json, which the pages print, and drawn in docs/pictures/jump_cost.png. Ten minutes.

python docs/make_jump.py [--first 30000] [--lives 20] [--many 150]

`--first` is the first seed: take one that nothing was developed on. `--lives` of every row of the table, `--many` beside multipliers.
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from wearfem import __version__
from wearfem.proofs import jump
from wearfem.proofs._plants import (
    Plant,
    alike,
    beyond_threshold,
    by_jumps,
    gradient,
    growing,
    known,
    layered,
    nearly_alike,
    oscillating,
    seen_through_noise,
)

RESULTS = Path(__file__).parent / "jump.json"
PICTURE = Path(__file__).parent / "pictures" / "jump_cost.png"
BLUE, ORANGE, GREY, BLACK = "#1f5f99", "#c8641b", "#9a9a9a", "#222222"
PARTS = (0.1, 0.18, 0.32, *jump.NEAR, 2.5, 5.6, 10.0)  # of the multiplier that spends the floor: two decades
TOLERANCES = (0.06, 0.04, *jump.TOLERANCES)
SPREADS = (0.01, 0.02, 0.05)  # of the rates of facets that are nearly equal
MULTIPLIED = 2000  # lives: many at once cost nothing


def main() -> None:
    """The table, the costs beside multipliers, the picture."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--first", type=int, default=30000)
    parser.add_argument("--lives", type=int, default=20)
    parser.add_argument("--many", type=int, default=150)
    wish = parser.parse_args()
    found: dict[str, Any] = {"wearfem": __version__, **vars(wish)}
    few = range(wish.first, wish.first + wish.lives)
    found["rows"] = [row(plant, few) for plant in plants()] + [
        nearly_equal(spread, few) for spread in SPREADS
    ]
    found["beside"] = [beside(plant, range(wish.first, wish.first + wish.many)) for plant in compared()]
    RESULTS.write_text(json.dumps(found, indent=1) + "\n")
    print(f"wrote {RESULTS}\n{table()}\n{counts()}\n{multipliers()}", flush=True)
    picture()


def plants() -> list[Plant]:
    """Every plant with little and with much noise, two that nothing was developed on, and facets that are equal or nearly so"""
    fresh = [
        seen_through_noise(make(), noise) for make in (beyond_threshold, oscillating) for noise in jump.NOISES
    ]
    return [*jump.noisy_plants(), *fresh, seen_through_noise(alike(), 0.2)]


def compared() -> list[Plant]:
    """Those that multipliers are set beside: laws of the flow, and of a metal that the case and the multipliers know"""
    made = (gradient(), growing(), layered(), known(gradient()), known(layered()))
    return [seen_through_noise(plant, jump.NOISES[1]) for plant in made]


def row(plant: Plant, seeds: Sequence[int]) -> dict[str, Any]:
    """Lives of a plant: promise, error and cost"""
    return told_of(plant, [plant] * len(seeds), seeds)


def nearly_equal(spread: float, seeds: Sequence[int]) -> dict[str, Any]:
    """Lives of plates whose facets differ a little, each plate in its own way"""
    made = [seen_through_noise(nearly_alike(spread, seed), 0.2) for seed in seeds]
    return told_of(made[0], made, seeds)


def told_of(named: Plant, made: Sequence[Plant], seeds: Sequence[int]) -> dict[str, Any]:
    """One life of each plant, by its seed"""
    lives = [by_jumps(plant, plant.goal, seed) for plant, seed in zip(made, seeds, strict=True)]
    life, floor = (np.array([what(plant) for plant in made]) for what in (lambda one: one.life, jump.floor))
    true = np.array([lived.life for lived in lives]) / life - 1.0
    told = np.array([lived.told.error() for lived in lives if lived.told]) / life
    smoothed = float(np.sqrt(np.square(named.spread).sum(axis=1).mean())) if len(named.spread) else 1.0
    found = {
        "plant": named.name,
        "noise": round(named.noise * smoothed, 3),
        "told_over_true": float(np.sqrt(np.mean(told**2) / np.mean(true**2))),
        "mean": float(true.mean()),
        "error": float(np.quantile(np.abs(true), jump.CONFIDENCE)),
        "cost": float(np.mean([lived.cost for lived in lives] / floor)),
        "warm_up": float(np.mean([lived.warm_up for lived in lives] / floor)),
        "samples": float(np.mean([lived.cycles for lived in lives])),
        "rejected": float(np.mean([lived.rejected for lived in lives])),
    }
    print(found, flush=True)
    return found


def beside(plant: Plant, seeds: Sequence[int]) -> dict[str, Any]:
    """A plant by jumps and by constant multipliers: prices for the picture, and the comparison at 2 %"""
    ours = jump.by_tolerance(plant, TOLERANCES, seeds)
    ways = jump.by_multipliers(plant, PARTS, MULTIPLIED, seeds[0])
    near = [way.at([PARTS.index(part) for part in jump.NEAR]) for way in ways]
    tight = ours.at([TOLERANCES.index(tolerance) for tolerance in jump.TOLERANCES])
    told = jump.compare(plant, tight, near, jump.TOLERANCES.index(plant.goal.tolerance))
    found = {
        "plant": plant.name,
        "floor": jump.floor(plant),
        **asdict(told),
        "prices": {way.name: way.prices.tolist() for way in (ours, *ways)},
    }
    print({name: value for name, value in found.items() if name != "prices"}, flush=True)
    return found


def results() -> dict[str, Any]:
    """As written down"""
    return json.loads(RESULTS.read_text())


def seeds() -> str:
    """In words"""
    told = results()
    return f"{told['lives']} lives a row, seeds {told['first']} to {told['first'] + told['lives'] - 1}"


def table() -> str:
    """Markdown"""
    lines = [
        "| plant | noise | error told / true (rms) | mean error | 90 % within | cost / floor | of it warm-ups | samples | rejected |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {one['plant']} | {one['noise']:g} | {one['told_over_true']:.2f} | {one['mean']:+.2%} | {one['error']:.2%} | {one['cost']:.2f} "
        f"| {one['warm_up']:.2f} | {one['samples']:.1f} | {one['rejected']:.1f} |".replace("%", " %")
        for one in results()["rows"]
    ]
    return "\n".join(lines)


def counts() -> str:
    """How many rows keep what is asked; a sentence"""
    found = results()["rows"]
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


def multipliers() -> str:
    """Markdown"""
    lines = [
        "| plant, noise 0.3 | 90 % within | cost / floor | beside the best multiplier, as run | at the same error |",
        "|---|---|---|---|---|",
    ]
    for one in results()["beside"]:
        error, *ratios = (one[name] for name in ("error", "over_floor", "as_run", "same_error"))
        within = f"{error[0]:.2%} +- {error[1]:.2%}".replace("%", " %")
        lines.append(
            f"| {one['plant']} | {within} | " + " | ".join(f"{a:.2f} +- {b:.2f}" for a, b in ratios) + " |"
        )
    return "\n".join(lines)


def many() -> str:
    """In words"""
    told = results()
    return f"{told['many']} lives a tolerance, seeds {told['first']} to {told['first'] + told['many'] - 1}"


def picture() -> None:
    """Error of the end of life over simulated seconds, for jumps and for constant multipliers."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    told = results()
    figure, panels = plt.subplots(2, 3, figsize=(13.2, 8.4), constrained_layout=True, sharey=True)
    for panel, one in zip(panels.flat, told["beside"], strict=False):
        draw(panel, one, told["many"])
    for panel in panels[:, 0]:
        panel.set_ylabel("error that 90 % of lives stay within [%]")
    panels[1, 2].axis("off")
    panels[1, 2].legend(*panels[0, 0].get_legend_handles_labels(), frameon=False, loc="center")
    figure.savefig(PICTURE, dpi=140)
    print(f"wrote {PICTURE}")


def draw(panel: Any, one: dict[str, Any], lives: int) -> None:
    """One plant"""
    marks = (
        ("creeping", GREY, "s-", f"constant multiplier, geometry creeps ({MULTIPLIED} lives a point)"),
        ("equal jumps", ORANGE, "^-", f"constant multiplier, equal jumps ({MULTIPLIED} lives a point)"),
        (
            "wearfem",
            BLUE,
            "o-",
            f"wearfem, tolerance {', '.join(f'{100 * t:g}' for t in TOLERANCES)} % ({lives} lives a point)",
        ),
    )
    for name, colour, mark, words in marks:
        cost, error = np.array(one["prices"][name]).T
        panel.loglog(cost, 100.0 * error, mark, color=colour, label=words, markersize=4)
    cost, error = one["prices"]["wearfem"][TOLERANCES.index(0.02)]
    panel.plot(cost, 100.0 * error, "o", color=BLUE, markersize=9)
    panel.axvline(one["floor"], color=BLACK, linewidth=0.8, linestyle="--", label="statistical floor for 2 %")
    panel.axhline(2.0, color=BLACK, linewidth=0.8, linestyle=":")
    panel.set(title=one["plant"], xlabel="simulated flow [s]")
    panel.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main()
