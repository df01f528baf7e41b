"""Studies of the wearing plate: with a stand-in for the runs, then with real ones, and on a real Dask cluster of two workers."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future
from pathlib import Path

import h5py
import numpy as np
import pytest

from wearfem import study as module
from wearfem.errors import UserError
from wearfem.plan import grid
from wearfem.run import run_case
from wearfem.study import dask_executor, planned, study

ROOT = Path(__file__).parents[2]
PLATE = ROOT / "cases" / "wearing_plate"
SHORT = {"noise": 0.1, "cells": 2, "tolerance": 0.2, "law": "constant"}  # a life of a few cycles
TRICKY = """
import importlib.util, os, time
from dataclasses import replace
from pathlib import Path

def case(*, ending: str = "well", seed: int = 1, jumps: int = 0):
    spec = importlib.util.spec_from_file_location("plate", {plate!r})
    plate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(plate)
    life = plate.case(noise=0.0, delay=0.0, cells=2, tolerance=0.2, law="constant", seed=seed, jumps=jumps)

    def measure(history):
        from wearfem.errors import UserError
        if ending == "sentence":
            raise UserError("the plate was given away: take another")
        if ending == "crash":
            os.kill(os.getpid(), 9)
        if ending == "once" and not Path({mark!r}).exists():
            Path({mark!r}).touch()
            raise KeyboardInterrupt
        return life.measure(history)

    return replace(life, name="tricky", measure=measure)
"""


@pytest.fixture
def formula(monkeypatch):
    """Runs by formula instead of processes; the calls that were made."""
    calls = []

    def run_one(case_folder, given, place, in_cycles):
        calls.append(given)
        if given.get("law") == "running_in" and given["cells"] == 4:
            return {"status": "failed", "seconds": 1.0, "figures": [], "problem": "no plate of 4 cells"}
        h = 1.0 / given.get("cells", 8)
        noise = 1e-3 * (-1) ** given.get("seed", 0)
        figures = [
            {"name": "life", "value": 7.0 + h**2 + (noise if "seed" in given else 0.0), "unit": "d"},
            {"name": "count", "value": None, "unit": "-"},
        ]
        return {"status": "done", "seconds": 2.0, "figures": figures, "problem": ""}

    monkeypatch.setattr(module, "run_one", run_one)
    return calls


def test_what_is_done_is_not_run_again(formula, tmp_path):
    first = study(PLATE, grid({"cells": (2, 4)}), tmp_path / "s", quiet=True)
    assert (len(first), len(formula)) == (2, 2)
    again = study(PLATE, grid({"cells": (2, 4, 8)}), tmp_path / "s", quiet=True)
    assert [given["cells"] for given in formula[2:]] == [8]
    assert [row.settings["cells"] for row in again] == [2, 4, 8]
    assert again[:2] == first


def test_failures_are_kept_and_shown(formula, tmp_path, capsys):
    plan = grid({"cells": (2, 4), "law": ("constant", "running_in")})
    rows = study(PLATE, plan, tmp_path / "s", quiet=True)
    assert [row.status for row in rows].count("failed") == 1
    assert "failed: law=running_in, cells=4: no plate of 4 cells" in capsys.readouterr().out
    study(PLATE, plan, tmp_path / "s", quiet=True)
    assert len(formula) == 4
    study(PLATE, plan, tmp_path / "s", quiet=True, retry=True)
    assert len(formula) == 5


def test_the_tables_hold_the_same_rows(formula, tmp_path):
    rows = study(
        PLATE, grid({"cells": (2, 4), "law": ("constant", "running_in")}), tmp_path / "s", quiet=True
    )
    with open(tmp_path / "s" / "results.csv", encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert len(table) == 4 and list(table[0])[:5] == ["run", "status", "seconds", "law", "cells"]
    assert [float(line["life [d]"] or "nan") for line in table] == pytest.approx(
        [row.figure("life") for row in rows], nan_ok=True, rel=1e-15
    )
    assert {line["problem"] for line in table} == {"", "no plate of 4 cells"}
    with h5py.File(tmp_path / "s" / "results.h5") as file:
        np.testing.assert_array_equal(file["life [d]"][()], [row.figure("life") for row in rows])
        assert file["life [d]"].attrs["unit"] == "d"
        assert [text.decode() for text in file["law"][()]] == [row.settings["law"] for row in rows]
        assert np.isnan(file["count [-]"][()]).all()
    assert {path.name for path in (tmp_path / "s" / "pictures").iterdir()} == {"life.png", "count.png"}


def test_a_size_has_an_order_and_an_answer(formula, tmp_path, capsys):
    study(PLATE, grid({"cells": (2, 4, 8)}), tmp_path / "s", sizes=["cells"], quiet=True)
    (told,) = json.loads((tmp_path / "s" / "converged.json").read_text())
    assert told["answer"]["value"] == pytest.approx(
        7.0, abs=1e-9
    )  # the fit ends where rounding hides the rest
    assert told["answer"]["order"] == pytest.approx(2.0, abs=1e-6)
    assert "life as cells goes to zero: 7 d, order 2" in capsys.readouterr().out


def test_seeds_are_samples_of_one_result(formula, tmp_path):
    study(PLATE, grid({"cells": (2, 4, 8), "seed": (1, 2)}), tmp_path / "s", sizes=["cells"], quiet=True)
    (told,) = json.loads((tmp_path / "s" / "converged.json").read_text())
    assert told["answer"]["value"] == pytest.approx(7.0, abs=1e-6)  # +-0.001 have the mean 0
    assert told["answer"]["noise"] > 1e-3  # the standard error of a mean of two, and more at size zero


class Later(Executor):
    """The least that an executor can be: it does the work when it is asked for."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        future.set_result(fn(*args, **kwargs)) if args[1]["cells"] != 4 else future.set_exception(
            OSError("lost")
        )
        return future


