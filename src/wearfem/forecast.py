"""How long a liner will last: its remaining life by zone as a distribution, beside the straight line and the frozen geometry.

Each life is drawn many times from what the samples of the run say of the rates and leave open (`wear/trend.py`), and from what is known
of the coefficient of wear and of the mesh. Why it is so: docs/decisions/0010-forecasts.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from wearfem.case import LifeCase
from wearfem.errors import UserError
from wearfem.history import History
from wearfem.known import KnownEffects, PlainDepth
from wearfem.report_facts import corrected_thickness, lag_of, zones_of
from wearfem.wear.trend import COARSE, EXACT, Draws, Noise, ratio_courses, zone_courses

DRAWS = 1000
MOST = 300  # facets of a zone that may be the first to fail
CALENDAR = 200  # parts of two lives in which calendars are told
LATE = 2.0  # lives of the shortest-lived facet, after which no other is the first to fail
QUANTILES = (0.1, 0.5, 0.9)
WHOLE = "whole worn face"
FEWEST_STRESSES = 3  # cycles that tell how stress grows as the liner thins


@dataclass(frozen=True)
class Known:
    """What is known beside the samples, each as a relative standard deviation [-] of every rate of the run; None if not included."""

    coefficient_error: float | None = None
    mesh_error: float | None = None

    def __post_init__(self) -> None:
        """Refuse what is no part of 1."""
        for name in ("coefficient_error", "mesh_error"):
            value = getattr(self, name)
            if value is not None and not 0.0 <= value < 1.0:
                raise UserError(
                    f"{name} is {value!r}; it is a standard deviation as a part of 1, such as 0.1 for 10 %, and below 1"
                )


@dataclass(frozen=True)
class ZoneLife:
    """When a zone is worn out in one sense: the service time [s], since the liner was new, drawn many times."""

    zone: str
    until: str  # what ends it, in words
    draw: np.ndarray = field(repr=False)  # (d,) [s]; infinite where it never comes
    share: Mapping[str, float]  # of the variance of ln life by source; they add up to 1
    straight_line: float  # [s] by the depth worn so far over the time served
    frozen: float  # [s] with the geometry, and so the rates, of the first sample
    last_rate: float  # [s] with the rates of the last sample

    @property
    def quantile(self) -> tuple[float, ...]:
        """[s] at 10, 50 and 90 %: the 80 % interval and the middle"""
        return tuple(np.quantile(self.draw, QUANTILES, method="inverted_cdf").tolist())

    def probability_to_reach(self, time: float) -> float:
        """[-] that it lasts to a service time [s]"""
        return float((self.draw > time).mean())


@dataclass(frozen=True)
class Forecast:
    """The lives of all zones, with what they rest on."""

    served: float  # [s] service time of the last sample
    samples: int
    zone: tuple[ZoneLife, ...]
    left_out: tuple[str, ...]  # what the intervals do not hold, in words


def forecast(
    history: History,
    limit: float | None = None,
    known: Known | None = None,
    *,
    stress_limit: float | None = None,
    case: LifeCase | None = None,
    draws: int = DRAWS,
    seed: int = 0,
) -> Forecast:
    """The remaining life by zone: to a limit of thickness, to breakthrough, and to a limit of stress where strength was asked.

    Parameters
    ----------
    history
        Of a life of two kept samples at least.
    limit
        [m] thickness at which the liner is to be changed; the depths that the case allows if not given.
    known
        Of the coefficient of wear and of the mesh.
    stress_limit
        [Pa] largest von Mises stress allowed; the yield stress of the case's structure if not given.
    case
        That was run. Its effects (hardness through the thickness, running-in, a calendar) go on as they are known to; what the flow
        does is taken from the samples. Without it all is.
    draws, seed
        How many lives to draw, and from which random numbers.

    Raises
    ------
    UserError
        for a life of one sample, a limit above the present thickness, a stress limit that is passed already or cannot be foretold, and
        a face that does not wear.
    """
    known = known or Known()
    if len(history.samples) < 2:
        raise UserError(
            f"a forecast was asked of {len(history.samples)} cycle, and two that were kept are needed to see how the rate goes on: go on "
            "with wearfem resume"
        )
    random = np.random.default_rng(seed)
    doubt = {
        "wear coefficient": random.normal(size=draws) * (known.coefficient_error or 0.0),
        "mesh": random.normal(size=draws) * (known.mesh_error or 0.0),
    }
    until = limits(history, limit)
    if stress_limit is None and case is not None and case.structure is not None:
        yields = case.structure.yield_stress
        stress_limit = yields if np.isfinite(yields) and len(history.samples) >= FEWEST_STRESSES else None
    found, effects = [], known_effects(history, case)
    for name, facet in zones(history).items():
        ways = [(words, allowed, np.zeros(draws)) for words, allowed in until.items()]
        if stress_limit is not None:
            ways.append(_stress_way(history, facet, stress_limit, random, draws))
        for words, allowed, shift in ways:
            known_facet = np.isfinite(allowed[facet]) & (allowed[facet] > 0.0)
            judged = facet[known_facet & (history.rate[:, facet] > 0.0).all(axis=0)]
            if len(judged):
                course = _Zone.of(
                    history, judged, allowed[judged], effects, np.random.default_rng([seed, 1]), draws
                )
                found.append(_zone_life(history, name, words, course, shift, doubt))
    if not found:
        raise UserError(
            "no facet with a limit wears in every cycle: nothing ends this life, so sample longer or look where the flow goes"
        )
    left_out = [
        words
        for words, value in (
            ("the wear coefficient", known.coefficient_error),
            ("the mesh", known.mesh_error),
        )
        if value is None
    ]
    return Forecast(float(history.service_time[-1]), len(history.samples), tuple(found), tuple(left_out))


def zones(history: History) -> dict[str, np.ndarray]:
    """Facets (k,) by zone: the whole worn face, and the mesh's own groups on it."""
    mesh = history.state.now.liner.mesh
    named = zones_of(mesh)
    everything = np.arange(len(mesh.wear))
    return {WHOLE: everything} | (dict(named) if any(name in mesh.group for name in named) else {})


