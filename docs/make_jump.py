"""Draw docs/pictures/jump_cost.png: error of the end of life over simulated seconds, for jumps and for constant multipliers.

python docs/make_jump.py
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from wearfem.proofs import jump
from wearfem.proofs._plants import (
    by_equal_jumps,
    by_jumps,
    by_multiplier,
    gradient,
    growing,
    layered,
    seen_through_noise,
)

BLUE, ORANGE, GREY, BLACK = "#1f5f99", "#c8641b", "#9a9a9a", "#222222"
SEEDS = 20


def main() -> None:
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