def test_any_executor_and_a_lost_worker(formula, tmp_path):
    rows = study(PLATE, grid({"cells": (2, 4)}), tmp_path / "s", executor=Later(), quiet=True)
    assert [row.status for row in rows] == ["done", "failed"]
    assert rows[1].problem == "its worker failed (OSError: lost)"


@pytest.mark.parametrize(
    ("texts", "more", "sentence"),
    [
        (["celsl=1,2"], {}, "nothing was run.* no keyword celsl .did you mean cells"),
        (["cells=2,x"], {}, "nothing was run, because of the row cells=x: cells was given 'x'"),
        (["noise=0,-1"], {}, "because of the row noise=-1: .* must be 0 or more"),
        (["noise=0..1"], {}, "needs --sobol N or --latin N"),
        (["noise=0..1"], {"sobol_count": 3}, "power of 2"),
        (["noise=0..1"], {"sobol_count": 4, "latin_count": 4}, "two plans at once"),
        (["cells=1,2"], {"fixed": {"cells": 2}}, "cells was given to --set and to the study"),
    ],
)
def test_mistakes_are_told_before_anything_runs(formula, tmp_path, texts, more, sentence):
    with pytest.raises(UserError, match=sentence):
        study(PLATE, planned(PLATE, texts, more.pop("fixed", {}), **more), tmp_path / "s", quiet=True)
    assert not formula and not (tmp_path / "s").exists()


