"""A case written as a file: what it says is what was put in, and it is a case like any other."""

from pathlib import Path

import pytest

from wearfem.case import LifeCase, load_any_case
from wearfem.case_file import with_effects, write_case
from wearfem.errors import UserError
from wearfem.run import run_case
from wearfem.wear.effect import Log
from wearfem.wear.effects import BuildUp, FactorCurve, HardnessGradient, Temperature
from wearfem.wear.laws import Scaled

PLATE = Path(__file__).parents[2] / "cases" / "wearing_plate"
EFFECTS = (
    HardnessGradient(50.0, 0.4),
    Temperature(0.01, 20.0, Log((0.0, 1.0), (2.0, 3.0))),
    BuildUp((0.0, 1.0, 2.0), 0.1),
    FactorCurve("position", (0.0, 0.1), (1.0, 2.0), 1),
)


def written(tmp_path, effects=EFFECTS, **more):
    settings = {"noise": 0.0, "delay": 0.0, "law": "constant", "cells": 4, "tolerance": 1e-3}
    return write_case(tmp_path / "improved", PLATE, settings, 1.25, effects, "A story.", **more)


def test_what_is_written_is_what_was_put_in(tmp_path):
    case = load_any_case(written(tmp_path))
    assert isinstance(case, LifeCase)
    assert case.effects == EFFECTS
    assert case.name == "wearing_plate_improved"
    assert isinstance(case.wear_law, Scaled) and case.wear_law.factor == 1.25
    assert case.settings["law"] == "constant" and case.settings["noise"] == 0.0
    assert PLATE / "case.py" in case.files  # its hash goes into the manifest


def test_its_keywords_are_those_of_the_original(tmp_path):
    file = written(tmp_path)
    assert load_any_case(file, {"cells": 6}).liner.mesh.wear.shape[0] == 2 * 6 * 3
    with pytest.raises(UserError, match="it can be constant, hardness_gradient or running_in"):
        load_any_case(file, {"law": "unknown"})
    with pytest.raises(UserError, match="no keyword cels .did you mean cells"):
        load_any_case(file, {"cels": 6})


def test_it_wears_by_its_factor(tmp_path):
    figures = {f.name: f for f in run_case(written(tmp_path, ()), {}, tmp_path / "run", quiet=True)}
    life = figures["end of life"]
    assert life.value == pytest.approx(1e7 / 1.25 / 86400.0, rel=1e-3)  # D / (1.25 r0), 0.1 % asked of it
    assert (life.expected, life.tolerance) == (None, None)  # the original's expectation is not this one's


def test_it_stops_where_it_is_told(tmp_path):
    file = written(tmp_path, (), stop=2e6)
    assert load_any_case(file).stop.service_time == 2e6
    assert load_any_case(file, {"stop": 1e6}).stop.service_time == 1e6


def test_an_improved_case_can_be_improved(tmp_path):
    first = written(tmp_path)
    second = load_any_case(write_case(tmp_path / "second", first.parent, {}, 2.0, (), "Again."))
    assert second.effects == EFFECTS
    assert second.wear_law == Scaled(load_any_case(first).wear_law, 2.0)


def test_a_case_with_effects_leaves_the_one_it_was_given():
    plain = load_any_case(PLATE)
    assert with_effects(plain, 2.0, EFFECTS).effects == (*plain.effects, *EFFECTS)
    assert load_any_case(PLATE).effects == plain.effects


def test_nothing_is_written_over(tmp_path):
    file = written(tmp_path)
    before = file.read_text()
    assert written(tmp_path) == file  # the same again is no harm
    with pytest.raises(UserError, match="give --out a new folder"):
        written(tmp_path, ())
    assert file.read_text() == before


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="give --out another folder"):
        write_case(tmp_path / "file" / "case", PLATE, {}, 1.0, (), "")
