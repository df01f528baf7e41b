"""What the forecasts of a survey would have been worth: each occasion foretold from those before it, and then read.

An effect that is there need not foretell better: its curve may be known too badly, or campaigns may err by more than it explains. So which
forecast to plan by is decided by what earlier ones were worth.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wearfem.errors import UserError
from wearfem.survey.choose import Choice
from wearfem.survey.diagnose import LEAST_READINGS, diagnose
from wearfem.survey.forecast import (
    ALONE,
    FULL,
    LINE,
    SHARE,
    Forecast,
    Outlook,
    allowance,
    explanations,
    lines_ahead,
    wear_ahead,
)
from wearfem.survey.identify import Fit, Readings
from wearfem.survey.survey import Survey

FEWEST = 3  # occasions from which one is foretold
MOST = 12  # occasions that are foretold; of more, as many evenly over the survey
DRAWS = 400
NAMES = (LINE, ALONE, FULL)


@dataclass(frozen=True)
class Foretold:
    """An occasion that was foretold from all before it.

    Parameters
    ----------
    occasion
        Its name.
    progress
        Its median, in the survey's unit.
    named
        The effects that were named from the occasions before.
    error
        (3, r) [SI] foretold less read, of the straight line, the coefficient alone and the model with what was named.
    reach
        (3, r) [-] error over the distance from the median to the end of the 80 % interval on that side; up to 1 the interval holds the
        reading.
    """

    occasion: str
    progress: float
    named: tuple[str, ...]
    error: np.ndarray
    reach: np.ndarray

    @property
    def held(self) -> np.ndarray:
        """(3, r) whether the 80 % interval of each holds the reading"""
        return self.reach <= 1.0

    @property
    def rmse(self) -> np.ndarray:
        """(3,) [SI] of each model"""
        return np.sqrt(np.mean(self.error**2, axis=1))


@dataclass(frozen=True)
class BackTest:
    """All occasions that were foretold; empty where there are too few."""

    occasions: tuple[Foretold, ...]

    @property
    def rmse(self) -> np.ndarray:
        """(3,) [SI] of each model, over all readings"""
        return np.sqrt(np.mean(np.concatenate([f.error for f in self.occasions], axis=1) ** 2, axis=1))

    @property
    def coverage(self) -> np.ndarray:
        """(3,) share of the readings that the 80 % interval of each model holds"""
        return np.mean(np.concatenate([f.held for f in self.occasions], axis=1), axis=1)

    @property
    def readings(self) -> int:
        """How many readings were foretold"""
        return sum(f.error.shape[1] for f in self.occasions)

    @property
    def stretch(self) -> np.ndarray:
        """(3,) by how much the intervals of each model must be stretched to have held 80 % of the readings; 1 where they did

        Readings of an occasion share its errors, so shares are compared occasion by occasion: 1 too where their mean is below 80 % by no
        more than its standard error (at least that of so many readings by themselves), or where two occasions or fewer were foretold.
        """
        share = np.array([f.held.mean(axis=1) for f in self.occasions])
        count = len(share)
        if count < 3:
            return np.ones(len(NAMES))
        error = np.maximum(
            share.std(axis=0, ddof=1) / np.sqrt(count), np.sqrt(SHARE * (1.0 - SHARE) / self.readings)
        )
        needed = np.quantile(np.concatenate([f.reach for f in self.occasions], axis=1), SHARE, axis=1)
        return np.where(share.mean(axis=0) + error < SHARE, np.maximum(needed, 1.0), 1.0)


@dataclass(frozen=True)
class Advice:
    """The forecast to plan by.

    Parameters
    ----------
    outlook
        Of the model that erred least, its intervals stretched as the back-test asks; of the most probable model where nothing was tested.
    stretch
        [-] by how much.
    tested
        Whether earlier forecasts could be compared with readings.
    """

    outlook: Outlook
    stretch: float
    tested: bool


def advised(ahead: Forecast, tested: BackTest) -> Advice:
    """Which of the forecasts to plan by: the one whose model erred least when each occasion was foretold from those before it.

    Parameters
    ----------
    ahead
        The forecasts.
    tested
        The back-test of the same survey.
    """
    if not tested.occasions:
        return Advice(ahead.outlooks[-1], 1.0, False)
    error, stretch = dict(zip(NAMES, tested.rmse, strict=True)), dict(zip(NAMES, tested.stretch, strict=True))
    best = min(ahead.outlooks, key=lambda outlook: error[outlook.name])
    return Advice(stretched(best, stretch[best.name], ahead.now), stretch[best.name], True)


def stretched(outlook: Outlook, factor: float, now: float) -> Outlook:
    """The same medians with intervals that are so many times as wide; nothing that serves ends before `now`."""
    if factor == 1.0:
        return outlook
    low, middle, high = outlook.worn
    worn = np.array([middle + factor * (low - middle), middle, middle + factor * (high - middle)])
    median = np.quantile(outlook.end, 0.5, axis=0, method="closest_observation")
    served = np.isfinite(outlook.end) & np.isfinite(median) & (outlook.end > now)
    with np.errstate(invalid="ignore"):
        wider = np.maximum(median + factor * (outlook.end - median), now)
    return replace(outlook, worn=worn, end=np.where(served, wider, outlook.end))


def back_test(survey: Survey, *, seed: int = 0) -> BackTest:
    """Foretell occasion n + 1 from the first n, for every n from 3 on, and compare with what was then read.

    Each time all is done anew from the first n occasions alone: doubted readings, calibration, and the diagnosis. The amount of service
    at the next occasion is told, its covariates are not. Only plates that had been read in service are foretold, all models on the same
    readings, and none of these is left out.
    """
    return BackTest(tuple(_foretold(survey, seed)))


def _foretold(survey: Survey, seed: int) -> Iterator[Foretold]:
    occasions = np.unique(survey.occasion)
    numbers = range(FEWEST, len(occasions))
    if len(numbers) > MOST:
        numbers = np.linspace(FEWEST, len(occasions) - 1, MOST).round().astype(int)  # type: ignore[assignment]
    for number in numbers:
        before = survey.occasion < occasions[number]
        served = np.unique(survey.life[before & ~survey.is_new])
        asked = (survey.occasion == occasions[number]) & ~survey.is_new & np.isin(survey.life, served)
        if before.sum() < LEAST_READINGS or not asked.any():
            continue
        try:
            choice = diagnose(survey.only(before), name_without=False).choice
        except UserError:  # too little to diagnose yet: one amount of service, or no wear
            continue
        yield foretell(choice, survey.only(asked), seed)


def foretell(choice: Choice, asked: Survey, seed: int = 0) -> Foretold:
    """Readings that were taken later, beside what each model lets expect of them.

    Parameters
    ----------
    choice
        From the occasions before.
    asked
        Rows of the next occasion.
    seed
        Where the draws begin.
    """
    data = choice.plain.readings
    random = np.random.default_rng([seed, asked.size])
    worn = asked.reading if asked.sign > 0.0 else allowance(data, 0.0)[asked.life] - asked.reading
    last = float(data.past.end.max())
    at = np.unique(np.append(last, np.maximum(asked.progress, last)))
    column = np.searchsorted(at, np.maximum(asked.progress, last))
    lines = lines_ahead(data, at, DRAWS, random, noise=1.0)[:, asked.life, column]
    models = [[(choice.plain, 1.0)], explanations(choice)]
    told = [lines, *(_readings_ahead(model, data, asked, at, column, random) for model in models)]
    low, middle, high = np.quantile(told, [0.5 - 0.5 * SHARE, 0.5, 0.5 + 0.5 * SHARE], axis=1)
    width = np.maximum(np.where(worn < middle, middle - low, high - middle), 1e-12 * data.deepest)
    return Foretold(
        asked.occasion_names[asked.occasion[0]], float(np.median(asked.progress)),
        tuple(suspect.name for suspect in choice.best.suspects),
        middle - worn, np.abs(worn - middle) / width,
    )  # fmt: skip


def _readings_ahead(
    models: Sequence[tuple[Fit, float]],
    data: Readings,
    asked: Survey,
    at: np.ndarray,
    column: np.ndarray,
    random: np.random.Generator,
) -> np.ndarray:
    """Draws (s, r) of readings: the wear, with the errors of a campaign and the gauge's own"""
    worn = wear_ahead(models, at, DRAWS, random)[:, asked.life, column]
    spread = models[0][0].spread
    zero = random.normal(0.0, spread.zero, (DRAWS, 1))
    scale = random.normal(0.0, spread.scale, (DRAWS, 1))
    gauge = spread.gauge * np.where(np.isfinite(asked.sigma), asked.sigma / data.reference, 1.0)
    warped = models[0][0].readings.past.warped
    if warped.shape[1]:
        zero = zero + spread.warp * random.normal(size=(DRAWS, warped.shape[1])) @ warped[asked.life].T
    return worn * (1.0 + scale) + zero + gauge * random.normal(size=worn.shape)
