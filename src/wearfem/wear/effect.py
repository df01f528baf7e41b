"""What an effect is: a factor on the wear rate, a formula of named features.

Forwards, `modify` takes the features from the facet loads and the liner and multiplies the rate; backwards, a diagnosis takes them from
a survey and integrates

    d(depth)/d(progress) = k x exposure x product of factors + sum of additions.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from wearfem.errors import UserError, in_words
from wearfem.loads import FacetLoads
from wearfem.wear.features import FROM_LOADS, Features, WornLiner, features

Smooth = Callable[
    [np.ndarray], np.ndarray
]  # of fields (b, f) by facet; the identity where nothing is smoothed


class Effect(Protocol):
    """What every effect can do."""

    needs: ClassVar[tuple[str, ...]]

    def modify(self, rate: np.ndarray, loads: FacetLoads, liner: WornLiner) -> np.ndarray:
        """The rate (b, f) [m/s] with the effect in it."""
        ...


class FactorEffect:
    """What all effects that multiply the rate share."""

    needs: ClassVar[tuple[str, ...]] = ()

    factor: Callable[
        ..., Any
    ]  # [-] by which the rate is multiplied, of the features by keyword; numbers or arrays like them

    def known(self, loads: FacetLoads, liner: WornLiner) -> dict[str, Any]:
        """The features that the effect needs, in a run."""
        return features(self.needs, loads, liner)

    def modify(self, rate: np.ndarray, loads: FacetLoads, liner: WornLiner) -> np.ndarray:
        """The rate (b, f) [m/s] times the factor of each facet."""
        return rate * self.factor(**self.known(loads, liner))


def acts_on_the_flow(effect: Effect) -> bool:
    """Whether an effect looks at what the flow does to a facet; else at the metal there, its place and the calendar"""
    return any(name in FROM_LOADS for name in effect.needs)


def smoothed_with_effects(
    rate: np.ndarray, effects: Sequence[Effect], loads: FacetLoads, liner: WornLiner, smooth: Smooth
) -> np.ndarray:
    """The rate (b, f) [m/s] of a law with effects, smoothed between those of the flow and those of the metal.

    Smoothing stands for loads that scatter over a neighbourhood, and steel does not scatter: a facet that is through its hard layer
    wears by what is below it, whatever its neighbours still have.
    """
    return on_the_metal(smooth(on_the_flow(rate, effects, loads, liner)), effects, loads, liner)


def on_the_flow(
    rate: np.ndarray, effects: Sequence[Effect], loads: FacetLoads, liner: WornLiner
) -> np.ndarray:
    """The rate (b, f) [m/s] with the effects that look at what the flow does; they act before it is smoothed"""
    for effect in effects:
        if acts_on_the_flow(effect):
            rate = effect.modify(rate, loads, liner)
    return rate


def on_the_metal(
    rate: np.ndarray, effects: Sequence[Effect], loads: FacetLoads, liner: WornLiner
) -> np.ndarray:
    """The rate (b, f) [m/s], smoothed, with the effects of depth, place and calendar"""
    for effect in effects:
        if not acts_on_the_flow(effect):
            rate = effect.modify(rate, loads, liner)
    return rate


def all_factors(effects: Sequence[FactorEffect], known: Features) -> Any:
    """Product of the factors of several effects [-], each with the features that it needs out of `known`.

    Raises
    ------
    UserError
        naming the features that an effect needs and that are not known.
    """
    product: Any = 1.0
    for effect in effects:
        if missing := [name for name in effect.needs if name not in known]:
            raise UserError(
                f"{type(effect).__name__} needs {in_words(missing)}; known are {in_words(sorted(known))}."
            )
        product = product * effect.factor(**{name: known[name] for name in effect.needs})
    return product


@dataclass(frozen=True)
class Log:
    """What was written down in the course of service: values at times, straight lines between, constant beyond."""

    service_time: tuple[float, ...]  # [s] rising
    value: tuple[float, ...]

    def __post_init__(self) -> None:
        require_steps("a log", self.service_time, self.value)

    def at(self, service_time: float) -> float:
        """The value at a time [s]"""
        return float(np.interp(service_time, self.service_time, self.value))


def step(progress: Any, begins: Sequence[float], ratio: Sequence[float]) -> Any:
    """1 before the first beginning, then the ratio of the last that has come"""
    return np.array([1.0, *ratio])[np.searchsorted(begins, progress, side="right")]


def power(ratio: Any, exponent: float) -> Any:
    """ratio^exponent; 1 where the ratio is 0 and the exponent below 0"""
    nothing = (ratio <= 0.0) & (exponent < 0.0)
    return np.where(nothing, 1.0, np.where(nothing, 1.0, ratio) ** exponent)


def unit(direction: Sequence[float]) -> np.ndarray:
    """A direction as a vector of length 1"""
    length = float(np.linalg.norm(direction))
    if not 0.0 < length < math.inf:
        raise UserError(f"the direction {tuple(direction)} was given; it must point somewhere.")
    return np.asarray(direction, float) / length


def logged(name: str, log: Log | None, loads: FacetLoads, liner: WornLiner) -> dict[str, Any]:
    """A feature that only a log can tell, at the liner's service time"""
    return features((name,), loads, liner) if log is None else {name: log.at(liner.service_time)}


def require(name: str, value: float, low: float, high: float, open_below: bool = False) -> None:
    """Refuse a coefficient outside its range, or that is not finite."""
    if not (low <= value <= high and math.isfinite(value)) or (open_below and value == low):
        above = (
            f"above {low:g}"
            if open_below
            else f"{low:g} or more"
            if high == math.inf
            else f"{low:g} to {high:g}"
        )
        raise UserError(f"{name} is {value!r}; it must be {'finite' if low == -math.inf else above}.")


def require_steps(name: str, at: Sequence[float], value: Sequence[float], least: float = -math.inf) -> None:
    """Refuse lists of different lengths, without entries, that do not rise, or with values below `least` or not finite."""
    rising = all(a < b for a, b in zip(at, at[1:], strict=False))
    whole = len(at) == len(value) > 0 and bool(np.isfinite([*at, *value]).all())
    if not (rising and whole and min(value) >= least):
        floor = f", {least:g} or more" if least > -math.inf else ""
        raise UserError(
            f"{name} was given {list(at)} and {list(value)}; it needs as many values as places, at least one, "
            f"finite{floor}, at places that rise."
        )
