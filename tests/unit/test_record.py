"""The run folder: what is written is whole or absent, and nothing that exists is touched."""

import errno
import json
import os
import signal
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
import pytest

from wearfem.case import Case, Figure, Stage, Window
from wearfem.errors import UserError
from wearfem.record import (
    RunFolder,
    hdf5_file,
    manifest,
    now,
    require_writable,
    whole_file,
    write_json,
    write_loads,
    write_surface,
)


def test_a_new_folder_and_an_empty_one_are_taken(tmp_path):
    assert RunFolder.create(tmp_path / "a" / "b").path.is_dir()
    assert RunFolder.create(tmp_path / "a" / "b").path.is_dir()


def test_a_folder_with_files_is_refused_and_left_alone(tmp_path):
    (tmp_path / "old.txt").write_text("mine")
    with pytest.raises(UserError, match="is a folder with files in it.*nothing was changed"):
        RunFolder.create(tmp_path)
    assert [path.read_text() for path in tmp_path.iterdir()] == ["mine"]


@pytest.mark.parametrize("below", ["", "/run"])
def test_a_file_in_the_way_is_refused(tmp_path, below):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(UserError, match="output folder"):
        RunFolder.create(Path(f"{tmp_path}/file{below}"))
    assert (tmp_path / "file").read_text() == "mine"


def test_a_place_that_cannot_be_written_is_refused(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(UserError, match=r"cannot make the output folder .*/run \(Read-only file system\)"):
        RunFolder.create(tmp_path / "run")


def test_an_empty_folder_that_cannot_be_written_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write anywhere, so the mode would not tell
    with pytest.raises(UserError, match="Permission denied"):
        RunFolder.create(tmp_path)


def test_a_free_folder_is_found(tmp_path):
    names = [RunFolder.create_free("disc", tmp_path).path.name for _ in range(3)]
    assert names == ["disc", "disc-2", "disc-3"]


def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch):
    file = tmp_path / "figures.json"
    write_json(file, {"a": 1})

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(UserError, match=r"cannot write .*figures.json \(No space left on device\)"):
        write_json(file, {"a": 2})
    assert json.loads(file.read_text()) == {"a": 1}
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("kind", [OSError, RuntimeError])  # h5py raises either, by how far it came
def test_a_full_disk_under_hdf5_is_a_sentence(tmp_path, kind):
    with (
        pytest.raises(UserError, match="No space left on device"),
        hdf5_file(tmp_path / "loads.h5"),
    ):
        message = "file write failed: errno = 28, error message = 'No space left on device'"
        raise RuntimeError(message) if kind is RuntimeError else OSError(errno.ENOSPC, message)
    assert list(tmp_path.iterdir()) == []


def test_a_bug_while_writing_is_not_hidden(tmp_path):
    with pytest.raises(RuntimeError, match="a bug"), hdf5_file(tmp_path / "loads.h5"):
        raise RuntimeError("a bug")
    assert list(tmp_path.iterdir()) == []


