"""The run folder of a life: what is read back is what was written, and what is damaged or foreign is refused."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
import pytest

from wearfem.case import load_any_case
from wearfem.errors import UserError
from wearfem.history import computing_of, cycles_of, read_cycle, read_history
from wearfem.life import line, live
from wearfem.material import Material
from wearfem.proofs.cycle import differences
from wearfem.record import alone
from wearfem.run import resume_run, run_case
from wearfem.values import read_value, write_value

CASE = Path(__file__).parents[2] / "cases" / "wearing_plate"
SETTINGS = {"cells": 4, "law": "running_in", "tolerance": 0.05}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    run = tmp_path_factory.mktemp("life") / "run"
    figures = run_case(CASE, SETTINGS, run, quiet=True)
    return run, figures


@pytest.fixture
def run(finished, tmp_path):
    """A copy that a test may damage, as if it had been stopped before the last cycle."""
    shutil.copytree(finished[0], tmp_path / "run")
    run = tmp_path / "run"
    (run / "cycles" / f"{cycles_of(run):04d}.h5").unlink()
    change_manifest(run, finished=None)
    return run


def change_manifest(run, **changes):
    manifest = run / "manifest.json"
    manifest.write_text(json.dumps(json.loads(manifest.read_text()) | changes))


class Row(NamedTuple):
    force: np.ndarray
    step: float


def test_values_come_back_to_the_bit(tmp_path):
    material = Material("steel", 7850.0, 80e9, 0.3)
    value = (
        material,
        {"wear": np.arange(300).reshape(100, 3), "empty": np.zeros((0, 3), np.int32)},
        (1, 2.5, True, None, "word", np.float64(0.1), np.int64(3), float("inf"), np.nan, -0.0),
        np.array(0.1),
    )
    with h5py.File(tmp_path / "x.h5", "w") as file:
        write_value(file, "value", value)
    with h5py.File(tmp_path / "x.h5") as file:
        assert differences(read_value(file, "value"), value) == 0


@dataclass(frozen=True)
class Foreign:
    number: int = 1


def test_a_class_of_nobody_is_not_made(tmp_path):
    with h5py.File(tmp_path / "x.h5", "w") as file:
        write_value(file, "value", Foreign())
        write_value(file, "other", Material("steel", 1.0, 1.0, 0.3))
        file["other"].attrs["kind"] = "wearfem.record:write_json"
        with pytest.raises(UserError, match="belongs neither to wearfem nor to the case"):
            read_value(file, "value")
        with pytest.raises(UserError, match="which this version does not have"):
            read_value(file, "other")
        with pytest.raises(TypeError, match="cannot be written"):
            write_value(file, "third", object())


def test_the_history_is_the_life(finished):
    run, figures = finished
    history = read_history(run)
    cycles, facets = len(history.service_time), 16
    assert history.ended == "end of life"
    for field in ("depth", "rate", "error", "thickness"):
        assert getattr(history, field).shape == (cycles, facets)
    assert (np.diff(history.depth, axis=0) > 0.0).all()
    np.testing.assert_allclose(history.thickness[0], 20e-3, rtol=1e-12)  # rounding
    # a plane plate: what is gone from the thickness is what the surface was moved by
    moved = np.array([r.depth for r in history.reports if r.kept])
    np.testing.assert_allclose(history.thickness, 20e-3 - moved, rtol=1e-9)
    assert figures[0].value * 86400.0 == pytest.approx(history.life[-1].time)
    assert np.isnan(history.least_reserve).all()
    assert len(history.jump) == len(history.life) == cycles


def test_paraview_finds_the_worn_faces(finished):
    run, _ = finished
    import pyvista

    series = json.loads((run / "surface.vtkhdf.series").read_text())
    assert series["file-series-version"] == "1.0"
    times = [entry["time"] for entry in series["files"]]
    history = read_history(run)
    assert times == [report.service_time for report in history.reports]
    last = pyvista.read(run / series["files"][-1]["name"])
    np.testing.assert_allclose(last["depth [m]"], history.reports[-1].depth[last["facet"]])
    # VTK reads points of single precision
    assert 20e-3 + last.points[:, 2].mean() == pytest.approx(history.thickness[-1].mean(), rel=1e-5)


def test_lines_are_honest(finished, tmp_path, capsys):
    run_case(CASE, SETTINGS, tmp_path / "run", quiet=True)
    lines = [row for row in capsys.readouterr().out.splitlines() if row.startswith("cycle ")]
    assert len(lines) == cycles_of(tmp_path / "run")
    assert "0 s served, 0 t, deepest 0 mm, 0 cm3, jump" in lines[0]
    assert all("end of life at" in row and "+-" in row and "90%" in row for row in lines)


def test_going_on_gives_the_same_figures(run, finished, capsys):
    before = (run / "cycles" / "0001.h5").stat().st_mtime_ns
    figures = resume_run(run, quiet=True)
    assert figures == finished[1]
    assert (run / "cycles" / "0001.h5").stat().st_mtime_ns == before
    load = read_cycle(run, cycles_of(run)), read_cycle(finished[0], cycles_of(run))
    assert differences(*load) == 0


def test_a_finished_run_is_not_resumed(finished):
    with pytest.raises(UserError, match="is finished .*: there is nothing to resume"):
        resume_run(finished[0])


def test_a_truncated_file_is_refused_and_nothing_is_lost(run):
    last = run / "cycles" / f"{cycles_of(run):04d}.h5"
    whole = last.read_bytes()
    last.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(UserError, match=r"is cut off or damaged .*resume from the cycle before"):
        resume_run(run, quiet=True)
    assert len(last.read_bytes()) == len(whole) // 2
    last.unlink()  # as the sentence says
    assert resume_run(run, quiet=True)


def test_a_damaged_array_is_noticed(run):
    last = run / "cycles" / f"{cycles_of(run):04d}.h5"
    with h5py.File(last) as file:
        place = file["state/now/liner/mesh/node"].id.get_chunk_info(0).byte_offset
    content = bytearray(last.read_bytes())
    content[place + 40] ^= 1
    last.write_bytes(content)
    with pytest.raises(UserError, match="is cut off or damaged"):
        read_history(run)


def test_a_missing_cycle_is_told(run):
    (run / "cycles" / "0002.h5").unlink()
    with pytest.raises(UserError, match=r"but not cycle 2: put 0002.h5 back"):
        resume_run(run)


def test_another_case_is_refused(run, monkeypatch, tmp_path):
    begun = json.loads((run / "manifest.json").read_text())
    change_manifest(run, sha256=dict.fromkeys(begun["sha256"], "0" * 64))
    with pytest.raises(UserError, match=r"case.py is not what it was when .* was begun"):
        resume_run(run)


def test_another_version_is_refused(run):
    begun = json.loads((run / "manifest.json").read_text())
    change_manifest(run, versions=begun["versions"] | {"wearfem": "0.0.0"})
    with pytest.raises(UserError, match=r"was begun by wearfem 0.0.0, and this is"):
        resume_run(run)
    change_manifest(run, versions=begun["versions"])
    last = run / "cycles" / f"{cycles_of(run):04d}.h5"
    with h5py.File(last, "a") as file:
        file.attrs["wearfem"] = "0.0.0"
    with pytest.raises(UserError, match=r"was written by wearfem 0.0.0"):
        resume_run(run)


def test_what_is_no_run_is_refused(tmp_path):
    with pytest.raises(UserError, match="is no run folder"):
        resume_run(tmp_path)
    (tmp_path / "manifest.json").write_text("{}")
    with pytest.raises(UserError, match="was not written by wearfem run"):
        resume_run(tmp_path)
    with pytest.raises(UserError, match="has no cycle yet"):
        read_history(tmp_path)


def test_another_process_at_work_is_noticed(run):
    from wearfem.history import write_cycle

    state, report = read_cycle(run, cycles_of(run))
    with pytest.raises(UserError, match="another process is at work"):
        write_cycle(run, state, report, worn=state.now)


def test_time_outside_the_flow_leaves_out_the_first_cycle(run):
    """1.8 of 20 s: the first cycle, which may have compiled, is not in the share and is in the sum."""
    for number in range(1, cycles_of(run) + 1):
        with h5py.File(run / "cycles" / f"{number:04d}.h5", "a") as file:
            attributes = {1: (100.0, 50.0), 2: (15.0, 14.0), 3: (5.0, 4.2)}
            file.attrs["run_time"], file.attrs["flow_time"] = attributes.get(number, (0.0, 0.0))
    told = computing_of(run)
    assert told.total == 120.0
    assert told.outside == pytest.approx(0.09, rel=1e-12)  # rounding
    assert told.words().startswith("computing: 2 min 00 s in cycles; all but the flow ")
    assert " took 9 % of it, the first cycle left out" in told.words()


def test_a_run_tells_the_time_outside_the_flow(finished, capsys):
    """What the clock of the cycles says; a flow by formula takes some time and not all of it."""
    told = computing_of(finished[0])
    assert 0.0 < told.flow < told.later < told.total
    live(load_any_case(CASE, SETTINGS), finished[0], quiet=True)  # it is ended: nothing is computed again
    assert told.words() in capsys.readouterr().out.splitlines()


def test_a_run_that_is_at_work_is_left_alone(run):
    """A second process would write the same cycles, and the first would find them there and stop."""
    before = sorted(path.name for path in run.rglob("*"))
    with alone(run), pytest.raises(UserError, match="another process is at work"):
        resume_run(run, quiet=True)
    assert sorted(path.name for path in run.rglob("*")) == before
    resume_run(run, quiet=True)  # and then it goes on
    assert len(list(run.rglob("*"))) > len(before)


def test_time_to_run_ends_where_the_life_is_stopped(finished):
    """After half of what is asked, in 10 s, 10 s are to come, though the liner would last far longer."""
    report = read_history(finished[0]).reports[1]
    case = load_any_case(CASE, SETTINGS | {"stop": 2.0 * report.service_time})
    state, _ = read_cycle(finished[0], 2)
    assert report.life.time > 3.0 * report.service_time
    assert line(report, case, 10.0, state).endswith(", about 10 s to run")
