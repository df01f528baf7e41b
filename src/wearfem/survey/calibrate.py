"""The coefficient of wear from a survey, with its interval, robust to readings that are wrong.

Readings that do not go with their neighbours are left out first, then those further than 6 gauge errors from the calibrated model if they
are few (many would be the model's fault). What is left is fitted by weighted least squares in which zero errors, the tonnage book and
scatter between places are integrated out, so that 100 readings of one plate do not count as 100 plates.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wearfem.errors import UserError
from wearfem.survey.diagnose import coefficient_intervals
from wearfem.survey.doubt import Doubt, doubted
from wearfem.survey.identify import Fit, plain_fit, readings
from wearfem.survey.nuisance import nuisances
from wearfem.survey.residual import NoiseTest, noise_tests
from wearfem.survey.survey import Survey

FAR = 6.0  # gauge errors
FEW = 0.05  # share of readings


@dataclass(frozen=True)
class Calibration:
    """A coefficient and what stands behind it.

    Parameters
    ----------
    coefficient, interval
        Wear [SI: m, kg or m3] by unit of exposure and of progress; 90 %. Of the first mechanism where there are several.
    others
        The same by name of each other mechanism.
    correlation
        (e, e) [-] of the logarithms of all coefficients, the first first.
    unit
        Of the coefficient, in words.
    gauge
        [measured unit] of one reading, as the scatter tells.
    rmse
        [measured unit] of the calibrated model, nuisances not taken off.
    doubts
        Readings left out, and why.
    tests
        Whether what is left is noise, by quantity.
    fitted
        The fit itself.
    """

    coefficient: float
    interval: tuple[float, float]
    unit: str
    gauge: float
    rmse: float
    doubts: tuple[Doubt, ...]
    tests: tuple[NoiseTest, ...]
    fitted: Fit
    others: Mapping[str, tuple[float, tuple[float, float]]]
    correlation: np.ndarray


def calibrate(survey: Survey) -> Calibration:
    """The coefficient of a survey with its 90 % interval.

    Raises
    ------
    UserError
        for a survey without wear.
    """
    doubts = doubted(survey)
    keep = np.ones(survey.size, bool)
    keep[[d.row for d in doubts]] = False
    if keep.sum() < 2 or survey.is_new.all():
        raise UserError(
            f"{survey.source} has {survey.size} readings, none after service began; expected two or more"
        )
    data = readings(survey.only(keep))
    found = plain_fit(data)
    more = _far_off(found, np.flatnonzero(keep))
    if 0 < len(more) <= FEW * survey.size:
        keep[[d.row for d in more]] = False
        data = readings(survey.only(keep))
        found, doubts = plain_fit(data), (*doubts, *more)
    (value, interval), *others = (told := coefficient_intervals(found))[0]
    left = data.worn - data.past.of_rows(found.depth)
    si = {"um": "m", "mm": "m", "cm": "m", "g": "kg", "mg": "kg", "mm3": "m3", "cm3": "m3"}
    unit = f"{si.get(survey.measured_unit, survey.measured_unit)} per unit of exposure and {survey.progress_unit or survey.progress_name}"
    if survey.course is not None:
        unit = "times the run's own wear"
    factor = survey.measured_factor
    return Calibration(
        value, interval, unit, found.spread.gauge / factor, float(np.sqrt(np.mean(left**2))) / factor, doubts,
        noise_tests(found), found, dict(zip(survey.mechanisms[1:], others, strict=True)), told[1],
    )  # fmt: skip


def _far_off(found: Fit, rows: np.ndarray) -> tuple[Doubt, ...]:
    """Readings more than 6 gauge errors from the model and its nuisances"""
    data = found.readings
    survey = data.survey
    left = data.left(found.depth)
    known = found.disturbance
    value, _ = nuisances(known, found.spread, left)
    apart = left - known.column @ value
    width = max(1.4826 * float(np.median(np.abs(apart))), 0.5 * data.reference)
    return tuple(
        Doubt(
            int(rows[i]), survey.point_names[survey.point[i]], survey.occasion_names[survey.occasion[i]],
            float(survey.reading[i]), float(survey.reading[i] - survey.sign * apart[i]),
            f"{abs(apart[i]) / survey.measured_factor:.3g} {survey.measured_unit} off the calibrated model, "
            f"{abs(apart[i]) / width:.0f} gauge errors",
        )
        for i in np.flatnonzero(np.abs(apart) > FAR * width)
    )  # fmt: skip
