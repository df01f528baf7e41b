"""Plates whose new thickness is known from readings only: alike as far as those say, each by itself where they are not."""

import numpy as np
import pytest

from wearfem.survey import nuisance
from wearfem.survey.choose import Choice
from wearfem.survey.diagnose import held_out
from wearfem.survey.forecast import ALONE, forecast
from wearfem.survey.history import Model, depths
from wearfem.survey.identify import fit, readings
from wearfem.survey.survey import read_survey


def plates_read_new(folder, spread, seed=5, gauge=0.1, points=40):
    """A survey of thicknesses whose plates were read when new, thick to `spread` [mm]; wears 1 mm per 100 kt at exposure 1"""
    random = np.random.default_rng(seed)
    exposure = random.uniform(0.4, 1.6, points)
    thick = 30.0 + spread * random.normal(size=points)
    rows, tonnage = (
        ["point,occasion,tonnage_kt,thickness_mm,sigma_mm,exposure"],
        [0.0, 150.0, 320.0, 410.0, 640.0, 800.0],
    )
    for j, t in enumerate(tonnage):
        read = thick - 0.01 * exposure * t + gauge * random.normal(size=points)
        rows += [f"{i},{j},{t},{read[i]:.6f},{gauge},{exposure[i]:.6f}" for i in range(points)]
    folder.mkdir(parents=True)
    (folder / "survey.csv").write_text("\n".join(rows) + "\n")
    return folder / "survey.csv"


@pytest.mark.parametrize("spread", [0.0, 1.0])
def test_new_thicknesses_are_those_of_gaussian_conditioning(spread, tmp_path):
    """Told by another route: thicknesses normal about a mean that nobody knows, given all readings and the wear"""
    data = readings(read_survey(plates_read_new(tmp_path / "plate", spread)))
    survey, gauge, size = data.survey, 1e-4, max(1e-3 * spread, 2e-5)
    depth = depths(data.past, Model(data.coefficient))
    found = nuisance.disturbance(data.survey, data.past, depth, data.reference, data.thickness_free)
    few = nuisance.Spread(gauge, 1e-12, size, *[1e-12] * 7)
    value, _ = nuisance.nuisances(found, few, data.left(depth))
    told = np.zeros(len(survey.life_point))
    told[survey.life] = survey.reading + data.worn - data.offset  # mean of all
    told -= value[found.group == 1] + value[found.group == 4][0]
    back = survey.reading + data.past.of_rows(depth)  # each reading carried back to the new plate
    count = np.bincount(survey.life)
    mean = np.bincount(survey.life, back) / count
    variance = size**2 + gauge**2 / count
    common = np.sum(mean / variance) / np.sum(1.0 / variance)
    expected = common + size**2 / variance * (mean - common)
    assert told == pytest.approx(expected, abs=2e-9)  # the mean is free to 1000 gauge errors, not without end


@pytest.mark.parametrize(("spread", "expected"), [(0.0, 0.1), (1.0, 0.1 * np.sqrt(2.0))])
def test_plates_alike_are_not_judged_by_one_reading_when_new(spread, expected, tmp_path):
    """Plates of which only the reading when new is known: later ones err by the gauge, and where plates differ by that reading too"""
    data = readings(read_survey(plates_read_new(tmp_path / "plate", spread, points=100)))
    held = held_out(data)
    fitted = fit(data.only(~held))
    asked = data.only(held)
    alone = np.bincount(data.survey.life[~held])[asked.survey.life] == 1
    assert alone.sum() == 100  # of 20 plates
    error = 1e3 * np.sqrt(np.mean((asked.worn - fitted.predict(asked))[alone] ** 2))
    assert error == pytest.approx(expected, rel=0.25)  # 20 plates scatter by 7 (100 readings) to 12 %
    # of 100 plates: 7 %, three times; what is far below the gauge is not told
    assert fitted.spread.initial == pytest.approx(1e-3 * spread, rel=0.21, abs=5e-5)


def test_a_plate_lasts_as_long_as_its_own_thickness(tmp_path):
    """Plates that differ by millimetres: each life is its own thickness over its own rate, both put in"""
    survey = read_survey(plates_read_new(tmp_path / "plate", 3.0, gauge=0.02, points=12))
    plain = fit(readings(survey))
    found = forecast(Choice(plain, plain, (plain,), -3.0, ()), 18e-3, draws=200)
    random = np.random.default_rng(5)
    exposure, thick = random.uniform(0.4, 1.6, 12), 30.0 + 3.0 * random.normal(size=12)
    outlook = next(one for one in found.outlooks if one.name == ALONE)
    ends = {place: found.of_place(outlook, place).median for place in found.places}
    soon = [i for i in range(12) if 850.0 < (thick[i] - 18.0) / (0.01 * exposure[i]) < 1500.0]
    assert len(soon) > 3 and np.ptp(thick[soon]) > 3.0
    for i in soon:  # 0.02 mm of 12 mm, read six times, is 0.1 %; and the lives are told on a grid
        assert ends[str(i)] == pytest.approx((thick[i] - 18.0) / (0.01 * exposure[i]), rel=5e-3)
