"""The case transfer_chute, shortened and with coarse ore, against its `expected.json`."""

import json
from pathlib import Path

import pytest

from wearfem.case import load_any_case
from wearfem.check import check_case
from wearfem.errors import UserError
from wearfem.run import run_case

CASE = Path(__file__).parents[2] / "cases" / "transfer_chute"
EXPECTED = json.loads((CASE / "expected.json").read_text())


def test_the_first_two_cycles(tmp_path):
    """Two short samples of coarse ore, and a jump of three days between them."""
    short = EXPECTED["short"]
    figures = {f.name: f for f in run_case(CASE, short["settings"], tmp_path / "run", quiet=True)}
    for name, expected in short["figures"].items():
        assert figures[name].unit == expected["unit"]
        assert figures[name].value == pytest.approx(expected["value"], abs=expected["tolerance"])
    assert (tmp_path / "run" / "chute.png").stat().st_size > 10_000  # an empty picture has some 3 kB


def test_the_shortcuts_are_told():
    """The default names each of its own; the published keywords leave only the time step."""
    assert len(load_any_case(CASE).notes) == 5
    published = {"slice_width": 0.0, "shear_modulus": 65e9, "coarsening": 1.0, "mesh_size": 50e-3}
    notes = load_any_case(CASE, published | {"time_step_share": 0.8}).notes
    assert len(notes) == 2
    assert "time step is 1.13e-06 s instead of 1.5e-6 s" in notes[0]


def test_the_published_chute_is_checked_before_it_runs():
    """With the printed time step the checker would refuse; with 80 % of the Rayleigh time it tells how long it takes."""
    published = {"slice_width": 0.0, "shear_modulus": 65e9, "coarsening": 1.0, "mesh_size": 50e-3}
    found = {finding.name: finding for finding in check_case(CASE, published | {"time_step_share": 0.8})}
    assert found["time to run"].value > 3600.0  # hours, not minutes
    assert found["time step over Rayleigh time"].value == pytest.approx(0.8, rel=1e-9)  # rounding


def test_a_limit_above_the_thickness_is_refused():
    with pytest.raises(UserError, match="worn out from the beginning"):
        load_any_case(CASE, {"limit_thickness": 25e-3})
