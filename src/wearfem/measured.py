"""What the commands `calibrate` and `diagnose` do: read, compute, say it in words, write it down."""

from pathlib import Path

from wearfem.errors import UserError
from wearfem.record import require_writable, write_json
from wearfem.survey.calibrate import calibrate
from wearfem.survey.diagnose import diagnose
from wearfem.survey.survey import Survey, read_survey
from wearfem.survey.words import calibration_lines, calibration_values, diagnosis_lines, diagnosis_values


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
) -> None:
    """Print the diagnosis of a survey, and write `diagnosis.json` into the folder and where asked."""
    read = _read(survey, progress, exposure, run)
    files = [file for file in (json_file, out / "diagnosis.json" if out else None) if file]
    if out:
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(f"{out} cannot be made ({error.strerror}); give --out another folder") from error
    for file in files:
        require_writable(file)
    found = diagnose(read)
    print("\n".join(diagnosis_lines(found)))
    for file in files:
        write_json(file, diagnosis_values(found))
        print(f"wrote {file}")


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
