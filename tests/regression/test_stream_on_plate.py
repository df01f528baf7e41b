"""The case stream_on_plate: it aims at what it wears, and a frozen plate does not."""

import json
from pathlib import Path

import pytest

from wearfem.run import run_case

CASE = Path(__file__).parents[2] / "cases" / "stream_on_plate"
EXPECTED = json.loads((CASE / "expected.json").read_text())


@pytest.mark.parametrize("kind", ["moving", "frozen"])
def test_half_a_life(kind, tmp_path):
    settings = {"cells": 16, "frozen": kind == "frozen", "stop": 3.456e7}  # 400 days
    figures = {f.name: f for f in run_case(CASE, settings, tmp_path / "run", quiet=True)}
    for name, expected in EXPECTED[kind].items():
        assert figures[name].unit == expected["unit"]
        assert figures[name].value == pytest.approx(expected["value"], abs=expected["tolerance"])