def limits(history: History, limit: float | None) -> dict[str, np.ndarray]:
    """(f,) [m] that each facet may lose since the first sample, by what then ends its life.

    Raises
    ------
    UserError
        for a limit that is negative or above the present thickness.
    """
    left = corrected_thickness(history)
    if limit is None:
        worn_out = {"the depth that the case allows": history.allowed_depth}
    else:
        present = float(np.nanmin(left[-1])) if np.isfinite(left[-1]).any() else np.inf
        if not 0.0 <= limit < present:
            raise UserError(
                f"the limit is {1e3 * limit:.4g} mm, and the least thickness left is {1e3 * present:.4g} mm: give a limit of 0 mm or more "
                "and below it"
            )
        worn_out = {f"{1e3 * limit:.4g} mm left": left[0] - limit}
    return worn_out | {"breakthrough": left[0]}


def _stress_way(
    history: History, facet: np.ndarray, limit: float, random: np.random.Generator, draws: int
) -> tuple[str, np.ndarray, np.ndarray]:
    """Words, depths (f,) [m] at which the zone's largest stress reaches the limit, and what each draw adds to them (d,) [m]."""
    left = corrected_thickness(history)
    kept = [report for report in history.reports if report.kept]
    own = np.array(
        [
            report.strain.von_mises[facet].max()
            if report.strain and len(report.strain.von_mises) == len(history.area)
            else np.nan
            for report in kept
        ]
    )
    zone_tells = len(facet) < len(history.area) and np.isfinite(own).sum() >= FEWEST_STRESSES
    stress = own if zone_tells else history.largest_von_mises
    thinnest = np.nanmin(left[:, facet], axis=1)
    at = thickness_at_stress(thinnest, stress, limit, random, draws)
    middle = float(np.median(at))
    return f"{1e-6 * limit:.4g} MPa von Mises", left[0] - middle, middle - at


def thickness_at_stress(
    thickness: np.ndarray, stress: np.ndarray, limit: float, random: np.random.Generator, draws: int
) -> np.ndarray:
    """(d,) [m] thickness at which the stress reaches its limit, drawn from the run's own stresses; 0 where it never does.

    Least squares of ln stress = a - p ln thickness: p is 1 for tension and 2 for bending under a given load. a and p are drawn with
    the covariance of the fit (Student's t).

    Parameters
    ----------
    thickness, stress
        (n,) [m] least thickness and [Pa] largest stress of each cycle.
    limit
        [Pa]
    random, draws
        What to draw with, and how often.

    Raises
    ------
    UserError
        for fewer than three cycles with stress, and for a limit that the last one has passed.
    """
    told = np.isfinite(stress) & np.isfinite(thickness) & (stress > 0.0)
    if told.sum() < FEWEST_STRESSES:
        raise UserError(
            f"a stress limit of {1e-6 * limit:.4g} MPa was given, and {told.sum()} cycles tell a stress: {FEWEST_STRESSES} are needed, "
            "of a case with a structure, to see how it grows"
        )
    if not limit > stress[told][-1]:
        raise UserError(
            f"the stress limit is {1e-6 * limit:.4g} MPa, and the last cycle had {1e-6 * stress[told][-1]:.4g} MPa: give a limit above it"
        )
    rows = np.column_stack([np.ones(told.sum()), -np.log(thickness[told])])
    answer, *_ = np.linalg.lstsq(rows, np.log(stress[told]), rcond=None)
    freedom = len(rows) - 2
    scatter = float(np.square(np.log(stress[told]) - rows @ answer).sum()) / freedom
    root = np.linalg.cholesky(np.linalg.inv(rows.T @ rows) + 1e-30 * np.eye(2))
    off = np.sqrt(scatter * freedom / random.chisquare(freedom, size=draws))
    a, p = answer[:, None] + root @ random.normal(size=(2, draws)) * off
    grows = p > 0.0
    return np.where(grows, np.exp((a - np.log(limit)) / np.where(grows, p, 1.0)), 0.0).clip(
        0.0, float(thickness[told][-1])
    )


