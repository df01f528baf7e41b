"""What it costs to change a liner at one time or another: the price of a tonne over many liners, from the distribution of their lives."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from wearfem.errors import UserError

TIMES = 60  # of a change, from which the cheapest is told


@dataclass(frozen=True)
class Prices:
    """What a change of the liner costs, in one currency. What is not given is zero, and nothing is assumed."""

    liner: float  # of a new liner, fitted
    unplanned_stop: float = 0.0  # what a stop that nobody planned costs beside standing
    standing_hour: float = 0.0  # of an hour in which the plant stands
    planned_hours: float = 0.0  # [h] that it stands for a planned change
    unplanned_hours: float = 0.0  # [h] that it stands when the liner fails
    currency: str = "money"

    def __post_init__(self) -> None:
        """Refuse prices below zero, and hours without a price or the reverse."""
        for name in ("liner", "unplanned_stop", "standing_hour", "planned_hours", "unplanned_hours"):
            if not 0.0 <= getattr(self, name) < np.inf:
                said = {"liner": "price of a liner"}.get(name, name.replace("_", " "))
                raise UserError(f"the {said} was given as {getattr(self, name):g}: it must be 0 or more")
        if (self.standing_hour > 0.0) != (self.planned_hours > 0.0 or self.unplanned_hours > 0.0):
            raise UserError(
                f"an hour of standing costs {self.standing_hour:g} {self.currency}, for {self.planned_hours:g} h at a planned change and "
                f"{self.unplanned_hours:g} h at an unplanned one: give the price of an hour together with at least one of the two times"
            )

    @property
    def planned(self) -> float:
        """Of a change that was planned [currency]"""
        return self.liner + self.standing_hour * self.planned_hours

    @property
    def unplanned(self) -> float:
        """Of a change when the liner has failed [currency]"""
        return self.liner + self.unplanned_stop + self.standing_hour * self.unplanned_hours


@dataclass(frozen=True)
class Costs:
    """Cost by time of change; see `costs`."""

    time: np.ndarray = field(repr=False)  # (t,) [s] service time of a planned change
    rate: np.ndarray = field(repr=False)  # (t,) [currency/s] of service
    to_the_end: float  # [currency/s] without planned changes
    best: float  # [s] the cheapest of `time`; infinite where running to the end is cheaper
    prices: Prices


def costs(life: np.ndarray, prices: Prices, time: Sequence[float] | np.ndarray | None = None) -> Costs:
    """Expected cost of a second of service if each liner is changed at a time, or when it fails if that comes first.

        C(t) = (planned P(T > t) + unplanned P(T <= t)) / E[min(T, t)]

    Parameters
    ----------
    life
        (d,) [s] drawn lives T of a new liner.
    prices
        Of a planned and of an unplanned change.
    time
        [s] at which to change; from the first percent of the lives to the last if not given.

    **Source** R. Barlow and L. Hunter, Operations Research 8 (1960) 90-100, age replacement.
    **Valid for** liners in a row whose lives differ as the draws do; doubt of the wear coefficient, which is the same for all of them,
    is taken as if it were drawn anew for each.
    """
    if time is None:
        time = np.linspace(0.5 * np.quantile(life, 0.01), np.quantile(life, 0.99), TIMES)
    at = np.asarray(time, float)
    fails = (life[None, :] <= at[:, None]).mean(axis=1)
    served = np.minimum(life[None, :], at[:, None]).mean(axis=1)
    rate = (prices.planned * (1.0 - fails) + prices.unplanned * fails) / served
    to_the_end = prices.unplanned / float(life.mean())
    best = int(np.argmin(rate))
    return Costs(at, rate, to_the_end, float(at[best]) if rate[best] < to_the_end else np.inf, prices)
