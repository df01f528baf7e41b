"""How much sharper the wear of a run may be than its smoothing lets it be: the deepest rate, smoothed over less, free of noise.

Smoothing over a length l keeps noise from being carved into a liner, and flattens what is sharp: a wave of wave number k to 1 / (1 + l^2 k^2), a
band of width b to 1 - exp(-b / 2l) in its middle. What it did can be told from the loads that a run has kept, without another one.
Docs: docs/decisions/0012-forecasts.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wearfem.case import LifeCase
from wearfem.history import History
from wearfem.known import AsWorn
from wearfem.liner.liner import wear_surface
from wearfem.wear.smooth import HelmholtzFilter

PARTS = (0.5, 0.25, 0.0)  # of the smoothing length; 0: a facet stands for itself
FEWEST = 6  # samples: two halves, of which one is left out in turn


@dataclass(frozen=True)
class Sharpness:
    """The deepest rate with the smoothing of the case, over that with less of it."""

    length: float  # [m] smoothing length of the case
    over: float  # [m] the shorter one, at which the deepest rate is largest
    kept: float  # [-] 1 where the wear is smooth
    error: float  # [-] standard error of `kept`, by sampling


def sharpness(
    history: History, case: LifeCase | None, facet: np.ndarray, allowed: np.ndarray
) -> Sharpness | None:
    """How much of the deepest rate, over the depth allowed, the smoothing of a run has kept.

    The least of many noisy lives is too short, and the more so the less they are smoothed. So the place is taken from one half of the samples and
    the rate there from the other, and the other way round: at a place that only noise has chosen, the rate of the other half is an
    ordinary one. What is told is therefore rather too little than too much. The standard error leaves out one sample after the other.

    Parameters
    ----------
    history, case
        A run, and its case with law, effects and smoothing length.
    facet, allowed
        (k,) facets of a zone, and (k,) [m] what each may lose.

    Returns
    -------
    Sharpness or None
        None without smoothing, for fewer than six samples, and where the mesh has changed.

    Notes
    -----
    By rates alone, over the shapes of this run: what a sharper wear would do to the shape, and that to the flow, is not in it.
    Facets are as fine as it gets; what is sharper than they are is for a study of the mesh.
    Source: sample splitting, D. R. Cox, Biometrika 62 (1975) 441-444; the jackknife, B. Efron and C. Stein, Ann. Stat. 9 (1981) 586-596.
    Valid for: rates of a shape that keeps its deepest place; where that wanders, less is told.
    """
    kept = [report for report in history.reports if report.kept]
    facets = len(history.area)
    same = all(len(report.depth) == facets for report in kept)
    if case is None or not case.smoothing_length > 0.0 or len(kept) < FEWEST or not same:
        return None
    raw = raw_rates(history, case)
    liner = history.state.kept.liner if history.state.kept else history.state.now.liner
    surface = wear_surface(liner)
    step = np.diff(history.service_time)
    weight = 0.5 * (np.append(0.0, step) + np.append(step, step[-1]))
    length = case.smoothing_length

    def rate(part: float) -> np.ndarray:
        smoothed = HelmholtzFilter(surface, part * length)(raw) if part > 0.0 else raw
        return weight[:, None] * smoothed[:, facet] / allowed

    rates = [rate(part) for part in (1.0, *PARTS)]
    everyone = np.arange(len(kept))
    found = [deepest(one, weight, everyone) for one in rates]
    sharpest = 1 + int(np.argmax(found[1:]))
    told = min(found[0] / found[sharpest], 1.0)
    without = [np.delete(everyone, one) for one in everyone]
    again = np.array(
        [deepest(rates[0], weight, some) / deepest(rates[sharpest], weight, some) for some in without]
    )
    error = np.sqrt((len(again) - 1) * again.var())
    return Sharpness(length, PARTS[sharpest - 1] * length, float(told), float(error))


def raw_rates(history: History, case: LifeCase) -> np.ndarray:
    """(n, f) [m/s] of each sample by law and effects, before smoothing"""
    rows = []
    for report in history.reports:
        if report.kept:
            mesh: Any = (history.state.kept or history.state.now).liner.mesh
            there: Any = AsWorn(mesh, report.depth, report.service_time, report.throughput)
            rate = case.wear_law.depth_rate(report.loads, there)
            for effect in case.effects:
                rate = effect.modify(rate, report.loads, there)
            rows.append(rate[0])
    return np.array(rows)


def deepest(rate: np.ndarray, weight: np.ndarray, some: Sequence[int] | np.ndarray) -> float:
    """The largest of the mean rates (k,) of some samples, place and rate from different halves of them.

    `rate` (n, k) is weighted already; the halves take turns along the life, so that both see all of it.
    """
    halves = some[0::2], some[1::2]
    one, other = (rate[half].sum(axis=0) / weight[half].sum() for half in halves)
    return 0.5 * float(other[np.argmax(one)] + one[np.argmax(other)])