def _zone_life(
    history: History,
    name: str,
    until: str,
    course: "_Zone",
    shift: np.ndarray,
    doubt: Mapping[str, np.ndarray],
) -> ZoneLife:
    """Lives of the facet that fails first, drawn, and how much each source of doubt would spread them alone."""
    start = float(history.service_time[0])
    depth, served = course.depth[-1], float(history.service_time[-1])
    life = start + course.lives(shift, unseen=True, noise=True) * np.exp(sum(doubt.values()))
    nothing = np.zeros_like(shift)
    alone = {
        "sampling noise": np.log(course.lives(nothing, noise=True)),
        "rate between and beyond the samples": np.log(course.lives(nothing, unseen=True)),
        "growth of stress": np.log(course.lives(shift)) - np.log(course.lives(nothing)),
    } | dict(doubt)
    variance = {source: float(np.var(value)) for source, value in alone.items()}
    whole = sum(variance.values())
    share = {source: value / whole if whole > 0.0 else 0.0 for source, value in variance.items()}
    return ZoneLife(
        zone=name,
        until=until,
        draw=life,
        share=share,
        straight_line=start + _shortest(course.allowed, depth / (served - start)),
        frozen=start + _shortest(course.allowed, course.rate[0]),
        last_rate=served + _shortest(course.allowed - depth, course.rate[-1]),
    )


def _shortest(depth: np.ndarray, rate: np.ndarray) -> float:
    return float(np.divide(depth, rate, out=np.full(len(depth), np.inf), where=rate > 0.0).min())


