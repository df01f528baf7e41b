"""What an effect may know about a place on the liner: features by name, each with its unit and where it comes from.

In a run, features are taken from the facet loads and from the liner (`features`), one value for each facet; in a survey they are columns,
one value for each reading. Effects see names and arrays only, so they serve both.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from wearfem.errors import UserError, in_words
from wearfem.loads import FacetLoads
from wearfem.wear.impact_laws import impact_points

Features = Mapping[str, Any]  # name -> number or array


class WornMesh(Protocol):
    """Where the facets of the worn face are."""

    @property
    def node(self) -> np.ndarray:
        """(n, 3) [m]"""

    @property
    def wear(self) -> np.ndarray:
        """(f, 3) or (f, 4) corner nodes of each facet"""


class WornLiner(Protocol):
    """What an effect may know of the liner; `wearfem.liner.liner.Liner` is one."""

    @property
    def mesh(self) -> WornMesh:
        """as it is now"""

    @property
    def depth(self) -> np.ndarray:
        """(f,) [m] worn off so far"""

    @property
    def service_time(self) -> float:
        """[s]"""

    @property
    def throughput(self) -> float:
        """[kg]"""


@dataclass(frozen=True)
class Feature:
    """A quantity that effects may depend on.

    Parameters
    ----------
    unit, meaning
        of the value.
    of
        the value from loads and liner; None where only the user can tell it (a log, a column of the survey).
    """

    unit: str
    meaning: str
    of: Callable[[FacetLoads, WornLiner], Any] | None = None


def _total(amount: np.ndarray) -> np.ndarray:
    return amount.sum(axis=0)


def _over(amount: np.ndarray, by: np.ndarray) -> np.ndarray:
    """A ratio, 0 where there is nothing to divide by."""
    return np.divide(amount, by, out=np.zeros(np.shape(amount)), where=by > 0.0)


def _pressure(loads: FacetLoads, liner: WornLiner) -> np.ndarray:
    return _over(_total(loads.normal_impulse), loads.area * loads.duration.sum())


def _slip_speed(loads: FacetLoads, liner: WornLiner) -> np.ndarray:
    return _over(_total(loads.load_distance), _total(loads.normal_impulse))


def _mobilised_friction(loads: FacetLoads, liner: WornLiner) -> np.ndarray:
    push = np.linalg.norm(loads.tangential_impulse, axis=2)
    return _over(_total(push), _total(loads.normal_impulse))


def _impact_angle(loads: FacetLoads, liner: WornLiner) -> np.ndarray:
    points = impact_points(loads)
    return _over(_total(points.total(points.energy * points.angle)), _total(points.total(points.energy)))


def _impact_work(loads: FacetLoads, liner: WornLiner) -> np.ndarray:
    energy = loads.impact_energy.sum(axis=(0, 2, 3))
    return _over(energy, loads.area * loads.duration.sum()) * liner.service_time


def _position(loads: FacetLoads, liner: WornLiner) -> np.ndarray:
    return liner.mesh.node[liner.mesh.wear].mean(axis=1)


FEATURES: Mapping[str, Feature] = {
    "depth": Feature("m", "worn off so far", lambda loads, liner: liner.depth),
    "service_time": Feature(
        "s", "that the plate has been in service", lambda loads, liner: liner.service_time
    ),
    "throughput": Feature("kg", "that the plate has seen", lambda loads, liner: liner.throughput),
    "position": Feature("m", "(..., 3) middle of the facet", _position),
    "pressure": Feature("Pa", "mean normal pressure, sum F_n dt / (A T)", _pressure),
    "slip_speed": Feature(
        "m/s", "of contact points, weighted by force: sum F_n |v_t| dt / sum F_n dt", _slip_speed
    ),
    "mobilised_friction": Feature("-", "tangential over normal impulse", _mobilised_friction),
    "impact_angle": Feature("rad", "mean of first touches, weighted by energy; 0 grazing", _impact_angle),
    "impact_work": Feature("J/m2", "energy of impacts so far, at the present rate", _impact_work),
    "temperature": Feature("K", "of the worn face; differences count, so degrees Celsius do too"),
    "ore_hardness": Feature("Pa", "of the ore that flows"),
}


FROM_LOADS = (
    "pressure",
    "slip_speed",
    "mobilised_friction",
    "impact_angle",
    "impact_work",
)  # what the flow does


def features(needs: Sequence[str], loads: FacetLoads, liner: WornLiner) -> dict[str, Any]:
    """The features of these names in a run: numbers, or one value for each facet.

    They are taken over all blocks of the sample, so that an effect that is not linear is not biased by the noise of single blocks.

    Raises
    ------
    UserError
        for a name that does not exist, or that only a log or a survey can tell.
    """
    found = {}
    for name in needs:
        feature = FEATURES.get(name)
        if feature is None:
            raise UserError(f"there is no feature {name}; the features are {in_words(sorted(FEATURES))}.")
        if feature.of is None:
            raise UserError(f"particles do not tell the {name}: give the effect a `log` of it for a run.")
        found[name] = feature.of(loads, liner)
    return found
