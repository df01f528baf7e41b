"""Draw docs/pictures/story.png: a plate foretold before and after a diagnosis, with the truth, and what earlier forecasts were worth.

python docs/make_story.py
"""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt

from wearfem.errors import in_a_sentence
from wearfem.proofs.survey_life import ENDS, LATER, READ, plants, surveyed
from wearfem.survey.backtest import NAMES, back_test
from wearfem.survey.diagnose import diagnose
from wearfem.survey.forecast import SHARE, forecast

PICTURE = Path(__file__).parent / "pictures" / "story.png"
COLOURS = ("#8a949e", "#c8641b", "#0b5c8a")


def main() -> None:
    """The deepest place on the left, the back-test on the right."""
    plant = plants().plant("hardness_gradient", 2, occasions=LATER, points=24)
    survey = surveyed(plant, READ)
    found = diagnose(survey, name_without=False)
    deepest = int(plant.clean[:, ENDS - 1].argmax())
    limit = float(plant.clean[deepest, ENDS - 1])
    ahead = forecast(found.choice, 1e-3 * limit)
    shown = ahead.progress <= 1.6 * ahead.now
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11, 4.2), layout="constrained", width_ratios=(1.5, 1.0)
    )
    for outlook, colour in zip(ahead.outlooks, COLOURS, strict=True):
        low, middle, high = 1e3 * outlook.worn[:, deepest][:, shown]
        left.fill_between(ahead.progress[shown], low, high, color=colour, alpha=0.2, linewidth=0)
        left.plot(ahead.progress[shown], middle, color=colour, label=f"{outlook.name}, {SHARE:.0%} interval")
    left.plot(plant.tonnage[:READ], plant.reading[deepest, :READ], "ko", markersize=4, label="read")
    left.plot(
        plant.tonnage[READ:], plant.clean[deepest, READ:], "k*", markersize=9, label="what came (never shown)"
    )
    left.axhline(limit, color="#b00020", linestyle="--", linewidth=1.0, label="limit")
    left.set(
        xlabel="tonnage [kt]",
        ylabel="wear [mm]",
        title=f"deepest place of a virtual plant: {found.effects[0].name} named",
    )
    left.set_ylim(0.0, 1.6 * limit)
    left.legend(frameon=False, fontsize=8)
    tested = back_test(survey)
    at = [f.progress for f in tested.occasions]
    for i, colour in enumerate(COLOURS):
        label = f"{NAMES[i]}: {tested.coverage[i]:.0%} held"
        right.semilogy(at, [1e3 * f.rmse[i] for f in tested.occasions], "o-", color=colour, label=label)
    right.axhline(plant.sigma, color="black", linewidth=0.8, linestyle=":", label="gauge")
    right.set(
        xlabel="foretold occasion, tonnage [kt]",
        ylabel="error of the forecast, RMSE [mm]",
        title="each occasion from those before it",
    )
    right.legend(frameon=False, fontsize=8)
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(PICTURE, dpi=130)
    print(f"wrote {PICTURE}", np.round(1e3 * tested.rmse, 3), np.round(tested.coverage, 2))


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
