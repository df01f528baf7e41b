"""Draw docs/pictures/bionic_chute.png from what is shipped in cases/bionic_chute: trends.json, decay.json.

python docs/make_bionic.py
"""

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

HERE = Path(__file__).parent
CASE = HERE.parent / "cases" / "bionic_chute"
BLUE, ORANGE, GREY, BLACK = "#1f5f99", "#c8641b", "#9a9a9a", "#222222"


def script(name: str) -> ModuleType:
    """A script of the case's folder."""
    sys.path.insert(0, str(CASE))
    return import_module(name)


def main() -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(2, 3, figsize=(13.2, 7.6), constrained_layout=True)
    trends, decay = script("trends"), script("decay")
    runs = trends.read()
    for panel, name in zip(panels.ravel(), trends.LEVELS, strict=False):
        draw_trend(panel, trends, runs, name)
    panels[0, 0].legend(frameon=False, fontsize=8)
    found = decay.read()
    draw_decay(panels[1, 1], decay, found, decay.smooth_rate())
    draw_places(figure, panels[1, 2], found[0])
    target = HERE / "pictures" / "bionic_chute.png"
    figure.savefig(target, dpi=130)
    print(f"wrote {target}")


def draw_trend(panel, trends, runs, name: str) -> None:
    """Wear saved over one length of the convexes."""
    letter, levels, printed = trends.LEVELS[name]
    for span, colour, mark in (("upper half", BLUE, "o-"), ("zone 2", ORANGE, "s")):
        rows = [
            (level, 100.0 * one.mean, 100.0 * one.half)
            for level in levels
            if (one := trends.saved(runs, span, **{name: 1e-3 * level}))
        ]
        if rows:
            x, mean, half = np.array(rows).T
            label = "upper half of zone 2" if span == "upper half" else "whole of zone 2"
            panel.errorbar(x, mean, half, fmt=mark, color=colour, capsize=3, label=label)
    panel.plot(list(printed), list(printed.values()), "x", color=BLACK, label="printed, zone 2")
    words = {"a0": "radius along", "b0": "height", "c0": "spacing along", "d0": "spacing across"}[letter]
    panel.set(xlabel=f"{letter}, {words} [mm]", ylabel="wear saved [%]", ylim=(0, 100))


def draw_decay(panel, decay, found, smooth: float) -> None:
    """Wear saved and height of the convexes over throughput."""
    tonnage = np.array([1e-6 * one.throughput for one in found])
    saved = np.array([100.0 * (1.0 - one.rate / smooth) for one in found])
    half = np.array([100.0 * decay.WIDE * one.error / smooth for one in found])
    panel.errorbar(
        tonnage, saved, half, fmt="o-", color=BLUE, capsize=2, markersize=4, label="convexes wear away"
    )
    panel.axhline(saved[0], color=GREY, linestyle="--", label="kept as new")
    panel.set(xlabel="throughput [kt]", ylabel="wear saved, upper half of zone 2 [%]", ylim=(0, 100))
    panel.legend(frameon=False, fontsize=8, loc="lower left")
    other = panel.twinx()
    other.plot(tonnage, [1e3 * one.convex_height for one in found], color=ORANGE)
    other.set_ylabel("height of the convexes [mm]", color=ORANGE)
    other.set_ylim(0, None)


def draw_places(figure, panel, first) -> None:
    """Depth rate by place on a tile with a convex, of the first sample."""
    from wearfem.liner.convexes import Convex, Fineness, Pattern, tile_with, tile_without

    pattern, fineness = Pattern(Convex(3e-3, 2e-3, 2e-3), 40e-3, 30e-3), Fineness(8, 2, 1)
    tile = tile_with(pattern, fineness)
    others = tile_without(pattern, fineness).alike.max() + 1
    rate = np.array(first.by_place)[others + tile.alike]
    x, y = 1e3 * tile.node.T
    colours = panel.tripcolor(
        x, y, tile.triangle, facecolors=1e9 * rate, cmap="inferno_r", edgecolors="w", lw=0.3
    )
    panel.set(
        xlabel="along the flow [mm]",
        ylabel="across [mm]",
        aspect="equal",
        title="new convex, flow to the right",
    )
    figure.colorbar(colours, ax=panel, label="depth rate [nm/s]", shrink=0.8)


if __name__ == "__main__":
    main()
