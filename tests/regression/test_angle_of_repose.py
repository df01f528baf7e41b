"""The angle of repose, coarse and in full, against the figures that the case stood at when it was written."""

import json
from pathlib import Path

import pytest

from wearfem.case import load_case
from wearfem.run import run_stages

FOLDER = Path(__file__).parents[2] / "cases" / "angle_of_repose"


def test_the_case_is_as_printed():
    """Feed, time scale and pairs of materials are those of the paper; nothing else may slip in."""
    case = load_case(FOLDER, {"experiment": 2})
    model = case.stages[0].model
    table = model.table
    assert [round(float(value), 12) for value in table.friction[0]] == [0.41, 0.46, 0.24]
    assert [round(float(value), 12) for value in table.rolling_friction[0]] == [0.22, 0.3, 0.22]
    assert model.inlets[0].due(10.0) == pytest.approx(2.775, rel=1e-12)  # rounding
    turn = model.walls[0].motion
    assert (turn.stop - turn.start) * turn.rate == pytest.approx(1.0471975511965976, rel=1e-12)  # 60 degrees
    assert turn.rate == pytest.approx(10 * 0.22863813201125717, rel=1e-12)  # 13.1 degrees a second


@pytest.mark.parametrize(
    ("experiment", "coarsening"),
    [(2, 3.0), pytest.param(1, 1.0, marks=pytest.mark.slow), pytest.param(2, 1.0, marks=pytest.mark.slow)],
)
def test_three_angles(experiment, coarsening):
    expected = json.loads((FOLDER / "expected.json").read_text())[
        f"experiment {experiment}, coarsening {coarsening:g}"
    ]
    case = load_case(FOLDER, {"experiment": experiment, "coarsening": coarsening})
    figures = {figure.name: figure.value for figure in case.measure(run_stages(case, quiet=True))}
    for name, (value, tolerance) in expected.items():
        assert figures[name] == pytest.approx(value, abs=tolerance)  # the tolerance is the spread over seeds
