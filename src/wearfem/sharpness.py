"""How much sharper the wear of a run may be than its smoothing shows it: the deepest rate with less smoothing, free of what noise adds.

Smoothing over a length l keeps noise from being carved into a liner, and it flattens what is sharp: a wave of wave number k to
1 / (1 + l^2 k^2), a band of width b to 1 - exp(-b / 2l) in its middle. How much it took off the deepest rate is told by the loads that the
run has kept. Why it is so: docs/decisions/0012-forecasts.md.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from wearfem.errors import in_words
from wearfem.history import History
from wearfem.known import AsWorn
from wearfem.liner.liner import wear_surface
from wearfem.units import day, mm
from wearfem.wear.effect import Smooth, smoothed_with_effects
from wearfem.wear.smooth import filter_over

if TYPE_CHECKING:
    from wearfem.case import LifeCase

PARTS = (0.5, 0.25, 0.0)  # of the smoothing length; 0: each facet stands for itself
FEWEST = 6  # samples: two halves of three


@dataclass(frozen=True)
class Sharpness:
    """The deepest rate as a run smoothed it, over what it is with less smoothing."""

    length: float  # [m] of the run
    over: np.ndarray  # (n,) [m] shorter ones; 0 where each facet stands for itself
    kept: np.ndarray  # (n,) [-] deepest rate of the run over that one; 1 where the wear is smooth
    error: np.ndarray  # (n,) [-] standard error of `kept`, by sampling

    def words(self, life: float) -> str:
        """What that does to a life [s], in words"""
        shorter = in_words([f"{over / mm:.3g}" for over in self.over])
        lost = in_words(
            [
                f"{(kept - 1.0) * life / day:+.1f} +- {error * life / day:.1f}"
                for kept, error in zip(self.kept, self.error, strict=True)
            ]
        )
        return (
            f"smoothing, no part of the interval: {lost} d (one standard error), had the same loads been smoothed over {shorter} mm "
            f"instead of {self.length / mm:.3g} mm"
        )


def sharpness(
    history: History, case: "LifeCase | None", facet: np.ndarray, allowed: np.ndarray
) -> Sharpness | None:
    """How much of the deepest rate, over the depth allowed, the smoothing of a run has kept.

    The deepest of many noisy rates is too deep, and the more so the less they are smoothed. So the place is taken from one half of the
    samples and the rate there from the other half, and the other way round: at a place that noise alone has chosen, the other half sees
    an ordinary rate. What is told is therefore too little rather than too much. The standard error is by how much samples differ.

    Parameters
    ----------
    history, case
        A run, and its case with law, effects and smoothing length.
    facet, allowed
        (k,) facets, and (k,) [m] what each may lose.

    Returns
    -------
    Sharpness or None
        None without smoothing or without the case, for fewer than six samples, and where the mesh has changed.

    Notes
    -----
    By the rates alone, over the shapes of this run: what sharper wear would do to the shape, and that to the flow, is not in it.
    Nothing is seen that is sharper than facets; that is for a study over the mesh.

    Source: sample splitting, D. R. Cox, Biometrika 62 (1975) 441-444.
    Valid for: a deepest place that stays; where it wanders over a life, less is told.
    """
    kept = [report for report in history.reports if report.kept]
    same = all(len(report.depth) == len(history.area) for report in kept)
    if case is None or not case.smoothing_length > 0.0 or len(kept) < FEWEST or not same:
        return None
    length = case.smoothing_length
    surface = wear_surface((history.state.kept or history.state.now).liner)
    step = np.diff(history.service_time)
    weight = 0.5 * (np.append(0.0, step) + np.append(step, step[-1]))  # [s] that each sample stands for
    over = np.array(PARTS) * length

    def deepest_of(length: float) -> np.ndarray:
        return deepest(rates(history, case, filter_over(surface, length))[:, facet] / allowed, weight)

    smoothed = deepest_of(length)
    told = [_quotient(smoothed, deepest_of(one), weight) for one in over.tolist()]
    return Sharpness(length, over, *np.array(told).T)


def _quotient(top: np.ndarray, bottom: np.ndarray, weight: np.ndarray) -> tuple[float, float]:
    """Of weighted means (n,), and its standard error to first order: by how much single samples differ from it"""
    value = float(weight @ top / (weight @ bottom))
    off = top - value * bottom
    spread = np.square(weight * off).sum() * len(weight) / (len(weight) - 1)
    return value, float(np.sqrt(spread) / (weight @ bottom))


def rates(history: History, case: "LifeCase", smooth: Smooth) -> np.ndarray:
    """(n, f) [m/s] of each sample kept, by law and effects, smoothed in this way"""
    mesh, rows = (history.state.kept or history.state.now).liner.mesh, []
    for report in history.reports:
        if report.kept:
            there: Any = AsWorn(mesh, report.depth, report.service_time, report.throughput)
            rate = case.wear_law.depth_rate(report.loads, there)
            rows.append(smoothed_with_effects(rate, case.effects, report.loads, there, smooth)[0])
    return np.array(rows)


def deepest(rate: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """(n,) of the rates (n, k) of each sample, the one at the place where the mean of the other half of the samples is largest.

    The halves take turns along the life, so that both see all of it. Means are weighted (n,).
    """
    found = np.empty(len(rate))
    for half in (0, 1):
        other = weight[1 - half :: 2] @ rate[1 - half :: 2]
        found[half::2] = rate[half::2, np.argmax(other)]
    return found


def of_whole_face(history: History, case: "LifeCase | None") -> Sharpness | None:
    """`sharpness` of all facets that have a limit and wear"""
    limited = np.isfinite(history.allowed_depth) & (history.rate > 0.0).all(axis=0)
    facet = np.flatnonzero(limited)
    return sharpness(history, case, facet, history.allowed_depth[facet]) if len(facet) else None
