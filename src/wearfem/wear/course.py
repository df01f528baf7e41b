"""The course of a rate along a life, as noisy samples show it: its slope, its bend, sudden changes, and the time that is left."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from wearfem.errors import UserError
from wearfem.wear.budget import LEAST
from wearfem.wear.first_failure import without_noise
from wearfem.wear.sampling import ROUNDING, Sample, lag_products, noise_density, passage

if TYPE_CHECKING:
    from wearfem.wear.jump import Goal

FIRST_BEND = 2.0  # r'' L^2 / r taken until the samples tell it: of a rate that grows fourfold in a life
LATEST = 16  # samples that may tell of the present bend
SURPRISE = 1.0 / np.sqrt(3.0)  # rms of where in a jump a sudden change came, over half the jump


@dataclass(frozen=True)
class Course:
    """The samples seen from where life ends first: one relative rate, its slope and bend, and the time that is left.

    What was learnt before a sudden change says nothing of the course after it: slopes and bends are those of the present layer.
    """

    time: np.ndarray  # (n,) [s] when the liner came through the shapes that were sampled
    service_time: np.ndarray  # (n,) [s] when the jumps were to bring it there
    relative: np.ndarray  # (n,) [-] rate over the present one
    relative_error: np.ndarray  # (n,) [-] of `relative`
    together: float  # [s] relative variance of the weighted rate times the window
    own: float  # [s] what a facet's rate has beyond that, by itself
    distinct: float  # [-] how far lives differ, beside how well they are to be known: 0 where all are alike, 1 where one stands out
    window: np.ndarray  # (n,) [s]
    memory: float  # [s] in which the flow forgets most (1 - 1/e) of a change
    block: float  # [s]
    weight: np.ndarray  # (f,)
    rate: float  # [m/s] present, weighted
    left: float  # [s]
    layer: np.ndarray  # (n,) the first sample of the layer that each was taken in
    slope: float = 0.0  # [1/s] r' / r beyond its noise; the expected one where that is larger
    bend: float = 0.0  # [1/s2] |r''| / r likewise, beyond twice its noise

    @property
    def life(self) -> float:
        """[s]"""
        return float(self.time[-1]) + self.left - float(self.time[0])

    @property
    def least(self) -> float:
        """[s] of the shortest sample"""
        return LEAST * self.block

    @classmethod
    def along(cls, samples: Sequence[Sample], goal: "Goal") -> "Course":
        """What the samples tell where life ends first; raises `UserError` where nothing wears."""
        now = samples[-1]
        time, depth = passage(samples)
        weight, lefts = _where_life_ends(samples[-1], time[-1] - time[0], depth[-1], goal)
        left = float(lefts.min())
        series = [sample.rate @ weight for sample in samples]
        mean = np.array([one.mean() for one in series])
        relative = [one / value - 1.0 for one, value in zip(series, mean, strict=True)]
        together = noise_density(
            [lag_products(one[:, None]) for one in relative], sum(one @ one for one in relative), now.block
        )
        squares = (weight * now.mean / mean[-1]) @ sum(sample.squares for sample in samples)
        facets = noise_density(
            [sample.lag_products / sample.mean.sum() ** 2 for sample in samples], squares, now.block
        )
        window = np.array([sample.window for sample in samples])
        course = cls(
            time=time,
            service_time=np.array([sample.service_time for sample in samples]),
            relative=mean / mean[-1],
            relative_error=np.sqrt(together / window) * mean / mean[-1],
            together=float(together),
            own=max(float(facets - together), 0.0),
            distinct=1.0,
            window=window,
            memory=_memory(samples[0], weight),
            block=now.block,
            weight=weight,
            rate=float(mean[-1]),
            left=left,
            layer=np.zeros(len(samples), int),
        )
        for jump in range(1, len(samples)):
            course.layer[jump] = jump if course.sudden(jump) else course.layer[jump - 1]
        course = replace(course, distinct=course.how_distinct(lefts, goal))
        slope, slope_error = course.fit(len(samples), 1)
        bend, bend_error = course.fit(len(samples), 2)
        slope *= kept(slope, slope_error)
        left = float(time_to_wear(np.array(left), np.array(1.0), np.array(slope)))
        expected = FIRST_BEND / (time[-1] - time[0] + left) ** 2
        bend = abs(bend) * np.sqrt(kept(bend, 2.0 * bend_error))
        return replace(
            course,
            left=left,
            slope=max(abs(slope), np.sqrt(expected)) if slope_error > np.sqrt(expected) else abs(slope),
            bend=max(bend, expected) if bend_error > expected else bend,
        )

    def fit(self, count: int, degree: int) -> tuple[float, float]:
        """The derivative of this degree of the relative rate at the latest of the first `count` samples, and its standard error
        [1/s^degree].

        From a polynomial of this degree through as many of the latest samples of the layer as it fits: chi^2 within three deviations
        of its expectation.
        """
        used = min(count - self.layer[count - 1], LATEST)
        if used <= degree:
            return 0.0, np.inf
        while True:
            latest = slice(count - used, count)
            time = self.time[latest] - self.time[count - 1]
            value, error = self.relative[latest], self.relative_error[latest]
            error = np.maximum(error, np.sqrt(ROUNDING) * value)
            rows = np.vander(time / -time[0], degree + 1, increasing=True) / error[:, None]
            answer, *_ = np.linalg.lstsq(rows, value / error, rcond=None)
            chi2, freedom = float(np.square(rows @ answer - value / error).sum()), used - degree - 1
            if not freedom or chi2 <= freedom + 3.0 * np.sqrt(2.0 * freedom):
                break
            used = max(degree + 1, 3 * used // 4)
        scale = degree / (-time[0]) ** degree / answer[0]  # degree! / length^degree for 1 and 2
        deviation = float(np.sqrt(np.linalg.inv(rows.T @ rows)[degree, degree]))
        return float(answer[degree]) * scale, deviation * scale

    @property
    def independent(self) -> float:
        """How many facets share one noise, as the weighted rate shows it: 1 where it is common to all"""
        return 1.0 + self.own / self.together if self.together > 0.0 else 1.0

    def how_distinct(self, left: np.ndarray, goal: "Goal") -> float:
        """A / (A + v), the part of a facet's own noise that will be left in the life of the first: A the true variance of lives, v the
        one that noise may have in the end."""
        weight = self.quadrature
        weight[-1] += self.left
        noise = self.own * float(weight**2 @ (1.0 / self.window))
        lives = without_noise(self.time[-1] - self.time[0] + left, goal.area, noise, self.independent)
        allowed = (goal.tolerance * self.life / goal.deviations) ** 2
        return lives.true_variance / (lives.true_variance + allowed)

    @property
    def noise_density(self) -> float:
        """[s] relative variance of the rate where life ends first, times the window"""
        return self.together + self.distinct * self.own

    @property
    def noise(self) -> np.ndarray:
        """(n,) [-] standard error of a facet's rate over the rate"""
        return np.sqrt(self.noise_density / self.window)

    @property
    def quadrature(self) -> np.ndarray:
        """(n,) [s] weight of each sample in the depth so far"""
        step = np.diff(self.time)
        return 0.5 * (np.append(0.0, step) + np.append(step, 0.0))

    @property
    def sudden_variance(self) -> float:
        """[s2] of life, from sudden changes"""
        return sum(self.sudden(jump) for jump in range(1, len(self.time)) if self.layer[jump] == jump)

    @property
    def spent_bias(self) -> float:
        """[s] signed, of the jumps so far: the trapezoid rule gains D^3 r'' / 12 too much depth, so life is told too short"""
        total = 0.0
        for jump in range(1, len(self.time)):
            if self.layer[jump] == jump:
                continue
            bend, error = self.fit(max(jump + 1, min(3, len(self.time))), 2)
            total -= (self.time[jump] - self.time[jump - 1]) ** 3 * bend * kept(bend, error) / 12.0
        return total

    def surprise(self, jump: int) -> tuple[float, float]:
        """Corrector minus predictor of a jump [s], and its standard deviation from sampling: the embedded pair.

        Nothing where the layer that the jump began in has but one sample.
        """
        if jump - self.layer[jump - 1] < 2:
            return 0.0, 0.0
        step, before = np.diff(self.service_time[jump - 2 : jump + 1])[::-1]
        ratio = step / before
        part = np.array([ratio, -1.0 - ratio, 1.0])
        scale = 0.5 * step / self.relative[jump]
        difference = scale * float(part @ self.relative[jump - 2 : jump + 1])
        latest = slice(jump - 2, jump + 1)
        error = np.maximum(self.relative_error[latest], np.sqrt(ROUNDING) * self.relative[latest])
        return difference, scale * float(np.linalg.norm(part * error))

    def sudden(self, jump: int) -> float:
        """[s2] variance of life from a jump in which the rate changed as no smooth course foretold; zero for others.

        Sudden is a surprise of three deviations and four times the one that the bend before it foretells.
        """
        if jump - self.layer[jump - 1] < 3:
            return 0.0
        surprise, noise = self.surprise(jump)
        if abs(surprise) <= 3.0 * noise:
            return 0.0
        step, before = np.diff(self.service_time[jump - 2 : jump + 1])[::-1]
        foretold = 0.25 * step**2 * (step + before) * abs(self.fit(jump, 2)[0])
        if abs(surprise) <= 4.0 * foretold:
            return 0.0
        return float((SURPRISE * surprise) ** 2 - noise**2 * SURPRISE**2)