def test_sizes_and_folders_are_checked(formula, tmp_path):
    plan = grid({"law": ("constant", "running_in"), "cells": (2,)})
    for size, sentence in (("law", "a size is a number above 0"), ("celsl", "did you mean cells")):
        with pytest.raises(UserError, match=sentence):
            study(PLATE, plan, tmp_path / "s", sizes=[size], quiet=True)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "notes.txt").touch()
    with pytest.raises(UserError, match="is a folder with files in it"):
        study(PLATE, plan, tmp_path / "full", quiet=True)
    study(PLATE, plan, tmp_path / "s", quiet=True)
    begun = json.loads((tmp_path / "s" / "study.json").read_text())
    for change, sentence in (
        ({"case": "chute"}, "is a study of chute"),
        ({"sha256": dict.fromkeys(begun["sha256"], "0")}, "is not what it was"),
    ):
        (tmp_path / "s" / "study.json").write_text(json.dumps(begun | change))
        with pytest.raises(UserError, match=sentence):
            study(PLATE, plan, tmp_path / "s", quiet=True)
    (tmp_path / "s" / "study.json").write_text("{")
    with pytest.raises(UserError, match="study.json cannot be read"):
        study(PLATE, plan, tmp_path / "s", quiet=True)
    assert len(formula) == 2


def test_without_dask_there_is_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(UserError, match=r"dask.distributed is not installed.*wearfem\[study\]"),
        dask_executor("tcp://127.0.0.1:1"),
    ):
        pass


@pytest.mark.usefixtures("meshing")
def test_real_runs_end_as_they_do(tmp_path):
    """One ends well, one with a sentence, one is killed, one is interrupted and resumed by the next call."""
    folder = tmp_path / "tricky"
    folder.mkdir()
    mark = str(tmp_path / "mark")
    (folder / "case.py").write_text(
        TRICKY.replace("{plate!r}", repr(str(PLATE / "case.py"))).replace("{mark!r}", repr(mark))
    )
    plan = grid({"ending": ("well", "sentence", "crash", "once")})
    with pytest.raises(KeyboardInterrupt):
        study(folder, plan, tmp_path / "s", workers=2, quiet=True)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "s" / "rows").iterdir()}
    assert len(before) == 3
    rows = {row.settings["ending"]: row for row in study(folder, plan, tmp_path / "s", workers=2, quiet=True)}
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert {name: row.status for name, row in rows.items()} == {
        "well": "done", "sentence": "failed", "crash": "failed", "once": "done",
    }  # fmt: skip
    assert rows["sentence"].problem == "the plate was given away: take another."
    assert "ended by signal 9" in rows["crash"].problem
    assert rows["once"].figures == rows["well"].figures  # resumed to the bit


@pytest.mark.usefixtures("meshing")
def test_a_dask_cluster_of_two_workers(tmp_path):
    distributed = pytest.importorskip("distributed")
    plan = tuple(SHORT | row for row in grid({"seed": (1, 2)}))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, local_directory=str(tmp_path / "dask")
    ) as cluster:
        began = len(cluster.workers)
        with dask_executor(cluster.scheduler_address) as executor:
            rows = study(PLATE, plan, tmp_path / "s", executor=executor, quiet=True)
    assert began == 2
    assert [row.status for row in rows] == ["done", "done"]
    figures = run_case(PLATE, plan[1], tmp_path / "alone", quiet=True)
    assert rows[1].figures == figures  # to the bit, wherever it ran


@pytest.mark.slow
def test_a_killed_study_goes_on(tmp_path):
    """The whole process group is killed between two rows; the command begun again makes the rest alone."""
    words = ["study", str(PLATE), "seed=1,2,3,4", "--out", str(tmp_path / "s"), "--workers", "1", "--quiet"]
    words += [part for name, value in SHORT.items() for part in ("--set", f"{name}={value}")]
    command = [sys.executable, "-m", "wearfem.cli", *words]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    process = subprocess.Popen(command, env=environment, start_new_session=True, stdout=subprocess.DEVNULL)
    while len(list((tmp_path / "s" / "rows").glob("*.json"))) < 2:
        assert process.poll() is None
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "s" / "rows").glob("*.json")}
    assert 2 <= len(before) < 4
    subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL)
    assert {path: path.stat().st_mtime_ns for path in before} == before
    rows = [json.loads(path.read_text()) for path in (tmp_path / "s" / "rows").glob("*.json")]
    assert [row["status"] for row in rows] == ["done"] * 4
