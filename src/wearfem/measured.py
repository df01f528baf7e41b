"""What the commands do with a survey (`calibrate`, `diagnose`, `forecast`, `improve`): read, compute, say it in words, write it down."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wearfem.diagnosis_page import PAGE, write_page
from wearfem.errors import UserError, in_words
from wearfem.foretell import quantity
from wearfem.record import require_writable, whole_file, write_json
from wearfem.survey.backtest import BackTest, back_test
from wearfem.survey.calibrate import calibrate
from wearfem.survey.columns import UNITS, column
from wearfem.survey.diagnose import diagnose
from wearfem.survey.forecast import Forecast, forecast
from wearfem.survey.survey import Survey, read_survey
from wearfem.survey.words import (
    back_test_lines,
    back_test_values,
    calibration_lines,
    calibration_values,
    diagnosis_lines,
    diagnosis_values,
    forecast_lines,
    forecast_values,
)

LIKE = {
    "g": "8*gram",
    "mg": "8*gram",
    "kg": "8*kg",
    "mm3": "8*mm**3",
    "cm3": "8*cm**3",
}  # limits as one types them


def calibrate_survey(
    survey: Path, progress: str, exposure: Path | None, run: Path | None, json_file: Path | None
) -> None:
    """Print the coefficient of a survey, and write it where asked."""
    read = _read(survey, progress, exposure, run)
    if json_file:
        require_writable(json_file)
    found = calibrate(read)
    print("\n".join(calibration_lines(found, read)))
    if json_file:
        write_json(json_file, calibration_values(found))


def diagnose_survey(
    survey: Path,
    progress: str,
    exposure: Path | None,
    run: Path | None,
    out: Path | None,
    json_file: Path | None,
    limit: str = "",
    next_stop: str = "",
) -> None:
    """Print the diagnosis of a survey, and write it where asked; into a folder with forecast, back-test and one page."""
    read = _read(survey, progress, exposure, run)
    files = [file for file in (json_file, out / "diagnosis.json" if out else None) if file]
    if out:
        _folder(out)
        require_writable(out / PAGE)
    for file in files:
        require_writable(file)
    asked = limit_of(limit, read), stop_of(next_stop, read)
    found = diagnose(read)
    print("\n".join(diagnosis_lines(found)), flush=True)
    ahead = forecast(found.choice, *asked)
    tested = back_test(read) if limit or out else BackTest(())
    if limit:
        print("\n".join(forecast_lines(ahead, tested)), flush=True)
    if limit or out:
        print("\n".join(back_test_lines(tested, read)))
    if out:
        write_json(out / "forecast.json", _told(ahead, tested, read))
        write_page(out / PAGE, found, ahead, tested, [file for file in (survey, exposure) if file])
        print(f"wrote {out / PAGE} and {out / 'forecast.json'}")
    for file in files:
        write_json(file, diagnosis_values(found))
        print(f"wrote {file}")


def forecast_survey(
    survey: Path,
    asked: Mapping[str, Any],
    progress: str,
    exposure: Path | None,
    run: Path | None,
    out: Path | None,
    json_file: Path | None,
) -> None:
    """Print when the plates of a survey come to a limit, and what earlier forecasts would have been worth; write it where asked.

    Of what was `asked` on the command line only `limit` and `next_stop` make sense; the rest is refused.
    """
    read = _read(survey, progress, exposure, run)
    more = [
        name
        for name, value in asked.items()
        if name not in ("limit", "next_stop") and value not in ("", None)
    ]
    if more:
        words = in_words([f"--{name.replace('_', '-')}" for name in more])
        raise UserError(
            f"{survey} is a survey, and {words} is for runs; of a survey give --limit and --next-stop"
        )
    if not asked["limit"]:
        measured, unit = read.measured_name.removesuffix(f"_{read.measured_unit}"), read.measured_unit
        raise UserError(
            f"{survey} is a survey, and no limit was given; give the {measured.replace('_', ' ')} at which a plate is worn out, like "
            f"--limit {LIKE.get(unit, '8*mm')}"
        )
    for file in filter(None, (out, json_file)):
        require_writable(file)
    limit, next_stop = limit_of(asked["limit"], read), stop_of(asked["next_stop"], read)
    found = diagnose(read, name_without=False)
    ahead = forecast(found.choice, limit, next_stop)
    tested = back_test(read)
    lines = [*forecast_lines(ahead, tested), *back_test_lines(tested, read)]
    print("\n".join(lines))
    if out:
        with whole_file(out) as temporary:
            temporary.write_text("\n".join([*lines, ""]), encoding="utf-8")
    if json_file:
        write_json(json_file, _told(ahead, tested, read))
    for file in filter(None, (out, json_file)):
        print(f"wrote {file}")


def _told(ahead: Forecast, tested: BackTest, survey: Survey) -> dict[str, Any]:
    return {"forecast": forecast_values(ahead, tested), "back_test": back_test_values(tested, survey)}


def limit_of(text: str, survey: Survey) -> float | None:
    """A limit [SI of what was measured] from what was typed, `8*mm`; None for nothing."""
    kind = {"kg": "mass"}.get(UNITS[survey.measured_unit][2], "length")  # a volume is mm**3
    return quantity("limit", text, kind) if text else None


def stop_of(text: str, survey: Survey) -> float | None:
    """The progress of the next stop in the survey's unit, from `1200*kt`, or from a bare number where the survey names no unit."""
    if not text:
        return None
    told = column(survey.progress_name)
    kind = {"s": "time", "kg": "mass", "m": "length"}.get(UNITS[told.unit][2] if told.unit else "")
    if kind:
        return quantity("next-stop", text, kind) / told.factor
    try:
        return float(text)
    except ValueError:
        raise UserError(
            f"--next-stop was given {text}; {survey.progress_name} of {survey.source} has no unit, so expected is a bare number like "
            f"{1.2 * survey.progress.max():.4g}"
        ) from None


