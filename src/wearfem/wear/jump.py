"""How long a sample of the flow may be trusted: the jump in service time after it, and the error that it costs.

Each cycle samples the rate over one geometry, jumps ahead and moves the surface. Two errors reach the end of life: the rate bends
between samples (bias: shorter jumps help, each costs a warm-up), and the rate is noise (longer samples help). Both are kept in one
currency, seconds of life: a depth error e made while the rate is r moves the end of life by e / r, whatever the wear does to the rate
later. That is exact for one facet whose rate depends on its own depth.

The scheme is a predictor-corrector pair spread over consecutive cycles, second order in time with one sample a cycle:

    predict   surface moves by   D (r_n + s_n D / 2),  s_n the slope of the last two samples    (Adams-Bashforth 2, variable step)
    correct   depth grew by      D (r_n + r_n+1) / 2,  when the next sample is known            (trapezoid rule)

The correction rides on the next jump. Noise is not amplified: in the end each sample weighs as in the trapezoid rule.

Functions take the samples so far and return values; a jump that is rejected is one whose last sample is not kept.
The derivation is in docs/decisions/0006-how-long-a-sample-may-be-trusted.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from statistics import NormalDist

import numpy as np

from wearfem.errors import UserError
from wearfem.wear.budget import LEAST, Plan, cheapest_plan
from wearfem.wear.sampling import ROUNDING, Sample, lag_products, noise_density, statistical_inefficiency

LARGEST_GROWTH = 2.0  # a jump over the one before: Adams-Bashforth 2 is zero-stable below 1 + sqrt(2)
FIRST_BEND = 2.0  # r'' L^2 / r taken until the samples tell it: of a rate that grows fourfold in a life
INDEPENDENT = 10  # blocks in the first sample: its variance is known within a half, sqrt(2/10)
LATEST = 16  # samples that may tell of the present bend
SURPRISE = 1.0 / np.sqrt(3.0)  # rms of where in a jump a sudden change came, over half the jump


@dataclass(frozen=True)
class Bounds:
    """Lengths that a jump must stay well below: the surface may recede by `part` of each.

    Beyond, elements turn over, the flow meets a shape it was not sampled on, or a curved surface changes its area. A quarter leaves
    the area of a receding sphere within (1 - 1/4)^2; it is a rule of caution, what the jump errs by is measured.
    """

    edge_length: np.ndarray | float = np.inf  # (f,) [m]
    particle_radius: float = np.inf  # [m] of the smallest particle
    curvature: np.ndarray | float = 0.0  # (f,) [1/m] largest absolute
    part: float = 0.25  # [-]

    def durations(self, rate: np.ndarray) -> dict[str, float]:
        """The longest jump [s] that each length allows at the rates (f,) [m/s]"""
        per_second = {
            "edge length": rate / self.edge_length,
            "particle radius": rate / self.particle_radius,
            "curvature": rate * self.curvature,
        }
        return {name: _inverse(np.max(value) / self.part) for name, value in per_second.items()}


@dataclass(frozen=True)
class Goal:
    """The end of life, and how well it is to be known: within `tolerance` of itself with the probability `confidence`."""

    allowed_depth: np.ndarray  # (f,) [m] at which a facet is worn out; infinite where none is judged
    area: np.ndarray | float = 1.0  # (f,) [m2]
    tolerance: float = 0.02  # [-]
    confidence: float = 0.9  # [-]

    def __post_init__(self) -> None:
        if not 0.0 < self.tolerance < 1.0 or not 0.0 < self.confidence < 1.0:
            raise UserError(
                f"tolerance is {self.tolerance!r} and confidence {self.confidence!r}; both are parts of 1, such as 0.02 and 0.9."
            )
        if not (np.asarray(self.allowed_depth) > 0.0).all() or not np.isfinite(self.allowed_depth).any():
            raise UserError(
                "allowed_depth must be above 0 m at every facet and finite at one at least: there is no end of life without it."
            )

    @property
    def deviations(self) -> float:
        """Standard deviations within which a normal error lies with `confidence`"""
        return NormalDist().inv_cdf(0.5 + 0.5 * self.confidence)


@dataclass(frozen=True)
class Jump:
    """How far to go on one sample.

    `limited_by` is `edge length`, `particle radius`, `curvature`, `jump error`, `growth`, `asked` or `end of life`, or `noise`: then
    the duration is zero and the sample is to be made `window` long before it is asked again. A duration of zero at `end of life`
    means that the goal is met. Otherwise `window` is the length of the next sample. It is fixed before that sample is seen: who
    samples on until the numbers look good gets rates that are too small, because a low rate promises a long life and asks for less.
    """

    duration: float  # [s] service time
    limited_by: str
    expected_error: float  # [m] of the depth gained, where life ends first: bias and one standard deviation
    acceleration: float  # service seconds per simulated second of this cycle
    window: float  # [s] of steady flow that the next sample needs
    recession: np.ndarray = field(repr=False)  # (f,) [m] by which the surface moves, never negative
    warm_up: float = 0.0  # [s] of flow to throw away after the jump


@dataclass(frozen=True)
class Life:
    """The end of life of the facet that fails first. Beyond the last sample its rate is taken to stay."""

    time: float  # [s]
    facet: int
    bias: float  # [s] expected, of the jumps; positive if `time` is too late
    noise: float  # [s] standard deviation, of sampling and of sudden changes within jumps

    def error(self, deviations: float = 1.0) -> float:
        """What `time` may be off by [s]"""
        return abs(self.bias) + deviations * self.noise


def corrected_depth(samples: Sequence[Sample]) -> np.ndarray:
    """(f,) [m] worn off at the service time of the last sample: the trapezoid rule over all rates"""
    depth = np.zeros_like(samples[-1].mean)
    for before, after in zip(samples[:-1], samples[1:], strict=True):
        depth += 0.5 * (after.service_time - before.service_time) * (before.mean + after.mean)
    return depth


def choose_jump(
    samples: Sequence[Sample],
    depth: np.ndarray,
    goal: Goal,
    bounds: Bounds | None = None,
    at_most: float = np.inf,
) -> Jump:
    """The jump after the last sample.

    Parameters
    ----------
    samples
        Of all cycles so far, in the order of service time.
    depth
        (f,) [m] by which the surface has been moved since the first sample. What the corrected depth has ahead of it is added to
        this jump, so a mesh that takes only half of a jump loses nothing.
    goal, bounds
        What is to be known and how well; lengths that the jump must respect.
    at_most
        [s] set by the caller: a stop, a period's end, half of a jump that was rejected.

    Notes
    -----
    The bias of a jump D is D^3 r'' / (12 r), r'' from the samples with its sampling variance subtracted. The part of the tolerance
    that bias may use is the one that makes warm-ups and samples together cheapest (`_cheapest_share`).
    """
    now, cycles = samples[-1], len(samples)
    course = _Course.along(samples, goal)
    ahead = corrected_depth(samples) - depth
    last = now.service_time - samples[-2].service_time if cycles > 1 else 0.0
    longest = {"asked": at_most} | (bounds or Bounds()).durations(now.mean)
    foreseen = _foreseen(samples, goal, course)
    plan = _plan(foreseen, goal, min(longest.values()))
    longest |= {"growth": LARGEST_GROWTH * last if last else np.inf, "jump error": plan.jump}
    limited_by = min(longest, key=lambda name: longest[name])
    left = foreseen.left if course.left > goal.tolerance * course.life else 0.0
    parts = np.ceil(left / longest[limited_by] - 1e-9)
    duration = left / parts if parts > 0 else 0.0
    if parts <= 1:
        limited_by = "end of life"

    if cycles == 1:
        window = _window_needed(course, 0.0, duration, course.left, plan.variance)
        window = max(window, INDEPENDENT * now.block * statistical_inefficiency(now.rate))
        if window > 1.1 * now.window:  # a tenth is not worth asking twice
            return Jump(0.0, "noise", 0.0, 0.0, window, np.zeros_like(now.mean))
    after = min(duration, left - duration)
    window = max(_window_needed(course, duration, after, left - duration, plan.variance), course.least)
    bias, noise = duration**3 * course.bend / 12.0, duration * course.noise[-1]
    recession = np.maximum(ahead + duration * (now.mean + 0.5 * duration * _slope(samples, course)), 0.0)
    return Jump(
        duration,
        limited_by,
        float(course.rate * (bias + noise)),
        duration / (now.window + now.warm_up),
        window,
        recession,
        plan.warm_up,
    )


def is_trusted(samples: Sequence[Sample], goal: Goal) -> bool:
    """Whether the jump that led to the last sample may be kept. The first blocks of a sample are enough to ask.

    If not, take back the liner before it, drop the last sample and choose again with `at_most` half as long. A jump fails if the
    corrector differs from the predictor by so much, beyond three times its noise, that going back is cheaper than what a sudden change
    at an unknown moment of the jump costs. That is a variance v of life; with V allowed and S seconds of sampling planned, S v / (V - v)
    more seconds make up for it. Three, since every false alarm costs a sample and, where the rate bends up, keeps the low ones.
    """
    if len(samples) < 3:
        return True
    course = _Course.along(samples, goal)
    plan = _plan(course, goal, np.inf)
    surprise, noise = course.surprise(len(samples) - 1)
    variance = (SURPRISE * max(abs(surprise) - 3.0 * noise, 0.0)) ** 2
    price = 2.0 * (
        plan.warm_up + course.least
    )  # of the sample dropped and the one more that a shorter jump needs
    return variance * (plan.sampling + price) <= plan.variance * price


def end_of_life(samples: Sequence[Sample], goal: Goal) -> Life:
    """When the first facet is worn out, with what is known of the error."""
    course = _Course.along(samples, goal)
    depth = np.zeros_like(samples[-1].mean)
    time = np.full(len(depth), np.inf)
    for before, after in zip(samples[:-1], samples[1:], strict=True):
        step = after.service_time - before.service_time
        gain = 0.5 * step * (before.mean + after.mean)
        crossed = np.isinf(time) & (depth + gain >= goal.allowed_depth) & (gain > 0.0)
        into = _time_to_wear(goal.allowed_depth - depth, before.mean, (after.mean - before.mean) / step)
        time[crossed] = before.service_time + into[crossed]
        depth = depth + gain
    on = np.isinf(time) & (samples[-1].mean > 0.0)
    time[on] = samples[-1].service_time + ((goal.allowed_depth - depth)[on] / samples[-1].mean[on])
    facet = int(np.argmin(time))
    return Life(float(time[facet]), facet, course.spent_bias, float(np.sqrt(course.spent_noise)))


@dataclass(frozen=True)
class _Course:
    """The samples seen from where life ends first: one relative rate, its slope and bend, and the time that is left.

    What was learnt before a sudden change says nothing of the course after it: slopes and bends are those of the present layer.
    """

    time: np.ndarray  # (n,) [s]
    relative: np.ndarray  # (n,) [-] rate over the present one
    relative_error: np.ndarray  # (n,) [-] of `relative`
    noise_density: float  # [s] relative variance of a facet's rate times the window
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
    def along(cls, samples: Sequence[Sample], goal: Goal) -> "_Course":
        now = samples[-1]
        weight, left = _where_life_ends(samples, goal)
        series = [sample.rate @ weight for sample in samples]
        mean = np.array([one.mean() for one in series])
        relative = [one / value - 1.0 for one, value in zip(series, mean, strict=True)]
        together = noise_density(
            [lag_products(one[:, None]) for one in relative], sum(one @ one for one in relative), now.block
        )
        share = weight * now.mean / mean[-1]
        facets = noise_density(
            [sample.lag_products / sample.mean.sum() ** 2 for sample in samples],
            share @ sum(sample.squares for sample in samples),
            now.block,
        )
        window = np.array([sample.window for sample in samples])
        course = cls(
            time=np.array([sample.service_time for sample in samples]),
            relative=mean / mean[-1],
            relative_error=np.sqrt(together / window) * mean / mean[-1],
            noise_density=float(facets),
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
        slope, slope_error = course.fit(len(samples), 1)
        bend, bend_error = course.fit(len(samples), 2)
        slope *= _kept(slope, slope_error)
        left = float(_time_to_wear(np.array(left), np.array(1.0), np.array(slope)))
        expected = FIRST_BEND / (now.service_time - samples[0].service_time + left) ** 2
        bend = abs(bend) * np.sqrt(_kept(bend, 2.0 * bend_error))
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
    def noise(self) -> np.ndarray:
        """(n,) [-] standard error of a facet's rate over the rate"""
        return np.sqrt(self.noise_density / self.window)

    @property
    def quadrature(self) -> np.ndarray:
        """(n,) [s] weight of each sample in the depth so far"""
        step = np.diff(self.time)
        return 0.5 * (np.append(0.0, step) + np.append(step, 0.0))

    @property
    def spent_noise(self) -> float:
        """[s2] variance of life from the samples so far, and from sudden changes"""
        sudden = sum(self.sudden(jump) for jump in range(1, len(self.time)) if self.layer[jump] == jump)
        return float(np.square(self.quadrature * self.noise).sum()) + sudden

    @property
    def spent_bias(self) -> float:
        """[s] signed, of the jumps so far: the trapezoid rule gains D^3 r'' / 12 too much depth, so life is told too short"""
        total = 0.0
        for jump in range(1, len(self.time)):
            if self.layer[jump] == jump:
                continue
            bend, error = self.fit(max(jump + 1, min(3, len(self.time))), 2)
            total -= (self.time[jump] - self.time[jump - 1]) ** 3 * bend * _kept(bend, error) / 12.0
        return total

    def surprise(self, jump: int) -> tuple[float, float]:
        """Corrector minus predictor of a jump [s], and its standard deviation from sampling: the embedded pair.

        Nothing where the layer that the jump began in has but one sample.
        """
        if jump - self.layer[jump - 1] < 2:
            return 0.0, 0.0
        step, before = np.diff(self.time[jump - 2 : jump + 1])[::-1]
        ratio = step / before
        part = np.array([ratio, -1.0 - ratio, 1.0])
        scale = 0.5 * step / self.relative[jump]
        difference = scale * float(part @ self.relative[jump - 2 : jump + 1])
        return difference, scale * float(np.linalg.norm(part * self.relative_error[jump - 2 : jump + 1]))

    def sudden(self, jump: int) -> float:
        """[s2] variance of life from a jump in which the rate changed as no smooth course foretold; zero for others.

        Sudden is a surprise of three deviations and four times the one that the bend before it foretells.
        """
        if jump - self.layer[jump - 1] < 3:
            return 0.0
        surprise, noise = self.surprise(jump)
        if abs(surprise) <= 3.0 * noise:
            return 0.0
        step, before = np.diff(self.time[jump - 2 : jump + 1])[::-1]
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


