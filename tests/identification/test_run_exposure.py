"""The exposure of survey points from a run folder: closed forms, another pace of the same course, and refusals in one sentence."""

import numpy as np
import pytest

from wearfem.cli import wearfem
from wearfem.errors import UserError
from wearfem.exposure import exposed_by_run
from wearfem.run import run_case
from wearfem.survey.calibrate import calibrate
from wearfem.survey.diagnose import diagnose
from wearfem.survey.history import Model, depths, history
from wearfem.survey.survey import read_survey
from wearfem.wear.effects import HardnessGradient

# A plate whose flow is the stronger the further along and the deeper: d' = r0 q (1 + c d), q = 1 + x / L, so d = (exp(c q r0 t) - 1) / c.
CASE = """
import numpy as np
from wearfem.case import LifeCase, Stop, Window
from wearfem.formula import FormulaFlow, Sliding
from wearfem.liner.block import Tetrahedra, block
from wearfem.liner.liner import Liner
from wearfem.material import Material
from wearfem.surface import Surface
from wearfem.wear.jump import Goal
from wearfem.wear.laws import Archard

GROWTH = 60.0  # [1/m] c

def stronger(surface: Surface) -> np.ndarray:
    middle = surface.corner.mean(axis=1)
    area = surface.area
    def mean(value):
        return np.bincount(surface.facet, area * value, surface.facet_count) / surface.facet_area
    return (1.0 + mean(middle[:, 0]) / 0.2) * (1.0 - GROWTH * mean(middle[:, 2]))

def case(*, frozen: bool = False, throughput: float = 100.0) -> LifeCase:
    steel = Material("steel", 7850.0, 5e6, 0.3, restitution=0.4, friction=0.3)
    mesh = block((0, 0, -0.02), (0.2, 0.1, 0), (12, 4, 2), Tetrahedra, name="plate")
    return LifeCase(
        name="stronger", liner=Liner(mesh, steel), goal=Goal(np.full(len(mesh.wear), 9e-3)), flow=FormulaFlow(),
        sampler=Sliding(10e3, 1.0, intensity=stronger), wear_law=Archard(1e-13), window=Window(10.0, 8),
        throughput_rate=throughput, longest_jump=3e5, frozen=frozen,
        stop=Stop(service_time=3e6 if throughput else 6e5), measure=lambda history: (),
    )
"""
GROWTH, RATE = 60.0, 1e-9  # of the case


def exact(x, seconds, pace=1.0):
    return np.expm1(GROWTH * pace * RATE * (1.0 + x / 0.2) * seconds) / GROWTH


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("course")
    (folder / "case.py").write_text(CASE)
    for name, settings in {"moving": {}, "frozen": {"frozen": True}, "dry": {"throughput": 0.0}}.items():
        run_case(folder, settings, folder / name, quiet=True)
    return folder


def survey_of(folder, depth, noise=0.0, clock="tonnage_kt", scale=1.0, name="survey.csv"):
    """24 points, 6 occasions; `depth(x, seconds)` in m"""
    random = np.random.default_rng(5)
    rows = [f"point,occasion,{clock},depth_mm,sigma_mm,x_m,y_m,z_m"]
    by_second = {"tonnage_kt": 100.0 / 1e6, "time_h": 1 / 3600.0, "distance_m": 1.0}[clock]
    for j, seconds in enumerate(np.linspace(0.5e6, 3.0e6, 6)):
        for i, x in enumerate(np.linspace(0.012, 0.188, 24)):
            read = 1e3 * depth(x, seconds) + noise * random.normal()
            rows.append(
                f"P{i},{j},{by_second * seconds:.6g},{read:.6f},{noise or 0.01},{scale * x:.6f},{scale * (0.02 + 0.06 * (i % 3) / 2):.6f},0"
            )
    (folder / name).write_text("\n".join(rows) + "\n")
    return read_survey(folder / name)


def test_a_point_wears_as_the_run_says(runs, tmp_path):
    for clock in ("tonnage_kt", "time_h"):
        survey = exposed_by_run(survey_of(tmp_path, exact, clock=clock), runs / "moving")
        past = history(survey)
        told = past.of_rows(depths(past, Model(1.0)))
        # the trapezoid rule of 10 jumps, in each of which the rate grows by 4 %, errs by 1e-4; facets of 17 mm at the rim, which the
        # mesh moves by less than they wear, by 1.2e-3 (below 1e-3 with facets of 12 mm)
        assert told == pytest.approx(survey.reading, rel=2e-3)


