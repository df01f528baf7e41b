"""Jumps: closed forms, the order in time, what the controller promises, and what a life costs beside constant multipliers."""

from collections.abc import Callable, Iterable, Iterator, Sequence
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
    known,
    layered,
    running_in,
    seen_through_noise,
)

SEEDS = 20
FORMULAS: tuple[Callable[[], Plant], ...] = (growing, falling, gradient, running_in, layered)
METALS = (gradient, running_in, layered)
TOLERANCES = (0.028, 0.02, 0.014)
NEAR = (0.5, 0.7, 1.0, 1.4)  # parts of the multiplier that spends the floor
CONFIDENCE = 0.9
NOISES = (0.1, 0.3)  # [-] of a block of 0.25 s: 1 and 9 s of flow for 5 %


def claims() -> Iterator[Claim]:
    """Closed forms and order without noise; error promised and cost where noise is little. `everything` does it for all."""
    yield from closed_forms()
    yield from order((falling(),), (40, 80))
    plants = [seen_through_noise(make(), NOISES[0]) for make in (growing, falling, gradient, running_in)]
    yield from promises(plants)
    yield from costs(seen_through_noise(known(gradient()), NOISES[1]))


def everything() -> Iterator[Claim]:
    """The same for every plant with little and with much noise: minutes"""
    yield from closed_forms()
    yield from order((growing(), falling(), field_with_feedback()), (80, 160))
    yield from promises(noisy_plants())
    for plant in (*(make() for make in (gradient, growing, layered)), known(gradient()), known(layered())):
        yield from costs(seen_through_noise(plant, NOISES[1]))


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
    """Every plant with little and with much noise; metals as laws of a flow too, that nobody is told of"""
    plants = (*(make() for make in (*FORMULAS, field_with_feedback)), *(known(make()) for make in METALS))
    return [seen_through_noise(plant, noise) for plant in plants for noise in NOISES]


def promise(plant: Plant, seeds: int = SEEDS) -> tuple[float, float]:
    """Root mean squares of the error promised and of the true one, both over the life [-]"""
    lives = [by_jumps(plant, plant.goal, seed) for seed in range(seeds)]
    told = [lived.told.error() / plant.life for lived in lives if lived.told]
    true = [lived.life / plant.life - 1.0 for lived in lives]
    return float(np.sqrt(np.mean(np.square(told)))), float(np.sqrt(np.mean(np.square(true))))


def floor(plant: Plant) -> float:
    """The seconds that noise alone demands at fixed geometry, and one warm-up of five delays"""
    goal = plant.goal
    return plant.noise_density * (goal.deviations / goal.tolerance) ** 2 + 5.0 * plant.delay


@dataclass(frozen=True)
class Way:
    """One way of going on at several settings: what its lives cost, and how far they are off."""

    name: str
    cost: np.ndarray  # (w, n) [s] of each life
    error: np.ndarray  # (w, n) [-] of each life, absolute

    @classmethod
    def of(cls, name: str, plant: Plant, settings: Iterable[Sequence[Lived]]) -> "Way":
        """From the lives (w) (n) at each setting."""
        lives = [list(some) for some in settings]
        cost = np.array([[lived.cost for lived in some] for some in lives])
        life = np.array([[lived.life for lived in some] for some in lives])
        return cls(name, cost, np.abs(life / plant.life - 1.0))

    @property
    def prices(self) -> np.ndarray:
        """(w, 2) mean cost [s], and the error that 90 % of the lives stay within [-]"""
        return np.column_stack([self.cost.mean(axis=1), np.quantile(self.error, CONFIDENCE, axis=1)])

    def at(self, settings: Sequence[int]) -> "Way":
        """Some of the settings, by their number"""
        return Way(self.name, self.cost[list(settings)], self.error[list(settings)])

    def cost_at(self, error: float) -> float:
        """[s] for which 90 % of the lives stay within the error: on a line through log cost and log error"""
        x, y = np.log(self.prices.T)
        slope, level = np.polyfit(x, y, 1)
        return float(np.exp((np.log(error) - level) / slope))

    def drawn_again(self, random: np.random.Generator) -> "Way":
        """As many lives, drawn from these: by how much figures differ is how well they are known (bootstrap)."""
        pick = random.integers(0, self.cost.shape[1], self.cost.shape)
        cost, error = (np.take_along_axis(one, pick, axis=1) for one in (self.cost, self.error))
        return Way(self.name, cost, error)


