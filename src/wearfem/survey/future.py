"""The service to come, as a continuation of the history: the future is like the past.

Intervals are as long as the median one, each with its own error of the tonnage book. What is the same at all places (ore, weather, days by
unit of service) comes again as it was from some occasion on, drawn by chance, since warm months follow one another; what belongs to a place
stays as it was last, or follows the course of a run.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from wearfem.survey.history import History
from wearfem.survey.identify import Readings
from wearfem.survey.survey import Survey


def typical_interval(survey: Survey) -> float:
    """Progress between occasions, the median"""
    at = [float(np.median(survey.progress[survey.occasion == j])) for j in np.unique(survey.occasion)]
    gaps = np.diff(np.unique(np.append(0.0, at)))
    return float(np.median(gaps))


def carried_on(data: Readings, progress: np.ndarray, interval: np.ndarray) -> History:
    """The history with intervals that end at `progress` (f,) after it, in the state that each place had last, or along a run's course.

    The first goes from a plate's own last reading to the last of the survey; the others belong to `interval` (f - 1,) to come.
    """
    past, survey = data.past, data.survey
    lives, served = past.end.shape
    used = past.end > past.begin
    last = np.where(used.any(axis=1), served - 1 - np.argmax(used[:, ::-1], axis=1), 0)
    again = np.tile(last[:, None], (1, len(progress)))
    rows = np.arange(lives)[:, None]

    def more(value: np.ndarray) -> np.ndarray:
        return np.concatenate([value, value[rows, again]], axis=1)

    end = np.concatenate([past.end, np.tile(progress, (lives, 1))], axis=1)
    begin = np.concatenate([past.begin, past.end[:, -1:], end[:, served:-1]], axis=1)
    exposure, feature = more(past.exposure), {name: more(value) for name, value in past.feature.items()}
    if (course := survey.course) is not None:
        first = (begin - past.start[:, None])[:, served:]
        then = np.maximum((end - past.start[:, None])[:, served:], first + 1e-6 * end.max())
        exposure[:, served:] = (course.depth_at(then) - course.depth_at(first)) / (then - first)
        for name in course.state:
            feature[name][:, served:] = course.state_at(name, 0.5 * (first + then))
    calendar = None
    if past.calendar is not None:
        calendar = more(past.calendar / np.where(used, past.end - past.begin, 1.0)) * (end - begin)
        calendar[:, :served] = past.calendar
    label = np.append(past.occasion[used].max(initial=0), len(survey.occasion_names) + interval)
    return replace(
        past, begin=begin, end=end, exposure=exposure, calendar=calendar, feature=feature,
        occasion=np.concatenate([past.occasion, np.tile(label, (lives, 1))], axis=1),
        others=np.array([more(other) for other in past.others]).reshape(len(past.others), *end.shape),
    )  # fmt: skip


def dated(data: Readings) -> dict[str, np.ndarray]:
    """What is the same at all places, occasion by occasion (o,): features by name, `exposure`, and `days` for [s] by unit of service."""
    past = data.past
    used = past.end > past.begin
    occasions = [used & (past.occasion == j) for j in np.unique(past.occasion[used])]
    told = {**past.feature}
    if data.survey.course is None:
        told["exposure"] = past.exposure
    if past.calendar is not None:
        told["days"] = past.calendar / np.where(used, past.end - past.begin, 1.0)
    found = {}
    for name, value in told.items():
        least = 1e-9 * float(np.abs(value).max(initial=0.0))
        if value.ndim == 2 and all(np.ptp(value[here]) <= least for here in occasions):
            found[name] = np.array([value[here].mean() for here in occasions])
    return found


def one_future(
    future: History, served: int, weather: Mapping[str, np.ndarray], wanted: set[str], interval: np.ndarray,
    random: np.random.Generator,
) -> History:  # fmt: skip
    """The history with what is dated and wanted drawn anew for the intervals to come: from some occasion on, in their order."""
    names = sorted(wanted & weather.keys())
    if not names:
        return future
    start = random.integers(len(weather[names[0]]))
    feature, exposure, calendar = dict(future.feature), future.exposure, future.calendar
    for name in names:
        values = as_seldom_seen(weather[name], random)
        comes = values[(start + interval) % len(values)]
        if name == "exposure":
            exposure = exposure.copy()
            exposure[:, served + 1 :] = comes
        elif name == "days" and calendar is not None:
            calendar = calendar.copy()
            calendar[:, served + 1 :] = comes * (future.end - future.begin)[:, served + 1 :]
        else:
            feature[name] = feature[name].copy()
            feature[name][:, served + 1 :] = comes
    return replace(future, feature=feature, exposure=exposure, calendar=calendar)


def as_seldom_seen(value: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Values of n occasions (n,) as they may come again, as uncertain as so few leave their mean and their spread.

    Deviations from the mean grow by sqrt(n / (n - 1)), and the mean has an error of the spread over sqrt(n), one for all that is to come;
    of logarithms where all are positive.
    """
    n = len(value)
    if n < 2:
        return value
    positive = bool((value > 0.0).all())
    known = np.log(value) if positive else value
    shift = known.std(ddof=1) / np.sqrt(n) * random.standard_normal()
    shown = known.mean() + np.sqrt(n / (n - 1)) * (known - known.mean()) + shift
    return np.exp(shown) if positive else shown
