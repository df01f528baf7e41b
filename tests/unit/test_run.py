"""A run from the case to the figures on disk, with a stand-in for the particles."""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import h5py
import numpy as np
import pytest

from wearfem.case import Figure
from wearfem.errors import UserError
from wearfem.run import figure_table, run_case

CASE = """
from wearfem.case import Case, Figure, Stage, Window

def case(*, force: float = 5.0) -> Case:
    stages = (Stage("settle", "still", Window(1.0)), Stage("slide", "turning", Window(2.0)))

    def measure(outcome):
        impulse = outcome["slide"].loads.impulse.sum()
        return (Figure("impulse", impulse, "N.s", 2.0 * force, "force times time", 1e-12 * force),)

    return Case("disc", force, stages, None, measure, notes=("a stand-in",))
"""


@dataclass(frozen=True)
class Loads:
    impulse: np.ndarray


@pytest.fixture
def disc(tmp_path, monkeypatch):
    """A case in cases/disc whose particles only multiply force and time."""

    def sample(flow, model, window, until, tell):
        tell(window.duration, model)
        return flow, Loads(np.full(2, 0.5 * flow * window.duration)), ()

    module, start = ModuleType("wearfem.dem.sample"), ModuleType("wearfem.dem.start")
    module.sample, start.check_start = sample, lambda flow, model: None
    monkeypatch.setitem(sys.modules, "wearfem.dem", ModuleType("wearfem.dem"))
    monkeypatch.setitem(sys.modules, "wearfem.dem.sample", module)
    monkeypatch.setitem(sys.modules, "wearfem.dem.start", start)
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "cases" / "disc"
    folder.mkdir(parents=True)
    (folder / "case.py").write_text(CASE)
    return Path("cases/disc")


def test_a_run_writes_what_it_shows(disc, capsys):
    figures = run_case(disc, {"force": 3.0}, json_file=Path("figures.json"))
    assert figures[0].value == 6.0
    run = Path("runs/disc")
    assert json.loads(Path("figures.json").read_text()) == json.loads((run / "figures.json").read_text())
    manifest = json.loads((run / "manifest.json").read_text())
    assert manifest["settings"] == {"force": 3.0}
    assert manifest["finished"] is not None
    with h5py.File(run / "loads.h5") as file:
        assert file["settle/impulse"][()].sum() == 3.0
    out = capsys.readouterr().out
    assert out.startswith("disc: writing to runs/disc\n")
    assert "agrees" in out and "note: a stand-in" in out and "wrote runs/disc in" in out


def test_a_second_run_has_its_own_folder(disc):
    run_case(disc, {}, quiet=True)
    run_case(disc, {}, quiet=True)
    assert sorted(path.name for path in Path("runs").iterdir()) == ["disc", "disc-2"]


@pytest.mark.parametrize(
    ("case", "settings", "out", "json_file"),
    [
        ("cases/disk", {}, "new", None),
        ("cases/disc", {"forse": 1.0}, "new", None),
        ("cases/disc", {}, "cases", None),
        ("cases/disc", {}, "new", "nowhere/figures.json"),
    ],
)
def test_a_mistake_is_told_before_anything_is_written(disc, case, settings, out, json_file):
    before = sorted(Path().rglob("*"))
    with pytest.raises(UserError):
        run_case(Path(case), settings, Path(out), json_file and Path(json_file))
    after = {path for path in Path().rglob("*") if "__pycache__" not in path.parts}
    assert sorted(after) == before


def test_the_table_is_aligned():
    table = figure_table(
        [Figure("volume", 5.8609e-9, "m3", 5.861e-9, "theory", 1e-12), Figure("n", 3.0, "-")]
    )
    assert table.splitlines() == [
        "figure  value          expected      tolerance  verdict   source",
        "volume  5.8609e-09 m3  5.861e-09 m3  1e-12 m3   agrees    theory",
        "n       3 -                                     reported",
    ]
