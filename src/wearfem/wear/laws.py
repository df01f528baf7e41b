"""Wear laws: the rate of depth that facet loads make. Here the laws of sliding, and the sum of sliding and impact. [PLUG]

A law is a frozen dataclass of its coefficients with two formulas: `depth_rate`, the law itself, and `volume`, what all blocks
together remove. Both take `FacetLoads` alone, so a law is changed and fitted without running the particles again. The laws of
impact are in `impact_laws.py`.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from wearfem.errors import UserError
from wearfem.loads import FacetLoads


class WearLaw(Protocol):
    """What every wear law can do."""

    def depth_rate(self, loads: FacetLoads, liner: Any = None) -> np.ndarray:
        """(b, f) [m/s], never negative"""
        ...

    def volume(self, loads: FacetLoads) -> np.ndarray:
        """(f,) [m3] what all blocks together remove"""
        ...


@dataclass(frozen=True)
class Archard:
    """Volume in proportion to normal force and sliding distance: dV = k F_n |v_t| dt, so depth rate = k p |v_t|.

    **Source** Archard, J. Appl. Phys. 24 (1953) 981-988, with k = K/H.
    **Valid for** steady two-body sliding of a hard body on a softer surface whose hardness stays the same; k belongs to one pair of
    materials, one shape of particle and a range of pressure and speed. Impacts without sliding wear nothing.
    """

    specific_wear_rate: float  # [m2/N] k

    def __post_init__(self) -> None:
        require_number("specific_wear_rate", self.specific_wear_rate, "m2/N")

    def depth_rate(self, loads: FacetLoads, liner: Any = None) -> np.ndarray:
        """(b, f) [m/s] k (sum F_n |v_t| dt) / (A T)"""
        return self.specific_wear_rate * per_area_and_time(loads.load_distance, loads)

    def volume(self, loads: FacetLoads) -> np.ndarray:
        """(f,) [m3] k sum F_n |v_t| dt"""
        return self.specific_wear_rate * loads.load_distance.sum(axis=0)


@dataclass(frozen=True)
class ShearWork:
    """Volume in proportion to the work of friction: dV = c dW_friction.

    **Source** Fouvry, Kapsa and Vincent, Wear 200 (1996) 186-205 (energy wear coefficient); Cleary, Minerals Engineering 11 (1998)
    1061-1080, uses shear work for mill liners. **Valid for** sliding wear where friction does the damage; with one coefficient of friction
    and gross sliding it is `Archard` with k = c mu. What a contact loses in its dashpots is not friction.
    """

    volume_per_work: float  # [m3/J] c

    def __post_init__(self) -> None:
        require_number("volume_per_work", self.volume_per_work, "m3/J")

    def depth_rate(self, loads: FacetLoads, liner: Any = None) -> np.ndarray:
        """(b, f) [m/s] c W / (A T)"""
        return self.volume_per_work * per_area_and_time(loads.friction_work, loads)

    def volume(self, loads: FacetLoads) -> np.ndarray:
        """(f,) [m3] c W"""
        return self.volume_per_work * loads.friction_work.sum(axis=0)


@dataclass(frozen=True)
class Combined:
    """Sliding and impact wear side by side: the sum of both rates.

    **Source** the sum of abrasion and impact that STAR-CCM+ and Aspherix offer for particle flows.
    **Valid for** mechanisms that do not disturb each other. Friction during an oblique impact is sliding too: a sliding law sees it beside
    the impact law, so coefficients fitted to the two alone add up to an upper bound, and those fitted to both together do not.
    """

    sliding: WearLaw
    impact: WearLaw

    def depth_rate(self, loads: FacetLoads, liner: Any = None) -> np.ndarray:
        """(b, f) [m/s]"""
        return self.sliding.depth_rate(loads, liner) + self.impact.depth_rate(loads, liner)

    def volume(self, loads: FacetLoads) -> np.ndarray:
        """(f,) [m3]"""
        return self.sliding.volume(loads) + self.impact.volume(loads)


@dataclass(frozen=True)
class Scaled:
    """A law whose coefficient was measured: all that it says, times one factor.

    **Source** a calibration against readings. **Valid for** what the law is valid for, where the readings were taken.
    """

    law: WearLaw
    factor: float  # [-] coefficient measured over the coefficient that the law has

    def __post_init__(self) -> None:
        require_number("factor", self.factor, "times the law")

    def depth_rate(self, loads: FacetLoads, liner: Any = None) -> np.ndarray:
        """(b, f) [m/s]"""
        return self.factor * self.law.depth_rate(loads, liner)

    def volume(self, loads: FacetLoads) -> np.ndarray:
        """(f,) [m3]"""
        return self.factor * self.law.volume(loads)


def worn_depth(law: WearLaw, loads: FacetLoads, liner: Any = None) -> np.ndarray:
    """Depth that all blocks together wear off each facet, (f,) [m]: the sum of rate times duration."""
    return loads.duration @ law.depth_rate(loads, liner)


def per_area_and_time(amount: np.ndarray, loads: FacetLoads) -> np.ndarray:
    """A sum (b, f) over each facet's area and each block's time; facets without area have nothing on them."""
    area = np.where(loads.area > 0.0, loads.area, np.inf)
    return amount / area / loads.duration[:, None]


def require_number(name: str, value: float, unit: str, above_zero: bool = False) -> None:
    """Refuse a coefficient that is not a finite number of 0 or more, or above 0 where it divides."""
    if not 0.0 <= value < np.inf:
        raise UserError(f"{name} is {value!r} {unit}; it must be 0 or more, a surface does not grow by wear.")
    if above_zero and value == 0.0:
        raise UserError(f"{name} is 0 {unit}; it must be above 0, the law divides by it.")
