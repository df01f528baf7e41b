"""The metal through its depth, so far as a case knows it: plain depths, in which nothing of that knowledge is left.

Where the metal wears E(d) times as fast as the flow alone would have it (hardness through the thickness, layers, running-in),

    dd/dt = E(d) x what the flow does,        p = int_0^d dd / E(d),        dp/dt = what the flow does.

So jumps are chosen and lives are told in p: what is known of the metal is integrated and costs no samples. No more is done than to measure
the same depth in another way: were E wrong, rates over E would bend, and jumps be as short as that demands.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wearfem.wear.effect import Effect, FactorEffect, acts_by_depth_alone, all_factors
from wearfem.wear.sampling import Sample

CELLS = 1024  # of depth, that the table begins with
CHANGE = 0.01  # [-] of 1 / E from row to row; where it changes by more a cell is halved
HALVINGS = 30  # at most: a border between layers is met within 1e-12 of the reach
LEAST = 1e-6  # [-] of E: what never wears is never worn out
BEYOND = 1e6  # reaches to which E is taken to stay what it is at the end of the table


@dataclass(frozen=True)
class Metal:
    """A table over depth, and the depths at which facets began."""

    depth: np.ndarray  # (g,) [m] since the liner was new, rising from 0
    slowness: np.ndarray  # (g,) [-] 1 / E there
    plain: np.ndarray  # (g,) [m] p there
    begun: np.ndarray  # (f,) [m] of the facets at the first sample, from which on d and p are counted

    @classmethod
    def through(cls, factor: Callable[[np.ndarray], np.ndarray], reach: float, begun: np.ndarray) -> "Metal":
        """The table of E = `factor` of the depth (g,) [m], down to `reach` [m].

        **Valid for** layers above a thousandth of the reach: thinner ones may be missed.
        """

        def slowness_at(depth: np.ndarray) -> np.ndarray:
            return 1.0 / np.maximum(factor(depth) * np.ones_like(depth), LEAST)

        depth = np.linspace(0.0, reach, CELLS + 1)
        slowness = slowness_at(depth)
        for _ in range(HALVINGS):
            low, high = slowness[:-1], slowness[1:]
            uneven = np.flatnonzero(np.abs(high - low) > CHANGE * np.minimum(low, high))
            between = 0.5 * (depth[uneven] + depth[uneven + 1])
            depth = np.insert(depth, uneven + 1, between)
            slowness = np.insert(slowness, uneven + 1, slowness_at(between))
        depth, slowness = np.append(depth, BEYOND * reach), np.append(slowness, slowness[-1])
        step = 0.5 * np.diff(depth) * (slowness[1:] + slowness[:-1])
        return cls(depth, slowness, np.append(0.0, np.cumsum(step)), begun)

    @classmethod
    def known_by(cls, effects: Sequence[Effect], begun: np.ndarray, allowed: np.ndarray) -> "Metal | None":
        """What effects say of the metal by depth alone, to twice the depths allowed (f,) [m]; None where they say nothing."""
        known = [one for one in effects if isinstance(one, FactorEffect) and acts_by_depth_alone(one)]
        if not known:
            return None
        reach = 2.0 * float(np.max((begun + allowed)[np.isfinite(allowed)]))
        return cls.through(lambda depth: all_factors(known, {"depth": depth}), reach, begun)

    def plain_of(self, depth: np.ndarray) -> np.ndarray:
        """(f,) [m] p of d; infinite where that is"""
        plain = np.interp(self.begun + depth, self.depth, self.plain) - self._plain_begun
        return np.where(np.isfinite(depth), plain, np.inf)

    def depth_of(self, plain: np.ndarray) -> np.ndarray:
        """(f,) [m] d of p"""
        return np.interp(self._plain_begun + plain, self.plain, self.depth) - self.begun

    def factor(self, depth: np.ndarray) -> np.ndarray:
        """(f,) [-] E at d [m]"""
        return 1.0 / np.interp(self.begun + depth, self.depth, self.slowness)

    @property
    def _plain_begun(self) -> np.ndarray:
        return np.interp(self.begun, self.depth, self.plain)


def in_plain_depths(samples: Sequence[Sample], metal: Metal | None) -> Sequence[Sample]:
    """The samples as they would be on a metal that is the same at all depths; as they are where nothing is known of it."""
    return samples if metal is None else [_plain(sample, metal) for sample in samples]


def _plain(sample: Sample, metal: Metal) -> Sample:
    assert sample.depth is not None  # whoever knows the metal tells where in it a sample was taken
    return replace(sample, rate=sample.rate / metal.factor(sample.depth), depth=metal.plain_of(sample.depth))
