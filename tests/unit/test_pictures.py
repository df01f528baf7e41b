"""Pictures come whatever pyvista does; both ways put the same colours at the same places; files for ParaView read back."""

import sys
from dataclasses import replace

import numpy as np
import pytest
import pyvista

from wearfem import render
from wearfem.errors import UserError
from wearfem.liner.block import Hexahedra, Tetrahedra, block, mapped, sheet
from wearfem.liner.breakthrough import thickness
from wearfem.liner.liner import Liner, worn_face
from wearfem.liner.recede import recede
from wearfem.liner.solve import Load, Structure, solve_elastic
from wearfem.liner.support import Fixed
from wearfem.pictures import draw_liner, view_direction
from wearfem.proofs.recession import STEEL
from wearfem.record_mesh import write_body, write_liner
from wearfem.render import View, paint, round_below, shade

MESHES = {
    "tetrahedra": block((0, 0, 0), (0.3, 0.2, 0.04), (6, 4, 2), Tetrahedra),
    "hexahedra": block((0, 0, 0), (0.3, 0.2, 0.04), (6, 4, 2), Hexahedra),
    "shell": sheet((0, 0), (0.3, 0.2), (6, 4), 0.04),
}
EACH = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
ALL = ["thickness", "depth", "rate", "stress", "deflection", "quality"]


def worn(mesh):
    """A liner with a pocket, its rate of wear, and its strength."""
    centre = mesh.node[mesh.wear].mean(axis=1)
    rate = 1e-9 * np.exp(-(((centre[:, 0] - 0.1) / 0.05) ** 2))
    liner = recede(Liner(mesh, STEEL), 3e6 * rate, service_time=3e6)
    load = Load({"wear": np.tile([0.0, 0.0, -100.0], (len(mesh.wear), 1))})
    return liner, rate, solve_elastic(liner, Structure([Fixed("x_low")], yield_stress=3e8), load)


def child(monkeypatch, program):
    monkeypatch.setattr(render, "CHILD", (sys.executable, "-c", program))


@EACH
def test_matplotlib_alone_draws_all(mesh, tmp_path):
    liner, rate, strength = worn(mesh)
    drawn = draw_liner(tmp_path / "new" / "folder", liner, rate=rate, strength=strength, time_limit=0.0)
    assert [file.stem for file in drawn.files] == ALL and drawn.message == ""
    for file in drawn.files:
        assert file.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    fewer = draw_liner(tmp_path, Liner(mesh, STEEL), names=["quality", "depth"], time_limit=0.0)
    assert [file.name for file in fewer.files] == [
        "depth.png",
        "quality.png",
    ]  # nothing worn, and still drawn
    moved = draw_liner(tmp_path, liner, displacement=0.0 * mesh.node, names=["deflection"], time_limit=0.0)
    assert len(moved.files) == 1  # nothing moved, and still drawn


@pytest.mark.parametrize(
    ("program", "sentence"),
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "pyvista died of signal 11.*libgl1 libegl1 libosmesa6"),
        ("import time; time.sleep(60)", "pyvista took longer than 0.5 s"),
        ("raise ImportError('libXrender.so.1: cannot open shared object file')", "failed .*apt-get install libxrender1"),
        ("raise ModuleNotFoundError(\"No module named 'pyvista'\")", "pip install pyvista"),
        ("pass", "pyvista drew empty pictures"),
    ],
    ids=["crash", "late", "library", "package", "nothing"],
)  # fmt: skip
def test_pictures_come_when_pyvista_fails(program, sentence, tmp_path, monkeypatch):
    child(monkeypatch, program)
    late = 0.5 if "sleep" in program else 60.0
    drawn = draw_liner(tmp_path, Liner(MESHES["shell"], STEEL), names=["thickness"], time_limit=late)
    assert drawn.files[0].stat().st_size > 10_000
    with pytest.raises(AssertionError, match=sentence):
        raise AssertionError(drawn.message)


def test_no_python_to_start(tmp_path, monkeypatch):
    monkeypatch.setattr(render, "CHILD", (str(tmp_path / "python"),))
    assert "could not be started (No such file" in shade([], [], [], 1.0).trouble


def two_halves():
    mesh = MESHES["hexahedra"]
    value = (mesh.node[mesh.boundary].mean(axis=1)[:, 0] > 0.15).astype(float)
    return View(mesh.node, mesh.boundary, value, np.array([0.0, 0.0, 1.0]))


