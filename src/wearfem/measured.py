"""What the commands `calibrate`, `diagnose` and `forecast` do with a survey: read, compute, say it in words, write it down."""

from pathlib import Path
from typing import Any

from wearfem.diagnosis_page import PAGE, write_page
from wearfem.errors import UserError
from wearfem.record import require_writable, write_json
from wearfem.settings import parse_value
from wearfem.survey.backtest import BackTest, back_test
from wearfem.survey.calibrate import calibrate
from wearfem.survey.columns import column
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
    limit: str | None = None,
    next_stop: str | None = None,
) -> None:
    """Print the diagnosis of a survey, and write it where asked; into a folder with forecast, back-test and one page."""
    read = _read(survey, progress, exposure, run)
    files = [file for file in (json_file, out / "diagnosis.json" if out else None) if file]
    if out:
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(f"{out} cannot be made ({error.strerror}); give --out another folder") from error
        require_writable(out / PAGE)
    for file in files:
        require_writable(file)
    asked = limit_of(limit), stop_of(next_stop, read)
    found = diagnose(read)
    print("\n".join(diagnosis_lines(found)), flush=True)
    ahead = forecast(found.choice, *asked)
    if limit:
        print("\n".join(forecast_lines(ahead)), flush=True)
    if out:
        tested = back_test(read)
        print("\n".join(back_test_lines(tested, read)))
        write_json(out / "forecast.json", _told(ahead, tested, read))
        write_page(out / PAGE, found, ahead, tested, [file for file in (survey, exposure) if file])
        print(f"wrote {out / PAGE} and {out / 'forecast.json'}")
    for file in files:
        write_json(file, diagnosis_values(found))
        print(f"wrote {file}")


def forecast_survey(
    survey: Path,
    limit: str | None,
    next_stop: str | None,
    progress: str = "",
    exposure: Path | None = None,
    run: Path | None = None,
    json_file: Path | None = None,
) -> None:
    """Print when the plates of a survey come to a limit, and what earlier forecasts would have been worth; write it where asked."""
    read = _read(survey, progress, exposure, run)
    if limit is None:
        quantity, unit = read.measured_name.removesuffix(f"_{read.measured_unit}"), read.measured_unit
        raise UserError(
            f"{survey} is a survey, and no limit was given; give the {quantity} at which a plate is worn out, as in "
            f'--limit "8*{unit if unit in ("mm", "um", "cm") else "gram"}"'
        )
    if json_file:
        require_writable(json_file)
    asked = limit_of(limit), stop_of(next_stop, read)
    found = diagnose(read, name_without=False)
    ahead = forecast(found.choice, *asked)
    print("\n".join(forecast_lines(ahead)), flush=True)
    tested = back_test(read)
    print("\n".join(back_test_lines(tested, read)))
    if json_file:
        write_json(json_file, _told(ahead, tested, read))
        print(f"wrote {json_file}")


def _told(ahead: Forecast, tested: BackTest, survey: Survey) -> dict[str, Any]:
    return {"forecast": forecast_values(ahead), "back_test": back_test_values(tested, survey)}


def limit_of(text: str | None) -> float | None:
    """A limit [SI of what was measured] from what was typed, `8*mm`."""
    return None if text is None else _number("--limit", text)


def stop_of(text: str | None, survey: Survey) -> float | None:
    """The progress of the next stop, in the survey's unit, from what was typed, `1200*kt`; a bare number where the survey names no unit."""
    if text is None:
        return None
    told = column(survey.progress_name)
    return _number("--next-stop", text) / told.factor


def _number(option: str, text: str) -> float:
    try:
        value = parse_value(option, text)
    except UserError as error:
        raise UserError(str(error).removeprefix("--set ")) from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise UserError(f'{option} was given "{text}"; it needs a number with a unit, as in {option} "8*mm"')
    return float(value)


def _read(survey: Path, progress: str, exposure: Path | None, run: Path | None) -> Survey:
    if run is not None:
        raise UserError(
            f"--run {run} was given, and runs do not tell the exposure of survey points yet; give --exposure with a CSV file "
            "(point, exposure and features of the state)"
        )
    return read_survey(survey, progress=progress, exposure=exposure)