def _where_life_ends(samples: Sequence[Sample], goal: Goal) -> tuple[np.ndarray, float]:
    """Weights (f,) that fall with the eighth power of the life at the present rate, and the shortest time left [s]."""
    rate = samples[-1].mean
    if not (rate[np.isfinite(goal.allowed_depth)] > 0.0).any():
        raise UserError(
            "no facet with an allowed depth wears at all: sample longer, or look where the flow goes."
        )
    still = np.maximum(goal.allowed_depth - corrected_depth(samples), 0.0)
    left = np.where(rate > 0.0, still / np.where(rate > 0.0, rate, 1.0), np.inf)
    shortest = float(left.min())
    passed = samples[-1].service_time - samples[0].service_time
    weight = goal.area * ((passed + shortest) / (passed + left)) ** 8
    return weight / weight.sum(), shortest


def _plan(course: _Course, goal: Goal, longest: float) -> Plan:
    """The cheapest way through the life as it is known now, no jump longer than `longest` [s]."""
    return cheapest_plan(
        course.life,
        longest,
        change=course.slope * course.life,
        bend=course.bend * course.life**2,
        noise_density=course.noise_density,
        memory=course.memory,
        block=course.block,
        tolerance=goal.tolerance,
        confidence=goal.confidence,
    )


