"""Effects from the units of a survey to those of a run, by hand; what a run cannot have is refused."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.survey.history import history
from wearfem.survey.in_service import Service, in_service, service
from wearfem.survey.survey import read_survey
from wearfem.wear.effects import (
    BuildUp,
    Corrosion,
    FactorCurve,
    HardnessGradient,
    OreChange,
    OreChangeByTime,
    OreHardness,
    RunningInByThroughput,
    Temperature,
)

EXACT = 1e-12  # relative: products of a few numbers


def survey(tmp_path, progress="tonnage_kt", more="", values=(("", ""),) * 2):
    rows = [f"point,occasion,{progress},depth_mm{more}"]
    for point in "ab":
        for occasion, at in enumerate((10.0, 20.0, 40.0)):
            rows.append(
                f"{point},{occasion},{at},{at / 10}" + "".join(f",{v(point, occasion)}" for v in values)
            )
    (tmp_path / "survey.csv").write_text("\n".join(rows) + "\n")
    return read_survey(tmp_path / "survey.csv")


BY_MASS = Service(2.5e4, 1e6, True)  # kt at 40 kg/s
BY_TIME = Service(3600.0, 3600.0 * 40.0, False)  # h


def test_what_a_unit_of_progress_is(tmp_path):
    assert service(survey(tmp_path, values=()), 40.0) == BY_MASS
    assert service(survey(tmp_path, "time_h", values=()), 40.0) == BY_TIME
    assert service(survey(tmp_path, "time_h", values=()), 0.0).kilograms is None
    with pytest.raises(UserError, match="has no throughput_rate"):
        service(survey(tmp_path, values=()), 0.0)
    with pytest.raises(UserError, match="give the survey a column like time_h"):
        service(survey(tmp_path, "distance_m", values=()), 40.0)


def converted(effect, told, unit):
    return in_service(effect, told, history(told), unit)


def test_by_progress(tmp_path):
    told = survey(tmp_path, values=())
    assert converted(OreChange((20.0,), (1.5,)), told, BY_MASS) == OreChange((20e6,), (1.5,))
    assert converted(OreChange((20.0,), (1.5,)), told, BY_TIME) == OreChangeByTime((72000.0,), (1.5,))
    assert converted(RunningInByThroughput(1.0, 5.0), told, BY_MASS) == RunningInByThroughput(1.0, 5e6)
    assert converted(RunningInByThroughput(1.0, 5.0), told, BY_TIME) == RunningInByThroughput(1.0, 720000.0)
    curve = FactorCurve("throughput", (10.0, 20.0), (1.0, 2.0))
    assert converted(curve, told, BY_MASS) == FactorCurve("throughput", (10e6, 20e6), (1.0, 2.0))
    assert converted(curve, told, BY_TIME) == FactorCurve("service_time", (36000.0, 72000.0), (1.0, 2.0))
    with pytest.raises(UserError, match="goes by throughput"):
        converted(RunningInByThroughput(1.0, 5.0), told, replace(BY_TIME, kilograms=None))


def test_what_is_told_in_metres_stays(tmp_path):
    told = survey(tmp_path, values=())
    for effect in (
        HardnessGradient(50.0),
        BuildUp((0.0, 0.0, 0.0), 0.1),
        FactorCurve("pressure", (1.0, 2.0), (1.0, 2.0)),
    ):
        assert converted(effect, told, BY_MASS) is effect


def test_corrosion(tmp_path):
    told = survey(tmp_path, values=())
    # without a calendar: depth by kt, so by 2.5e4 s of service
    assert converted(Corrosion(1e-6), told, BY_MASS).addition() == pytest.approx(1e-6 / 2.5e4, rel=EXACT)
    days = survey(tmp_path, more=",days", values=(lambda p, o: (20, 40, 80)[o],))
    # 80 days of calendar for 40 kt = 1e6 s of service
    found = converted(Corrosion(1e-12), days, BY_MASS)
    assert found.calendar_per_service == pytest.approx(80 * 86400.0 / 1e6, rel=EXACT)
    assert found.addition() == pytest.approx(1e-12 * 6.912, rel=EXACT)


def test_columns_become_logs(tmp_path):
    warm = survey(tmp_path, more=",temperature_c", values=(lambda p, o: (20, 60, 30)[o],))
    effect = converted(Temperature(0.01, 300.0), warm, BY_MASS)
    for service_time, celsius in (
        (1.0, 20.0),
        (2.4e5, 20.0),
        (2.6e5, 60.0),
        (4.9e5, 60.0),
        (6e5, 30.0),
        (1e6, 30.0),
    ):
        assert effect.log.at(service_time) == pytest.approx(celsius + 273.15, rel=EXACT)
    curve = converted(FactorCurve("temperature", (293.0, 333.0), (1.0, 2.0)), warm, BY_MASS)
    assert curve.known(None, type("Worn", (), {"service_time": 3e5})) == {"temperature": 333.15}


def test_what_differs_from_place_to_place_is_refused(tmp_path):
    hard = survey(tmp_path, more=",ore_hardness_hv", values=(lambda p, o: 500 + o + 100 * (p == "b"),))
    with pytest.raises(UserError, match="differs from place to place"):
        converted(OreHardness(1.0, 5e9), hard, BY_MASS)


def test_dates_of_plates_put_in_one_by_one_are_refused(tmp_path):
    told = survey(tmp_path, values=())
    later = replace(told, life_start=np.array([0.0, 5.0]))
    with pytest.raises(UserError, match="put in at different dates"):
        converted(OreChange((20.0,), (1.5,)), later, BY_MASS)
