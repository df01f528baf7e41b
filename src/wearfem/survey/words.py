"""A calibration and a diagnosis in plain words, and as the values that go into JSON."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from wearfem.errors import in_words
from wearfem.survey.backtest import NAMES, BackTest, advised
from wearfem.survey.calibrate import Calibration
from wearfem.survey.diagnose import NOISE_LEVEL, PLACE, Diagnosis, Effect, Parameter, Score
from wearfem.survey.doubt import Doubt
from wearfem.survey.forecast import FULL, SHARE, End, Forecast, Outlook
from wearfem.survey.residual import NoiseTest
from wearfem.survey.survey import Survey

LONGEST = 100  # characters of a line

SAYS = {
    "HardnessGradient": "hardness falls through the thickness",
    "Overlay": "a harder layer lies on a softer plate",
    "RunningIn": "a new surface wears faster at first",
    "RunningInByThroughput": "wear is faster at first, by service and not by depth",
    "WorkHardening": "impacts harden the surface",
    "OreChange": "another ore from a date on",
    "OreHardness": "harder ore wears faster",
    "Temperature": "wear depends on temperature",
    "Corrosion": "the plate corrodes with calendar time",
    "PressureExponent": "wear is not in proportion to pressure",
    "SpeedExponent": "wear does not follow the speed as the law says",
    "ImpactAngleCurve": "wear depends on the angle of impact in another way",
    "SlipShare": "grains that roll wear differently from grains that slide",
    "BuildUp": "material covers a patch",
    "DeadZone": "slow material covers the liner",
    "LateralBias": "the feed comes in on one side",
    "AngularityLoss": "grains lose their edges on the way",
}


def diagnosis_lines(found: Diagnosis) -> list[str]:
    """The diagnosis as lines for a screen; labels left, words right."""
    unit = found.survey.measured_unit
    rows: list[tuple[str, str]] = [
        ("read", _read(found.survey)),
        (
            "model as it is",
            f"{_error(found.baseline, unit)} (gauge {found.noise_floor:.2g} {unit}; {_line(found, unit)})",
        ),
        (_label(found.tests_before, bool(found.effects)), _noise(found.tests_before, bool(found.effects))),
        *(("doubted", _doubt(doubt)) for doubt in found.doubts),
        *(("nuisances", told) for told in _nuisances(found)),
    ]
    for effect in found.effects:
        rows.append(
            ("missing effect", f"{effect_words(effect, found.survey)}, probability {effect.probability:.2f}")
        )
        others = (
            in_words(effect.indistinguishable_from, "or")
            if effect.indistinguishable_from
            else "nothing at these readings"
        )
        rows.append(("", f"cannot be told from: {others}"))
    if found.effects:
        rows.append(("added", _error(found.improved, unit)))
        if found.heldout.undecided:
            rows.append(("", _undecided(found)))
        rows.append(("what is left", _noise(found.tests_after, False)))
        without = found.heldout.named_without_them
        if without is not None and set(without) != {effect.name for effect in found.effects}:
            rows.append(
                ("", f"without the held-out readings the choice would have been: {in_words(list(without))}")
            )
    rows.append(("verdict", verdict_words(found)))
    course = found.survey.course
    if found.effects and course is not None and not course.follows_shape:
        rows.append(
            (
                "",
                "the run kept the geometry as new: what is found may be the change of shape; run the case with its geometry moving, and "
                "diagnose along that run",
            )
        )
    if found.effects and found.effects[0].suggested_measurement:
        rows.append(("measure next", found.effects[0].suggested_measurement))
    rows += [("note", note) for note in found.notes]
    return list(_wrapped(rows))


VERDICT = {
    "adequate": "adequate: the model says what these readings say, within their noise",
    "effect_found": "effect found",
    "cannot_tell": "cannot tell: something is missing, and more than one explanation fits these readings",
    "unexplained": "unexplained: something is missing that no effect of the library describes",
}


def verdict_words(found: Diagnosis) -> str:
    """The verdict; where an effect was named and what it leaves is still more than noise, that too."""
    words = VERDICT[found.verdict]
    return f"{words}; but {more_words(found)}" if found.effects and found.more_than_noise else words


def more_words(found: Diagnosis) -> str:
    """That what was named is not all, where what is left is more than noise."""
    first = found.tests_after[0]
    return (
        f"it is not all: what is left is more than noise ({_least(first)}, most with {first.quantity}), and nothing that was tried "
        "explains that surely"
    )


def _read(survey: Survey) -> str:
    return (
        f"{survey.size} readings of {len(survey.life_point)} plates at {len(survey.point_names)} points, "
        f"{len(survey.occasion_names)} occasions"
    )


def _error(score: Score, unit: str) -> str:
    if score.heldout_rmse is None:
        return (
            f"error {score.train_rmse:.3g} {unit} on the readings it was fitted to; too few to hold any out"
        )
    return f"error on readings never fitted {score.heldout_rmse:.3g} {unit}"


def _undecided(found: Diagnosis) -> str:
    """Readings, kept back, that no other tells"""
    held = found.heldout
    points = tuple(dict.fromkeys(point for point, _ in held.undecided))
    where = (
        f"point{'s' * (len(points) > 1)} {in_words(points)}" if len(points) <= 4 else f"{len(points)} points"
    )
    words = (
        f"{len(held.undecided)} of these {held.readings}, at {where}, are told by the fitted ones no better than to the gauge's error, "
        "even if the model is right"
    )
    rest = held.decided_rmse
    return words if rest is None else f"{words}; error on the rest {rest:.3g} {found.survey.measured_unit}"


def _line(found: Diagnosis, unit: str) -> str:
    line = found.straight_line.heldout_rmse
    return "no straight line to compare" if line is None else f"straight line per point {line:.3g} {unit}"


def _label(tests: Sequence[NoiseTest], named: bool) -> str:
    return "not noise" if named or tests[0].p < NOISE_LEVEL else "noise"


def _noise(tests: Sequence[NoiseTest], named: bool) -> str:
    first = tests[0]
    if first.p >= NOISE_LEVEL and named:
        return (
            f"p {first.p:.2g} against {first.quantity} in general; an effect of a known shape stands out more"
        )
    if first.p >= NOISE_LEVEL:
        return f"what is left is noise as far as can be seen (least p {first.p:.2g}, with {first.quantity})"
    strong = [t for t in tests if t.p < NOISE_LEVEL]
    return f"{_least(first)}; what is left depends most on {in_words([t.quantity for t in strong[:3]])}"


def _least(test: NoiseTest) -> str:
    return f"p < {max(test.p, 1e-99):.0e}"


def _doubt(doubt: Doubt) -> str:
    return f"point {doubt.point}, occasion {doubt.occasion}: {doubt.why}; left out"


def _nuisances(found: Diagnosis) -> list[str]:
    told = []
    unit = found.survey.measured_unit
    zero: Any = found.nuisance["zero_error"]
    for occasion, error in zero.items():
        low, high = error["interval"]
        if abs(error["value"]) > 2.0 * found.noise_floor / 3.0 and (low > 0.0 or high < 0.0):
            side = "high" if error["value"] > 0.0 else "low"
            told.append(
                f"occasion {occasion} reads {abs(error['value']):.2g} {unit} {side} everywhere (zero error): corrected"
            )
    scatter: Any = found.nuisance["place_to_place_scatter"]
    if scatter > 0.01:
        told.append(f"places that should wear alike differ by {100 * scatter:.2g} %")
    return told


def says(effect: Effect) -> str:
    """What an effect says, without numbers."""
    return (
        SAYS.get(effect.name)
        or f"a factor that follows {effect.quantity}, as a curve (tabulated, no formula)"
    )


def effect_words(effect: Effect, survey: Survey) -> str:
    """An effect with its parameters and their intervals."""
    shown = [
        parameter_in_words(n, p, survey) for n, p in effect.parameters.items() if p.interval or n in PLACE
    ]
    return f"{says(effect)} [{effect.name}]: {', '.join(shown)}"


def parameter_in_words(name: str, parameter: Parameter, survey: Survey) -> str:
    """A parameter with its interval and its unit."""
    unit = parameter.unit.replace("progress", survey.progress_unit or survey.progress_name)
    factor, unit = (1e3, "mm") if unit == "m" and name not in PLACE else (1.0, unit)
    factor, unit = (1e-3, "1/mm") if unit == "1/m" and name == "loss" else (factor, unit)
    value = f"{name} {factor * parameter.value:.3g}"
    if parameter.interval:
        value += f" ({factor * parameter.interval[0]:.3g} to {factor * parameter.interval[1]:.3g})"
    return value if unit in {"-", ""} else f"{value} {unit}"


def _wrapped(rows: Iterable[tuple[str, str]]) -> Iterable[str]:
    from textwrap import wrap

    for label, words in rows:
        first, *rest = wrap(words, LONGEST - 18) or [""]
        yield f"{label:<16}  {first}"
        yield from (f"{'':<16}  {line}" for line in rest)


def diagnosis_values(found: Diagnosis) -> dict[str, Any]:
    """The diagnosis as `diagnosis.json` has it."""
    return {
        "verdict": found.verdict,
        "baseline": found.baseline,
        "straight_line": found.straight_line,
        "improved": found.improved,
        "noise_floor": found.noise_floor,
        "effects": [
            {
                "name": effect.name.partition("(")[0],
                "parameters": effect.parameters,
                "probability": effect.probability,
                "indistinguishable_from": effect.indistinguishable_from,
                "suggested_measurement": effect.suggested_measurement,
            }
            for effect in found.effects
        ],
        "left_over": {"noise": not found.more_than_noise, "level": NOISE_LEVEL, "tests": found.tests_after},
        "nuisance": {**found.nuisance, "doubted": found.doubts},
        "heldout": found.heldout,
    }


def calibration_lines(found: Calibration, survey: Survey) -> list[str]:
    """A calibration as lines for a screen."""
    low, high = found.interval
    rows = [
        ("read", _read(survey)),
        ("coefficient", f"{found.coefficient:.4g} ({low:.4g} to {high:.4g}, 90 %) {found.unit}{_of(survey)}"),
        *(
            (
                "",
                f"{k:.4g} ({a:.4g} to {b:.4g}, 90 %) of {name}; correlation with that of {survey.mechanisms[0]} {r:.2f}",
            )
            for (name, (k, (a, b))), r in zip(found.others.items(), found.correlation[0, 1:], strict=True)
        ),
        (
            "error",
            f"{found.rmse:.3g} {survey.measured_unit} RMSE, gauge {found.gauge:.2g} {survey.measured_unit}",
        ),
        *(("doubted", _doubt(doubt)) for doubt in found.doubts),
        (_label(found.tests, False), _noise(found.tests, False)),
    ]
    if not survey.exposure_known:
        rows.append(("note", "no exposure was given: every place is taken to be exposed alike"))
    rows += [("note", note) for note in (survey.course.notes if survey.course else ())]
    return list(_wrapped(rows))


def _of(survey: Survey) -> str:
    return f", of {survey.mechanisms[0]}" if survey.mechanisms else ""


def calibration_values(found: Calibration) -> dict[str, Any]:
    """A calibration as JSON has it."""
    return {
        "coefficient": {"value": found.coefficient, "interval": found.interval, "unit": found.unit},
        "other_coefficients": {
            name: {"value": k, "interval": interval, "unit": found.unit}
            for name, (k, interval) in found.others.items()
        },
        "correlation": found.correlation,
        "rmse": found.rmse,
        "gauge": found.gauge,
        "doubted": found.doubts,
        "noise_tests": found.tests,
    }


SHOWN = 6  # points that come to the limit first


def forecast_lines(found: Forecast, tested: BackTest) -> list[str]:
    """A forecast as lines for a screen: which one to plan by and why; then when the limit is reached, by model, for zones and points."""
    unit = progress_unit(found.survey)
    rows = [("limit", f"{limit_words(found)}; service goes on as it did{_pace(found)}")]
    lines = list(_wrapped(rows))
    if found.limit is None:
        return lines
    advice = advised(found, tested)
    zones = list(dict.fromkeys(found.zones))
    ends = [(zone, found.of_zone(advice.outlook, zone)) for zone in zones]
    lines += _wrapped([("plan by", advice_words(found, tested))])
    lines += [
        f"{'worn out at' if i == 0 else '':<18}{zone[:24]}: {end_words(end, found)} {unit}"
        for i, (zone, end) in enumerate(ends)
    ]
    if found.next_stop is not None:
        told = [f"{zone} {end.reaches:.0%}" for zone, end in ends if end.reaches is not None]
        lines += _wrapped([("next stop", f"at {found.next_stop:.4g} {unit} is reached by {in_words(told)}")])
    lines += _wrapped([("all forecasts", f"service in {unit}, by")])
    lines.append(f"{'':<18}" + "".join(f"{o.name:<26}" for o in found.outlooks).rstrip())
    for names, end_at in ((zones, found.of_zone), (first_points(found)[:SHOWN], found.of_place)):
        for name in dict.fromkeys(names):
            by_model = [end_at(outlook, name) for outlook in found.outlooks]
            lines.append(
                f"{name[:16]:<18}" + "".join(f"{end_words(end, found):<26}" for end in by_model).rstrip()
            )
    told_as = (
        f"median and interval of {SHARE:.0%}; nothing is told beyond {found.progress[-1]:.4g} {unit} (>)"
    )
    return [*lines, *_wrapped([("note", told_as)])]


def advice_words(found: Forecast, tested: BackTest) -> str:
    """Which forecast to plan by, and what says so."""
    advice, unit = advised(found, tested), found.survey.measured_unit
    name = advice.outlook.name
    if not advice.tested:
        return f"{name}; nothing tells what earlier forecasts would have been worth, since four occasions are needed to foretell one"
    error = dict(zip(NAMES, tested.rmse / found.survey.measured_factor, strict=True))
    shown = [o.name for o in found.outlooks]
    others = in_words([f"{other} by {error[other]:.3g} {unit}" for other in shown if other != name])
    words = (
        f"{name}: when earlier occasions were foretold it erred least, by {error[name]:.3g} {unit}; {others}"
    )
    if name != shown[-1]:
        words += (
            f". The model {shown[-1]} explains the readings better, and yet foretells them worse"
            if shown[-1] == FULL
            else ". One coefficient explains the readings, and yet a line per point foretells them better"
        )
    held = float(tested.coverage[NAMES.index(name)])
    if advice.stretch > 1.0:
        words += f". Its intervals of {SHARE:.0%} held {held:.0%} of those readings: here they are {advice.stretch:.2g} times as wide"
    return words


def first_points(found: Forecast) -> list[str]:
    """Names of points, those first that come to the limit first by the last model."""
    end = {place: found.of_place(found.outlooks[-1], place).median for place in dict.fromkeys(found.places)}
    return sorted(end, key=lambda place: (np.isnan(end[place]), end[place]))


def progress_unit(survey: Survey) -> str:
    """The unit of service, or the name of its column where that has none"""
    return survey.progress_unit or survey.progress_name


def limit_words(found: Forecast) -> str:
    """The limit in words: what is left, or what is lost."""
    if found.limit is None:
        return "none was given: wear is told, and no life"
    survey = found.survey
    value = f"{found.limit / survey.measured_factor:.4g} {survey.measured_unit}"
    quantity = survey.measured_name.removesuffix(f"_{survey.measured_unit}").replace("_", " ")
    return (
        f"{quantity} of {value} must be left"
        if survey.sign < 0.0
        else f"{quantity} of {value} may be reached"
    )


def _pace(found: Forecast) -> str:
    if found.days is None:
        return ""
    return f", {1.0 / found.days:.3g} {progress_unit(found.survey)} a day"


def end_words(end: End, found: Forecast) -> str:
    """An end of life with its interval in a few words, in the unit of service."""
    if np.isnan(end.median):
        return "no reading, no line"
    far = f">{found.progress[-1]:.4g}"
    low, high = (f"{value:.4g}" if np.isfinite(value) else far for value in end.interval)
    if end.interval[1] <= found.now:
        return "limit passed"
    middle = f"{end.median:.4g}" if np.isfinite(end.median) else far
    return middle if low == high == far else f"{middle} ({low} to {high})"


def forecast_values(found: Forecast, tested: BackTest) -> dict[str, Any]:
    """A forecast as JSON has it; null stands for beyond reach."""
    survey = found.survey
    factor = survey.measured_factor
    advice = advised(found, tested)

    def told(end: End) -> dict[str, Any]:
        return {
            "place": end.place, "worn_out_at": end.median, "interval": end.interval, "beyond_reach": end.beyond,
            "remaining": end.median - found.now, "reaches_next_stop": end.reaches,
        }  # fmt: skip

    def ends(outlook: Outlook) -> dict[str, Any]:
        return {
            "name": outlook.name,
            "zones": [told(found.of_zone(outlook, zone)) for zone in dict.fromkeys(found.zones)],
            "points": [told(found.of_place(outlook, place)) for place in dict.fromkeys(found.places)],
        }

    return {
        "limit": None if found.limit is None else found.limit / factor,
        "measured": survey.measured_name,
        "progress": survey.progress_name,
        "now": found.now,
        "next_stop": found.next_stop,
        "reach": float(found.progress[-1]),
        "share_of_intervals": SHARE,
        "days_by_progress": found.days,
        "recommended": None if found.limit is None else {"stretched": advice.stretch, "tested": advice.tested} | ends(advice.outlook),
        "models": [ends(outlook) for outlook in found.outlooks if found.limit is not None],
    }  # fmt: skip


def back_test_lines(found: BackTest, survey: Survey) -> list[str]:
    """A back-test as lines for a screen."""
    if not found.occasions:
        return list(_wrapped([("back-test", "four occasions are needed to foretell one; there are fewer")]))
    said = f"{len(found.occasions)} occasions foretold from those before them, {found.readings} readings"
    lines = list(_wrapped([("back-test", said)]))
    for name, rmse, share in zip(NAMES, found.rmse / survey.measured_factor, found.coverage, strict=True):
        words = f"{name:<24} error {rmse:.3g} {survey.measured_unit}"
        lines.append(f"{'':<18}{words:<46} {share:.0%} of readings in the {SHARE:.0%} interval")
    return lines


def back_test_values(found: BackTest, survey: Survey) -> dict[str, Any]:
    """A back-test as JSON has it, errors in the measured unit."""
    factor = survey.measured_factor
    if not found.occasions:
        return {"readings": 0, "models": [], "occasions": []}
    return {
        "readings": found.readings,
        "models": [
            {"name": name, "rmse": rmse, "coverage": share}
            for name, rmse, share in zip(NAMES, found.rmse / factor, found.coverage, strict=True)
        ],
        "occasions": [
            {
                "occasion": f.occasion, "progress": f.progress, "readings": f.error.shape[1], "named": f.named,
                "rmse": f.rmse / factor, "coverage": f.held.mean(axis=1),
            }
            for f in found.occasions
        ],
    }  # fmt: skip
