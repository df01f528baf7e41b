"""Studies: converged answers and orders of integrals known in closed form, how often their error and noise hold, and even points."""

from collections.abc import Callable, Iterator
from math import log

import numpy as np
from scipy.stats import qmc

from wearfem.convergence import converged
from wearfem.plan import Range, latin, sobol
from wearfem.proof import Claim

LIFE = 10.0 + 2.0 * log(
    (1.0 + np.exp(-5.0)) / 2.0
)  # of a plate that runs in: D + s ln((1 + A exp(-D/s)) / (1 + A)), D = 10, s = 2, A = 1
SETS = 400  # of noisy results
NOISE = 2e-3  # [-] of them


def claims() -> Iterator[Claim]:
    """Orders and answers of three rules of quadrature for one life, noise, then the spread of the points."""
    parts = np.array([16, 24, 32])
    for name, rule, order in (
        ("left end", _left, 1.0),
        ("trapezoid", _trapezoid, 2.0),
        ("Simpson", _simpson, 4.0),
    ):
        value = np.array([rule(count) for count in parts])
        told = converged(1.0 / parts, value, formal_order=order)
        finest = abs(value[-1] - LIFE)
        yield Claim(
            f"observed order, {name} rule on 16, 24 and 32 parts", "order of the rule", order, told.order, "-", 0.05, False,
            "the next term of the error bends the order by some percent",
        )  # fmt: skip
        yield Claim(
            f"error of the converged answer over that of the finest, {name} rule", "integral of 1/rate in closed form", 0.0,
            abs(told.value - LIFE) / finest, "-", 0.1, False, "extrapolation takes off the leading term: a tenth is left at most",
        )  # fmt: skip
        yield Claim(
            f"error promised of the finest over its true error, {name} rule", "1.25, Roache's factor", 1.25, told.error / finest, "-",
            0.1, True, "the same tenth",
        )  # fmt: skip
    yield from _noisy()
    yield from _even()


def _noisy() -> Iterator[Claim]:
    """Sets of five noisy results of known order: the noise told of the answer against its scatter."""
    draw = np.random.default_rng(7)
    h = np.array([1.0, 0.7, 0.5, 0.35, 0.25])
    exact = 3.0 + h**2
    told = [converged(h, exact + NOISE * draw.standard_normal(len(h)), NOISE) for _ in range(SETS)]
    inside = np.mean([abs(one.value - 3.0) <= 1.96 * one.noise for one in told])
    yield Claim(
        "share of answers within 1.96 standard errors of the truth", "95 % of a normal distribution", 0.95, float(inside), "-",
        3.0 * float(np.sqrt(0.95 * 0.05 / SETS)), False, f"three standard errors of a share of {SETS}; the fit is not quite linear",
    )  # fmt: skip
    flat = [converged(h, 3.0 + NOISE * draw.standard_normal(len(h)), NOISE) for _ in range(SETS)]
    seen = np.mean([one.order == one.order for one in flat])
    yield Claim(
        "share of results without any order where one is seen", "5 % level of the chi-squared test", 0.05, float(seen), "-",
        3.0 * float(np.sqrt(0.95 * 0.05 / SETS)), False, f"three standard errors of a share of {SETS}",
    )  # fmt: skip


def _even() -> Iterator[Claim]:
    """Points of a plan fill each range evenly."""
    ranges = {"a": Range(2.0, 6.0), "b": Range(-1.0, 1.0), "c": Range(0.0, 1e-3)}
    for name, spread, count in (("Latin hypercube", latin, 20), ("Sobol sequence", sobol, 32)):
        rows = spread(ranges, count, seed=3)
        low, high = (np.array([getattr(one, end) for one in ranges.values()]) for end in ("low", "high"))
        unit = (np.array([tuple(row.values()) for row in rows], dtype=float) - low) / (high - low)
        met = min(len(np.unique((column * count).astype(int))) for column in unit.T)
        yield Claim(
            f"parts of each range met by {count} points, {name}", "one point in each part, in every direction", float(count),
            float(met), "-", 0.0, False,
        )  # fmt: skip
        if name == "Sobol sequence":
            random = np.mean(
                [qmc.discrepancy(np.random.default_rng(seed).random(unit.shape)) for seed in range(20)]
            )
            yield Claim(
                "discrepancy over that of random points, Sobol sequence", "none: lower is more even", 0.0,
                float(qmc.discrepancy(unit) / random), "-", float("inf"), False,
            )  # fmt: skip


def _slowness(depth: np.ndarray) -> np.ndarray:
    """1/rate by depth of a plate that runs in."""
    return 1.0 / (1.0 + np.exp(-depth / 2.0))


def _rule(count: int, weights: Callable[[int], np.ndarray]) -> float:
    depth = np.linspace(0.0, 10.0, count + 1)
    return float(weights(count) @ _slowness(depth) * 10.0 / count)


def _left(count: int) -> float:
    return _rule(count, lambda n: np.append(np.ones(n), 0.0))


def _trapezoid(count: int) -> float:
    return _rule(count, lambda n: np.concatenate([[0.5], np.ones(n - 1), [0.5]]))


def _simpson(count: int) -> float:
    return _rule(count, lambda n: np.concatenate([[1.0], np.tile([4.0, 2.0], n // 2)[:-1], [1.0]]) / 3.0)
