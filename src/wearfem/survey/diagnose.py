"""The diagnosis of a survey: is the model adequate, what is missing, how sure is that, what cannot be told, what to measure next."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from wearfem.errors import UserError, in_words
from wearfem.survey.candidates import Candidate, log_steps
from wearfem.survey.choose import (
    EVEN_BEND,
    EVEN_BOOK,
    EVEN_SCALE,
    EVEN_SCATTER,
    SUSPECTED,
    Choice,
    choose,
    uneven,
)
from wearfem.survey.doubt import Doubt, doubted
from wearfem.survey.history import depths
from wearfem.survey.identify import COEFFICIENT_PRIOR, Fit, Readings, fit, model_at, readings
from wearfem.survey.next_reading import Suggestion, suggestion
from wearfem.survey.nuisance import nuisances
from wearfem.survey.residual import NoiseTest, noise_tests
from wearfem.survey.survey import Survey
from wearfem.wear.effects import BuildUp, OreChange

NOISE_LEVEL = 0.01  # false alarms of all tests together, below which what is left is not noise
LEAST_READINGS = 8
PLACE = ("centre_x", "centre_y", "centre_z", "radius")  # of a patch, in metres
SHAPE = "change of shape with wear"
WRITTEN_DOWN = {"ore_hardness", "temperature"}  # the same everywhere, occasion by occasion
TOLD_BY_LOG = WRITTEN_DOWN | {"calendar time", "date"}  # the same for all places
WIDTH_90 = 1.645  # standard deviations, 90 % of a normal distribution


@dataclass(frozen=True)
class Score:
    """Errors of a model in the measured unit: on what it was fitted to, and on what it never saw."""

    train_rmse: float
    heldout_rmse: float | None
    chi2_per_dof: float


@dataclass(frozen=True)
class Parameter:
    """A value with its 90 % interval; no interval for what was looked for on a list."""

    value: float
    interval: tuple[float, float] | None
    unit: str


@dataclass(frozen=True)
class Effect:
    """An effect that the readings ask for."""

    name: str
    parameters: Mapping[str, Parameter]
    probability: float
    indistinguishable_from: tuple[str, ...]
    suggested_measurement: str
    quantity: str
    tabulated: bool


@dataclass(frozen=True)
class HeldOut:
    """What the figures of `heldout_rmse` are taken over.

    `undecided` (point, occasion) are those that the fitted ones do not tell to within the gauge's error, even if the improved model is
    right: at the border of a patch, or where wear is deeper than any that was fitted. `decided_rmse` is its error on all the others.
    """

    points: tuple[str, ...]
    occasions: tuple[str, ...]
    readings: int
    straight_line_readings: int
    named_without_them: tuple[str, ...] | None
    undecided: tuple[tuple[str, str], ...]
    decided_rmse: float | None


@dataclass(frozen=True)
class Diagnosis:
    """What was found; `words.py` says it in words and as JSON."""

    survey: Survey
    doubts: tuple[Doubt, ...]
    choice: Choice
    tests_before: tuple[NoiseTest, ...]
    tests_after: tuple[NoiseTest, ...]
    baseline: Score
    straight_line: Score
    improved: Score
    noise_floor: float
    verdict: str
    effects: tuple[Effect, ...]
    nuisance: Mapping[str, object]
    heldout: HeldOut
    notes: tuple[str, ...]

    @property
    def more_than_noise(self) -> bool:
        """Whether what the chosen model leaves still depends on some quantity: the first of `tests_after` is below the level"""
        return bool(self.tests_after) and self.tests_after[0].p < NOISE_LEVEL


def diagnose(survey: Survey, *, name_without: bool = True) -> Diagnosis:
    """Name what the model lacks, or say that nothing is lacking, or that it cannot be told.

    Parameters
    ----------
    survey
        With its exposure; where none is known every place is taken to be exposed alike.
    name_without
        Also choose the effect without the readings held out, to see that the same is named (takes as long again).

    Raises
    ------
    UserError
        for fewer than 8 readings or no second occasion.
    """
    if survey.size < LEAST_READINGS or len(np.unique(survey.progress[~survey.is_new])) < 2:
        raise UserError(
            f"{survey.source} has {survey.size} readings at {len(np.unique(survey.progress))} amounts of service; a diagnosis needs "
            f"{LEAST_READINGS} readings at two amounts of service or more. Calibrate instead"
        )
    doubts = doubted(survey)
    keep = np.ones(survey.size, bool)
    keep[[d.row for d in doubts]] = False
    data = readings(survey.only(keep))
    choice = choose(data)
    data = choice.plain.readings
    held = held_out(data)
    plain = improved = fit(data.only(~held))
    if choice.best.suspects:
        improved = fit(data.only(~held), choice.best.suspects)
        if held.any() and predicted_better(choice, plain, improved) < -SUSPECTED:
            choice = Choice(choice.plain, choice.plain, choice.tried, choice.odds, ())  # it does not predict
            improved = plain
    named = None
    if name_without and choice.best.suspects and held.any():
        named = tuple(s.name for s in choose(data.only(~held)).best.suspects)
    after = noise_tests(choice.best)
    effects = _effects(choice)
    notes = tuple(_notes(choice, data))
    factor = survey.measured_factor
    return Diagnosis(
        survey, doubts, choice, noise_tests(choice.plain), after,
        _baseline(data, held, factor), _straight_line(data, held, factor), _score(improved, data, held, factor),
        choice.best.spread.gauge / factor, _verdict(choice, effects, after), effects,
        _nuisance(choice.best, factor), _held_out_names(data, held, named, improved), notes,
    )  # fmt: skip


def predicted_better(choice: Choice, plain: Fit, improved: Fit) -> float:
    """[nats] by which the readings held out are more probable with the effect than without, given the others.

    The density of what is held out, given the rest, is that of all readings over that of the rest; so whatever is uncertain in either
    model (which points a patch covers) is paid for, and a prediction that claims no more than it knows is not punished. The readings
    held out have had their say in the evidence of all, and nuisances fitted to fewer readings make this difference uncertain by about one
    nat: an effect is taken back where they speak against it by as much as makes one suspected, not where they are silent.
    """
    return (choice.best.log_evidence - improved.log_evidence) - (
        choice.plain.log_evidence - plain.log_evidence
    )


def held_out(data: Readings) -> np.ndarray:
    """Readings (n,) that no fit sees: every fifth point in the order of exposure, the last occasion, and one in the middle of six.

    Whole points and whole occasions: neighbours in time or place of a reading that is kept would give it away. Readings of new plates
    stay, since they are no wear.
    """
    survey = data.survey
    occasions = np.unique(survey.occasion[~survey.is_new])
    held = np.zeros(survey.size, bool)
    if len(occasions) >= 3:
        held |= survey.occasion == occasions[-1]
    if len(occasions) >= 6:
        held |= survey.occasion == occasions[len(occasions) // 2 - 1]
    points = np.unique(survey.point)
    if len(points) >= 6:
        exposed = [float(np.mean(data.past.exposure[survey.life_point == p])) for p in points]
        order = points[np.argsort(exposed, kind="stable")]
        held |= np.isin(survey.point, order[2::5])
    return held & ~survey.is_new


def _score(fitted: Fit, data: Readings, held: np.ndarray, factor: float) -> Score:
    train = data.only(~held)
    left = train.worn - fitted.predict(train)
    freedom = len(left) - len(fitted.coordinate)
    return _as_score(
        left,
        data.only(held).worn - fitted.predict(data.only(held)) if held.any() else None,
        data,
        freedom,
        factor,
    )


def _as_score(
    train: np.ndarray, held: np.ndarray | None, data: Readings, freedom: int, factor: float
) -> Score:
    return Score(
        float(np.sqrt(np.mean(train**2))) / factor,
        float(np.sqrt(np.mean(held**2))) / factor if held is not None and len(held) else None,
        float(np.sum(train**2)) / data.reference**2 / max(1, freedom),
    )


def _baseline(data: Readings, held: np.ndarray, factor: float) -> Score:
    """The model as it is: its coefficients by least squares, no nuisances"""
    train = data.only(~held)

    def left_of(coordinate: np.ndarray) -> np.ndarray:
        return (
            train.worn - train.past.of_rows(depths(data.past, model_at(data, (), coordinate)))
        ) / data.reference

    best = least_squares(left_of, np.zeros(data.coefficients), method="lm").x
    wear = data.past.of_rows(depths(data.past, model_at(data, (), best)))
    left = data.worn - wear
    return _as_score(left[~held], left[held], data, int((~held).sum()) - len(best), factor)


def _straight_line(data: Readings, held: np.ndarray, factor: float) -> Score:
    """A line through the origin for each plate; readings of plates that have no other reading are not predicted"""
    survey = data.survey
    t = survey.progress - survey.life_start[survey.life]
    left = np.full(survey.size, np.nan)
    lines = 0
    for life in np.unique(survey.life):
        own = survey.life == life
        fitted = own & ~held & (t > 0.0)
        if fitted.any():
            lines += 1
            left[own] = data.worn[own] - t[own] * float(t[fitted] @ data.worn[fitted]) / float(
                t[fitted] @ t[fitted]
            )
    known = np.isfinite(left)
    return _as_score(
        left[known & ~held], left[known & held], data, int((known & ~held).sum()) - lines, factor
    )


def _effects(choice: Choice) -> tuple[Effect, ...]:
    best = choice.best
    model = best.model
    suggested = suggestion(
        best, [f for i in range(len(best.suspects)) for f in choice.instead_of(i)], choice.played_by
    )
    built = [*model.effects, *model.additions]
    found, at = [], best.readings.coefficients
    for i, suspect in enumerate(best.suspects):
        effect = suspect.effect(best.coordinate[at : at + len(suspect.free)])
        alike = [a for f in choice.instead_of(i) for a in _other(f, best, i)]
        alike += [f"any change with {quantity}" for quantity in choice.played_by[i]]
        if choice.unsure:
            alike.append("scatter between places, or errors of campaigns and of the tonnage book")
        if suspect.twin:
            alike.append(suspect.twin)
        if isinstance(effect, OreChange):
            alike.append("a step in the tonnage book")
        if _may_be_shape(choice, suspect):
            alike.append(SHAPE)
        found.append(
            Effect(
                suspect.name, parameters_of(best, i, at), choice.probability(suspect.name), tuple(dict.fromkeys(alike)),
                _in_words(suggested, best), suspect.quantity, suspect.name.startswith("FactorCurve"),
            )
        )  # fmt: skip
        at += len(suspect.free)
    assert len(built) == len(found)
    return tuple(found)


def _may_be_shape(choice: Choice, suspect: Candidate) -> bool:
    """Whether an effect may be the shape that wears: the run did not follow it, or the rate of each place goes its own way with depth"""
    course = choice.best.readings.survey.course
    if course is not None and not course.follows_shape and suspect.quantity not in WRITTEN_DOWN:
        return True
    return bends(choice.best) and suspect.quantity not in TOLD_BY_LOG


def bends(fitted: Fit) -> bool:
    """Whether the rates of places change with depth, each by its own way and by more than careful work lets them"""
    return fitted.readings.past.bent > 0.0 and fitted.spread.bend > EVEN_BEND


def _other(fitted: Fit, best: Fit, place: int) -> list[str]:
    have = {s.name for s in best.suspects}
    return [s.name for s in fitted.suspects if s.name not in have]


def parameters_of(best: Fit, place: int, at: int) -> dict[str, Parameter]:
    """Free parameters by name, with 90 % intervals; and what was kept fixed, without"""
    suspect = best.suspects[place]
    coordinate = best.coordinate[at : at + len(suspect.free)]
    effect = suspect.effect(coordinate)
    found = {}
    for i, free in enumerate(suspect.free):
        if i >= len(suspect.free) - suspect.frozen:
            continue
        width = WIDTH_90 * float(np.sqrt(best.deviation[at + i, at + i]))
        ends = sorted((free.value(coordinate[i] - width), free.value(coordinate[i] + width)))
        found[free.name] = Parameter(free.value(float(coordinate[i])), (ends[0], ends[1]), free.unit)
    if any(free.name.startswith("ratio_at_") for free in suspect.free):
        found = _curve_points(best, place, at)
    fixed = dict(effect.__dict__)
    if isinstance(effect, BuildUp):
        fixed |= {f"centre_{axis}": c for axis, c in zip("xyz", effect.centre, strict=True)}
    for name, value in fixed.items():
        if name not in found and isinstance(value, int | float) and not isinstance(value, bool):
            found[name] = Parameter(float(value), None, "m" if name in PLACE else "")
    return found


def _curve_points(best: Fit, place: int, at: int) -> dict[str, Parameter]:
    """Ratios of a curve with intervals; steps from knot to knot add up, so their covariance counts"""
    suspect = best.suspects[place]
    n = len(suspect.free)
    coordinate = best.coordinate[at : at + n]
    ratio = np.array(suspect.effect(coordinate).__dict__["ratio"])
    total = np.tri(n) * (log_steps(coordinate + 1e-4) - log_steps(coordinate - 1e-4)) / 2e-4
    deviation = np.sqrt(np.diag(total @ best.deviation[at : at + n, at : at + n] @ total.T))
    return {
        free.name: Parameter(
            float(r), (float(r * np.exp(-WIDTH_90 * s)), float(r * np.exp(WIDTH_90 * s))), "-"
        )
        for free, r, s in zip(suspect.free, ratio[1:], deviation, strict=True)
    }


def _verdict(choice: Choice, effects: tuple[Effect, ...], after: tuple[NoiseTest, ...]) -> str:
    """adequate, effect_found, cannot_tell or unexplained"""
    if not effects:
        left = bool(after) and after[0].p < NOISE_LEVEL
        return "unexplained" if uneven(choice.best.spread) or left else "adequate"
    if choice.unsure or any(choice.instead_of(i) or choice.played_by[i] for i in range(len(effects))):
        return "cannot_tell"
    if any(SHAPE in effect.indistinguishable_from for effect in effects):
        return "cannot_tell"
    return "unexplained" if any(effect.tabulated for effect in effects) else "effect_found"


def _nuisance(best: Fit, factor: float) -> dict[str, object]:
    """Zero errors by occasion [measured unit], the tonnage book by interval [-], scatter of places [-], with 90 % intervals"""
    r = best.readings
    found = best.disturbance
    value, deviation = nuisances(found, best.spread, r.left(best.depth))
    names = r.survey.occasion_names
    told: dict[str, object] = {}
    kinds = ((0, "zero_error", r.survey.sign * factor), (3, "tonnage_book", 1.0), (5, "scale_error", 1.0))
    for group, key, unit in kinds:
        rows = found.group == group
        told[key] = {
            names[int(label)]: {"value": float(v / unit), "interval": sorted(float((v + side * WIDTH_90 * s) / unit) for side in (-1, 1))}
            for label, v, s in zip(found.label[rows], value[rows], deviation[rows], strict=True)
        }  # fmt: skip
    told["shift"] = {
        "xyz"[int(axis)]: {
            "value": float(v),
            "interval": sorted(float(v + side * WIDTH_90 * s) for side in (-1, 1)),
        }
        for axis, v, s in zip(
            found.label[found.group == 8], value[found.group == 8], deviation[found.group == 8], strict=True
        )
    }
    told["zero_error_deviation"] = best.spread.zero / factor
    told["tonnage_book_deviation"] = best.spread.book
    told["scale_error_deviation"] = best.spread.scale
    told["place_to_place_scatter"] = best.spread.scatter
    told["smooth_error_of_the_rate"] = best.spread.smooth
    told["smooth_error_of_a_campaign"] = best.spread.warp / factor if r.past.warped.shape[1] else 0.0
    told["run_own_sampling"] = run_own_sampling(best)
    told["bend_deviation"] = best.spread.bend if r.past.bent else 0.0
    told["initial_reading_deviation"] = best.spread.initial / factor
    return told


def run_own_sampling(fitted: Fit) -> float:
    """[-] what the run that gives the exposure does not know of the depth at the last readings: the median of its standard errors"""
    past = fitted.readings.past
    if not past.sampled.shape[2]:
        return 0.0
    growth = np.diff(fitted.depth, axis=1, prepend=0.0)
    error = np.sqrt(np.square((growth[:, :, None] * past.sampled).sum(axis=1)).sum(axis=1))
    return float(np.median(error / np.maximum(fitted.depth[:, -1], 1e-300)))


def _held_out_names(
    data: Readings, held: np.ndarray, named: tuple[str, ...] | None, improved: Fit
) -> HeldOut:
    survey, asked = data.survey, data.only(held)
    seen_points = set(survey.point[~held & ~survey.is_new].tolist())
    seen_occasions = set(survey.occasion[~held].tolist())
    points = [survey.point_names[p] for p in np.unique(survey.point) if p not in seen_points]
    occasions = [survey.occasion_names[o] for o in np.unique(survey.occasion) if o not in seen_occasions]
    undecided = improved.doubt(asked) > improved.spread.gauge
    left = (asked.worn - improved.predict(asked))[~undecided]
    return HeldOut(
        tuple(points), tuple(occasions), int(held.sum()),
        int((held & np.isin(survey.life, np.unique(survey.life[~held & ~survey.is_new]))).sum()), named,
        tuple(
            (survey.point_names[p], survey.occasion_names[o])
            for p, o in zip(asked.survey.point[undecided], asked.survey.occasion[undecided], strict=True)
        ),
        float(np.sqrt(np.mean(left**2))) / survey.measured_factor if len(left) else None,
    )  # fmt: skip


def _notes(choice: Choice, data: Readings) -> list[str]:
    """What a reader must know beside the figures"""
    course = data.survey.course
    notes = [] if course is None else list(course.notes)
    if data.survey.taken_as_replaced:
        notes.append(
            f"the plate at {in_words(data.survey.taken_as_replaced)} was taken to be replaced, since its wear vanished; a column "
            "specimen would tell"
        )
    spread = choice.best.spread
    if not data.survey.exposure_known:
        notes.append("no exposure was given: every place is taken to be exposed alike")
    if data.past.calendar is None:
        notes.append("the survey has no days: corrosion is looked for as if service were steady in time")
    if spread.scatter > EVEN_SCATTER:
        notes.append(f"places differ by {100 * spread.scatter:.0f} % in their rate, and no column says why")
    if bends(choice.best):
        notes.append(
            f"rates change with depth by {100 * spread.bend:.0f} % of themselves (standard deviation between places, at the deepest wear), "
            "each place in its own way: that is what a change of shape does; give --run with a run whose surface moves"
        )
    elif data.survey.course is None and any(s.quantity == "depth" for s in choice.best.suspects):
        notes.append(
            "the exposure does not follow the shape as it wears: what changes with depth alike everywhere is taken for the material; a "
            "coupled run, given as --run, tells whether the shape does that"
        )
    if spread.smooth > EVEN_SCATTER:
        notes.append(
            f"the rate is off by {100 * spread.smooth:.0f} %, smoothly from place to place, and no column says why"
        )
    for share, how in (
        (spread.scatter, "each place by itself"),
        (spread.smooth, "smoothly from place to place"),
    ):
        gauges = share * data.deepest / spread.gauge
        if gauges > 1.0 and share <= EVEN_SCATTER:
            notes.append(
                f"the rate is off by {100 * share:.1f} %, {how}: no more than careful work leaves, but {gauges:.1f} times the gauge where "
                "the wear is deepest, and so in the errors above; no effect explains it better"
            )
    if data.past.warped.shape[1] and spread.warp > 0.5 * spread.gauge:
        notes.append(
            "readings that lie side by side err alike in a campaign (a scan that is bent, a warm plate); that is taken into account"
        )
    if spread.book > EVEN_BOOK:
        notes.append(
            f"intervals differ by {100 * spread.book:.0f} % in their rate, at all places alike: the ore or the tonnage book"
        )
    if spread.scale > EVEN_SCALE:
        notes.append(
            f"campaigns differ by {100 * spread.scale:.0f} % of the wear, at all places alike: the gauge, the ore or the tonnage book"
        )
    if data.gauge and spread.gauge > 1.3 * data.gauge:
        notes.append(
            f"readings scatter {spread.gauge / data.gauge:.1f} times as much as their sigma says, model and nuisances apart"
        )
    if data.past.feature.get("temperature") is None or data.past.feature.get("ore_hardness") is None:
        missing = [n for n in ("temperature", "ore_hardness") if n not in data.past.feature]
        notes.append(f"not suspected, for want of a column: {in_words(missing)}")
    return notes


def _in_words(suggested: Suggestion | None, best: Fit) -> str:
    return "" if suggested is None else suggested.sentence


def coefficient_intervals(fitted: Fit) -> tuple[list[tuple[float, tuple[float, float]]], np.ndarray]:
    """Each mechanism's coefficient with its 90 % interval, and the correlation (e, e) of their logarithms."""
    model, e = fitted.model, fitted.readings.coefficients
    sums = np.eye(e)
    sums[1:, 0] = 1.0  # ln k_i = ln k_1 + ln ratio_i
    covariance = sums @ fitted.deviation[:e, :e] @ sums.T
    width = np.sqrt(np.diag(covariance))
    told = []
    for k, w in zip(
        model.coefficient * np.array([1.0, *model.ratio]), WIDTH_90 * COEFFICIENT_PRIOR * width, strict=True
    ):
        told.append((float(k), (float(k * np.exp(-w)), float(k * np.exp(w)))))
    return told, covariance / np.outer(width, width)