def _window_needed(course: _Course, before: float, after: float, left: float, allowed: float) -> float:
    """Length of a sample [s] such that samples in proportion to the time they stand for keep the variance of life [s2] allowed.

    The sample stands for half of the jumps before and after it; the time `left` comes after it. Where earlier samples used up more
    than their part, the window is at most twice the one planned: what cannot be made good cheaply is told in the error.
    """
    weight = course.quadrature
    weight[-1] += 0.5 * before  # of the sample before, whose jump is known by now
    spent = float(np.square(weight * course.noise).sum()) if before else 0.0
    stands_for = 0.5 * before + left
    still = max(allowed - spent, 0.5 * allowed * stands_for / course.life)
    return course.noise_density * stands_for * 0.5 * (before + after) / still


def _foreseen(samples: Sequence[Sample], goal: Goal, course: _Course) -> _Course:
    """What the samples before the last one say of the time that is left; all of them where they cannot know."""
    if len(samples) < 3 or course.layer[-1] == len(samples) - 1:
        return course
    before = _Course.along(samples[:-1], goal)
    left = before.left - (course.time[-1] - before.time[-1])
    return replace(before, left=left, time=course.time) if left > goal.tolerance * course.life else course


def _slope(samples: Sequence[Sample], course: _Course) -> np.ndarray:
    """(f,) [m/s2] between the last two samples of one layer, kept so far as it stands out of the noise"""
    if course.layer[-1] == len(samples) - 1:
        return np.zeros_like(samples[-1].mean)
    before, now = samples[-2:]
    change = now.mean - before.mean
    signal, noise = course.weight @ change**2, course.weight @ (now.error**2 + before.error**2)
    return change * _kept(np.sqrt(signal), np.sqrt(noise)) / (now.service_time - before.service_time)


def _kept(value: float, error: float) -> float:
    """The part of a noisy value that is signal: 1 - error^2 / value^2, not below zero"""
    return float(max(1.0 - (error / value) ** 2, 0.0)) if value else 0.0


def _time_to_wear(depth: np.ndarray, rate: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Time [s] in which rate t + slope t^2 / 2 reaches the depth; twice the time at constant rate where it never does."""
    with np.errstate(divide="ignore", invalid="ignore"):
        even = depth / rate
        root = np.sqrt(np.maximum(1.0 + 2.0 * slope * even / rate, 0.0))
        return 2.0 * even / (1.0 + root)


def _over(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    return np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0)


def _inverse(value: float) -> float:
    return 1.0 / value if value > 0.0 else np.inf