def painted(view, image):
    """The pixels (h, w, 3) of a view as matplotlib draws it, in its frame."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.0, 2.0), dpi=100)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    paint(axes, view, image, (0.0, 1.0), "viridis")
    canvas.draw()
    at = (
        axes.transData.transform(np.array([[0.075, 0.11], [0.22, 0.11]])).round().astype(int)
    )  # of both halves, between edges
    pixels = np.asarray(canvas.buffer_rgba())[::-1, :, :3]
    return pixels[at[:, 1], at[:, 0]] / 255.0


def test_both_ways_put_the_colours_of_the_bar_where_they_belong():
    from matplotlib import colormaps

    view = two_halves()
    expected = colormaps["viridis"](np.array([0.0, 1.0]))[:, :3]
    assert painted(view, None) == pytest.approx(
        expected, abs=0.1
    )  # an edge of 12 % black may cross the pixel
    shaded = shade([view], [(0.0, 1.0)], ["viridis"], 120.0)
    if shaded.trouble:
        assert (
            "apt-get install" in shaded.trouble
        )  # a machine without graphics libraries: the sentence, and nothing to compare
        return
    assert painted(view, shaded.image[0]) == pytest.approx(expected, abs=0.1)  # the same; light adds 1 %


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (1, -2, 0.5)])
def test_the_frame_is_right_handed_and_holds_the_body(direction):
    view = replace(two_halves(), direction=np.array(direction, float))
    assert view.axes @ view.axes.T == pytest.approx(np.eye(3), abs=1e-15)  # rounding
    assert np.linalg.det(view.axes) == pytest.approx(1.0, rel=1e-15)
    assert view.axes[2] @ np.array(direction) == pytest.approx(np.linalg.norm(direction), rel=1e-15)
    middle, half = view.frame
    assert (np.abs(view.node @ view.axes[:2].T - middle) < half).all()
    assert view.axes[1, 2] >= 0.0  # z is never down


@EACH
def test_the_eye_looks_at_the_worn_face(mesh):
    assert view_direction(mesh) == pytest.approx([0, 0, 1], abs=1e-12)
    if mesh is MESHES["shell"]:
        assert view_direction(mesh.turned) == pytest.approx([0, 0, -1], abs=1e-12)
        roll = mapped(mesh, lambda x: np.column_stack([np.cos(20 * x[:, 0]), x[:, 1], np.sin(20 * x[:, 0])]))
        assert np.linalg.norm(view_direction(roll)) == pytest.approx(1.0)  # goes nearly all round


def test_round_numbers():
    assert [round_below(x) for x in (1.0, 1.99, 2.0, 4.9, 7.0, 0.03, 1e6)] == pytest.approx(
        [1, 1, 2, 2, 5, 0.02, 1e6], rel=1e-12
    )


@EACH
def test_bad_fields_are_one_sentence(mesh, tmp_path):
    liner, count, nodes = Liner(mesh, STEEL), len(mesh.wear), len(mesh.node)
    holed = np.zeros(count)
    holed[3] = np.nan
    cases = {
        f"a depth of shape \\({count - 1},\\) was given, but the group 'wear' has {count} facets": {"depth": np.zeros(count - 1)},
        "the depth of facet 3 is nan": {"depth": holed},
        "the rate of facet 3 is nan": {"rate": holed},
        f"was given for {nodes} nodes": {"displacement": np.zeros((nodes + 1, 3))},
        "at node 0 is .*nan": {"displacement": np.full((nodes, 3), np.nan)},
        "there is no picture stress: what was given makes thickness, depth and quality": {"names": ["stress"]},
    }  # fmt: skip
    for sentence, given in cases.items():
        with pytest.raises(UserError, match=sentence):
            draw_liner(tmp_path, liner, time_limit=0.0, **given)
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot make the folder"):
        draw_liner(tmp_path / "file", liner, time_limit=0.0)
    with pytest.raises(
        UserError, match=f"'rate .m/s.' has 1 values, but the mesh has {count} facets that wear"
    ):
        write_liner(tmp_path, liner, rate=np.zeros(1))
    with pytest.raises(UserError, match=f"'u' has 1 values, but the mesh has {nodes} nodes"):
        write_body(tmp_path / "a.vtkhdf", mesh, point_data={"u": np.zeros(1)})
    with pytest.raises(UserError, match="bodies are written to .vtkhdf or .vtu"):
        write_body(tmp_path / "a.vtk", mesh)


@EACH
@pytest.mark.parametrize("ending", [".vtkhdf", ".vtu"])
def test_paraview_reads_back_what_is_known(mesh, ending, tmp_path):
    liner, rate, strength = worn(mesh)
    body, face = (
        pyvista.read(path)
        for path in write_liner(tmp_path, liner, rate=rate, strength=strength, ending=ending)
    )
    assert type(body).__name__ == "UnstructuredGrid"
    assert (body.points == liner.mesh.node).all() and body.n_cells == len(mesh.element)
    assert (body.point_data["displacement [m]"] == strength.displacement).all()
    assert (body.point_data["von Mises stress [Pa]"] == strength.von_mises).all()
    assert (body.point_data["stress [Pa]"][:, 3] == strength.stress[:, 0, 1]).all()  # xx, yy, zz, xy, yz, xz
    assert (body.point_data["stress [Pa]"][:, 5] == strength.stress[:, 0, 2]).all()
    assert body.cell_data["quality [-]"].max() <= 1.0
    per = "/" if ending == ".vtu" else " per "
    facet = face.cell_data["facet"].astype(int)
    assert (face.cell_data[f"rate [m{per}s]"] == rate[facet]).all()
    assert (face.cell_data["depth [m]"] == liner.depth[facet]).all()
    assert (face.cell_data["thickness [m]"] == thickness(liner.mesh)[facet]).all()
    if mesh is MESHES["shell"]:
        assert (body.point_data["thickness [m]"] == liner.mesh.thickness).all()
        assert face.points == pytest.approx(worn_face(liner.mesh), abs=1e-15)
        return
    quads = mesh.element.shape[1] == 8
    volume = abs(body.compute_cell_sizes()["Volume"]).sum()
    assert volume == pytest.approx(
        liner.mesh.volume, rel=1e-4 if quads else 1e-12
    )  # VTK cuts warped hexahedra by other diagonals
