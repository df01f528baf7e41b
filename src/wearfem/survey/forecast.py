"""How long a plate will last, told by its readings: the wear that each model lets expect, in draws, until it comes to a limit.

A draw takes a model (as often as it is probable), its parameters from their posterior, and the nuisances that go with them. The wear of
plate l at progress t, as a gauge without errors would read it, is

    D(l, t) = d(l, t) (1 + u[l]) + h[l] + sum over intervals of b[interval] (growth of d in it) + ...:

the model, the plate's own rate, its new thickness, the tonnage book, and all else in `nuisance.py` but what campaigns read wrong, which
is no wear. The future is like the past (`future.py`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_solve, solve_triangular

from wearfem.errors import UserError
from wearfem.survey.choose import ALIKE, Choice
from wearfem.survey.future import carried_on, dated, one_future, typical_interval
from wearfem.survey.history import History, depths
from wearfem.survey.identify import Fit, Readings, model_at
from wearfem.survey.nuisance import Disturbance, covariance, disturbance
from wearfem.survey.survey import Survey
from wearfem.units import day

SHARE = 0.80  # of the draws that an interval holds
DRAWS = 1000  # the end of an 80 % interval is known to 0.08 standard deviations
REACH = 3.0  # times the service so far, beyond which nothing is told
OF_CAMPAIGNS = (
    0,
    5,
    7,
)  # nuisances that are errors of readings and no wear: zero, in proportion, smooth over place
NEW = (1, 4)  # of new thicknesses
WARM_UP = 200  # steps of a walk that are thrown away
THINNED = 3  # steps from one draw to the next
PARTS = 2  # of an interval, between which wear goes in a straight line
LINE, ALONE, FULL = "straight line per point", "coefficient alone", "with the missing effect"


@dataclass(frozen=True)
class Outlook:
    """What one model lets expect.

    Parameters
    ----------
    name
        Of the model, in words.
    worn
        (3, c, f) [SI] low end of the interval, median and high end of the wear of each plate in service at `Forecast.progress`.
    end
        (s, c) progress at which each plate comes to the limit, draw by draw; infinite where it does not within reach, not-a-number
        where the model has nothing to say (no line through no reading).
    """

    name: str
    worn: np.ndarray
    end: np.ndarray


@dataclass(frozen=True)
class Forecast:
    """Wear to come, by model.

    Parameters
    ----------
    survey
        Which was read.
    plates
        (c,) lives in service: at each point those that were put in last.
    places, zones
        (c,) names of their points and of their zones.
    allowed
        (c,) [SI] wear at which each comes to the limit; infinite where no limit is asked.
    limit
        [SI] as asked, of what was measured; None for none.
    progress
        (f,) of the survey's unit, from the last reading on.
    outlooks
        Straight line per point, coefficient alone and, where an effect was named, the model with it.
    next_stop
        Progress until which the plates should last, or None.
    """

    survey: Survey
    plates: np.ndarray
    places: tuple[str, ...]
    zones: tuple[str, ...]
    allowed: np.ndarray
    limit: float | None
    progress: np.ndarray
    outlooks: tuple[Outlook, ...]
    next_stop: float | None

    @property
    def now(self) -> float:
        """Progress at the last reading"""
        return float(self.progress[0])

    @property
    def days(self) -> float | None:
        """Calendar days by unit of progress so far; None where nobody wrote them down"""
        days = self.survey.feature.get("days")
        if days is None or not np.isfinite(days).any() or not self.now > 0.0:
            return None
        return float(np.nanmax(days)) / day / float(self.survey.progress[np.nanargmax(days)])

    def of_place(self, outlook: Outlook, place: str) -> "End":
        """When the first plate at a point comes to the limit."""
        return self._least(outlook, place, self.places)

    def of_zone(self, outlook: Outlook, zone: str) -> "End":
        """When the first plate of a zone comes to the limit."""
        return self._least(outlook, zone, self.zones)

    def _least(self, outlook: Outlook, name: str, names: Sequence[str]) -> "End":
        here = outlook.end[:, np.array(names) == name]
        known = ~np.isnan(here).any(axis=0)
        if not known.any():
            return End(name, np.nan, (np.nan, np.nan), np.nan, None)
        return end_of(name, here[:, known].min(axis=1), self.next_stop)


@dataclass(frozen=True)
class End:
    """When a plate or a zone comes to the limit.

    Parameters
    ----------
    place
        Its name.
    median, interval
        [progress] of the draws, and what holds 80 % of them; infinite beyond reach, not-a-number where a model has nothing to say.
    beyond
        [-] share of the draws that do not come to the limit within reach.
    reaches
        [-] probability that it lasts longer than to the next stop; None where none is asked.
    """

    place: str
    median: float
    interval: tuple[float, float]
    beyond: float
    reaches: float | None


def end_of(place: str, draws: np.ndarray, next_stop: float | None) -> End:
    """Median and interval of draws (s,) of the progress at which a limit is reached."""
    low, median, high = np.quantile(
        draws, [0.5 - 0.5 * SHARE, 0.5, 0.5 + 0.5 * SHARE], method="closest_observation"
    )
    reaches = None if next_stop is None else float(np.mean(draws > next_stop))
    return End(place, float(median), (float(low), float(high)), float(np.mean(np.isinf(draws))), reaches)


def forecast(
    choice: Choice, limit: float | None = None, next_stop: float | None = None, *, draws: int = DRAWS, seed: int = 0
) -> Forecast:  # fmt: skip
    """Wear to come and the end of life of each plate in service, before and after a diagnosis.

    Parameters
    ----------
    choice
        What a diagnosis chose, and from what.
    limit
        [SI] of what was measured: a thickness that must be left, or a depth, mass or volume that may be lost. None for the wear only.
    next_stop
        Progress, in the survey's unit, until which the plates should last.
    draws, seed
        Number of draws, and where they begin.

    Raises
    ------
    UserError
        for a limit that no plate can reach or that all have passed, and for a next stop that is over.

    **Valid for** up to three times the service so far; what lies beyond is told as infinite.
    """
    data = choice.plain.readings
    survey = data.survey
    plates = in_service(survey)
    allowed = np.full(len(plates), np.inf) if limit is None else allowance(data, limit)[plates]
    step, now = typical_interval(survey), float(data.past.end.max())
    if limit is not None:
        _check_limit(data, plates, allowed, limit)
    if next_stop is not None and not next_stop > now:
        unit = survey.progress_unit or survey.progress_name
        raise UserError(
            f"the next stop was given as {next_stop:.4g} {unit}, but the last reading was taken at {now:.4g} {unit}; give a later one, "
            f'with its unit, as in --next-stop "{_example(1.2 * now, survey)}"'
        )
    count = int(np.ceil(REACH * now / step)) * PARTS
    progress = now + step / PARTS * np.arange(count + 1)
    outlooks = []
    for name, worn in (
        (LINE, lines_ahead(data, progress, draws, np.random.default_rng([seed, 0]))),
        (ALONE, wear_ahead([(choice.plain, 1.0)], progress, draws, np.random.default_rng([seed, 1]))),
        *(
            [(FULL, wear_ahead(explanations(choice), progress, draws, np.random.default_rng([seed, 2])))]
            if choice.best.suspects
            else []
        ),
    ):
        serving = worn[:, plates]
        ends = [0.5 - 0.5 * SHARE, 0.5, 0.5 + 0.5 * SHARE]
        outlooks.append(
            Outlook(name, np.quantile(serving, ends, axis=0), reached(serving, allowed, progress))
        )
    places = tuple(survey.point_names[p] for p in survey.life_point[plates])
    zones = tuple(survey.zone[p] if survey.zone else "all points" for p in survey.life_point[plates])
    return Forecast(survey, plates, places, zones, allowed, limit, progress, tuple(outlooks), next_stop)


def explanations(choice: Choice) -> list[tuple[Fit, float]]:
    """The models that the readings do not tell from the best by odds of 20, with their probabilities among one another."""
    if not choice.best.suspects:
        return [(choice.best, 1.0)]
    best = choice.belief(choice.best)
    near = [f for f in choice.tried if choice.belief(f) > best - ALIKE]
    near = near if any(f is choice.best for f in near) else [choice.best, *near]
    weight = np.exp([choice.belief(f) - best for f in near])
    return list(zip(near, (weight / weight.sum()).tolist(), strict=True))


def in_service(survey: Survey) -> np.ndarray:
    """(c,) the lives that go on after the last reading: at each point those that were put in last."""
    read = np.isin(np.arange(len(survey.life_point)), survey.life)
    last = np.array(
        [survey.life_start[read & (survey.life_point == p)].max(initial=0.0) for p in survey.life_point]
    )
    return np.flatnonzero(read & (survey.life_start >= last))


def allowance(data: Readings, limit: float) -> np.ndarray:
    """(l,) [SI] wear at which each plate comes to the limit; not-a-number for plates that were never read."""
    survey = data.survey
    if survey.sign > 0.0:
        return np.full(len(survey.life_point), limit)
    new = np.full(len(survey.life_point), np.nan)
    new[survey.life] = survey.reading + data.worn
    return new - limit


def wear_ahead(
    models: Sequence[tuple[Fit, float]], progress: np.ndarray, draws: int, random: np.random.Generator
) -> np.ndarray:
    """Draws (s, l, f) [SI] of the wear of every plate at `progress` (f,), the first of which is that of the last reading."""
    share = random.multinomial(draws, [weight for _, weight in models])
    return np.concatenate(
        [_draws(fitted, progress, int(n), random) for (fitted, _), n in zip(models, share, strict=True) if n]
    )


def _draws(fitted: Fit, progress: np.ndarray, count: int, random: np.random.Generator) -> np.ndarray:
    """Draws (s, l, f) of one model.

    Nuisances act on the wear to come by the columns that they have at the best parameters, in proportion to the wear of the draw.
    """
    data, spread, found = fitted.readings, fitted.spread, fitted.disturbance
    past = data.past
    lives, served = past.end.shape
    known = covariance(found, spread)
    size = found.deviation(spread)
    inverse = cho_solve((known.factor, True), np.eye(len(size)))
    gain = size[:, None] * (inverse @ (known.scaled / (spread.gauge * np.sqrt(found.weight))[:, None]).T)
    root = size[:, None] * solve_triangular(known.factor, np.eye(len(size)), lower=True, trans="T")
    middle = 0.5 * (progress[1:] + progress[:-1]) - progress[0]
    interval: np.ndarray = np.floor(middle / typical_interval(data.survey)).astype(int)
    future, weather = carried_on(data, progress, interval), dated(data)
    best = depths(future, fitted.model)
    there = _to_come(data, future, best)
    there_size = there.deviation(spread)
    place = {(int(g), int(k)): i for i, (g, k) in enumerate(zip(found.group, found.label, strict=True))}
    at = np.array([place.get((int(g), int(k)), -1) for g, k in zip(there.group, there.label, strict=True)])
    told = np.empty((count, len(at)))
    depth = np.empty((count, lives, len(progress)))
    for s, coordinate in enumerate(posterior(fitted, count, random)):
        model = model_at(data, fitted.suspects, coordinate)
        wanted = {name for effect in model.effects for name in effect.needs} | {"exposure"}
        wanted |= {"days"} if model.additions else set()
        grown = depths(one_future(future, served, weather, wanted, interval, random), model)
        nuisance = gain @ data.left(grown[:, :served]) + root @ random.standard_normal(len(size))
        told[s] = np.where(at >= 0, nuisance[at], there_size * random.standard_normal(len(at)))
        depth[s] = grown[:, served:]
    apart = np.isin(there.group, NEW)  # do not grow with wear
    ratio = depth / np.maximum(best[:, served:], 1e-12 * best.max())
    by_wear = (told[:, ~apart] @ there.column[:, ~apart].T).reshape(depth.shape)
    by_plate = (told[:, apart] @ there.column[:, apart].T).reshape(depth.shape)
    offset = np.zeros((lives, 1))
    offset[data.survey.life, 0] = data.offset
    by_plate += offset
    return depth + ratio * by_wear + by_plate


def _to_come(data: Readings, future: History, depth: np.ndarray) -> Disturbance:
    """How nuisances enter the wear of each life at each progress to come, rows (l f,); not those that are errors of campaigns"""
    survey = data.survey
    lives, served = data.past.end.shape
    columns = depth.shape[1] - served
    life = np.repeat(np.arange(lives), columns)
    interval = np.tile(np.arange(served, depth.shape[1]), lives)
    nothing = np.full(len(life), np.nan)
    names = (
        *survey.occasion_names,
        *(["to come"] * (int(future.occasion.max()) + 1 - len(survey.occasion_names))),
    )
    asked = replace(
        survey, point=survey.life_point[life], occasion=future.occasion[life, interval], life=life, occasion_names=names,
        progress=future.end[life, interval], reading=nothing, sigma=nothing, initial=nothing, exposure=nothing, feature={},
    )  # fmt: skip
    rows = replace(future, row_life=life, row_interval=interval)
    found = disturbance(asked, rows, depth, data.reference, data.thickness_free)
    wear = ~np.isin(found.group, OF_CAMPAIGNS)
    return replace(found, column=found.column[:, wear], group=found.group[wear], label=found.label[wear])


def posterior(fitted: Fit, count: int, random: np.random.Generator) -> np.ndarray:
    """Draws (s, d) of the coordinates of a fit, by a random walk of Metropolis with the steps that its covariance lets expect to be best.

    The covariance alone would not do: a parameter that the readings only bound from one side (the core of a plate that is not worn to
    it) is not normal.

    **Source** Roberts, Gelman and Gilks, Ann. Appl. Probab. 7 (1997) 110-120: steps of 2.38 / sqrt(d) standard deviations.
    """
    data = fitted.readings
    root = covariance(fitted.disturbance, fitted.spread).root()

    def energy(coordinate: np.ndarray) -> float:
        depth = depths(data.past, model_at(data, fitted.suspects, coordinate))
        left = root @ data.left(depth)
        return 0.5 * float(left @ left + coordinate @ coordinate)

    value, vector = np.linalg.eigh(fitted.deviation)
    moving = int((value > 1e-12).sum())
    turn = 2.38 / np.sqrt(max(moving, 1)) * vector * np.sqrt(np.maximum(value, 0.0))
    drawn = np.empty((count, len(value)))
    here, height = fitted.coordinate, energy(fitted.coordinate)
    for step in range(-WARM_UP, THINNED * count):
        there = here + turn @ random.normal(size=len(value))
        other = energy(there)
        if np.log(random.uniform()) < height - other:
            here, height = there, other
        if step >= 0 and step % THINNED == THINNED - 1:
            drawn[step // THINNED] = here
    return drawn


def lines_ahead(
    data: Readings, progress: np.ndarray, draws: int, random: np.random.Generator, noise: float = 0.0
) -> np.ndarray:
    """Draws (s, l, f) [SI] of straight lines through each plate's new state, by least squares; not-a-number where no reading is.

    The standard error of a slope is that of the pooled scatter about all lines, which is drawn too (Student's distribution). With `noise`
    1 a reading's own scatter is added.
    """
    survey = data.survey
    served = survey.progress - survey.life_start[survey.life]
    lives = len(survey.life_point)
    square = np.bincount(survey.life, served**2, lives)
    slope = np.divide(
        np.bincount(survey.life, served * data.worn, lives), square, out=np.full(lives, np.nan), where=square > 0.0
    )  # fmt: skip
    used = served > 0.0
    left = (data.worn - served * slope[survey.life])[used]
    freedom = len(left) - int((square > 0.0).sum())
    variance = float(left @ left) / freedom if freedom > 0 else data.reference**2
    scatter = np.sqrt(variance * max(freedom, 1) / random.chisquare(max(freedom, 1), draws))
    error = (
        scatter[:, None] * random.normal(size=(draws, lives)) / np.sqrt(np.where(square > 0.0, square, 1.0))
    )
    since = progress[None, :] - survey.life_start[:, None]
    worn = (slope + error)[:, :, None] * since
    return worn + noise * scatter[:, None, None] * random.normal(size=worn.shape) if noise else worn


def reached(worn: np.ndarray, allowed: np.ndarray, progress: np.ndarray) -> np.ndarray:
    """(s, c) progress at which wear (s, c, f) first comes to what is allowed (c,), on straight lines between; infinite if it does not."""
    over = worn >= allowed[:, None]
    first = np.argmax(over, axis=2)
    before = np.maximum(first - 1, 0)
    low = np.take_along_axis(worn, before[..., None], axis=2)[..., 0]
    high = np.take_along_axis(worn, first[..., None], axis=2)[..., 0]
    part = np.divide(
        allowed - low, high - low, out=np.zeros_like(low), where=(high > low) & np.isfinite(allowed)
    )
    end = progress[before] + part * (progress[first] - progress[before])
    end = np.where(over.any(axis=2), end, np.inf)
    return np.where(np.isnan(worn).any(axis=2), np.nan, end)


def _check_limit(data: Readings, plates: np.ndarray, allowed: np.ndarray, limit: float) -> None:
    """Refuse a limit that cannot be meant"""
    survey = data.survey
    unit, factor = survey.measured_unit, survey.measured_factor
    said = f"the limit was given as {limit / factor:.4g} {unit} of {survey.measured_name}"
    extreme = survey.reading.min() if survey.sign < 0.0 else survey.reading.max()
    if not limit >= 0.0 or (survey.sign > 0.0 and limit == 0.0):
        raise UserError(f"{said}; it must be above 0")
    if survey.sign < 0.0 and (allowed <= 0.0).all():
        raise UserError(
            f"{said}, which is more than the new plates had; give what must be left of them, less than "
            f"{(allowed + limit).max() / factor:.4g} {unit}"
        )
    last = np.array(
        [data.worn[own][np.argmax(survey.progress[own])] for own in (survey.life == p for p in plates)]
    )
    if (last >= allowed).all():
        raise UserError(
            f"{said}, which all plates in service have passed (the extreme reading is {extreme / factor:.4g} {unit}); "
            "there is no life left to tell. Check the limit and its unit"
        )


def _example(progress: float, survey: Survey) -> str:
    """An amount of service as one types it"""
    names = {
        "kt": "kt",
        "t": "tonne",
        "h": "hour",
        "d": "day",
        "days": "day",
        "m": "m",
        "km": "km",
        "s": "second",
        "min": "minute",
    }
    unit = names.get(survey.progress_unit, "")
    return f"{progress:.4g}*{unit}" if unit else f"{progress:.4g}"
