"""The service of each plate as a table of intervals, and the wear that a model lets grow along it.

    d(depth)/d(progress) = k x exposure x product of factors + sum of additions.

Factors that know the depth, g, and those that do not, s, part: the integral of d(depth)/g(depth) is k times that of exposure x s. So one
table of the left side serves all plates at once, and no step of time is taken. Where a run of the model tells the course of each plate,
its depth D after service s, the exposure is D' and each plate is at D(k x integral of factors); see `course.py`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wearfem.survey.course import Course
from wearfem.survey.survey import Survey
from wearfem.wear.effect import FactorEffect, all_factors
from wearfem.wear.effects import BuildUp, Corrosion, OreChange, OreChangeByTime, Overlay

CELLS = 240  # of the table over depth: error of the depth below 1e-4 for factors that change twofold over it
EVEN = np.linspace(0.0, 1.0, CELLS + 1) ** 1.5  # its places: finer near the new surface
GAUSS_AT = 0.5 + 0.5 * np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
GAUSS_WEIGHT = np.array([5.0, 8.0, 5.0]) / 18.0
FEWEST_PLACES = 8  # over which a smooth function can be told from scatter
SMOOTH_LENGTH = 0.33  # [-] of the span of places
STEPS = 4  # of the classical Runge-Kutta rule in an interval, where wear and additions go together
UNSEEN = 0.3  # [gauge errors] below which a mode of a run's own errors adds less than a tenth to the variance of readings in its direction
FAINT = 1e-6  # [-] least factor over depth: where nothing wears, the integral of 1/g has no end


@dataclass(frozen=True)
class History:
    """Intervals of service of l lives; m of each, those that are not used have no length.

    Parameters
    ----------
    begin, end
        (l, m) progress of each interval, by the tonnage book.
    start
        (l,) progress at which the plate was put in.
    exposure
        (l, m) by unit of coefficient and progress; of the first mechanism where there are several.
    feature
        (l, m) or (l, m, 3) by name.
    calendar
        (l, m) [s] of calendar time in each interval, or None where nobody wrote it down.
    occasion
        (l, m) index of the occasion that ends the interval.
    row_life, row_interval
        (n,) where each reading stands; interval -1 for a reading of the new plate.
    course
        Of a run whose shape changes; then `exposure` is the run's at its own pace.
    others
        (e - 1, l, m) exposures of the other mechanisms.
    smooth
        (l, k) smooth functions of place, with a mean of 0 and a mean square of 1 together; none where places are few or not told.
    warped
        (l, k) those by which the readings of a campaign may err together; none where they are taken to err each by itself.
    steepness
        (l, 3) [1/m] gradient of the logarithm of the wear along the face.
    sampled
        (l, m, q) relative errors of the growth in each interval by the run's own sampling, for q independent standard normals; none for a
        table of exposures. They are those at the run's own pace.
    bent
        Depth at which the rates of places are compared that change with depth, each by its own shape; 0 where they are taken not to.
    """

    begin: np.ndarray
    end: np.ndarray
    start: np.ndarray
    exposure: np.ndarray
    feature: Mapping[str, np.ndarray]
    calendar: np.ndarray | None
    occasion: np.ndarray
    row_life: np.ndarray
    row_interval: np.ndarray
    course: Course | None = None
    others: np.ndarray = field(default_factory=lambda: np.zeros((0, 1, 1)))
    smooth: np.ndarray = field(default_factory=lambda: np.zeros((1, 0)))
    warped: np.ndarray = field(default_factory=lambda: np.zeros((1, 0)))
    steepness: np.ndarray = field(default_factory=lambda: np.zeros((1, 3)))
    sampled: np.ndarray = field(default_factory=lambda: np.zeros((1, 1, 0)))
    bent: float = 0.0

    def of_rows(self, at_end: np.ndarray) -> np.ndarray:
        """What (l, m) says at the ends of intervals, for each reading (n,); 0 for a new plate."""
        return np.where(self.row_interval < 0, 0.0, at_end[self.row_life, self.row_interval])


@dataclass(frozen=True)
class Model:
    """A coefficient and effects; the wear of a plate is k x exposure x factors, and what is added.

    Where several mechanisms wear, the exposure is that of the first plus `ratio` times each other; k x ratio are their coefficients.
    """

    coefficient: float
    effects: tuple[FactorEffect, ...] = ()
    additions: tuple[Corrosion, ...] = ()
    ratio: tuple[float, ...] = ()


def history(survey: Survey) -> History:
    """The intervals of each life: they end where the point, or the survey at large, was read.

    A covariate at a reading is taken as the mean since the reading before. Where a point was not read, it has the median of the others
    at that occasion if they agree with one another, else its own next value.
    """
    lives, occasions = len(survey.life_point), len(survey.occasion_names)
    common = np.array(
        [np.median(survey.progress[survey.occasion == j]) if (survey.occasion == j).any() else np.nan for j in range(occasions)]
    )  # fmt: skip
    same = all(np.ptp(survey.progress[survey.occasion == j]) == 0.0 for j in set(survey.occasion.tolist()))
    ends = []
    for i in range(lives):
        own = np.unique(survey.progress[survey.life == i])
        between = (common > survey.life_start[i]) & (common < own.max(initial=0.0))
        nodes = np.unique(np.concatenate([own, common[between]])) if same else own
        ends.append(nodes[nodes > survey.life_start[i]])
    width = max(1, *(len(nodes) for nodes in ends))
    end = np.stack(
        [np.concatenate([e, np.full(width - len(e), e[-1] if len(e) else s)]) for e, s in zip(ends, survey.life_start, strict=True)]
    )  # fmt: skip
    begin = np.concatenate([survey.life_start[:, None], end[:, :-1]], axis=1)
    interval = np.full(survey.size, -1)
    for row in np.flatnonzero(~survey.is_new):
        interval[row] = np.searchsorted(ends[survey.life[row]], survey.progress[row])
    fill = _Filling(survey, interval, (lives, width))
    occasion = _occasion_of(survey, fill, end, common)
    feature = {name: fill(value, occasion) for name, value in survey.feature.items() if name != "days"}
    feature = {
        name: np.squeeze(value, -1) if value.shape[-1] == 1 else value for name, value in feature.items()
    }
    exposure, *others = np.moveaxis(fill(survey.exposure, occasion), -1, 0)
    course = survey.course
    sampled = np.zeros((1, 1, 0))
    if course is not None:
        served = begin - survey.life_start[:, None], end - survey.life_start[:, None]
        exposure = _exposure_of(course, *served)
        sampled = course.own_errors(*served, UNSEEN * _reading_error(survey))
        middle = 0.5 * (begin + end) - survey.life_start[:, None]
        feature = {name: course.state_at(name, middle) for name in course.state} | feature
    return History(
        begin, end, survey.life_start, exposure, feature, _calendar(survey, begin, end), occasion,
        survey.life, interval, course if course is not None and course.follows_shape else None,
        np.array(others).reshape(len(others), *begin.shape), sampled=sampled, **_over_place(feature.get("position"), exposure, course),
    )  # fmt: skip


def _reading_error(survey: Survey) -> float:
    """Of one reading as given; else what is small beside the wear"""
    known = survey.sigma[np.isfinite(survey.sigma)]
    return float(np.median(known)) if len(known) else 1e-3 * float(np.ptp(survey.reading))


def _over_place(position: np.ndarray | None, exposure: np.ndarray, course: Course | None) -> dict[str, Any]:
    """`smooth` and `steepness` of a history, where places are told and many"""
    if position is None or len(np.unique(position[:, 0], axis=0)) < FEWEST_PLACES:
        return {}
    place = position[:, 0]
    if course is not None:
        return {"smooth": smooth_functions(place), "steepness": course.steepness}
    return {"smooth": smooth_functions(place), "steepness": steepness(place, exposure.mean(axis=1))}


def smooth_functions(place: np.ndarray) -> np.ndarray:
    """(l, k) principal functions of a Gaussian field over places (l, 3) whose length is a third of their span.

    **Source** Karhunen-Loeve expansion; those that carry 2 % of the variance or more, at most 8.
    """
    apart = np.linalg.norm(place[:, None] - place, axis=2)
    gram = np.exp(-0.5 * (apart / (SMOOTH_LENGTH * apart.max())) ** 2)
    gram = gram - gram.mean(axis=0)
    gram = gram - gram.mean(axis=1, keepdims=True)
    size, function = np.linalg.eigh(gram)
    kept = np.flatnonzero(size > 0.02 * size.sum())[-8:]
    return function[:, kept] * np.sqrt(size[kept] * len(place) / size[kept].sum())


def steepness(place: np.ndarray, wear: np.ndarray) -> np.ndarray:
    """(l, 3) [1/m] gradient of the logarithm of what wears at places (l, 3), by a plane through each place's nearest; 0 without wear"""
    found = np.zeros(place.shape)
    if np.ptp(wear) < 1e-6 * wear.max() or not (wear > 0.0).all():
        return found
    for i, middle in enumerate(place):
        near = np.argsort(np.linalg.norm(place - middle, axis=1), kind="stable")[: FEWEST_PLACES + 1]
        apart = place[near] - place[near].mean(axis=0)
        level = np.log(wear[near])
        found[i] = np.linalg.pinv(apart, rcond=0.1) @ (level - level.mean())
    return found


