"""What a case knows beforehand of how its liner will wear: what its effects do as the facets get deeper and time goes on.

A facet wears as  dd/dt = E(d) T(t) x what the flow does,  with the factors E and T of the effects (hardness through the thickness, layers,
running-in; a change of ore at a date). In the plain depth p and the plain time q,

    p = int_0^d dd / E(d),        q = int T dt,        dp/dq = what the flow does alone,

nothing is left of them. So what is known of the metal and of the calendar is integrated, and no part of what has to be learnt from samples.
Why it is so: docs/decisions/0012-forecasts.md.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from wearfem.case import LifeCase
from wearfem.liner.liner import Liner, wear_surface
from wearfem.loads import FacetLoads
from wearfem.wear.effect import on_the_flow, on_the_metal
from wearfem.wear.smooth import filter_over

ROWS = 2000  # of depths in a table: a layer is met within a part of a thousand
LEAST = 1e-6  # [-] of a factor: what never wears is never worn out


@dataclass(frozen=True)
class AsWorn:
    """What effects may know of a liner, at depths and times that it has not come to yet."""

    mesh: Any
    depth: np.ndarray  # (g, f) [m]
    service_time: float  # [s]
    throughput: float  # [kg]


class KnownEffects:
    """The effects of a case under the loads of one sample, at depths and times to come.

    Parameters
    ----------
    case, liner, loads
        With its effects; as it is now; of the last sample.
    worn
        (f,) [m] d of that liner. Where d is 0 p grows as fast as d, so that facets worn alike stay alike.
    """

    def __init__(self, case: LifeCase, liner: Liner, loads: FacetLoads, worn: np.ndarray) -> None:
        self.case, self.liner, self.loads = case, liner, loads
        self.law = case.wear_law.depth_rate(loads, liner)
        self.smooth = filter_over(wear_surface(liner), case.smoothing_length)
        self.plain = self.smooth(self.law)
        self.begun = liner.depth - worn
        self.new = self._factors(self.begun[None], liner.service_time)

    def _factors(self, depth: np.ndarray, service_time: float) -> np.ndarray:
        """(g, f) [-] by which the effects multiply the rates of facets at depths (g, f) [m]; 1 where nothing wears"""
        liner, effects = self.liner, self.case.effects
        passed = liner.throughput + (service_time - liner.service_time) * self.case.throughput_rate
        there: Any = AsWorn(liner.mesh, depth, service_time, passed)
        rate = self.smooth(on_the_flow(self.law, effects, self.loads, there))
        rate = on_the_metal(np.repeat(rate, len(depth), axis=0), effects, self.loads, there)
        plain = np.broadcast_to(self.plain, rate.shape)
        return np.divide(np.maximum(rate, LEAST * plain), plain, out=np.ones_like(rate), where=plain > 0.0)

    def at(self, depth: np.ndarray) -> np.ndarray:
        """(g, f) [-] E at depths d (g, f) [m], over that where d is 0, at the present time"""
        return self._factors(self.begun + depth, self.liner.service_time) / self.new

    def by_depth(self, reach: np.ndarray) -> "PlainDepth":
        """The table of p over d to `reach` (f,) [m]"""
        step = np.where(reach > 0.0, reach, 1.0) / ROWS
        factor = self.at((np.arange(ROWS)[:, None] + 0.5) * step)
        return PlainDepth(step, np.concatenate([np.zeros((1, len(step))), np.cumsum(step / factor, axis=0)]))

    def in_time(self, service_time: np.ndarray) -> np.ndarray:
        """(g, f) [-] T at times (g,) [s], over that of now, at the present depth"""
        depth = self.liner.depth[None]
        now = self._factors(depth, self.liner.service_time)
        return np.array([(self._factors(depth, time) / now)[0] for time in service_time.tolist()])


@dataclass(frozen=True)
class PlainDepth:
    """A table of p over d for each facet, and back; straight lines between its rows and beyond its last."""

    step: np.ndarray  # (f,) [m] of d from row to row
    plain: np.ndarray  # (g, f) [m] p at d = 0, step, 2 step ...

    @classmethod
    def same(cls, facets: int) -> "PlainDepth":
        """p = d, where nothing is known"""
        return cls(np.ones(facets), np.array([[0.0], [1.0]]) * np.ones(facets))

    def of(self, facet: np.ndarray) -> "PlainDepth":
        """That of some of the facets (k,)"""
        return PlainDepth(self.step[facet], self.plain[:, facet])

    def without(self, depth: np.ndarray) -> np.ndarray:
        """(..., f) [m] p of d; infinite where that is"""
        place = np.minimum(depth / self.step, 1e9)
        low, high = self._ends(place)
        row = np.clip(place.astype(int), 0, len(self.plain) - 2)
        return np.where(np.isfinite(depth), low + (place - row) * (high - low), np.inf)

    def depth(self, plain: np.ndarray) -> np.ndarray:
        """(f,) [m] d of p"""
        row = np.clip((self.plain <= plain).sum(axis=0) - 1, 0, len(self.plain) - 2)
        low, high = self._ends(row)
        return self.step * (row + (plain - low) / (high - low))

    def _ends(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(..., f) [m] p at the rows before and after"""
        row, facet = np.clip(place.astype(int), 0, len(self.plain) - 2), np.arange(len(self.step))
        return self.plain[row, facet], self.plain[row + 1, facet]