def improve_with_survey(
    survey: Path,
    progress: str,
    run: Path,
    out: Path,
    rounds: int,
    json_file: Path | None,
    quiet: bool,
) -> None:
    """Put into a case what a survey asks for, repeat its coupled run until both agree, and write the improved case.

    The folder gets `diagnosis.json`, `improved.json`, `improved/case.py` and, in `rounds`, the case and the run of each round.
    """
    from wearfem.improve import improve  # here, since it loads the liner
    from wearfem.improve_words import improvement_lines, improvement_values, story

    if rounds < 1:
        raise UserError(f"--rounds {rounds} was given; one coupled run is the least: give 1 or more")
    _folder(out)
    files = [file for file in (json_file, out / "improved.json") if file]
    for file in (*files, out / "diagnosis.json"):
        require_writable(file)
    read = read_survey(survey, progress=progress)
    if read.exposure_known:
        raise UserError(f"{survey} has a column exposure, and --run {run} was given too; give one of them")
    found = improve(read, run, out, rounds=rounds, quiet=quiet)
    print("\n".join(["", *diagnosis_lines(found.diagnosis), "", *improvement_lines(found)]))
    write_json(out / "diagnosis.json", diagnosis_values(found.diagnosis))
    case = found.write(out / "improved", story(found, survey, run))
    for file in files:
        write_json(file, improvement_values(found, case))
        print(f"wrote {file}")
    print(f"wrote {case}: wearfem run {case.parent}")


def _folder(out: Path) -> None:
    """Make a folder, or take one that is there and is no run's: its report would be written over."""
    if (out / "manifest.json").exists():
        raise UserError(
            f"{out} is the folder of a run, whose report would be written over; give --out another folder"
        )
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"{out} cannot be made ({error.strerror}); give --out another folder") from error


def _read(survey: Path, progress: str, exposure: Path | None, run: Path | None) -> Survey:
    if run is None:
        return read_survey(survey, progress=progress, exposure=exposure)
    if exposure is not None:
        raise UserError(
            f"--run {run} and --exposure {exposure} were given; both tell the exposure of points: give one of them"
        )
    from wearfem.exposure import exposed_by_run  # here, since it loads the liner

    read = read_survey(survey, progress=progress)
    if read.exposure_known:
        raise UserError(f"{survey} has a column exposure, and --run {run} was given too; give one of them")
    return exposed_by_run(read, run)
