"""Lives foretold from surveys: virtual plants that go on after their last reading, and how often the 80 % interval holds the truth.

A plant is made with twelve occasions by its own equations (`tests/identification/plants.py`), and only the first eight are read. The
limit is what the deepest place has lost at the tenth occasion, so the truth is the amount of service then, without a formula.
"""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.proof import Claim
from wearfem.proofs.diagnosis import ISSUE, plants
from wearfem.survey.backtest import BackTest, back_test
from wearfem.survey.diagnose import diagnose
from wearfem.survey.forecast import SHARE, forecast
from wearfem.survey.survey import Survey, read_survey

READ, LATER, ENDS = (
    8,
    12,
    10,
)  # occasions that are read, that the plant has, and at which the deepest place comes to the limit
CAREFUL: dict[str, float] = {}
CARELESS = {
    "scatter": 0.03,
    "book": 0.02,
    "campaign_zero": 0.1,
}  # a plant as it is: places, tonnage book and campaigns
SHOWN = ("none", "hardness_gradient", "ore_hardness", "pressure_exponent", "same_exposure")


@dataclass(frozen=True)
class Trial:
    """A plant, when it was really worn out, and when it was foretold to be, by model."""

    plant: str
    seed: int
    named: tuple[str, ...]
    truth: float  # progress
    now: float
    models: tuple[str, ...]
    median: np.ndarray  # (m,) progress
    low: np.ndarray
    high: np.ndarray

    @property
    def held(self) -> np.ndarray:
        """(m,) whether the interval of each model holds the truth"""
        return (self.low <= self.truth) & (self.truth <= self.high)


def surveyed(plant: Any, read: int) -> Survey:
    """The survey of the first occasions of a plant."""
    early = replace(
        plant, tonnage=plant.tonnage[:read], clean=plant.clean[:, :read], reading=plant.reading[:, :read],
        occasion_column={name: value[:read] for name, value in plant.occasion_column.items()},
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        survey, exposure = early.write(Path(folder))
        return read_survey(survey, exposure=exposure)


def trial(name: str, seed: int, **design: float) -> Trial:
    """Make a plant, read its beginning, foretell its end."""
    plant = plants().plant(name, seed, occasions=LATER, **design)
    found = diagnose(surveyed(plant, READ), name_without=False)
    ahead = forecast(found.choice, 1e-3 * float(plant.clean[:, ENDS - 1].max()))
    ends = [ahead.of_zone(outlook, "all points") for outlook in ahead.outlooks]
    return Trial(
        name, seed, tuple(effect.name for effect in found.effects), float(plant.tonnage[ENDS - 1]), ahead.now,
        tuple(outlook.name for outlook in ahead.outlooks),
        np.array([e.median for e in ends]), np.array([e.interval[0] for e in ends]), np.array([e.interval[1] for e in ends]),
    )  # fmt: skip


def line(one: Trial) -> str:
    """A trial in a line: how far off each model was [kt], with its interval, and whether that held the truth."""
    told = [
        f"{m - one.truth:+.0f} ({a - one.truth:+.0f} to {b - one.truth:+.0f}){'' if h else ' missed'}"
        for m, a, b, h in zip(one.median, one.low, one.high, one.held, strict=True)
    ]
    named = " + ".join(one.named) or "nothing"
    return f"  {one.plant:<18} {one.seed:>4}  {one.truth - one.now:.0f} kt left  {' | '.join(told)}  named {named}"


def coverage(trials: Sequence[Trial], place: int) -> float:
    """Share of trials in which the interval of a model (0 straight line, 1 coefficient alone, -1 diagnosed) held the truth."""
    return float(np.mean([t.held[place] for t in trials]))


def error(trials: Sequence[Trial], place: int) -> float:
    """Median over trials of the error of the remaining life over that life [-]."""
    return float(np.median([abs(t.median[place] - t.truth) / (t.truth - t.now) for t in trials]))


def claims() -> Iterator[Claim]:
    """Five plants, careful and careless; and a back-test of two of them."""
    trials = []
    for name in SHOWN:
        for seed, design in ((1, CAREFUL), (2, CARELESS)):
            trials.append(trial(name, seed, points=24, **design))
            print(line(trials[-1]), flush=True)
    yield from summary(trials)
    for name in ("none", "hardness_gradient"):
        tested = back_test(surveyed(plants().plant(name, 3, points=24, occasions=6), 6))
        yield from back_test_claims(name, tested)


def summary(trials: Sequence[Trial]) -> Iterator[Claim]:
    """What a set of trials comes to."""
    noise = np.sqrt(SHARE * (1.0 - SHARE) / len(trials))
    yield Claim(
        "share of lives that the 80 % interval holds, after diagnosis", ISSUE, SHARE, coverage(trials, -1), "-",
        0.05 + 2.0 * float(noise), False, f"{len(trials)} plants: 0.05 as asked, and 2 standard errors of so many",
    )  # fmt: skip
    for place, name in ((0, "straight line per point"), (1, "coefficient alone")):
        yield Claim(
            f"the same, {name}", ISSUE, SHARE, coverage(trials, place), "-", np.inf, False,
            "it leaves out what the plant does",
        )  # fmt: skip
    yield Claim(
        "median error of the remaining life over that of a straight line", "plants whose rates change are most of them", 0.0,
        error(trials, -1) / error(trials, 0), "-", 1.0, False, f"{100.0 * error(trials, -1):.1f} % of the remaining life after diagnosis",
    )  # fmt: skip


def back_test_claims(name: str, tested: BackTest) -> Iterator[Claim]:
    """Errors of a back-test over those of a straight line."""
    yield Claim(
        f"{name}: error of the next occasion foretold, diagnosed over straight line", ISSUE, 0.0,
        float(tested.rmse[2] / tested.rmse[0]), "-", 1.1, False,
        f"{tested.readings} readings; where nothing is hidden a line is right too, and 10 % is chance",
    )  # fmt: skip
    yield Claim(
        f"{name}: share of the readings that the 80 % interval held", ISSUE, SHARE, float(tested.coverage[2]), "-", 0.15, False,
        f"{tested.readings} readings of {len(tested.occasions)} occasions, which share the errors of their campaigns",
    )  # fmt: skip