def test_another_coefficient_walks_the_same_course_faster(runs, tmp_path):
    survey = exposed_by_run(survey_of(tmp_path, lambda x, t: exact(x, t, 0.8), noise=0.05), runs / "moving")
    found = calibrate(survey)
    assert found.interval[0] < 0.8 < found.interval[1]  # 90 % of the time; this seed is one of them
    assert found.coefficient == pytest.approx(0.8, rel=0.01)  # 144 readings of 0.05 mm in 3 mm tell 0.2 %
    assert found.rmse < 0.06  # the gauge's 0.05, not the shape's
    assert diagnose(survey, name_without=False).verdict == "adequate"


def test_an_effect_on_top_of_the_shape_is_told_apart(runs, tmp_path):
    soft = 45.0  # [1/m]; with d' = r (1 + c d)/(1 - g d):  (1 + g/c) ln(1 + c d)/c - g d/c = r t

    def depth(x, seconds):
        deep = np.linspace(0.0, 0.016, 200001)
        needed = (1.0 + soft / GROWTH) * np.log1p(GROWTH * deep) / GROWTH - soft / GROWTH * deep
        return np.interp(RATE * (1.0 + x / 0.2) * 0.7 * seconds, needed, deep)

    survey = exposed_by_run(survey_of(tmp_path, depth, noise=0.05), runs / "moving")
    past = history(survey)
    told = past.of_rows(depths(past, Model(0.7, (HardnessGradient(soft),))))
    assert told == pytest.approx(survey.reading, abs=4 * 0.05e-3)  # four standard errors of 144 readings
    found = diagnose(survey, name_without=False)
    assert [effect.name for effect in found.effects] == ["HardnessGradient"]
    assert found.effects[0].parameters["loss"].value == pytest.approx(
        soft, rel=0.2
    )  # what 0.05 mm in 6 allows


def test_a_frozen_run_does_not_pass_its_shape_off_as_a_material(runs, tmp_path):
    survey = exposed_by_run(survey_of(tmp_path, exact, noise=0.05), runs / "frozen")
    assert not survey.course.follows_shape
    found = diagnose(survey, name_without=False)
    assert found.verdict == "cannot_tell"
    assert all("change of shape with wear" in effect.indistinguishable_from for effect in found.effects)


def test_what_cannot_be_laid_over_a_run_is_refused(runs, tmp_path):
    with pytest.raises(UserError, match=r"24 of 24 plates further off .* if x_m, y_m, z_m were in mm"):
        exposed_by_run(survey_of(tmp_path, exact, scale=1e3), runs / "moving")
    with pytest.raises(UserError, match="of the same machine"):
        exposed_by_run(survey_of(tmp_path, exact, scale=-1.0), runs / "moving")
    with pytest.raises(UserError, match="counts service by distance_m"):
        exposed_by_run(survey_of(tmp_path, exact, clock="distance_m"), runs / "moving")
    with pytest.raises(UserError, match="counts no throughput"):
        exposed_by_run(survey_of(tmp_path, exact), runs / "dry")
    with pytest.raises(UserError, match="is no run folder"):
        exposed_by_run(survey_of(tmp_path, exact), tmp_path)
    bare = tmp_path / "bare.csv"
    bare.write_text("point,occasion,tonnage_kt,depth_mm\nA,1,10,1\nA,2,20,2\n")
    with pytest.raises(UserError, match="no x_m, y_m, z_m"):
        exposed_by_run(read_survey(bare), runs / "moving")


def test_the_command_takes_a_run(runs, tmp_path, capsys):
    survey_of(tmp_path, exact, noise=0.05)
    arguments = ["calibrate", str(tmp_path / "survey.csv"), "--run", str(runs / "moving")]
    wearfem.main(arguments, standalone_mode=False)
    shown = capsys.readouterr().out
    assert "times the run's own wear" in " ".join(shown.split()) and "samples up to" in " ".join(
        shown.split()
    )
    with pytest.raises(UserError, match="give one of them"):
        wearfem.main([*arguments, "--exposure", str(tmp_path / "survey.csv")], standalone_mode=False)