def _memory(first: Sample, weight: np.ndarray) -> float:
    """[s] after which 1/e is left of a change of the flow: from 1 to the scatter of a block in the first warm-up, where it was lost to
    sight."""
    series = first.rate @ weight
    scatter = float(series.std() / series.mean())
    return first.warm_up / max(np.log(1.0 / max(scatter, np.sqrt(ROUNDING))), 1.0)


def _where_life_ends(
    last: Sample, passed: float, depth: np.ndarray, goal: "Goal"
) -> tuple[np.ndarray, np.ndarray]:
    """Weights (f,) that fall with the eighth power of the life at the present rate, and the times left (f,) [s]."""
    rate = last.mean
    if not (rate[np.isfinite(goal.allowed_depth)] > 0.0).any():
        raise UserError(
            "no facet with an allowed depth wears at all: sample longer, or look where the flow goes."
        )
    still = np.maximum(goal.allowed_depth - depth, 0.0)
    left = np.where(rate > 0.0, still / np.where(rate > 0.0, rate, 1.0), np.inf)
    weight = goal.area * ((passed + left.min()) / (passed + left)) ** 8
    return weight / weight.sum(), left


def kept(value: float, error: float) -> float:
    """The part of a noisy value that is signal: 1 - error^2 / value^2, not below zero"""
    return float(max(1.0 - (error / value) ** 2, 0.0)) if value else 0.0


def time_to_wear(depth: np.ndarray, rate: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Time [s] in which rate t + slope t^2 / 2 reaches the depth; twice the time at constant rate where it never does."""
    with np.errstate(divide="ignore", invalid="ignore"):
        even = depth / rate
        root = np.sqrt(np.maximum(1.0 + 2.0 * slope * even / rate, 0.0))
        return 2.0 * even / (1.0 + root)
