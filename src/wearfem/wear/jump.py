"""How long a sample of the flow may be trusted: the jump in service time after it, and the error that it costs.

Each cycle samples the rate over one geometry, jumps ahead and moves the surface. Two errors reach the end of life: the rate bends
between samples (bias: shorter jumps help, each costs a warm-up), and the rate is noise (longer samples help). Both are kept in one
currency, seconds of life: a depth error e made while the rate is r moves the end of life by e / r, whatever the wear does to the rate
later. That is exact for one facet whose rate depends on its own depth.

The scheme is a predictor-corrector pair spread over consecutive cycles, with one sample a cycle:

    predict   surface moves by   D (r_n + s_n D / 2),  s_n the slope of the last two samples    (Adams-Bashforth 2, variable step)
    correct   the surface of the next sample is known exactly, and when the liner came through it is told by both rates,
              step (r_n + r_n+1) / 2 = the way between the two surfaces                         (trapezoid rule)

What the predictor was off by rides on the next jump and costs no accuracy. The bias of the trapezoid rule is second order and taken off in
the end by the bends that were seen. Noise is not amplified: in the end each sample weighs as in the trapezoid rule.

What a case knows of its metal by depth (`Goal.metal`) is taken out before: all of this is done in plain depths (`metal.py`).

Functions take the samples so far and return values; a jump that is rejected is one whose last sample is not kept.
The derivation is in docs/decisions/0006-how-long-a-sample-may-be-trusted.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from statistics import NormalDist

import numpy as np

from wearfem.errors import UserError
from wearfem.wear.budget import Plan, cheapest_plan
from wearfem.wear.course import SURPRISE, Course, kept, time_to_wear
from wearfem.wear.first_failure import without_noise
from wearfem.wear.metal import Metal, in_plain_depths
from wearfem.wear.sampling import Sample, corrected_depth, passage, statistical_inefficiency

LARGEST_GROWTH = 2.0  # a jump over the one before: Adams-Bashforth 2 is zero-stable below 1 + sqrt(2)
INDEPENDENT = 10  # blocks in the first sample: its variance is known within a half, sqrt(2/10)


@dataclass(frozen=True)
class Bounds:
    """Lengths that a jump must stay well below: the surface may recede by `part` of each.

    Beyond, elements turn over, the flow meets a shape it was not sampled on, or a curved surface changes its area. A quarter leaves
    the area of a receding sphere within (1 - 1/4)^2; it is a rule of caution, what the jump errs by is measured.
    """

    edge_length: np.ndarray | float = np.inf  # (f,) [m]
    particle_radius: np.ndarray | float = np.inf  # [m] of the smallest particle
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

    def plain(self, metal: Metal, depth: np.ndarray) -> "Bounds":
        """The bounds in plain depths, of a surface that has receded by `depth` (f,) [m]"""

        def ahead(length: np.ndarray | float) -> np.ndarray:
            return (metal.plain_of(depth + self.part * length) - metal.plain_of(depth)) / self.part

        with np.errstate(divide="ignore"):
            radius_of_curvature = 1.0 / np.asarray(self.curvature)
        return replace(
            self,
            edge_length=ahead(self.edge_length),
            particle_radius=ahead(self.particle_radius),
            curvature=1.0 / ahead(radius_of_curvature),
        )


@dataclass(frozen=True)
class Goal:
    """The end of life, and how well it is to be known: within `tolerance` of itself with the probability `confidence`."""

    allowed_depth: np.ndarray  # (f,) [m] at which a facet is worn out; infinite where none is judged
    area: np.ndarray | float = 1.0  # (f,) [m2]
    tolerance: float = 0.02  # [-]
    confidence: float = 0.9  # [-]
    metal: Metal | None = None  # what is known of the way there beforehand

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

    @property
    def plain(self) -> "Goal":
        """The goal in plain depths, with nothing left that is known of the metal"""
        if self.metal is None:
            return self
        return replace(self, allowed_depth=self.metal.plain_of(self.allowed_depth), metal=None)


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
    bias: float  # [s] of the jumps, positive where they made it too late; `time` is without it, and it stays as its error
    noise: float  # [s] standard deviation, of sampling and of sudden changes within jumps

    def error(self, deviations: float = 1.0) -> float:
        """What `time` may be off by [s]"""
        return abs(self.bias) + deviations * self.noise


def choose_jump(
    samples: Sequence[Sample],
    depth: np.ndarray,
    goal: Goal,
    bounds: Bounds | None = None,
    at_most: float = np.inf,
    stop: float = np.inf,
) -> Jump:
    """The jump after the last sample: what is left is gone in equal parts.

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
        [s] set by the caller: half of a jump that was rejected, say.
    stop
        [s] from the last sample to where the caller stops, if life goes on until then.

    Notes
    -----
    The bias of a jump D is D^3 r'' / (12 r), r'' from the samples with its sampling variance subtracted. The part of the tolerance
    that bias may use is the one that makes warm-ups and samples together cheapest (`_cheapest_share`).
    """
    if goal.metal is not None:
        return _through_the_metal(goal.metal, samples, depth, goal, bounds or Bounds(), at_most, stop)
    now, cycles = samples[-1], len(samples)
    course = Course.along(samples, goal)
    ahead = corrected_depth(samples) - depth
    last = now.service_time - samples[-2].service_time if cycles > 1 else 0.0
    longest = {"asked": at_most} | (bounds or Bounds()).durations(now.mean)
    foreseen = _foreseen(samples, goal, course)
    plan = _plan(foreseen, goal, min(longest.values()))
    longest |= {"growth": LARGEST_GROWTH * last if last else np.inf, "jump error": plan.jump}
    limited_by = min(longest, key=lambda name: longest[name])
    ends = course.left <= goal.tolerance * course.life
    left = 0.0 if ends else max(foreseen.left - (now.service_time - course.time[-1]), 0.0)
    way = min(left, stop)
    parts = np.ceil(way / longest[limited_by] - 1e-9)
    duration = way / parts if parts > 0 else 0.0
    if parts <= 1:
        limited_by = "end of life" if left <= stop else "asked"

    if cycles == 1:
        window = _window_needed(course, 0.0, duration, course.left, plan.variance)
        window = max(window, INDEPENDENT * now.block * statistical_inefficiency(now.rate))
        if window > 1.1 * now.window:  # a tenth is not worth asking twice
            return Jump(0.0, "noise", 0.0, 0.0, window, np.zeros_like(now.mean))
    after = min(duration, way - duration)
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
    course = Course.along(in_plain_depths(samples, goal.metal), goal.plain)
    plan = _plan(course, goal, np.inf)
    surprise, noise = course.surprise(len(samples) - 1)
    variance = (SURPRISE * max(abs(surprise) - 3.0 * noise, 0.0)) ** 2
    price = 2.0 * (
        plan.warm_up + course.least
    )  # of the sample dropped and the one more that a shorter jump needs
    return variance * (plan.sampling + price) <= plan.variance * price


def end_of_life(samples: Sequence[Sample], goal: Goal) -> Life:
    """When the first facet is worn out, with what is known of the error.

    The trapezoid rule over the rates at the shapes that the liner came through, less the bias that the bends of the rate tell of it.
    """
    samples, goal = in_plain_depths(samples, goal.metal), goal.plain
    course = Course.along(samples, goal)
    when, worn = passage(samples)
    time = np.full(worn.shape[1], np.inf)
    for number, (before, after) in enumerate(zip(samples[:-1], samples[1:], strict=True)):
        step, depth = when[number + 1] - when[number], worn[number]
        crossed = np.isinf(time) & (worn[number + 1] >= goal.allowed_depth) & (worn[number + 1] > depth)
        into = time_to_wear(goal.allowed_depth - depth, before.mean, (after.mean - before.mean) / step)
        time[crossed] = when[number] + into[crossed]
    on = np.isinf(time) & (samples[-1].mean > 0.0)
    time[on] = when[-1] + ((goal.allowed_depth - worn[-1])[on] / samples[-1].mean[on])
    weight = course.quadrature
    weight[-1] += max(float(time.min()) - course.time[-1], 0.0)
    lives = without_noise(
        time, goal.area, course.own * float(weight**2 @ (1.0 / course.window)), course.independent
    )
    facet = int(np.argmin(lives.time))
    density = course.together + lives.kept**2 * course.own
    variance = (
        density * float(course.quadrature**2 @ (1.0 / course.window))
        + course.sudden_variance
        + lives.doubt**2
    )
    return Life(
        float(lives.time[facet]) - course.spent_bias, facet, course.spent_bias, float(np.sqrt(variance))
    )


def _through_the_metal(
    metal: Metal,
    samples: Sequence[Sample],
    depth: np.ndarray,
    goal: Goal,
    bounds: Bounds,
    at_most: float,
    stop: float,
) -> Jump:
    """The jump as it is chosen in plain depths, in metres that wear."""
    plain = metal.plain_of(depth)
    jump = choose_jump(
        in_plain_depths(samples, metal), plain, goal.plain, bounds.plain(metal, depth), at_most, stop
    )
    recession = np.maximum(metal.depth_of(plain + jump.recession) - depth, 0.0)
    factor = recession.max() / jump.recession.max() if recession.any() else 1.0
    return replace(jump, recession=recession, expected_error=float(factor * jump.expected_error))


def _plan(course: Course, goal: Goal, longest: float) -> Plan:
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


def _window_needed(course: Course, before: float, after: float, left: float, allowed: float) -> float:
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


def _foreseen(samples: Sequence[Sample], goal: Goal, course: Course) -> Course:
    """What the samples before the last one say of the time that is left; all of them where they cannot know."""
    if len(samples) < 3 or course.layer[-1] == len(samples) - 1:
        return course
    before = Course.along(samples[:-1], goal)
    left = before.left - (course.time[-1] - before.time[-1])
    return replace(before, left=left, time=course.time) if left > goal.tolerance * course.life else course


def _slope(samples: Sequence[Sample], course: Course) -> np.ndarray:
    """(f,) [m/s2] between the last two samples of one layer, kept so far as it stands out of the noise"""
    if course.layer[-1] == len(samples) - 1:
        return np.zeros_like(samples[-1].mean)
    before, now = samples[-2:]
    change = now.mean - before.mean
    signal, noise = course.weight @ change**2, course.weight @ (now.error**2 + before.error**2)
    return change * kept(np.sqrt(signal), np.sqrt(noise)) / (now.service_time - before.service_time)


def _inverse(value: float) -> float:
    return 1.0 / value if value > 0.0 else np.inf
