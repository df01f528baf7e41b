"""The case wearing_plate against its `expected.json`, through the command that people use."""

import json
from pathlib import Path

import pytest

from wearfem.case import LifeCase, load_any_case, load_case
from wearfem.check import check_case
from wearfem.errors import UserError
from wearfem.run import run_case

CASE = Path(__file__).parents[2] / "cases" / "wearing_plate"
EXPECTED = json.loads((CASE / "expected.json").read_text())


@pytest.mark.parametrize("law", ["constant", "hardness_gradient", "running_in"])
def test_lives_without_noise(law, tmp_path):
    settings = {"law": law, "noise": 0.0, "delay": 0.0, "tolerance": 1e-3, "cells": 4}
    figures = {f.name: f for f in run_case(CASE, settings, tmp_path / "run", quiet=True)}
    expected = EXPECTED["lives"][law]
    assert figures["end of life"].value * 86400.0 == pytest.approx(
        expected["value"], abs=expected["tolerance"]
    )


def test_the_default(tmp_path):
    figures = {f.name: f for f in run_case(CASE, {}, tmp_path / "run", quiet=True)}
    expected = EXPECTED["noisy"]["end of life"]
    assert figures["end of life"].unit == expected["unit"]
    assert figures["end of life"].value == pytest.approx(expected["value"], abs=expected["tolerance"])


def test_a_life_that_was_stopped_is_not_judged(tmp_path):
    """What would come if the flow stayed is no end of life, however well it is known."""
    run_case(CASE, {"stop": 20 * 86400.0, "noise": 0.0, "cells": 4}, tmp_path / "run", quiet=True)
    told = json.loads((tmp_path / "run" / "figures.json").read_text())[0]
    assert told["name"] == "end of life, at the last rate"
    assert told["verdict"] == "reported"
    # the hardness is known and the flow stays: 86.8 d by the closed form, where the first rate says 115.7 d
    assert told["value"] == pytest.approx(7.5e6 / 86400.0, rel=1e-4)


def test_a_life_is_no_case_in_stages():
    assert isinstance(load_any_case(CASE), LifeCase)
    with pytest.raises(UserError, match="is the life of a liner in cycles"):
        load_case(CASE)


def test_it_is_checked_before_it_runs():
    names = {finding.name for finding in check_case(CASE, {"loads": "particles"})}
    assert "memory" in names
    with pytest.raises(UserError, match="there is nothing to check"):
        check_case(CASE, {})


@pytest.mark.slow
def test_under_particles(tmp_path):
    settings = {"loads": "particles", "law": "constant", "tolerance": 0.1, "stop": 1e6}
    figures = {f.name: f for f in run_case(CASE, settings, tmp_path / "run", quiet=True)}
    (name, expected), *_ = EXPECTED["particles"].items()
    assert figures[name].value == pytest.approx(expected["value"], abs=expected["tolerance"])
