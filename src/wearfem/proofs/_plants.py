"""Flows by formula: liners whose rate of wear is known, seen through the noise and the delay of a sampled flow."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from wearfem.wear.budget import LEAST
from wearfem.wear.jump import Bounds, Goal, Jump, Life, choose_jump, end_of_life, is_trusted
from wearfem.wear.metal import Metal
from wearfem.wear.sampling import Sample, steady_from

RATE = 1e-9  # [m/s] about 0.1 mm a day
ALLOWED = 10e-3  # [m]
BLOCK = 0.25  # [s]
PILOT = 40  # blocks of steady flow before anything is asked of them


@dataclass(frozen=True)
class Plant:
    """A liner on which the rate follows from the depth, and a flow that shows it late and with noise."""

    name: str
    law: Callable[[np.ndarray], np.ndarray]  # depth (f,) [m] -> rate (f,) [m/s]
    life: float  # [s] true
    facets: int = 1
    noise: float = 0.0  # [-] standard deviation of a block's rate over the rate
    memory: float = 0.0  # [-] correlation of one block with the next
    delay: float = 0.0  # [s] in which the flow forgets most (1 - 1/e) of the old geometry
    spread: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (f, f) smoothing of the noise
    metal: Metal | None = None  # what a case would know of the law

    @property
    def goal(self) -> Goal:
        """Every facet may lose 10 mm"""
        return Goal(np.full(self.facets, ALLOWED), metal=self.metal)

    def without_metal(self, rate: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """(f,) [m/s] of plain depth"""
        return rate / self.metal.factor(depth) if self.metal else rate

    def depth_of(self, plain: np.ndarray) -> np.ndarray:
        """(f,) [m] of plain depth"""
        return self.metal.depth_of(plain) if self.metal else plain

    @property
    def noise_density(self) -> float:
        """[s] relative variance of a mean rate times the length of the sample, at the worst facet"""
        worst = int(np.argmax(self.law(np.zeros(self.facets))))
        smoothed = float(np.square(self.spread[worst]).sum()) if len(self.spread) else 1.0
        return self.noise**2 * smoothed * BLOCK * (1.0 + self.memory) / (1.0 - self.memory)


@dataclass
class Flow:
    """The flow over a plant while it is being simulated: what it shows lags behind the geometry."""

    plant: Plant
    random: np.random.Generator
    shown: np.ndarray
    wander: np.ndarray
    time: float = 0.0  # [s] simulated so far: the cost

    @classmethod
    def start(cls, plant: Plant, seed: int) -> "Flow":
        """An empty chute"""
        random = np.random.default_rng(seed)
        return cls(plant, random, np.zeros(plant.facets), random.normal(size=plant.facets))

    def blocks(self, depth: np.ndarray, count: int) -> np.ndarray:
        """(count, f) rates while the geometry stays"""
        rate, plant = self.plant.law(depth), self.plant
        forgets = np.exp(-BLOCK / plant.delay) if plant.delay else 0.0
        faded = forgets ** np.arange(1, count + 1)[:, None]
        shown = rate + (self.shown - rate) * faded
        fresh = np.sqrt(1.0 - plant.memory**2) * self.random.normal(size=(count, plant.facets))
        wander, _ = lfilter([1.0], [1.0, -plant.memory], fresh, axis=0, zi=plant.memory * self.wander[None])
        self.shown, self.wander = shown[-1], wander[-1]
        noise = wander @ plant.spread.T if len(plant.spread) else wander
        self.time += count * BLOCK
        return shown * (1.0 + plant.noise * noise)


@dataclass(frozen=True)
class Lived:
    """A life told by one way of going on, and what it cost."""

    life: float  # [s]
    cost: float  # [s] of simulated flow
    cycles: int
    told: Life | None = None  # what the controller says of its error
    warm_up: float = 0.0  # [s] of the cost
    rejected: int = 0


def by_jumps(
    plant: Plant, goal: Goal, seed: int = 0, bounds: Bounds | None = None, at_most: float = np.inf
) -> Lived:
    """The cycle as `cycle.py` does it: sample, choose, jump, sample; reject where the jump was too bold."""
    flow, geometry = Flow.start(plant, seed), [np.zeros(plant.facets)]
    samples: tuple[Sample, ...] = ()
    rejected, warm_up, time = 0, 0.0, 0.0
    jump: Jump | None = None
    while True:
        known = int(np.ceil(jump.warm_up / BLOCK)) if jump else 0
        least = int(np.ceil(jump.window / BLOCK)) if jump else PILOT
        rows = flow.blocks(geometry[-1], known + LEAST)
        while True:
            start = max(steady_from(rows.sum(axis=1)) if plant.delay else 0, known)
            steady = len(rows) - start
            if steady >= LEAST:
                trial = (*samples, Sample(time, rows[start:], BLOCK, start * BLOCK, geometry[-1]))
                trusted = is_trusted(trial, goal)
                if steady >= least and not samples:
                    first = choose_jump(trial, geometry[-1], goal, bounds, at_most)
                    least = int(np.ceil(first.window / BLOCK)) if first.limited_by == "noise" else least
                if steady >= least or not trusted:
                    break
            rows = np.vstack((rows, flow.blocks(geometry[-1], max(least - steady, 1))))
        warm_up += start * BLOCK
        if trusted:
            samples = trial
            jump = choose_jump(samples, geometry[-1], goal, bounds, at_most)
        else:
            rejected += 1
            geometry.pop()
            jump = choose_jump(samples, geometry[-1], goal, bounds, 0.5 * (time - samples[-1].service_time))
        if jump.duration == 0.0:
            told = end_of_life(samples, goal)
            return Lived(told.time, flow.time, len(samples), told, warm_up, rejected)
        time = samples[-1].service_time + jump.duration
        geometry.append(geometry[-1] + jump.recession)


def by_multiplier(plant: Plant, multiplier: float, lives: int, seed: int = 0) -> list[Lived]:
    """A constant multiplier on the wear while the flow goes on, as the vendors do: no warm-up but the first, no jumps.

    Many lives of a plant of one facet at once, each with noise of its own. Whoever knows the metal multiplies plain depths.
    """
    flow = _many(plant, lives, seed)
    flow.blocks(np.zeros(lives), int(np.ceil(5.0 * plant.delay / BLOCK)))
    return _multiplied(plant, flow, multiplier * BLOCK, lambda depth: flow.blocks(depth, 1)[0])


def by_equal_jumps(plant: Plant, multiplier: float, window: float, lives: int, seed: int = 0) -> list[Lived]:
    """Samples of one length, each followed by a jump `multiplier` times as long (Euler); the warm-up is known beforehand."""
    flow = _many(plant, lives, seed)

    def sampled(depth: np.ndarray) -> np.ndarray:
        flow.blocks(depth, int(np.ceil(5.0 * plant.delay / BLOCK)))
        return flow.blocks(depth, int(np.ceil(window / BLOCK))).mean(axis=0)

    return _multiplied(plant, flow, multiplier * window, sampled)


def _many(plant: Plant, lives: int, seed: int) -> Flow:
    """The flows of many lives: to the noise they are as many facets"""
    assert plant.facets == 1
    return Flow.start(replace(plant, facets=lives), seed)


def _multiplied(
    plant: Plant, flow: Flow, step: float, sampled: Callable[[np.ndarray], np.ndarray]
) -> list[Lived]:
    """Lives in steps of service time [s], each at the rate sampled before it"""
    lives = flow.plant.facets
    plain, life, cost, cycles = np.zeros(lives), np.full(lives, np.nan), np.zeros(lives), 0
    allowed = plant.goal.plain.allowed_depth
    while np.isnan(life).any():
        depth = plant.depth_of(plain)
        rate = np.maximum(plant.without_metal(sampled(depth), depth), 1e-30)
        ends = np.isnan(life) & ((left := (allowed - plain) / rate) <= step)
        life[ends], cost[ends] = (cycles * step + left)[ends], flow.time
        plain, cycles = np.minimum(plain + step * rate, allowed), cycles + 1
    return [Lived(*one, cycles) for one in zip(life.tolist(), cost.tolist(), strict=True)]


class WornOut:
    """Ends an integration over time where the first facet has lost what it may: an event of `solve_ivp`"""

    terminal = True

    def __call__(self, _: float, depth: np.ndarray) -> float:
        return float(depth.max() - ALLOWED)


def growing(decades: float = 0.5) -> Plant:
    """A rate that grows with depth, r = r0 exp(a d / D): life = D / (a r0) (1 - exp(-a))"""
    a = decades * np.log(10.0)
    life = ALLOWED / RATE * (1.0 - np.exp(-a)) / a
    return Plant("accelerating", lambda depth: RATE * np.exp(a * depth / ALLOWED), life)


def falling(decades: float = 0.5) -> Plant:
    """A rate that falls with depth, r = r0 exp(-a d / D)"""
    return replace(growing(-decades), name="decelerating")


def gradient(part: float = 1.0) -> Plant:
    """A hardness that falls through the thickness, r = r0 (1 + p d / D): life = D / (p r0) ln(1 + p)"""
    life = ALLOWED / RATE * np.log1p(part) / part
    return Plant("hardness gradient", lambda depth: RATE * (1.0 + part * depth / ALLOWED), life)


def running_in(part: float = 1.0, length: float = 0.2) -> Plant:
    """r = r0 (1 + p exp(-d/s)), s = length D: life = (D + s ln((1 + p exp(-D/s)) / (1 + p))) / r0"""
    s = length * ALLOWED
    life = (ALLOWED + s * np.log((1.0 + part * np.exp(-ALLOWED / s)) / (1.0 + part))) / RATE
    return Plant("running-in", lambda depth: RATE * (1.0 + part * np.exp(-depth / s)), life)


def layered(where: float = 0.43, times: float = 3.0) -> Plant:
    """A hard layer on a soft one: r0 down to d1, then `times` as fast: life = (d1 + (D - d1) / times) / r0"""
    border = where * ALLOWED
    life = (border + (ALLOWED - border) / times) / RATE
    return Plant("layered", lambda depth: RATE * np.where(depth < border, 1.0, times), life)


def oscillating(part: float = 0.5, bands: int = 2) -> Plant:
    """Bands of harder and softer metal, r = r0 / (1 + p sin(2 pi n d/D)), n whole: life = D / r0"""

    def law(depth: np.ndarray) -> np.ndarray:
        return RATE / (1.0 + part * np.sin(2.0 * np.pi * bands * depth / ALLOWED))

    return Plant("oscillating hardness", law, ALLOWED / RATE)


def beyond_threshold(start: float = 0.5, part: float = 3.0) -> Plant:
    """r0 down to the depth c D, r0 (1 + p (d/D - c)) beyond: life = D / r0 (c + ln(1 + p (1 - c)) / p)"""
    life = ALLOWED / RATE * (start + np.log1p(part * (1.0 - start)) / part)

    def law(depth: np.ndarray) -> np.ndarray:
        return RATE * (1.0 + part * np.maximum(depth / ALLOWED - start, 0.0))

    return Plant("accelerating beyond a threshold", law, life)


def alike(facets: int = 64) -> Plant:
    """A plate that wears evenly, each facet with noise of its own"""
    return Plant("equal facets", lambda depth: np.full(facets, RATE), ALLOWED / RATE, facets)


def nearly_alike(spread: float, seed: int, facets: int = 64) -> Plant:
    """A plate whose facets wear at rates that scatter by a small part of them, each facet with noise of its own"""
    rate = RATE * np.exp(spread * np.random.default_rng([seed, facets]).normal(size=facets))
    name = f"facets that differ by {spread:.0%}"
    return Plant(name, lambda depth: rate.copy(), ALLOWED / float(rate.max()), facets)


def field_with_feedback(facets: int = 200) -> Plant:
    """A pocket on a chute of 200 facets: what has worn around speeds the flow up there, what stands out wears faster."""
    x = np.linspace(0.0, 2.0, facets)
    base = RATE * (0.3 + 0.7 * np.exp(-0.5 * ((x - 0.8) / 0.25) ** 2))
    wide, narrow = _smoothing(x, 0.15), _smoothing(x, 0.03)

    def law(depth: np.ndarray) -> np.ndarray:
        around = wide @ depth / ALLOWED
        return base * np.exp(1.2 * around) * np.maximum(1.0 - 2.0 * (depth / ALLOWED - around), 0.0)

    span = (0.0, 5.0 * ALLOWED / RATE)
    truth = solve_ivp(lambda _, d: law(d), span, np.zeros(facets), events=WornOut(), rtol=1e-9, atol=1e-12)
    return Plant("field with feedback", law, float(truth.t_events[0][0]), facets, spread=narrow)


def _smoothing(x: np.ndarray, length: float) -> np.ndarray:
    weight = np.exp(-0.5 * ((x[:, None] - x) / length) ** 2)
    return weight / weight.sum(axis=1, keepdims=True)


def known(plant: Plant) -> Plant:
    """The plant whose law is one of its metal, and told by the case: of an even flow nothing is left to be learnt."""
    metal = Metal.through(lambda depth: plant.law(depth) / RATE, 2.0 * ALLOWED, np.zeros(plant.facets))
    return replace(plant, name=f"{plant.name}, known", metal=metal)


def seen_through_noise(plant: Plant, noise: float = 0.3, memory: float = 0.5, delay: float = 1.0) -> Plant:
    """The plant as a sampled flow shows it"""
    if len(plant.spread):  # the noise of a facet is meant after smoothing
        noise = noise / float(np.sqrt(np.square(plant.spread).sum(axis=1).mean()))
    return replace(plant, noise=noise, memory=memory, delay=delay)
