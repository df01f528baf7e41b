"""The command `forecast`: what it prints and writes is the forecast, and mistakes end in a sentence."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from wearfem.cli import wearfem as command
from wearfem.errors import UserError
from wearfem.forecast import forecast
from wearfem.foretell import (
    Asked,
    asked_for,
    coefficient_error,
    forecast_lines,
    forecast_run,
    foretell,
    mesh_error,
    quantity,
)
from wearfem.history import read_history
from wearfem.record import read_manifest
from wearfem.report_facts import case_of_run
from wearfem.report_page import write_report
from wearfem.run import run_case
from wearfem.units import day, hour, kt

CASE = Path(__file__).parents[2] / "cases" / "wearing_plate"
SETTINGS = {"cells": 4, "tolerance": 0.05, "stop": 40 * day}
NOTHING = dict.fromkeys(("price", "unplanned_price", "hour_price", "planned_hours", "unplanned_hours"))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    run = tmp_path_factory.mktemp("forecast") / "run"
    run_case(CASE, SETTINGS, run, quiet=True)
    return run


def test_what_is_printed_and_written_is_the_forecast(run, tmp_path):
    words = [
        "forecast",
        str(run),
        "--limit",
        "11*mm",
        "--next-stop",
        "60*day",
        "--coefficient-error",
        "5*percent",
    ]
    prices = ["--price", "20000", "--unplanned-price", "50000", "--currency", "EUR"]
    files = ["--out", str(tmp_path / "told.txt"), "--json", str(tmp_path / "told.json")]
    done = CliRunner().invoke(command, [*words, *prices, *files])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "told.txt").read_text() in done.output
    told = json.loads((tmp_path / "told.json").read_text())
    life = foretell(run, Asked(limit="11*mm", coefficient_error="0.05")).forecast.zone[0]
    assert list(told["zones"][0]["life_d"].values()) == pytest.approx(np.array(life.quantile) / day)
    low, high = (told["zones"][0]["life_d"][part] for part in ("10%", "90%"))
    assert f"{low:.4g} d to {high:.4g} d" in done.output
    # 100 kg/s of the case over the middle of the draws
    assert told["zones"][0]["throughput_t"]["50%"] == pytest.approx(
        0.1 * told["zones"][0]["life_d"]["50%"] * 86400.0
    )
    cost = told["costs"]
    assert cost["unit"] == "EUR/t"
    # closed form: an unplanned change of 70000 EUR after the mean life, of which the middle is 1 % away
    assert cost["run_until_it_fails"] == pytest.approx(
        70000.0 / told["zones"][0]["throughput_t"]["50%"], rel=0.03
    )
    assert cost["change_at_next_stop"] < cost["run_until_it_fails"]
    for word in (
        "until 11 mm left:",
        "straight line",
        "frozen geometry",
        "reaches the stop at 60 d",
        "the mesh",
    ):
        assert word in done.output
    assert "not included, since not given: the mesh" in done.output


def test_without_prices_no_costs_are_invented(run, capsys):
    found = forecast_run(run, Asked())
    assert found.costs is None and "cost" not in capsys.readouterr().out


def test_a_stop_is_told_by_time_or_by_throughput(run):
    by_time, by_mass = (foretell(run, Asked(next_stop=stop)) for stop in ("1440*hour", "518.4*kt"))
    assert by_time.next_stop == pytest.approx(60 * day)
    assert by_mass.next_stop == pytest.approx(by_time.next_stop, rel=1e-9)  # 100 kg/s for 60 d; rounding


def test_doubts_come_from_files(tmp_path):
    file = tmp_path / "calibration.json"
    file.write_text(json.dumps({"coefficient": {"value": 2.0, "interval": [1.8355, 2.1645], "unit": "-"}}))
    # 1.645 deviations to either side of 90 %: 0.1645 / 1.645 / 2 = 5 %
    assert coefficient_error(Asked(calibration=file)) == pytest.approx(0.05, rel=1e-3)
    study = tmp_path / "study"
    study.mkdir()
    answer = {"figure": "end of life", "answer": {"value": 80.0, "error": 1.6}}
    (study / "converged.json").write_text(json.dumps([answer]))
    assert mesh_error(study) == pytest.approx(0.01)


def test_the_page_tells_the_same(run, tmp_path):
    asked = Asked(
        limit="11*mm",
        next_stop="60*day",
        prices=asked_for(**NOTHING | {"price": 1000.0}, currency="EUR").prices,
    )
    page = tmp_path / "page.html"
    figures = {figure.name: figure for figure in write_report(run, page, asked=asked)}
    zone = foretell(run, asked).forecast.zone[0]
    name = "life foretold, whole worn face, until 11 mm left, 50% of the draws end before"
    assert figures[name].value == pytest.approx(zone.quantile[1] / day)
    assert figures[
        "probability to reach the next stop, whole worn face, until 11 mm left"
    ].value == pytest.approx(zone.probability_to_reach(60 * day))
    assert figures["cost, run until it fails"].unit == "EUR/t"
    text = re.sub(r"<[^>]+>", " ", page.read_text())
    for word in (
        "How long it will last",
        "reaches the stop at 60 d",
        "Costs: a planned change 1,000 EUR",
        "the wear coefficient",
    ):
        assert word in text


def test_the_case_that_was_run_is_found_again(run):
    case = case_of_run(read_manifest(run))
    assert case is not None and case.settings["cells"] == 4
    history = read_history(run)
    with_case, without = (forecast(history, case=one).zone[0] for one in (case, None))
    assert not np.array_equal(with_case.draw, without.draw)  # the hardness gradient is known to one of them


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({"limit": "19*mm"}, "the limit is 19 mm, and the least thickness left is"),
        ({"limit": "12"}, "--limit was given 12, and it needs a number with a unit of length, such as 8"),
        ({"limit": "3*hour"}, "needs a number with a unit of length"),
        ({"limit": "3*mn"}, "did you mean"),
        ({"limit": "3*"}, "--limit 3.* cannot be read"),
        ({"stress_limit": "100*MPa"}, "0 cycles tell a stress"),
        ({"next_stop": "30*day"}, "--next-stop 30.day is in the past: the liner has served 40 d"),
        ({"next_stop": "100*kt"}, "is in the past"),
        ({"next_stop": "60"}, "needs a number with a unit of time or mass"),
        ({"coefficient_error": "2"}, "coefficient_error is 2.0; it is a standard deviation as a part of 1"),
        ({"coefficient_error": "lots"}, "--coefficient-error was given lots"),
        (
            {"coefficient_error": "0.1", "calibration": Path("x")},
            "both --coefficient-error and --calibration",
        ),
        ({"calibration": Path("nowhere.json")}, "there is no file nowhere.json: give what wearfem calibrate"),
        ({"study": Path("nowhere")}, "there is no file nowhere/converged.json"),
    ],
)
def test_wishes_that_make_no_sense(run, asked, sentence):
    with pytest.raises(UserError, match=sentence):
        foretell(run, Asked(**asked))


@pytest.mark.parametrize(
    "content", ['[{"a": 1}]', '{"figure": 3}', "[3]", "3", '[{"figure": "end of life", "answer": {}}]']
)
def test_what_is_no_study_is_a_sentence(run, tmp_path, content):
    (tmp_path / "converged.json").write_text(content)
    with pytest.raises(UserError, match="tells no converged end of life"):
        foretell(run, Asked(study=tmp_path))


def test_a_life_that_has_ended_is_told_as_such(run, tmp_path):
    """What is told of it is how surely its end is known; of one that goes on nothing of the kind is said."""
    run_case(CASE, {"cells": 4, "tolerance": 0.05}, tmp_path / "ended", quiet=True)
    said = [list(forecast_lines(foretell(one, Asked())))[1] for one in (tmp_path / "ended", run)]
    assert said[0].startswith("this life was followed to its end")
    assert said[1] == ""


def test_a_file_in_a_run_is_no_run(run):
    with pytest.raises(
        UserError, match=r"manifest.json is no run folder, .* give the folder that wearfem run"
    ):
        foretell(run / "manifest.json", Asked())


def test_prices_need_that_of_a_liner():
    with pytest.raises(UserError, match="prices were given without --price"):
        asked_for(**NOTHING | {"unplanned_price": 5.0}, currency="")
    with pytest.raises(UserError, match="the price of a liner was given as -1: it must be 0 or more"):
        asked_for(**NOTHING | {"price": -1.0}, currency="")
    assert asked_for(**NOTHING, currency="").prices is None


@pytest.mark.parametrize(
    ("text", "value"), [("600*hour", 600 * hour), ("60*kt", 60 * kt), ("2*day + 12*hour", 2.5 * day)]
)
def test_quantities_have_units(text, value):
    assert quantity("next-stop", text, "time", "mass") == pytest.approx(value)


def test_one_cycle_and_other_folders_are_refused(run, tmp_path):
    one = tmp_path / "one"
    shutil.copytree(run, one)
    for file in (one / "cycles").iterdir():
        if int(file.stem) > 1:
            file.unlink()
    with pytest.raises(UserError, match="a forecast was asked of 1 cycle"):
        foretell(one, Asked())
    shutil.rmtree(one / "cycles")
    with pytest.raises(UserError, match="has no cycles: a forecast is of a life"):
        foretell(one, Asked())
    with pytest.raises(UserError, match="is no run folder, it has no manifest"):
        foretell(tmp_path, Asked())
    with pytest.raises(UserError, match="but its geometry moves"):
        foretell(run, Asked(frozen=run))
