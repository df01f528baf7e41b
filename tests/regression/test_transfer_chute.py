"""The case transfer_chute, shortened and with coarse ore, against its `expected.json`."""

import json
from pathlib import Path

import pytest

from wearfem.case import load_any_case
from wearfem.check import check_case
from wearfem.cycle import cycle, first_state
from wearfem.errors import UserError
from wearfem.history import history_of
from wearfem.liner.liner import wear_surface
from wearfem.liner.recede import volume

CASE = Path(__file__).parents[2] / "cases" / "transfer_chute"
EXPECTED = json.loads((CASE / "expected.json").read_text())


def test_the_first_cycle(tmp_path):
    """A short sample of coarse ore, its rates of wear, the first jump, and the picture."""
    short = EXPECTED["short"]
    case = load_any_case(CASE, short["settings"])
    state, report = cycle(case, first_state(case))
    history = history_of(state, (report,))
    figures = {figure.name: figure for figure in case.measure(history)}
    for name, expected in short["figures"].items():
        assert figures[name].unit == expected["unit"]
        assert figures[name].value == pytest.approx(expected["value"], abs=expected["tolerance"])
    lost = volume(case.liner.mesh) - volume(state.now.liner.mesh)
    area = wear_surface(case.liner).facet_area
    assert report.jump.recession.max() > 0.1e-3  # [m]; at most a quarter of the smallest ball's 4.5 mm
    assert lost == pytest.approx(area @ report.jump.recession, rel=1e-9)  # what recession promises
    case.draw(history, tmp_path)
    assert (tmp_path / "chute.png").stat().st_size > 10_000  # an empty picture has some 3 kB


def test_the_shortcuts_are_told():
    """The default names each of its own; the published keywords leave only the time step."""
    assert len(load_any_case(CASE).notes) == 5
    published = {"slice_width": 0.0, "shear_modulus": 65e9, "coarsening": 1.0, "mesh_size": 50e-3}
    notes = load_any_case(CASE, published | {"time_step_share": 0.8}).notes
    assert len(notes) == 2
    assert "time step is 1.13e-06 s instead of 1.5e-6 s" in notes[0]


def test_the_published_chute_is_checked_before_it_runs():
    """The published keywords can be built, and it is told how long even a first sample would take."""
    published = {"slice_width": 0.0, "shear_modulus": 65e9, "coarsening": 1.0, "mesh_size": 50e-3}
    found = {finding.name: finding for finding in check_case(CASE, published | {"time_step_share": 0.8})}
    assert found["time to run"].value > 1200.0  # [s] for a first sample alone; some 20 follow
    assert found["time step over Rayleigh time"].value == pytest.approx(0.8, rel=1e-9)  # rounding


def test_a_limit_above_the_thickness_is_refused():
    with pytest.raises(UserError, match="worn out from the beginning"):
        load_any_case(CASE, {"limit_thickness": 25e-3})
