"""Jumps: closed forms, the order in time, what the controller promises, and what a life costs beside constant multipliers."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wearfem.proof import Claim
from wearfem.proofs._plants import (
    Lived,
    Plant,
    by_equal_jumps,
    by_jumps,
    by_multiplier,
    falling,
    field_with_feedback,
    gradient,
    growing,
    layered,
    running_in,
    seen_through_noise,
)

SEEDS = 20
FORMULAS: tuple[Callable[[], Plant], ...] = (growing, falling, gradient, running_in, layered)
NOISES = (0.1, 0.3)  # [-] of a block of 0.25 s: 1 and 9 s of flow for 5 %


def claims() -> Iterator[Claim]:
    """Closed forms and order without noise; error promised and cost where noise is little. `everything` does it for all."""
    yield from closed_forms()
    yield from order((falling(),), (40, 80))
    plants = [seen_through_noise(make(), NOISES[0]) for make in (growing, falling, gradient, running_in)]
    yield from promises(plants)
    yield from costs(seen_through_noise(gradient(), NOISES[1]))


def everything() -> Iterator[Claim]:
    """The same for every plant with little and with much noise: minutes"""
    yield from closed_forms()
    yield from order((growing(), falling(), field_with_feedback()), (80, 160))
    yield from promises(noisy_plants())
    for make in (gradient, growing, layered):
        yield from costs(seen_through_noise(make(), NOISES[1]))


def promises(plants: Sequence[Plant]) -> Iterator[Claim]:
    """The error told beside the true one"""
    told = [promise(plant) for plant in plants]
    for plant, (promised, true) in zip(plants, told, strict=True):
        yield Claim(
            f"error told beside the true one, {plant.name}, noise {plant.noise:.2g}", f"rms of {SEEDS} lives", true, promised, "-",
            np.inf, True, "judged below, all together",
        )  # fmt: skip
    ratio = np.array(told)[:, 0] / np.array(told)[:, 1]
    yield Claim(
        "plants and noises with a promise within a factor 2 of the true error", "90 % asked", 1.0,
        float(((ratio > 0.5) & (ratio < 2.0)).mean()), "-", 0.1, False, "rms over seeds: one error alone is a draw",
    )  # fmt: skip


def closed_forms() -> Iterator[Claim]:
    """Lives by formula, 0.1 % asked of the jumps"""
    for plant in (*(make() for make in FORMULAS), field_with_feedback()):
        lived = by_jumps(plant, replace(plant.goal, tolerance=1e-3))
        source = "closed form" if plant.facets == 1 else "Runge-Kutta 45 at a tolerance of 1e-9"
        yield Claim(
            f"end of life, {plant.name}, no noise, {lived.cycles} cycles", source, plant.life, lived.life, "s", 1e-3, True,
            "0.1 % is asked and given to the controller as its tolerance",
        )  # fmt: skip


def order(plants: Sequence[Plant], counts: Sequence[int]) -> Iterator[Claim]:
    """Error over number of equal jumps, of the trapezoid rule and of the life told, from which its bias is taken"""
    for plant in plants:
        coarse, fine = (equal_jumps(plant, count) for count in counts)
        yield Claim(
            f"order in time, trapezoid rule, {plant.name}, {coarse.cycles} and {fine.cycles} samples", "second order", 2.0,
            observed_order(plant, coarse, fine, with_bias=True), "-", 0.25, False,
            "equal jumps; the number of samples is off by one or two",
        )  # fmt: skip
        one = plant.facets == 1
        yield Claim(
            f"the same less its bias, {plant.name}", "third order", 3.0, observed_order(plant, coarse, fine), "-",
            0.25 if one else np.inf, False, "as above" if one else "shown: the error is near that of the reference",
        )  # fmt: skip


def observed_order(plant: Plant, coarse: Lived, fine: Lived, with_bias: bool = False) -> float:
    """The power of the number of samples with which the error of life falls"""
    lives = [lived.life + (lived.told.bias if with_bias and lived.told else 0.0) for lived in (coarse, fine)]
    error = np.abs(np.array(lives) / plant.life - 1.0)
    return float(np.log(error[0] / error[1]) / np.log(fine.cycles / coarse.cycles))


def equal_jumps(plant: Plant, count: int) -> Lived:
    """A life in jumps of one length, which no tolerance shortens"""
    return by_jumps(plant, replace(plant.goal, tolerance=0.1 / count), at_most=plant.life / count)


def noisy_plants() -> list[Plant]:
    """Every plant with little and with much noise"""
    return [
        seen_through_noise(make(), noise) for make in (*FORMULAS, field_with_feedback) for noise in NOISES
    ]


def promise(plant: Plant, seeds: int = SEEDS) -> tuple[float, float]:
    """Root mean squares of the error promised and of the true one, both over the life [-]"""
    lives = [by_jumps(plant, plant.goal, seed) for seed in range(seeds)]
    told = [lived.told.error() / plant.life for lived in lives if lived.told]
    true = [lived.life / plant.life - 1.0 for lived in lives]
    return float(np.sqrt(np.mean(np.square(told)))), float(np.sqrt(np.mean(np.square(true))))


@dataclass(frozen=True)
class Price:
    """What one way of going on costs, and how well it knows the end of life."""

    cost: float  # [s] mean
    error: float  # [-] that `confidence` of the lives stay within


def price(lives: list[Lived], plant: Plant, confidence: float = 0.9) -> Price:
    """Mean cost, and the quantile of the error over the lives"""
    error = np.abs([lived.life / plant.life - 1.0 for lived in lives])
    return Price(float(np.mean([lived.cost for lived in lives])), float(np.quantile(error, confidence)))


def floor(plant: Plant) -> float:
    """The seconds that noise alone demands at fixed geometry, and one warm-up of five delays"""
    goal = plant.goal
    return plant.noise_density * (goal.deviations / goal.tolerance) ** 2 + 5.0 * plant.delay


def sweep(
    plant: Plant, way: Callable[[float, int], Lived], multipliers: np.ndarray, seeds: int
) -> list[Price]:
    """Prices of one way at each multiplier"""
    return [price([way(value, seed) for seed in range(seeds)], plant) for value in multipliers]


def multipliers(plant: Plant, count: int = 9) -> np.ndarray:
    """Two decades around the one that spends the floor"""
    return plant.life / floor(plant) * np.logspace(-1.0, 1.0, count)


def cost_at(prices: list[Price], error: float) -> float:
    """The cost at which the error is reached, on a line through log cost and log error: error = a cost^-b"""
    x, y = np.log([[one.cost, one.error] for one in prices]).T
    slope, level = np.polyfit(x, y, 1)
    return float(np.exp((np.log(error) - level) / slope))


def costs(plant: Plant, seeds: int = SEEDS) -> Iterator[Claim]:
    """The controller without hand tuning beside the floor and the best constant multiplier in hindsight"""
    ours = price([by_jumps(plant, plant.goal, seed) for seed in range(seeds)], plant)
    name, tolerance = plant.name, plant.goal.tolerance
    yield Claim(
        f"error that 90 % of lives stay within, {name}", "tolerance asked", tolerance, ours.error, "-", 0.4, True,
        f"the 90 % quantile of {seeds} lives is itself known to 20 % (one deviation)",
    )  # fmt: skip
    yield Claim(
        f"cost over the statistical floor, {name}", "at most 2 is asked", 1.0, ours.cost / floor(plant), "-", 1.0, False,
        "floor: samples at fixed geometry and one warm-up",
    )  # fmt: skip
    near = plant.life / floor(plant) * np.array([0.5, 0.7, 1.0, 1.4])
    smooth = sweep(plant, lambda m, seed: by_multiplier(plant, m, seed), near, seeds)
    window = floor(plant) / 8.0
    steps = sweep(plant, lambda m, seed: by_equal_jumps(plant, m, window, seed), near, seeds)
    best = min(cost_at(smooth, tolerance), cost_at(steps, tolerance))
    yield Claim(
        f"cost over that of the best multiplier found in hindsight, {name}", "at most 1.2 is asked", 1.0, ours.cost / best, "-", 0.2,
        False, "the best of creeping and stepping multipliers, from fits to four prices each",
    )  # fmt: skip
    same = ours.cost * (ours.error / tolerance) ** 2
    yield Claim(
        f"the same at the same error, {name}", "at most 1.2 is asked", 1.0, same / best, "-", np.inf, False,
        "our cost times (error / tolerance)^2, as noise has it; the quantile's own 20 % is 40 % of cost",
    )  # fmt: skip