def _exposure_of(course: Course, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(l, m) mean rate of a course in each interval; of an empty one, the rate there"""
    short = 1e-6 * float(end.max())
    end = np.maximum(end, begin + short)
    return course.grown(begin, end) / (end - begin)


@dataclass(frozen=True)
class _Filling:
    """Values of readings put into intervals."""

    survey: Survey
    interval: np.ndarray
    shape: tuple[int, int]

    def __call__(self, value: np.ndarray, occasion: np.ndarray) -> np.ndarray:
        """(l, m, c) of (n,) or (n, c), without holes"""
        value = value.reshape(self.survey.size, -1)
        cells = np.full((*self.shape, value.shape[1]), np.nan)
        cells[self.survey.life, np.maximum(self.interval, 0)] = (
            value  # a new plate's value, unless it is read later
        )
        later = self.interval >= 0
        cells[self.survey.life[later], self.interval[later]] = value[later]
        middle = np.nanmedian(value, axis=0)
        for j in range(len(self.survey.occasion_names)):
            here = value[(self.survey.occasion == j) & np.isfinite(value).all(axis=1)]
            if len(here) and (np.ptp(here, axis=0) == 0.0).all():
                hole = np.isnan(cells).any(axis=2) & (occasion == j)
                cells[hole] = here[0]
        for i in range(self.shape[0]):
            good = np.flatnonzero(np.isfinite(cells[i]).all(axis=1))
            if len(good):
                following = np.searchsorted(good, np.arange(self.shape[1]))
                cells[i] = cells[i, good[np.minimum(following, len(good) - 1)]]
        return np.where(np.isnan(cells), middle, cells)


def _occasion_of(survey: Survey, fill: _Filling, end: np.ndarray, common: np.ndarray) -> np.ndarray:
    """(l, m) the occasion that ends each interval: that of the reading, or the nearest in progress"""
    near = np.nanargmin(np.abs(end[..., None] - common), axis=-1)
    read = fill.interval >= 0
    near[survey.life[read], fill.interval[read]] = survey.occasion[read]
    return near


def _calendar(survey: Survey, begin: np.ndarray, end: np.ndarray) -> np.ndarray | None:
    """[s] of calendar time in each interval, straight between readings; from `days`, or from service time itself"""
    if survey.progress_unit in {"s", "min", "h", "d", "days"}:
        factor = {"s": 1.0, "min": 60.0, "h": 3600.0}.get(survey.progress_unit, 86400.0)
        return factor * (end - begin)
    days = survey.feature.get("days")
    if days is None or not np.isfinite(days).all():
        return None
    order = np.argsort(survey.progress, kind="stable")
    at, first = np.unique(survey.progress[order], return_index=True)
    when = days[order][first]
    if at[0] > 0.0:
        at, when = np.append(0.0, at), np.append(0.0, when)  # days are counted from when service began
    when = np.maximum.accumulate(when)
    return np.interp(end, at, when) - np.interp(begin, at, when)


def depths(history: History, model: Model) -> np.ndarray:
    """Depth (l, m) at the end of each interval, in the unit of coefficient x exposure x progress."""
    slow = [effect for effect in model.effects if "depth" not in effect.needs]
    quick = [effect for effect in model.effects if "depth" in effect.needs]
    if history.course is not None and not model.additions:
        pace = model.coefficient * _mean_factor(history, slow) * (history.end - history.begin)
        return _along(history.course, np.cumsum(pace, axis=1), quick)
    exposure = history.exposure
    if model.ratio:
        exposure = exposure + np.tensordot(np.array(model.ratio), history.others, 1)
    grown = model.coefficient * exposure * _mean_factor(history, slow) * (history.end - history.begin)
    if not model.additions:
        total = np.cumsum(grown, axis=1)
        return _against_depth(total, quick) if quick else total
    passed = history.calendar if history.calendar is not None else history.end - history.begin
    added = passed * sum(addition.addition() for addition in model.additions)
    return _together(grown, added, quick) if quick else np.cumsum(grown + added, axis=1)


def breaks(effects: Sequence[FactorEffect]) -> list[float]:
    """Progress at which a factor jumps"""
    changes = [e.throughput for e in effects if isinstance(e, OreChange)]
    changes += [e.service_time for e in effects if isinstance(e, OreChangeByTime)]
    changes += [(e.since,) for e in effects if isinstance(e, BuildUp)]
    return sorted(at for change in changes for at in change)


def _mean_factor(history: History, effects: Sequence[FactorEffect]) -> Any:
    """(l, m) mean over each interval of the product of factors that do not know the depth"""
    if not effects:
        return 1.0
    if not any({"throughput", "service_time"} & set(effect.needs) for effect in effects):
        return all_factors(effects, history.feature)
    edges = [history.begin, *(np.clip(at, history.begin, history.end) for at in breaks(effects)), history.end]
    length = history.end - history.begin
    books, parts = [], []
    for left, right in zip(edges, edges[1:], strict=False):
        part = np.divide(right - left, length, out=np.zeros_like(length), where=length > 0.0)
        for at, weight in zip(GAUSS_AT, GAUSS_WEIGHT, strict=True):
            books.append(left + at * (right - left))
            parts.append(weight * part)
    factors = np.broadcast_to(_product_at(history, effects, np.array(books)), (len(books), *length.shape))
    return sum(part * factor for part, factor in zip(parts, factors, strict=True))


def _product_at(history: History, effects: Sequence[FactorEffect], book: np.ndarray) -> Any:
    """(..., l, m) product of factors at a progress of the book; what runs in knows the progress of its own plate"""
    product: Any = 1.0
    for effect in effects:
        dated = isinstance(effect, OreChange | OreChangeByTime) or "position" in effect.needs
        at = book if dated else book - history.start[:, None]
        product = product * all_factors([effect], {**history.feature, "throughput": at, "service_time": at})
    return product


def _against_depth(total: np.ndarray, effects: Sequence[FactorEffect]) -> np.ndarray:
    """The depth at which the integral of 1/g has come to `total`"""
    edge = _table(2.0 * float(total.max(initial=0.0)) + 1e-300, effects)
    factor = np.maximum(all_factors(effects, {"depth": 0.5 * (edge[1:] + edge[:-1])}), FAINT)
    integral = np.append(0.0, np.cumsum(np.diff(edge) / factor))
    beyond = np.maximum(total - integral[-1], 0.0) * factor[-1]
    return np.interp(total, integral, edge) + beyond


def _table(most: float, effects: Sequence[FactorEffect]) -> np.ndarray:
    """Depths up to `most`, finer near the new surface, and where a factor jumps"""
    jumps = [e.thickness for e in effects if isinstance(e, Overlay) and e.thickness < most]
    edge = most * EVEN
    return np.unique(np.append(edge, jumps)) if jumps else edge


def _along(course: Course, walked: np.ndarray, effects: Sequence[FactorEffect]) -> np.ndarray:
    """The depth of each plate that has walked so much of its course, (l, m) service of the run; 1/g of the depth slows the walk"""
    if not effects:
        return course.depth_at(walked)
    most = 2.0 * float(course.depth_at(walked).max(initial=0.0)) + 1e-300
    edge = _table(most, effects)
    factor = np.maximum(all_factors(effects, {"depth": 0.5 * (edge[1:] + edge[:-1])}), FAINT)
    step = np.diff(course.progress_at(np.broadcast_to(edge, (len(walked), len(edge)))), axis=1) / factor
    needed = np.concatenate([np.zeros((len(walked), 1)), np.cumsum(step, axis=1)], axis=1)
    beyond = np.maximum(walked - needed[:, -1:], 0.0) * factor[-1] * course.rate[:, -1:]
    return np.stack([np.interp(w, n, edge) for w, n in zip(walked, needed, strict=True)]) + beyond


def _together(grown: np.ndarray, added: np.ndarray, effects: Sequence[FactorEffect]) -> np.ndarray:
    """Depth where factors of the depth and additions act at once, by the classical Runge-Kutta rule"""
    depth = np.zeros(len(grown))
    ends = np.empty_like(grown)
    for j in range(grown.shape[1]):
        own, more = grown[:, j], added[:, j]

        def rate(d: np.ndarray, own: np.ndarray = own, more: np.ndarray = more) -> np.ndarray:
            return own * np.maximum(all_factors(effects, {"depth": d}), FAINT) + more

        h = 1.0 / STEPS
        for _ in range(STEPS):
            first = rate(depth)
            second = rate(depth + 0.5 * h * first)
            third = rate(depth + 0.5 * h * second)
            fourth = rate(depth + h * third)
            depth = depth + h / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
        ends[:, j] = depth
    return ends
