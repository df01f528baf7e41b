"""Forecasts of lives whose end is known: how often the 80 % interval holds it, and what many equal noisy facets do to it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import exp

import numpy as np
from scipy.integrate import quad

from wearfem.case import LifeCase, Stop
from wearfem.forecast import ZoneLife, forecast
from wearfem.formula import Sliding
from wearfem.history import History
from wearfem.proof import Claim
from wearfem.proofs._balls import brute_force, end_by_brute_force, plate_of_balls
from wearfem.proofs.cycle import ALLOWED, RATE, lived, plate
from wearfem.surface import Surface
from wearfem.units import day

GRADIENT, EXCESS, RUN_IN = 50.0, 1.0, 2e-3  # [1/m], [-], [m] of the case
PARTS = (0.3, 0.6)  # of the life, after which it is foretold
KINDS = ("constant", "hardness_gradient", "running_in", "unknown hardness", "power", "bulge", "settling")
NOISES = ((0.2, 0.0), (0.05, 0.2), (0.1, 0.1))  # [-] of a block: common to all facets, and of each by itself
DRAWS = 400
FIRST = 20000  # seed; nothing was developed on those from here on, nor on lives that settle


@dataclass(frozen=True)
class Feedback:
    """Loads that change as the plate sinks, by the depth u over the one allowed.

    q(u) = 1 + rise u^power + bulge sin(pi u) + settles (1 - exp(-u / within))
    """

    rise: float = 0.0
    power: float = 1.0
    bulge: float = 0.0
    settles: float = 0.0
    within: float = 1.0

    def of(self, u: float) -> float:
        """[-] at one depth"""
        rises = self.rise * u**self.power + self.bulge * float(np.sin(np.pi * u))
        return 1.0 + rises + self.settles * (1.0 - exp(-u / self.within))

    def __call__(self, surface: Surface) -> np.ndarray:
        """(f,) [-] of a plate whose face was at z = 0"""
        sunk = -float(surface.point[surface.triangle][:, :, 2].mean())
        return np.full(surface.facet_count, self.of(max(sunk / ALLOWED, 0.0)))


@dataclass(frozen=True)
class Synthetic:
    """A life on the plate with its end by quadrature of 1/r, and what a forecast may know of it."""

    name: str
    case: LifeCase
    told: bool  # whether the forecast is given the case with its effects
    end: float  # [s]


def synthetic(kind: str, seed: int, common: float, own: float, cells: int = 4) -> Synthetic:
    """A life of one kind with noise common to all facets and of each by itself, strengths drawn from the seed.

    `constant`, `hardness_gradient` and `running_in` are known to the forecast by the case; of `unknown hardness` it is given no case;
    `power`, `bulge` and `settling` are feedbacks of the geometry on the loads, which no forecast knows.
    """
    random = np.random.default_rng([seed, 77])
    law = {
        "unknown hardness": "hardness_gradient",
        "power": "constant",
        "bulge": "constant",
        "settling": "constant",
    }.get(kind, kind)
    feedback = {
        "power": Feedback(random.uniform(-0.6, 1.5), random.uniform(0.5, 2.0)),
        "bulge": Feedback(bulge=random.uniform(-0.5, 1.0)),
        "settling": Feedback(settles=random.uniform(-0.5, 1.0), within=random.uniform(0.1, 0.6)),
    }.get(kind, Feedback())
    case, _ = plate(law=law, seed=seed, cells=cells)
    assert isinstance(case.sampler, Sliding)
    sampler = replace(case.sampler, noise=common, facet_noise=own, intensity=feedback)
    factor = {
        "constant": lambda d: 1.0,
        "hardness_gradient": lambda d: 1.0 / (1.0 - GRADIENT * d),
        "running_in": lambda d: 1.0 + EXCESS * exp(-d / RUN_IN),
    }[law]
    end, _ = quad(lambda d: 1.0 / (RATE * factor(d) * feedback.of(d / ALLOWED)), 0.0, ALLOWED)
    return Synthetic(kind, replace(case, sampler=sampler), kind != "unknown hardness", end)


def so_far(life: Synthetic, part: float) -> History:
    """The life through the real cycle, to a part of it"""
    return lived(replace(life.case, stop=Stop(part * life.end)))


def foretold(life: Synthetic, part: float) -> ZoneLife:
    """Its forecast, to the depth that the case allows"""
    return forecast(so_far(life, part), case=life.case if life.told else None, draws=DRAWS).zone[0]


@dataclass(frozen=True)
class Told:
    """What one forecast told, beside the truth."""

    kind: str
    part: float
    rank: float  # [-] share of the draws that end before the truth does: evenly spread if the draws are right
    middle: float  # [-] middle of the draws over the truth
    straight_line: float  # [-]
    frozen: float  # [-]
    last_rate: float  # [-]


def told(lives: int, first: int = FIRST) -> list[Told]:
    """Forecasts of many lives: kinds, noises and parts of the life in turn, each with its own seed."""
    found = []
    for number in range(lives):
        turn = number // len(KINDS)
        kind, noise = KINDS[number % len(KINDS)], NOISES[turn % len(NOISES)]
        part = PARTS[turn // len(NOISES) % len(PARTS)]
        life = synthetic(kind, first + number, *noise)
        zone = foretold(life, part)
        beside = np.array([zone.quantile[1], zone.straight_line, zone.frozen, zone.last_rate]) / life.end
        found.append(Told(kind, part, float((zone.draw < life.end).mean()), *beside.tolist()))
    return found


def inside(found: list[Told]) -> float:
    """[-] share of the truths that lie in the 80 % interval"""
    return float(np.mean([0.1 < one.rank < 0.9 for one in found]))


def claims(lives: int = 42, equal: int = 6) -> Iterator[Claim]:
    """A few lives of each kind; the slow tests do 336."""
    yield from coverage(told(lives))
    yield from equal_facets(equal)


@dataclass(frozen=True)
class UnderParticles:
    """A life of the small plate under real particles, as it was foretold."""

    seed: int
    quantile: tuple[float, float, float]  # [s] 10, 50 and 90 % of the draws end before
    rank: float  # [-] share of the draws that end before brute force does


def ends_under_particles(seeds: Iterable[int], steps: int = 24, window: float = 2.0) -> list[float]:
    """[s] of the small plate by brute force, which owes nothing to jumps and forecasts; each some two minutes of one core"""
    return [end_by_brute_force(*brute_force(seed, steps, window)) for seed in seeds]


def under_particles(seed: int, end: float, stop: float = 30 * day) -> UnderParticles:
    """A life foretold at `stop` [s], beside the `end` [s]; about a minute of one core"""
    zone = forecast(lived(replace(plate_of_balls(seed), stop=Stop(stop))), draws=DRAWS).zone[0]
    low, middle, high = (float(time) for time in zone.quantile)
    return UnderParticles(seed, (low, middle, high), float((zone.draw < end).mean()))


def coverage(found: list[Told]) -> Iterator[Claim]:
    """How often the interval holds the truth, and how far off its middle is beside what planners use"""
    lives = len(found)
    chance = 2.0 * np.sqrt(0.8 * 0.2 / lives)
    yield Claim(
        f"share of {lives} lives whose end lies in the 80 % interval", "quadrature of 1/r over depth", 0.8, inside(found), "-",
        max(0.05, chance), False, f"75 to 85 % is asked; two deviations of a count of {lives} are {chance:.1%}",
    )  # fmt: skip
    for kind in KINDS:
        some = [one for one in found if one.kind == kind]
        yield Claim(
            f"the same of {len(some)} lives, {kind}", "quadrature of 1/r over depth", 0.8, inside(some), "-", np.inf, False
        )  # fmt: skip
    for part in PARTS:
        some = [one for one in found if one.part == part]
        middle, line, frozen, last = (
            float(np.sqrt(np.mean([(getattr(one, name) - 1.0) ** 2 for one in some])))
            for name in ("middle", "straight_line", "frozen", "last_rate")
        )
        yield Claim(
            f"error of the middle of the draws over that of the straight line, told at {part:.0%} of {len(some)} lives (rms)",
            "quadrature of 1/r over depth", 1.0, middle / line if line else 0.0, "-", np.inf, False,
            f"rms errors: middle {middle:.1%}, straight line {line:.1%}, frozen geometry {frozen:.1%}, last rate {last:.1%}",
        )  # fmt: skip


def unequal(life: Synthetic, differ: float, seed: int) -> Synthetic:
    """A life of facets whose loads differ for ever, ln q normal with a deviation `differ` [-]; the end is that of the most loaded one"""
    factor = np.exp(differ * np.random.default_rng([seed, 5]).normal(size=len(life.case.liner.mesh.wear)))
    assert isinstance(life.case.sampler, Sliding)
    sampler = replace(life.case.sampler, intensity=lambda surface: factor)
    return replace(life, case=replace(life.case, sampler=sampler), end=life.end / float(factor.max()))


def equal_facets(plates: int, first: int = FIRST + 5000, differ: float = 0.0) -> Iterator[Claim]:
    """64 facets that wear alike, each with noise of its own: the first to fail is not the one with the luckiest noise.

    With `differ` [-] above 0 their loads do differ, by so much (one deviation): then the first to fail is one that stands out, and what
    is told is shown, not judged.
    """
    ranks, middle, naive = [], [], []
    for seed in range(first, first + plates):
        life = unequal(synthetic("constant", seed, 0.0, 0.2, cells=8), differ, seed)
        history = so_far(life, 0.6)
        zone = forecast(history, case=life.case, draws=DRAWS).zone[0]
        ranks.append(float((zone.draw < life.end).mean()))
        middle.append(zone.quantile[1] / life.end - 1.0)
        naive.append(history.life[-1].time / life.end - 1.0)
    error = float(np.std(middle, ddof=1) / np.sqrt(plates))
    kind = f"64 facets that differ by {100.0 * differ:g} %" if differ else "64 equal facets"
    yield Claim(
        f"mean error of life, {plates} plates of {kind} with noise of their own", "depth over rate", 0.0, float(np.mean(middle)),
        "-", np.inf if differ else max(0.005, 3.0 * error), False,
        f"0.5 %, or three standard errors of this mean ({3.0 * error:.2%}); the least of the noisy lives errs by {np.mean(naive):+.1%}",
    )  # fmt: skip
    yield Claim(
        f"share of {plates} such lives in the 80 % interval", "depth over rate", 0.8,
        float(np.mean([0.1 < rank < 0.9 for rank in ranks])), "-", np.inf if differ else max(0.05, 2.0 * np.sqrt(0.16 / plates)), False,
        "two deviations of the count",
    )  # fmt: skip
