"""An improvement in plain words, as the values of `improved.json`, and as the story that the improved case tells of itself."""

import math
from pathlib import Path
from textwrap import fill
from typing import Any

from wearfem.errors import in_words
from wearfem.improve import PART, Improvement, Round
from wearfem.record import file_hash
from wearfem.survey.diagnose import WIDTH_90, Effect, Score, parameters_of
from wearfem.survey.words import SAYS, parameter_in_words


def improvement_lines(found: Improvement) -> list[str]:
    """What was put in, and the errors before and after, as lines for a screen."""
    unit = found.diagnosis.survey.measured_unit
    rows = [("", "fitted", "never fitted")]
    rows += [
        (name, _number(score.train_rmse, unit), _number(score.heldout_rmse, unit))
        for name, score in _scores(found)
    ]
    rows += [("gauge, as the readings scatter", _number(found.diagnosis.noise_floor, unit), "")]
    wide = max(len(name) for name, _, _ in rows)
    table = [f"{name:<{wide}}  {fitted:>10}  {held:>13}".rstrip() for name, fitted, held in rows]
    return [
        "error (root mean square) of depth or thickness",
        *table,
        "",
        *(fill(line, 100) for line in sentences(found)),
    ]


def _scores(found: Improvement) -> list[tuple[str, Score]]:
    return [
        ("straight line per point", found.diagnosis.straight_line),
        ("run as it was given", found.as_given),
        ("coefficient alone", found.coefficient_alone),
        *([(f"with {_names(found)}, coupled run", found.improved)] if found.effects else []),
    ]


def _names(found: Improvement) -> str:
    return in_words([effect.name for effect in found.effects])


def _number(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value:.3g} {unit}"


def sentences(found: Improvement) -> list[str]:
    """What was changed, how sure that is, and what a reader must know."""
    told = [_changed(found)]
    for effect in found.effects:
        if effect.indistinguishable_from:
            others = in_words(effect.indistinguishable_from, "or")
            told.append(
                f"At these readings {effect.name} cannot be told from {others}; it was taken as the most probable."
            )
        if effect.tabulated:
            told.append(
                f"{effect.name} is tabulated: it says that the difference follows {effect.quantity}, and not why; beyond the range of "
                "these readings it is a guess."
            )
    dropped = [e.name for e in found.diagnosis.effects if e not in found.effects]
    if dropped and not found.no_better:
        told.append(
            f"{in_words(dropped)} was named along the run that was given; along the run with the rest in it the readings do not ask for "
            "it any more, and it was left out."
        )
    if found.no_better:
        told.append(
            f"{in_words([e.name for e in found.diagnosis.effects])} was found along the run that was given, but the coupled run with it "
            "does not predict the readings held out better than the coefficient alone: it was left out."
        )
    if not found.agreed:
        told.append(
            f"Run and readings do not agree yet: a parameter still moves by {found.last.change:.2g} of its standard deviation (less than "
            f"{PART:g} is asked); give --rounds more."
        )
    if found.own_sampling > 0.2 * found.diagnosis.noise_floor:
        known = _number(found.own_sampling, found.diagnosis.survey.measured_unit)
        told.append(
            f"The last run knows its own depths at the readings never fitted to {known} "
            "(sampling of the flow): with the gauge, no model of it can do better; a smaller tolerance of the case samples longer."
        )
    if found.again is not None:
        told.append(_left(found))
    return told


def _changed(found: Improvement) -> str:
    last = found.last
    low, high = _interval(last)
    runs = len(found.rounds)
    what = [f"the wear law times {last.put_in.factor:.4g} ({low:.4g} to {high:.4g}, 90 %)"]
    for i, effect in enumerate(found.effects):
        says = SAYS.get(effect.name) or f"a factor that follows {effect.quantity}, as a curve"
        shown = [
            parameter_in_words(n, p, found.diagnosis.survey)
            for n, p in _parameters(found, i).items()
            if p.interval
        ]
        what.append(f"{says} [{effect.name}: {', '.join(shown)}]")
    return f"After {runs} coupled run{'s' if runs > 1 else ''} the case has {in_words(what)}."


def _left(found: Improvement) -> str:
    again = found.again
    assert again is not None
    if again.verdict == "adequate":
        return "Diagnosed again along the last run: adequate, what is left is noise."
    named = in_words([effect.name for effect in again.effects])
    return f"Diagnosed again along the last run: {again.verdict.replace('_', ' ')} ({named}); something is still missing."


def _interval(last: Round) -> tuple[float, float]:
    width = WIDTH_90 * float(last.put_in.deviation[0])
    return last.put_in.factor * math.exp(-width), last.put_in.factor * math.exp(width)


def _parameters(found: Improvement, place: int) -> dict[str, Any]:
    fitted = found.last.put_in.fitted
    assert fitted is not None  # there are effects in the run
    at = 1 + sum(len(suspect.free) for suspect in fitted.suspects[:place])
    return parameters_of(fitted, place, at)


def improvement_values(found: Improvement, case: Path) -> dict[str, Any]:
    """The improvement as `improved.json` has it."""
    return {
        "verdict": found.diagnosis.verdict,
        "factor": {"value": found.last.put_in.factor, "interval": _interval(found.last), "unit": "-"},
        "effects": [_effect_values(found, i, effect) for i, effect in enumerate(found.effects)],
        "as_given": found.as_given,
        "straight_line": found.diagnosis.straight_line,
        "coefficient_alone": found.coefficient_alone,
        "improved": found.improved,
        "noise_floor": found.diagnosis.noise_floor,
        "run_own_sampling": found.own_sampling,
        "agreed": found.agreed,
        "rounds": [
            {
                "run": one.run,
                "factor_of_the_run": one.put_in.factor,
                "factor_by_the_readings": one.told.factor,
                "largest_change_in_standard_deviations": one.change,
            }
            for one in found.rounds
        ],
        "heldout": found.diagnosis.heldout,
        "what_is_left": found.again
        and {"verdict": found.again.verdict, "effects": [e.name for e in found.again.effects]},
        "case": case,
        "sentences": sentences(found),
    }


def _effect_values(found: Improvement, place: int, effect: Effect) -> dict[str, Any]:
    return {
        "name": effect.name.partition("(")[0],
        "parameters": _parameters(found, place),
        "probability": effect.probability,
        "indistinguishable_from": effect.indistinguishable_from,
        "tabulated": effect.tabulated,
    }


def story(found: Improvement, survey: Path, run: Path) -> str:
    """Where an improved case comes from."""
    unit = found.diagnosis.survey.measured_unit
    never = found.diagnosis.heldout.readings
    fitted = found.diagnosis.survey.size - len(found.diagnosis.doubts) - never
    what = _names(found) if found.effects else "another coefficient"
    scores = [f"    {name:<44} {_number(score.heldout_rmse, unit)}" for name, score in _scores(found)]
    return "\n".join(
        [
            f"A case with what a survey asked for: {what}. Written by wearfem improve.",
            "",
            *(fill(line, 110) for line in sentences(found)),
            "",
            f"    survey  {survey.name}, sha256 {file_hash(survey)}",
            f"    run     {run.name}, whose keywords are the defaults below",
            f"    fitted to {fitted} readings; {never} were never fitted",
            "",
            "Error on readings never fitted, root mean square",
            *scores,
            f"    {'gauge, as the readings scatter':<44} {_number(found.diagnosis.noise_floor, unit)}",
        ]
    )
