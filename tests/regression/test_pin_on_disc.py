"""The case pin_on_disc, shortened, against its `expected.json`; in full with -m slow."""

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from wearfem.case import load_case
from wearfem.dem.sample import Stepper
from wearfem.dem.tally import LOAD_DISTANCE
from wearfem.errors import UserError
from wearfem.run import run_case, run_stages

CASE = Path(__file__).parents[2] / "cases" / "pin_on_disc"
EXPECTED = json.loads((CASE / "expected.json").read_text())


@pytest.fixture(scope="module")
def short():
    """10 mm of sliding: some twenty joints."""
    case = load_case(CASE, {"distance": 10e-3})
    return case, run_stages(case, quiet=True)


@pytest.fixture(scope="module")
def sensitivity():
    spec = importlib.util.spec_from_file_location("pin_on_disc_sensitivity", CASE / "sensitivity.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_figures_agree(short):
    case, outcome = short
    figures = {figure.name: figure for figure in case.measure(outcome)}
    for name, expected in EXPECTED["figures"].items():
        assert figures[name].unit == expected["unit"]
        assert figures[name].value == pytest.approx(expected["value"], abs=expected["tolerance"]), name
    assert {figure.verdict for figure in figures.values()} == {"agrees", "reported"}


def test_wear_is_force_times_distance(short):
    case, outcome = short
    loads = outcome["slide"].loads
    load = 5.0 + 4850.0 * 4.0 / 3.0 * np.pi * 2e-3**3 * 9.81
    slid = 6.82 * 22e-3 * loads.duration.sum()
    assert case.wear_law.volume(loads).sum() == pytest.approx(
        6.51e-12 * load * slid, rel=1e-12
    )  # rounding of 44 000 terms
    assert (loads.area @ case.wear_law.depth_rate(loads).T @ loads.duration) == pytest.approx(
        case.wear_law.volume(loads).sum(),
        rel=1e-13,  # the same sum in another order
    )


def test_no_joint_is_felt_in_any_step():
    """Force, velocity and load at every step over the joints of the finest mesh, where the paper saw kicks."""
    case = load_case(CASE, {"mesh_size": 0.55e-3})
    stepper = Stepper(case.flow, case.stages[1].model)
    stepper.advance(1333)
    stepper.tally.sums[:] = 0.0
    rows = []
    for _ in range(8000):  # 1.8 mm
        stepper.advance(1)
        p = stepper.particles
        rows.append([*p.force[0], p.velocity[0, 2]])
    rows = np.array(rows)
    crossed = np.count_nonzero(stepper.tally.sums[:, LOAD_DISTANCE])
    assert crossed >= 4
    load = 5.0 + p.mass[0] * 9.81
    assert (
        np.abs(rows[:, 2] / load - 1.0).max() < 1e-11
    )  # rounding: 2e-3 m / 9e-7 m of overlap x 2e-16, some steps' worth
    assert (
        np.abs(np.hypot(rows[:, 0], rows[:, 1]) / load - 1.0).max() < 1e-6
    )  # friction 1: slides at its limit throughout
    assert np.abs(rows[:, 3]).max() < 1e-9 * 0.15  # [m/s] a part of the sliding speed


def test_wear_does_not_know_the_mesh_or_the_time_step(sensitivity):
    rows = [
        sensitivity.revolution(name, value, turns=0.02)
        for name, value in (
            ("mesh_size", 0.55e-3),
            ("mesh_size", 4.4e-3),
            ("time_step", 2.5e-6),
            ("shear_modulus", 0.65e9),
        )
    ]
    for row in rows:
        assert row.volume == pytest.approx(
            row.theory, rel=1e-7
        )  # what is left of settling at 0.65 GPa; others 1e-12


def test_wear_follows_force_and_weight(sensitivity):
    for name, value in (("radius", 1e-3), ("radius", 4e-3), ("density", 5050.0), ("force", 9.0)):
        row = sensitivity.revolution(name, value, turns=0.02)
        assert row.volume == pytest.approx(row.theory, rel=1e-9)  # rounding


def test_the_run_folder(tmp_path, capsys):
    run_case(CASE, {"distance": 2e-3}, tmp_path / "run", quiet=True)
    import pyvista

    mesh = pyvista.read(tmp_path / "run" / "surface.vtkhdf")
    volume = np.bincount(mesh["facet"], mesh["wear volume [m3]"]).sum()
    figures = {f["name"]: f["value"] for f in json.loads((tmp_path / "run" / "figures.json").read_text())}
    assert volume == pytest.approx(figures["wear volume"], rel=1e-12)  # the same sum in another order
    area = mesh.compute_cell_sizes()["Area"]
    assert mesh["depth [m]"] @ area == pytest.approx(
        volume, rel=1e-6
    )  # VTK's areas are of single-precision points
    assert (tmp_path / "run" / "pin_on_disc.png").stat().st_size > 10_000  # bytes: not an empty picture


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"mesh_size": 1.0e-3}, "no mesh of 1 mm"),
        ({"track_radius": 30e-3}, "on the disc"),
        ({"rotation_speed": 0.0}, "must turn"),
    ],
)
def test_mistakes(settings, sentence):
    with pytest.raises(UserError, match=sentence):
        load_case(CASE, settings)


@pytest.mark.slow
def test_the_full_180_m_twice():
    """8e8 steps, each time."""
    full = EXPECTED["full"]
    case = load_case(CASE, {"distance": full["distance"]})
    volumes = []
    for _ in range(2):
        loads = run_stages(case, quiet=True)["slide"].loads
        volumes.append(case.wear_law.volume(loads))
    expected = full["wear volume"]
    assert volumes[0].sum() == pytest.approx(expected["value"], abs=expected["tolerance"])
    np.testing.assert_array_equal(volumes[0], volumes[1])  # to the bit
