"""Which forecast to plan by: decided by what earlier ones were worth, both ways, and with intervals that hold what they promise."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from identification.plants import Plant, march

from wearfem.proofs.survey_life import plants, surveyed
from wearfem.survey.backtest import NAMES, BackTest, Foretold, advised, back_test, stretched
from wearfem.survey.diagnose import diagnose
from wearfem.survey.forecast import ALONE, FULL, LINE, Forecast, Outlook, forecast
from wearfem.survey.survey import read_survey
from wearfem.survey.words import advice_words, forecast_lines

BELT = Path(__file__).parents[2] / "cases" / "conveyor_belt" / "measured" / "survey.csv"


def foretold(error, reach):
    return Foretold("1", 1.0, (), np.asarray(error, float), np.asarray(reach, float))


def ahead_of(survey, names=NAMES):
    """Forecasts of one plate by each model, 500 draws about 900, 1000, 1100 ..."""
    random = np.random.default_rng(1)
    outlooks = tuple(
        Outlook(name, np.ones((3, 1, 2)), random.normal(900.0 + 100.0 * i, 30.0, (500, 1)))
        for i, name in enumerate(names)
    )
    return Forecast(
        survey, np.array([0]), ("A",), ("all points",), np.array([0.02]), 0.02, np.array([600.0, 2400.0]), outlooks, 1050.0,
    )  # fmt: skip


@pytest.fixture(scope="module")
def survey():
    return surveyed(plants().plant("none", 1, points=8, occasions=4), 4)


@pytest.mark.parametrize("best", range(3))
def test_the_forecast_that_erred_least_is_the_one_to_plan_by(survey, best):
    error = np.full((3, 5), 0.4e-3)
    error[best] = -0.3e-3  # whichever sign
    tested = BackTest((foretold(error, np.zeros((3, 5))),) * 3)
    ahead = ahead_of(survey)
    advice = advised(ahead, tested)
    assert (advice.outlook.name, advice.stretch, advice.tested) == (NAMES[best], 1.0, True)
    lines = forecast_lines(ahead, tested)
    assert lines[1].startswith("plan by") and NAMES[best] in lines[1]  # at the top, before the table
    said = " ".join(" ".join(lines).split())
    assert f"{ahead.of_zone(advice.outlook, 'all points').median:.4g} (" in said.partition("all forecasts")[0]
    assert all(name in said.partition("all forecasts")[2] for name in NAMES)  # the others stand beside
    assert ("foretells them worse" in advice_words(ahead, tested)) == (NAMES[best] != FULL)


def test_what_was_not_named_now_is_no_forecast_to_plan_by(survey):
    tested = BackTest((foretold([[4e-4], [5e-4], [1e-4]], np.zeros((3, 1))),))
    assert advised(ahead_of(survey, (LINE, ALONE)), tested).outlook.name == LINE


def test_without_earlier_forecasts_the_most_probable_model_stands_and_says_so(survey):
    advice = advised(ahead_of(survey), BackTest(()))
    assert (advice.outlook.name, advice.stretch, advice.tested) == (FULL, 1.0, False)
    assert "four occasions are needed" in advice_words(ahead_of(survey), BackTest(()))


@pytest.mark.parametrize(("times", "expected"), [(1.0, 1.0), (0.5, 1.0), (2.0, 2.0), (3.0, 3.0)])
def test_intervals_are_stretched_as_normal_errors_ask(times, expected):
    random = np.random.default_rng(3)
    # errors `times` as large as an 80 % interval of half width 1.2816 standard deviations has them
    reach = np.abs(times * random.normal(size=(20, 3, 200))) / 1.2816
    tested = BackTest(tuple(foretold(np.ones((3, 200)), part) for part in reach))
    # 4000 errors know their 80 % quantile to 1.4 sqrt(0.16 / 4000) / 0.35 = 2.5 % / 1.28; here 3 of these
    assert tested.stretch == pytest.approx(np.full(3, expected), rel=0.06)


def test_one_bad_occasion_of_many_stretches_nothing():
    good, bad = np.zeros((3, 10)), np.full((3, 10), 5.0)
    tested = BackTest(tuple(foretold(np.ones((3, 10)), part) for part in (good, good, bad)))
    assert tested.coverage == pytest.approx(np.full(3, 2.0 / 3.0))  # 0.67 with a standard error of 0.33
    assert tested.stretch.tolist() == [1.0, 1.0, 1.0]


def test_a_stretched_forecast_keeps_its_median_and_ends_no_plate_in_the_past(survey):
    ahead = ahead_of(survey)
    for factor in (1.0, 2.0, 20.0):
        wide = stretched(ahead.outlooks[1], factor, ahead.now)
        before, after = (ahead.of_zone(o, "all points") for o in (ahead.outlooks[1], wide))
        assert after.median == before.median
        low, high = (before.median + factor * (end - before.median) for end in before.interval)
        assert after.interval == pytest.approx((max(low, ahead.now), high))
        assert after.reaches >= before.reaches  # a stop beyond the median comes into reach
    endless = replace(ahead.outlooks[1], end=np.array([[700.0], [np.inf], [np.inf]]))
    assert np.array_equal(
        stretched(endless, 3.0, 600.0).end, endless.end
    )  # no median, nothing to stretch about


def test_a_plant_whose_hardness_falls_is_planned_by_the_effect():
    survey = surveyed(plants().plant("hardness_gradient", 11, points=12, occasions=6), 6)
    ahead = forecast(diagnose(survey, name_without=False).choice, 30e-3, draws=200)
    tested = back_test(survey)
    assert advised(ahead, tested).outlook.name == FULL
    assert tested.rmse[2] < 0.5 * min(tested.rmse[:2])


def test_a_plant_that_takes_two_ores_in_turn_is_planned_by_a_line(tmp_path):
    # nobody wrote the ores down, so what the readings of so many intervals look like, running-in, does not go on
    made = plants().plant("none", 11, points=12, occasions=6)
    clean = march(made.exposure, made.tonnage, lambda d, t, j: np.full(12, 0.7 if j % 2 else 1.4))
    read = np.round(clean + np.random.default_rng(11).normal(0.0, made.sigma, clean.shape), 3)
    plant = Plant("two ores", (), made.point, made.tonnage, made.exposure, clean, read, made.sigma)
    survey, exposure = plant.write(tmp_path)
    survey = read_survey(survey, exposure=exposure)
    found = diagnose(survey, name_without=False)
    assert found.effects  # an effect is told, if with doubt
    advice = advised(forecast(found.choice, 30e-3, draws=200), back_test(survey))
    assert advice.outlook.name == LINE


@pytest.mark.slow
def test_the_belt_is_planned_by_a_simpler_forecast_and_says_so():
    survey = read_survey(BELT, progress="cumulative_tonnage")
    ahead = forecast(diagnose(survey, name_without=False).choice, 25e-3, draws=200)
    tested = back_test(survey)
    advice = advised(ahead, tested)
    assert advice.outlook.name in (LINE, ALONE) and advice.stretch > 1.0
    words = advice_words(ahead, tested)
    assert "explains the readings better, and yet foretells them worse" in words
    assert f"{advice.stretch:.2g} times as wide" in words
