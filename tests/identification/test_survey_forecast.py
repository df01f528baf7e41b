"""Lives foretold from surveys: against closed forms, against virtual plants that go on, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

from wearfem.cli import wearfem
from wearfem.errors import UserError
from wearfem.proofs.survey_life import CAREFUL, CARELESS, coverage, error, plants, surveyed, trial
from wearfem.survey.backtest import back_test
from wearfem.survey.candidates import candidates
from wearfem.survey.choose import Choice
from wearfem.survey.forecast import (
    ALONE,
    FULL,
    LINE,
    forecast,
    in_service,
    posterior,
    reached,
    wear_ahead,
)
from wearfem.survey.future import as_seldom_seen
from wearfem.survey.identify import COEFFICIENT_PRIOR, fit, model_at, readings
from wearfem.survey.survey import read_survey

RATES = (0.010, 0.014, 0.020, 0.025)  # mm/kt


def survey_of(folder, rows, head="point,occasion,tonnage_kt,depth_mm,exposure"):
    file = folder / "survey.csv"
    file.write_text("\n".join([head, *rows]) + "\n")
    return file


def straight(folder, noise=0.0, occasions=6, extra="", more=lambda i: ""):
    """Plates that wear at their rates exactly, in proportion to their exposure; gauge error 0.01 mm or as asked."""
    random = np.random.default_rng(5)
    rows = [
        f"P{i},{j},{100 * j},{rate * 100 * j + noise * random.normal():.6f},{rate},{noise or 0.01}{more(i)}"
        for j in range(1, occasions + 1)
        for i, rate in enumerate(RATES)
    ]
    return survey_of(folder, rows, f"point,occasion,tonnage_kt,depth_mm,exposure,sigma_mm{extra}")


def alone(survey):
    """The choice of the coefficient alone, without a search for effects."""
    plain = fit(readings(survey))
    return Choice(plain, plain, (plain,), -3.0, ())


def test_steady_wear_ends_where_the_line_does(tmp_path):
    found = forecast(alone(read_survey(straight(tmp_path))), 20e-3, draws=400)
    assert [o.name for o in found.outlooks] == [LINE, ALONE]
    for outlook in found.outlooks:
        for place, rate in zip(found.places, RATES, strict=True):
            end = found.of_place(outlook, place)
            # 20 mm over the rate; readings are written to 1 nm; a gauge of 0.01 mm leaves 3e-4 of a depth of 10 mm: 3 of these
            assert end.median == pytest.approx(20.0 / rate, rel=3e-3)
            slack = 1e-6 * end.median  # a line through readings without noise has an interval without width
            assert end.interval[0] - slack <= 20.0 / rate <= end.interval[1] + slack
        assert found.of_zone(outlook, "all points").median == pytest.approx(20.0 / max(RATES), rel=3e-3)


def test_the_interval_of_a_coefficient_is_that_of_least_squares(tmp_path):
    survey = read_survey(straight(tmp_path, noise=0.2))
    fitted = fit(readings(survey))
    # nuisances off: then the logarithm of k has the deviation gauge / sqrt(sum of squared depths), by weighted least squares
    still = replace(
        fitted.spread, zero=1e-9, initial=1e-9, scatter=1e-9, book=1e-9, scale=1e-9, smooth=1e-9, bend=1e-9
    )
    depth = fitted.readings.past.of_rows(fitted.depth)
    expected = still.gauge / np.sqrt(depth @ depth)
    width = expected / COEFFICIENT_PRIOR
    plain = replace(fitted, spread=still, deviation=np.array([[width**2]]))
    drawn = COEFFICIENT_PRIOR * posterior(plain, 3000, np.random.default_rng(1))[:, 0]
    assert drawn.std() == pytest.approx(
        expected, rel=0.08
    )  # 3000 draws, every third step: some 1000 are worth it, 2 % each; 4 of these


def test_what_wears_off_its_hard_skin_ends_as_the_integral_says(tmp_path):
    loss, k = 0.02, 1.0  # 1/mm, and exposure is the rate of the new plate

    def worn(t, rate):  # d' = rate / (1 - loss d): d - loss d^2 / 2 = rate t
        return (1.0 - np.sqrt(1.0 - 2.0 * loss * rate * t)) / loss

    rows = [
        f"P{i},{j},{80 * j},{worn(80 * j, k * r):.6f},{r},0.02"
        for j in range(1, 9) for i, r in enumerate((0.01, 0.015, 0.02, 0.028))
    ]  # fmt: skip
    data = readings(
        read_survey(survey_of(tmp_path, rows, "point,occasion,tonnage_kt,depth_mm,exposure,sigma_mm"))
    )
    suspect = next(c for c in candidates(data.past, data.deepest) if c.name == "HardnessGradient")
    fitted = fit(data, [suspect])
    found = forecast(Choice(fit(data), fitted, (fitted,), -3.0, ((),)), 22e-3, draws=300)
    end = found.of_zone(found.outlooks[-1], "all points")
    truth = (22.0 - 0.5 * loss * 22.0**2) / 0.028
    assert found.outlooks[-1].name == FULL
    # deepest reading 26 mm is beyond the limit for the fastest plate; so the truth of the next, still to come, is asked too
    assert end.interval[0] <= max(truth, found.now)
    slow = found.of_place(found.outlooks[-1], "P2")
    truth = (22.0 - 0.5 * loss * 22.0**2) / 0.02
    assert slow.median == pytest.approx(truth, rel=0.01)  # an interval of 0.02 mm gauges is 0.5 % wide


def test_intervals_grow_with_what_is_uncertain(tmp_path):
    widths = []
    for noise in (0.05, 0.4):
        (tmp_path / f"{noise}").mkdir()
        found = forecast(alone(read_survey(straight(tmp_path / f"{noise}", noise=noise))), 20e-3, draws=400)
        end = found.of_zone(found.outlooks[-1], "all points")
        widths.append(end.interval[1] - end.interval[0])
    assert widths[1] > 3.0 * widths[0]  # 8 times the noise


def test_same_seed_same_forecast_and_order_of_rows_does_not_matter(tmp_path):
    file = straight(tmp_path, noise=0.1)
    ends = [forecast(alone(read_survey(file)), 20e-3, seed=3, draws=100).outlooks[-1].end for _ in range(2)]
    assert np.array_equal(*ends)


def test_a_limit_is_reached_between_its_neighbours():
    worn = np.array([[[0.0, 1.0, 3.0], [0.0, 0.1, 0.2], [5.0, 6.0, 7.0], [np.nan] * 3]])
    end = reached(worn, np.full(4, 2.0), np.array([10.0, 20.0, 30.0]))
    assert end[0, 0] == 25.0 and np.isinf(end[0, 1]) and end[0, 2] == 10.0 and np.isnan(end[0, 3])


def test_thickness_is_told_to_what_must_be_left_and_zones_are_as_old_as_their_first(tmp_path):
    rows = [
        f"{name},{j},{100 * j},{20.0 - rate * 100 * j:.4f},{zone},0.01"
        for j in range(6)
        for name, rate, zone in (("A", 0.01, "inlet"), ("B", 0.012, "inlet"), ("C", 0.02, "outlet"), ("D", 0.018, "outlet"))
    ]  # fmt: skip
    file = survey_of(tmp_path, rows, "point,occasion,tonnage_kt,thickness_mm,zone,sigma_mm")
    found = forecast(alone(read_survey(file)), 5e-3, next_stop=770.0, draws=400)
    line = found.outlooks[0]
    assert found.of_zone(line, "inlet").median == pytest.approx(
        15.0 / 0.012, rel=2e-3
    )  # gauge of 0.01 mm in 15 mm
    assert found.of_zone(line, "outlet").median == pytest.approx(15.0 / 0.02, rel=2e-3)
    assert found.of_zone(line, "outlet").reaches < 0.01 and found.of_zone(line, "inlet").reaches > 0.99


def test_of_plates_that_follow_one_another_the_last_is_foretold(tmp_path):
    rows = [
        f"A,{j},{100 * j},{0.02 * (100 * j if j <= 4 else 100 * j - 400):.4f},{'old' if j <= 4 else 'new'}"
        for j in range(1, 9)
    ]
    survey = read_survey(survey_of(tmp_path, rows, "point,occasion,tonnage_kt,depth_mm,specimen"))
    (life,) = in_service(survey)
    assert survey.life_start[life] == 400.0
    found = forecast(alone(survey), 12e-3, draws=200)
    assert found.of_place(found.outlooks[0], "A").median == pytest.approx(400.0 + 12.0 / 0.02, rel=0.01)


def test_what_was_seen_seldom_is_uncertain():
    random = np.random.default_rng(2)
    seen = np.array([4.0, 5.0, 6.5, 4.6])
    drawn = np.log([as_seldom_seen(seen, random) for _ in range(4000)])
    spread = np.log(seen).std(ddof=1)
    # one value that comes has the variance s^2 (1 + 1/n) of a normal prediction; 4000 draws know it to 3 %, here 4 of these
    assert drawn.ravel().var() == pytest.approx(spread**2 * (1.0 + 1.0 / 4.0), rel=0.12)


def test_wear_ahead_begins_where_the_readings_end(tmp_path):
    survey = read_survey(straight(tmp_path, noise=0.1))
    fitted = fit(readings(survey))
    worn = wear_ahead([(fitted, 1.0)], np.array([600.0, 700.0]), 300, np.random.default_rng(0))
    assert worn[:, :, 0].mean(axis=0) == pytest.approx(
        np.array(RATES) * 0.6, abs=0.1e-3
    )  # a gauge error, 6 readings
    assert (worn[:, :, 1] > worn[:, :, 0]).all()
    model = model_at(fitted.readings, (), fitted.coordinate)
    assert model.coefficient == pytest.approx(1e-3, rel=0.05)  # m by mm of exposure: what was planted


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ([], "is a survey, and no limit was given; give the depth"),
        (["--limit", "20"], "a number with a unit of length"),
        (["--limit", "2*mm"], "which all plates in service have passed"),
        (["--limit", "20*mm", "--next-stop", "300*kt"], "the last reading was taken at 600 kt"),
        (["--limit", "20*mm", "--next-stop", "900*mm"], "a unit of mass"),
        (["--limit", "20*mm", "--price", "3"], "--price is for runs"),
    ],
)
def test_what_cannot_be_foretold_is_refused(tmp_path, options, sentence):
    with pytest.raises(UserError, match=sentence):
        wearfem.main(["forecast", str(straight(tmp_path)), *options], standalone_mode=False)


def test_the_command_tells_lives_and_a_back_test(tmp_path, capsys):
    file = straight(tmp_path, noise=0.05, extra=",zone", more=lambda i: f",Z{i // 2}")
    out = tmp_path / "told.json"
    wearfem.main(
        ["forecast", str(file), "--limit", "20*mm", "--next-stop", "780*kt", "--json", str(out)],
        standalone_mode=False,
    )
    said = capsys.readouterr().out
    assert "depth of 20 mm may be reached" in said and "Z1" in said and "back-test" in said
    told = json.loads(out.read_text())
    zones = {zone["place"]: zone for zone in told["forecast"]["models"][1]["zones"]}
    assert zones["Z1"]["worn_out_at"] == pytest.approx(
        20.0 / RATES[3], rel=0.02
    )  # 0.05 mm of gauge in 15 mm, and nuisances
    assert zones["Z1"]["remaining"] == pytest.approx(zones["Z1"]["worn_out_at"] - 600.0)
    assert 0.5 < zones["Z1"]["reaches_next_stop"] <= 1.0  # worn out at 800 kt
    assert told["back_test"]["readings"] == 4 * 3  # occasions 4, 5 and 6 of four points


def test_a_back_test_knows_nothing_of_what_it_foretells():
    plant = plants().plant("none", 7, points=12, occasions=5)
    survey = surveyed(plant, 5)
    changed = replace(survey, reading=survey.reading + np.where(survey.occasion == 4, 7e-3, 0.0))
    errors = [back_test(s).occasions[-1].error for s in (survey, changed)]
    assert errors[1] == pytest.approx(
        errors[0] - 7e-3, abs=1e-12
    )  # rounding: foretold is the same, read is 7 mm more


def test_lives_of_plants_are_foretold_with_their_errors():
    trials = [
        trial(name, 40, points=24, **CAREFUL) for name in ("none", "hardness_gradient", "pressure_exponent")
    ]
    assert (
        error(trials, -1) < 0.1
    )  # of the remaining life; a straight line is off by far more where hardness falls
    hard = trials[1]
    assert abs(hard.median[0] - hard.truth) > 3.0 * abs(hard.median[-1] - hard.truth)


@pytest.mark.slow
def test_intervals_hold_the_truth_in_four_plants_of_five():
    names = plants().NAMES
    trials = [
        trial(name, seed, points=24, **(CARELESS if (seed + i) % 2 else CAREFUL))
        for seed in range(400, 406)
        for i, name in enumerate(names)
    ]
    share = coverage(trials, -1)
    print(
        f"{len(trials)} plants: after diagnosis {share:.3f}, line {coverage(trials, 0):.3f}, alone {coverage(trials, 1):.3f}"
    )
    assert 0.75 - 0.08 <= share <= 0.85 + 0.08  # as asked, and 2 standard errors of 108 plants