@dataclass(frozen=True)
class _Zone:
    """The facets of a zone that may fail first, and how their rates may go on: in plain depths and times, which know no effects."""

    scale: float  # [m] mean plain depth at which the zone is about worn out
    common: Draws  # of ln r, (d, g, 1)
    ratio: Draws  # of ln q, (d, g, k)
    allowed: np.ndarray  # (k,) [m]
    depth: np.ndarray  # (n, k) [m] by which the shapes had receded that were sampled
    rate: np.ndarray  # (n, k) [m/s]
    plain: PlainDepth
    calendar: tuple[
        np.ndarray, np.ndarray
    ]  # (m,) [s] plain times, and those of service since the first sample

    @classmethod
    def of(
        cls,
        history: History,
        facet: np.ndarray,
        allowed: np.ndarray,
        effects: KnownEffects | None,
        random: np.random.Generator,
        draws: int,
    ) -> "_Zone":
        """From the samples of a run."""
        window = history.window
        share = window / window.sum()
        depth = history.depth - lag_of(history)
        depth = depth - depth[0]
        everywhere = share @ history.rate
        life = float((allowed / everywhere[facet]).min())
        facets = history.rate.shape[1]
        plain = (effects.by_depth(LATE * life * everywhere) if effects else PlainDepth.same(facets)).of(facet)
        served = history.service_time - history.service_time[0]
        later = LATE * life * np.linspace(0.0, 1.0, CALENDAR + 1)
        middle = history.service_time[0] + 0.5 * (later[1:] + later[:-1])
        seasons = effects.in_time(middle)[:, facet] if effects else np.ones((CALENDAR, len(facet)))
        season = seasons[np.clip(np.searchsorted(later, served, side="right") - 1, 0, CALENDAR - 1)]

        factor = effects.at(depth)[:, facet] if effects else np.ones((len(depth), len(facet)))
        rate, depth = history.rate[:, facet], depth[:, facet]
        mean, spare = share @ (rate / factor), plain.without(allowed)
        first = np.argsort(spare / mean)[:MOST]
        first = first[(spare / mean)[first] <= LATE * (spare / mean).min()]
        facet, allowed, spare, mean, plain = (
            facet[first],
            allowed[first],
            spare[first],
            mean[first],
            plain.of(first),
        )
        rate, depth, factor = rate[:, first], depth[:, first], factor[:, first]
        season, seasons = season[:, first], seasons[:, first]

        error = np.sqrt(share**2 @ np.square(history.error[:, facet] / factor)) / mean
        weight = 1.0 / np.maximum(error, EXACT) ** 2
        weight /= weight.sum()
        samples = [
            replace(one, rate=one.rate[:, facet] / by)
            for one, by in zip(history.samples, factor, strict=True)
        ]
        noise = Noise.seen_in(samples, np.arange(len(facet)), weight)

        together, all_together = (some @ (weight * mean) / (weight @ mean) for some in (season, seasons))
        calendar = np.append(0.0, np.cumsum(all_together * np.diff(later)))
        without = rate / factor
        zone, scale = without @ weight / together, float((spare / mean).min() * (mean @ weight))
        u = plain.without(depth) @ weight / scale
        common = zone_courses(u, np.log(zone), noise.zone / window, noise.freedom, random, draws)
        value = np.log(without / (without @ weight)[:, None]) - np.log(season / together[:, None])
        place = _centres(history)[facet] / np.sqrt(history.area[facet].mean())
        ratio = ratio_courses(u, value, window, noise.ratio, place, random, draws)
        when = np.searchsorted(calendar, scale * COARSE / (mean @ weight), side="right") - 1
        apart = np.log(seasons / all_together[:, None])[np.clip(when, 0, CALENDAR - 1)]
        ratio = replace(ratio, mean=ratio.mean + apart)
        return cls(scale, common, ratio, allowed, depth, rate, plain, (calendar, later))

    def lives(self, shift: np.ndarray, *, unseen: bool = False, noise: bool = False) -> np.ndarray:
        """(d,) [s] from the first sample to the end of the first facet, with or without each source of doubt.

        `shift` (d,) [m] is added to the depths allowed.
        """
        common = self.common.value(unseen=unseen, noise=noise)[:, :, 0]
        ratio = self.ratio.value(unseen=unseen, noise=noise)
        spare = self.plain.without(np.maximum(self.allowed + shift[:, None], 1e-3 * self.allowed))
        worn = self.scale * _integral(np.exp(ratio), self.ratio.at) / spare[:, None, :]  # (d, g, k)
        end = _crossing(worn.max(axis=2), self.ratio.at)
        plain_time = self.scale * _value_at(end, _integral(np.exp(-common), self.common.at), self.common.at)
        told, later = self.calendar
        beyond = np.maximum(plain_time - told[-1], 0.0) * (later[-1] - later[-2]) / (told[-1] - told[-2])
        return np.interp(plain_time, told, later) + beyond


def known_effects(history: History, case: LifeCase | None) -> KnownEffects | None:
    """What the case knows of the rates to come, under the loads of the last sample; nothing where the mesh has changed since."""
    loads = [report.loads for report in history.reports if report.kept][-1]
    now = history.state.kept.liner if history.state.kept else history.state.now.liner
    if case is None or not case.effects or not len(loads.area) == len(now.depth) == len(history.area):
        return None
    return KnownEffects(
        case,
        now,
        loads,
        history.state.now.receded if history.state.kept is None else history.state.kept.receded,
    )


def _integral(value: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(d, g, ...) of values over an even grid, from its beginning"""
    step = 0.5 * at[1] * (value[:, 1:] + value[:, :-1])
    return np.concatenate([np.zeros_like(value[:, :1]), np.cumsum(step, axis=1)], axis=1)


def _crossing(value: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(d,) where rising values (d, g) over a grid reach 1; beyond it, by their last slope"""
    after = np.clip((value < 1.0).sum(axis=1), 1, len(at) - 1)
    row = np.arange(len(value))
    low, high = value[row, after - 1], value[row, after]
    return at[after - 1] + (1.0 - low) / (high - low) * at[1]


def _value_at(u: np.ndarray, value: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(d,) of values (d, g) over a grid at u (d,); beyond it, by their last slope"""
    after = np.clip(np.searchsorted(at, u), 1, len(at) - 1)
    row = np.arange(len(value))
    part = (u - at[after - 1]) / at[1]
    return value[row, after - 1] * (1.0 - part) + value[row, after] * part


def _centres(history: History) -> np.ndarray:
    """(f, 3) [m]"""
    mesh = history.state.now.liner.mesh
    return mesh.node[mesh.wear].mean(axis=1)
