"""Effects that a survey tells, for a run: from the units of the tonnage book to seconds and kilograms, and from columns to logs."""

from dataclasses import dataclass, replace

import numpy as np

from wearfem.errors import UserError, in_words
from wearfem.survey.candidates import Suspect
from wearfem.survey.columns import UNITS, column
from wearfem.survey.history import History
from wearfem.survey.survey import Survey
from wearfem.wear.effect import Log
from wearfem.wear.effects import (
    Corrosion,
    FactorCurve,
    OreChange,
    OreChangeByTime,
    OreHardness,
    RunningInByThroughput,
    Temperature,
)
from wearfem.wear.features import FEATURES

AT_ONCE = 1e-9  # part of the service in which a column goes from one value to the next


@dataclass(frozen=True)
class Service:
    """What one unit of a survey's progress is in a run.

    Parameters
    ----------
    seconds, kilograms
        Service time [s] and throughput [kg]; None where the run has no throughput.
    by_mass
        Whether the survey counts mass, not time.
    """

    seconds: float
    kilograms: float | None
    by_mass: bool


def service(survey: Survey, throughput_rate: float) -> Service:
    """What a survey's progress is in a run with this throughput [kg/s].

    Raises
    ------
    UserError
        for progress that a run does not count, and for mass where the run has no throughput.
    """
    told = column(survey.progress_name)
    unit = UNITS[told.unit][2] if told.unit else ""
    if unit == "s":
        return Service(told.factor, told.factor * throughput_rate or None, False)
    if unit == "kg" and throughput_rate > 0.0:
        return Service(told.factor / throughput_rate, told.factor, True)
    if unit == "kg":
        raise UserError(
            f"{survey.source} counts service by {survey.progress_name}, and the case has no throughput_rate; give the case one [kg/s]"
        )
    raise UserError(
        f"{survey.source} counts service by {survey.progress_name}; a run counts time and throughput, so give the survey a column "
        "like time_h or tonnage_kt, and name it with --progress"
    )


def in_service(effect: Suspect, survey: Survey, past: History, unit: Service) -> Suspect:
    """An effect in SI, as a case takes it.

    Parameters
    ----------
    effect
        As it was fitted to the survey.
    survey, past
        Where its columns come from.
    unit
        Of the survey's progress.

    Raises
    ------
    UserError
        for an effect that a run cannot have: one that depends on a column that differs from place to place, or on the date where plates
        were put in at different dates.
    """
    if isinstance(effect, OreChange | OreHardness | Temperature) and (survey.life_start > 0.0).any():
        raise UserError(
            f"{type(effect).__name__} goes by the date, and plates of {survey.source} were put in at different dates; a run is the life "
            "of plates put in together, so give a survey of those"
        )
    match effect:
        case OreChange():
            if not unit.by_mass:
                times = tuple(at * unit.seconds for at in effect.throughput)
                return OreChangeByTime(times, effect.ratio)
            return replace(effect, throughput=tuple(at * _mass(unit, survey) for at in effect.throughput))
        case RunningInByThroughput():
            return replace(effect, throughput=effect.throughput * _mass(unit, survey))
        case Corrosion():
            return _corrosion(effect, past, unit)
        case OreHardness():
            return replace(effect, log=_log("ore_hardness", survey, past, unit))
        case Temperature():
            return replace(effect, log=_log("temperature", survey, past, unit))
        case FactorCurve(feature="throughput"):
            if unit.by_mass:
                return replace(effect, at=tuple(at * _mass(unit, survey) for at in effect.at))
            return replace(effect, feature="service_time", at=tuple(at * unit.seconds for at in effect.at))
        case FactorCurve() if effect.feature not in FEATURES or FEATURES[effect.feature].of is None:
            return replace(effect, log=_log(effect.feature, survey, past, unit))
        case _:
            return effect


def _mass(unit: Service, survey: Survey) -> float:
    if unit.kilograms is None:
        raise UserError(
            f"the effect goes by throughput, {survey.source} counts {survey.progress_name}, and the case has no throughput_rate; give the "
            "case one [kg/s]"
        )
    return unit.kilograms


def _corrosion(effect: Corrosion, past: History, unit: Service) -> Corrosion:
    """Fitted by calendar time where the survey has one, else by progress"""
    if past.calendar is None:
        return Corrosion(effect.depth_rate / unit.seconds)
    served = float((past.end - past.begin).sum(axis=1).max()) * unit.seconds
    return Corrosion(effect.depth_rate, max(1.0, float(past.calendar.sum(axis=1).max()) / served))


def _log(name: str, survey: Survey, past: History, unit: Service) -> Log:
    """A column as a log over service time [s]: the mean of each interval holds all through it"""
    value = past.feature[name]
    date = past.end
    differ = value.ndim != 2 or any(
        np.ptp(value[date == at]) > 1e-9 * np.abs(value).max() for at in np.unique(date)
    )
    if differ or (survey.life_start > 0.0).any():
        raise UserError(
            f"the effect follows the column {name} of {survey.source}, which differs from place to place; a run knows "
            f"{in_words(sorted(n for n, f in FEATURES.items() if f.of))}, and of columns those that are the same everywhere at a date"
        )
    ends, first = np.unique(date, return_index=True)
    held = value.ravel()[first]
    keep = ends > 0.0
    ends, held = ends[keep] * unit.seconds, held[keep]
    begins = np.append(0.0, ends[:-1] + AT_ONCE * ends[-1])
    times = np.stack([begins, ends], axis=1).ravel()
    return Log(tuple(float(t) for t in times), tuple(float(v) for v in np.repeat(held, 2)))