def test_a_kill_in_the_middle_leaves_what_was_there(tmp_path):
    file = tmp_path / "figures.json"
    write_json(file, {"a": 1})
    script = f"""
import os, signal
from pathlib import Path
from wearfem.record import whole_file
with whole_file(Path({str(file)!r})) as temporary:
    temporary.write_text('{{"a": ')
    os.kill(os.getpid(), signal.SIGKILL)
"""
    killed = subprocess.run([sys.executable, "-c", script], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert json.loads(file.read_text()) == {"a": 1}


def test_a_file_appears_only_when_it_is_whole(tmp_path):
    with whole_file(tmp_path / "x") as temporary:
        temporary.write_text("half")
        assert not (tmp_path / "x").exists()
    assert (tmp_path / "x").read_text() == "half"


def test_a_json_file_that_cannot_be_written_is_known_before_the_work(tmp_path):
    with pytest.raises(UserError, match="is a folder"):
        require_writable(tmp_path)
    with pytest.raises(UserError, match="must be a folder that exists"):
        require_writable(tmp_path / "nowhere" / "f.json")
    require_writable(tmp_path / "f.json")


def make_case(tmp_path: Path) -> Case:
    (tmp_path / "case.py").write_text("# a case\n")
    mesh = tmp_path / "plate.msh"
    mesh.write_bytes(b"mesh")
    return Case(
        "disc",
        None,
        (Stage("slide", None, Window(1.0)),),
        None,
        lambda outcome: (),
        files=(mesh,),
        settings={"seed": 7, "radius": np.float64(0.002), "sizes": (0.003, 0.008)},
        folder=tmp_path,
    )


def test_the_manifest_says_what_to_run_again(tmp_path):
    folder = RunFolder.create(tmp_path / "run")
    started = now()
    folder.write_manifest(make_case(tmp_path), started)
    content = json.loads((folder.path / "manifest.json").read_text())
    assert content["finished"] is None
    assert content["seed"] == 7
    assert content["settings"] == {"seed": 7, "radius": 0.002, "sizes": [0.003, 0.008]}
    # printf mesh | sha256sum
    assert content["sha256"][str(tmp_path / "plate.msh")] == (
        "d30ca7a7a32bf5772dc5eb2a2e7bd35737eff795ad74f2479b359716b59abdfa"
    )
    assert len(content["sha256"][str(tmp_path / "case.py")]) == 64
    assert {"wearfem", "python", "numpy", "numba"} <= content["versions"].keys()
    folder.write_manifest(make_case(tmp_path), started, now())
    assert json.loads((folder.path / "manifest.json").read_text())["finished"] is not None


def test_a_mesh_that_is_gone_is_told(tmp_path):
    case = make_case(tmp_path)
    (tmp_path / "plate.msh").unlink()
    with pytest.raises(UserError, match=r"cannot read .*plate.msh"):
        manifest(case, now())


def test_figures_are_written_with_their_verdict(tmp_path):
    folder = RunFolder.create(tmp_path / "run")
    folder.write_figures(
        [Figure("volume", 5.0, "m3", 5.1, "theory", 0.2), Figure("nothing", float("nan"), "-")]
    )
    first, second = json.loads((folder.path / "figures.json").read_text())
    assert (first["verdict"], first["value"], first["unit"]) == ("agrees", 5.0, "m3")
    assert (second["verdict"], second["value"]) == ("reported", None)


class Plain(NamedTuple):
    force: np.ndarray
    time_step: float


@dataclass(frozen=True)
class Loads:
    normal_impulse: np.ndarray = field(metadata={"unit": "N.s", "shape": "(block, facet)"})
    plain: Plain
    histogram: np.ndarray | None = None


def test_loads_keep_their_units_and_shapes(tmp_path):
    impulse = np.arange(6.0).reshape(2, 3)
    with hdf5_file(tmp_path / "loads.h5") as file:
        write_loads(file.create_group("slide"), Loads(impulse, Plain(np.ones(3), 1e-6)))
    with h5py.File(tmp_path / "loads.h5") as file:
        group = file["slide"]
        np.testing.assert_array_equal(group["normal_impulse"][()], impulse)
        assert dict(group["normal_impulse"].attrs) == {"unit": "N.s", "shape": "(block, facet)"}
        assert group["plain"].attrs["time_step"] == 1e-6
        assert "histogram" not in group


def test_a_surface_opens_in_vtk(tmp_path):
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF", exc_type=ImportError)
    from vtkmodules.util.numpy_support import vtk_to_numpy

    point = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
    triangle = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    depth, shear = np.array([1e-3, 2e-3]), np.arange(6.0).reshape(2, 3)
    file = tmp_path / "surface.vtkhdf"
    write_surface(file, point, triangle, {"depth rate [m/s]": depth, "shear [Pa]": shear})
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(file))
    reader.Update()
    surface = reader.GetOutput()
    assert (surface.GetNumberOfPoints(), surface.GetNumberOfPolys(), surface.GetNumberOfCells()) == (4, 2, 2)
    np.testing.assert_array_equal(vtk_to_numpy(surface.GetPoints().GetData()), point)
    cells = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    np.testing.assert_array_equal(cells, triangle)
    data = surface.GetCellData()
    np.testing.assert_array_equal(vtk_to_numpy(data.GetArray("depth rate [m per s]")), depth)
    np.testing.assert_array_equal(vtk_to_numpy(data.GetArray("shear [Pa]")), shear)


def test_a_surface_with_too_few_values_is_refused(tmp_path):
    with pytest.raises(ValueError, match="depth has 1 values for 2 triangles"):
        write_surface(tmp_path / "s.vtkhdf", np.zeros((4, 3)), np.zeros((2, 3), int), {"depth": np.zeros(1)})
    assert list(tmp_path.iterdir()) == []