def by_tolerance(plant: Plant, tolerances: Sequence[float], seeds: Sequence[int]) -> Way:
    """The controller at several tolerances, without hand tuning"""
    goals = [replace(plant.goal, tolerance=tolerance) for tolerance in tolerances]
    return Way.of("wearfem", plant, ([by_jumps(plant, goal, seed) for seed in seeds] for goal in goals))


def by_multipliers(plant: Plant, parts: Sequence[float], lives: int, seed: int) -> tuple[Way, Way]:
    """Constant multipliers, as parts of the one that spends the floor: the geometry creeps, or goes in equal jumps"""
    values = plant.life / floor(plant) * np.asarray(parts)
    window = floor(plant) / 8.0
    return (
        Way.of("creeping", plant, (by_multiplier(plant, value, lives, seed) for value in values)),
        Way.of("equal jumps", plant, (by_equal_jumps(plant, value, window, lives, seed) for value in values)),
    )


@dataclass(frozen=True)
class Comparison:
    """What the controller costs beside the floor and beside the best multiplier found in hindsight, with standard errors."""

    error: tuple[float, float]  # [-] that 90 % of lives stay within at 2 %
    over_floor: tuple[float, float]
    as_run: tuple[float, float]  # beside the best multiplier at 2 %
    same_error: tuple[float, float]  # both at 2 %


def compare(plant: Plant, ours: Way, others: Sequence[Way], asked: int, draws: int = 200) -> Comparison:
    """At the tolerance that was asked for, the setting of that number in `ours`."""

    def figures(ours: Way, others: Sequence[Way]) -> list[float]:
        cost, error = ours.prices[asked].tolist()
        best = min(way.cost_at(plant.goal.tolerance) for way in others)
        return [error, cost / floor(plant), cost / best, ours.cost_at(plant.goal.tolerance) / best]

    random = np.random.default_rng(0)
    again = [
        figures(ours.drawn_again(random), [way.drawn_again(random) for way in others]) for _ in range(draws)
    ]
    told = zip(figures(ours, others), np.std(again, axis=0).tolist(), strict=True)
    return Comparison(*told)


def costs(plant: Plant, seeds: Sequence[int] = range(150)) -> Iterator[Claim]:
    """The controller without hand tuning beside the floor and the best constant multiplier in hindsight"""
    ours = by_tolerance(plant, TOLERANCES, seeds)
    found = compare(
        plant,
        ours,
        by_multipliers(plant, NEAR, 10 * len(seeds), seeds[0]),
        TOLERANCES.index(plant.goal.tolerance),
    )
    name = plant.name
    yield Claim(
        f"error that 90 % of {len(seeds)} lives stay within, {name}", "tolerance asked", plant.goal.tolerance, found.error[0], "-", 0.4,
        True, f"known to {found.error[1]:.2%} (one deviation)",
    )  # fmt: skip
    yield Claim(
        f"cost over the statistical floor, {name}", "at most 2 is asked", 1.0, found.over_floor[0], "-", 1.0, False,
        "floor: samples at fixed geometry and one warm-up",
    )  # fmt: skip
    yield Claim(
        f"cost over that of the best multiplier found in hindsight, {name}", "at most 1.2 is asked", 1.0, found.as_run[0], "-", 0.2,
        False, f"+- {found.as_run[1]:.2f}; the best of creeping and stepping multipliers, from fits to four prices each",
    )  # fmt: skip
    yield Claim(
        f"the same at the same error, {name}", "at most 1.2 is asked", 1.0, found.same_error[0], "-", np.inf, False,
        f"+- {found.same_error[1]:.2f}; from fits to both",
    )  # fmt: skip
