"""Bodies in colours, seen from a direction: shaded by pyvista in a process of its own, or painted by matplotlib where that fails.

Both ways share the projection (parallel, so lengths can be measured in the picture), the colours, the axes, the bar of length and all
words, which matplotlib sets. pyvista only adds hidden surfaces done well and light; without a graphics library it does
not raise but kills its process, so it gets one that may die.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.edges import neighbours
from wearfem.liner.mesh import triangles

CHILD = (sys.executable, "-m", "wearfem.render")  # the process that may die
SHARP = np.pi / 6  # [rad] edges that turn by more are drawn dark
PIXELS = 1100  # of the longer side of a view
GREY = "#c9ccd1"  # where there is no value
PACKAGES = {  # Debian's, of the shared libraries that VTK opens
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libOSMesa": "libosmesa6",
    "libXrender.so.1": "libxrender1",
    "libX11.so.6": "libx11-6",
    "libSM.so.6": "libsm6",
}


@dataclass(frozen=True)
class View:
    """A body seen from one direction, coloured by a value."""

    node: np.ndarray  # (n, 3) [m]
    facet: np.ndarray  # (k, 3) or (k, 4) corner nodes
    value: np.ndarray  # (k,) by facet, or (n,) by node if `by_node`; NaN is grey
    direction: np.ndarray  # (3,) from the body to the eye
    by_node: bool = False
    closed: bool = True  # whether facets that face away are hidden
    before: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 3)))  # (m, 2, 3) [m] dashed lines
    mark: np.ndarray | None = None  # (3,) [m] a place to ring
    title: str = ""

    @property
    def axes(self) -> np.ndarray:
        """(3, 3) rows: to the right, upwards, to the eye. z is up, where it is seen; else the longer of x and y goes right."""
        toward = self.direction / np.linalg.norm(self.direction)
        up = np.array([0.0, 0.0, 1.0])
        if abs(toward[2]) > 0.95:
            size = np.ptp(self.node[np.unique(self.facet)], axis=0)
            up = np.array([-1.0, 0.0, 0.0]) if size[1] > size[0] else np.array([0.0, 1.0, 0.0])
        right = np.cross(up, toward)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(toward, right), toward])

    @property
    def frame(self) -> tuple[np.ndarray, np.ndarray]:
        """Middle (2,) and half size (2,) [m] of what is seen, in the plane of the picture, with a margin of 5 %."""
        place = np.concatenate([self.node[np.unique(self.facet)], self.before.reshape(-1, 3)])
        flat = place @ self.axes[:2].T
        low, high = flat.min(axis=0), flat.max(axis=0)
        half = 0.5 * (high - low) + 0.025 * float((high - low).max())
        return 0.5 * (low + high), half

    @property
    def edges(self) -> np.ndarray:
        """(m, 2) nodes of borders and sharp edges"""
        corner, _ = triangles(self.facet)
        alone = neighbours(self.node, corner, SHARP) < 0
        return np.stack([corner, np.roll(corner, -1, axis=1)], axis=2).reshape(-1, 2)[alone]


@dataclass(frozen=True)
class Shaded:
    """What pyvista made of views: images (h, w, 3), or none and why."""

    image: Sequence[np.ndarray | None]
    trouble: str = ""


def shade(
    views: Sequence[View], limits: Sequence[tuple[float, float]], colours: Sequence[str], time_limit: float
) -> Shaded:
    """Views as images, by pyvista in a process of its own.

    Parameters
    ----------
    views, limits, colours
        What to draw; for each, the values at the ends of the colours, and matplotlib's name of those.
    time_limit
        [s] after which the process is ended. 0: do not even try.

    Returns
    -------
    Shaded
        No image and a sentence where the process died, took too long, or drew nothing: what went wrong and what to install.
    """
    none = [None] * len(views)
    if not time_limit > 0.0:
        return Shaded(none)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for k, view in enumerate(views):
            middle, half = view.frame
            np.savez(
                folder / f"{k}.npz", node=view.node, facet=view.facet, value=view.value, by_node=view.by_node, axes=view.axes,
                middle=middle, half=half, edges=view.edges,
            )  # fmt: skip
        (folder / "list.json").write_text(json.dumps([list(map(list, limits)), list(colours)]))
        source = str(Path(__file__).parents[1])
        path = os.pathsep.join(filter(None, [source, os.environ.get("PYTHONPATH", "")]))
        try:
            done = subprocess.run(
                [*CHILD, name], capture_output=True, text=True, timeout=time_limit, env=os.environ | {"PYTHONPATH": path}
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return Shaded(none, _sentence(f"took longer than {time_limit:g} s", ""))
        except OSError as error:
            return Shaded(none, _sentence(f"could not be started ({error.strerror})", ""))
        if done.returncode < 0:
            return Shaded(none, _sentence(f"died of signal {-done.returncode}", done.stderr))
        if done.returncode:
            last = done.stderr.strip().splitlines()[-1:] or [f"exit code {done.returncode}"]
            return Shaded(none, _sentence(f"failed ({last[0].strip()})", done.stderr))
        made = [folder / f"{k}.npy" for k in range(len(views))]
        image = [np.load(file) for file in made if file.exists()]
    if len(image) < len(views) or any(np.ptp(one) == 0 for one in image):
        return Shaded(none, _sentence("drew empty pictures", done.stderr))
    return Shaded(image)


def _sentence(what: str, heard: str) -> str:
    missing = re.findall(r"(lib[\w+-]+\.so[.\d]*)", heard)
    named = sorted(
        {package for library, package in PACKAGES.items() for one in missing if one.startswith(library)}
    )
    if "No module named" in heard:
        advice = "pip install pyvista"
    elif named:
        advice = f"sudo apt-get install {' '.join(named)}"
    else:
        advice = "sudo apt-get install libgl1 libegl1 libosmesa6, or run under xvfb-run"
    return f"pyvista {what}, so the pictures were painted by matplotlib, without light; for shaded ones: {advice}."


def _shade_here(folder: Path) -> None:
    """What the process does: an image `k.npy` of each view `k.npz` in the folder."""
    import pyvista

    limits, colours = json.loads((folder / "list.json").read_text())
    for k, (limit, colour) in enumerate(zip(limits, colours, strict=True)):
        view = np.load(folder / f"{k}.npz")
        facet, node, half = view["facet"], view["node"], view["half"]
        body = pyvista.PolyData(node, np.insert(facet, 0, facet.shape[1], axis=1).ravel())
        (body.point_data if view["by_node"] else body.cell_data)["value"] = view["value"]
        width, height = np.maximum(np.round(PIXELS * half / half.max()), 2).astype(int)
        plotter = pyvista.Plotter(off_screen=True, window_size=[int(width), int(height)], lighting="none")
        plotter.add_light(
            pyvista.Light(light_type="headlight")
        )  # what faces the eye has the colour of the bar
        plotter.set_background("white")  # type: ignore[arg-type]
        plotter.add_mesh(
            body, scalars="value", cmap=colour, clim=limit, nan_color=GREY, show_scalar_bar=False, ambient=0.7, diffuse=0.3,
            specular=0.0, interpolate_before_map=True, show_edges=len(facet) < 8000, edge_color="black", edge_opacity=0.12,
        )  # fmt: skip
        if len(view["edges"]):
            line = pyvista.PolyData(node, lines=np.insert(view["edges"], 0, 2, axis=1).ravel())
            plotter.add_mesh(line, color="#303030", line_width=2)
        right, up, toward = view["axes"]
        centre = node[np.unique(facet)].mean(axis=0)
        focus = view["middle"][0] * right + view["middle"][1] * up + (centre @ toward) * toward
        far = 10.0 * float(np.ptp(node, axis=0).max())
        camera = plotter.camera
        camera.position, camera.focal_point, camera.up = focus + far * toward, focus, up
        camera.parallel_projection, camera.parallel_scale = True, float(half[1])
        plotter.renderer.ResetCameraClippingRange()
        plotter.enable_anti_aliasing("ssaa")
        np.save(folder / f"{k}.npy", np.asarray(plotter.screenshot(return_img=True))[..., :3])
        plotter.close()


def paint(axes: Any, view: View, image: np.ndarray | None, limits: tuple[float, float], colours: str) -> Any:
    """Draw a view on matplotlib's `axes`, with its own axes and bar of length; returns what a colour bar is made of.

    Without an image, facets are painted from the far to the near, each in one colour: right wherever facets do not pierce one another.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.colors import Normalize

    scale = ScalarMappable(Normalize(*limits), colormaps[colours].with_extremes(bad=GREY))
    middle, half = view.frame
    low, high = middle - half, middle + half
    if image is not None:
        axes.imshow(image, extent=(low[0], high[0], low[1], high[1]), interpolation="antialiased")
    else:
        corner = view.node[view.facet] @ view.axes.T  # (k, c, 3) right, up, to the eye
        value = view.value[view.facet].mean(axis=1) if view.by_node else view.value
        first, last = corner[:, -2] - corner[:, 0], corner[:, -1] - corner[:, 1 - corner.shape[1] % 2]
        seen = first[:, 0] * last[:, 1] > first[:, 1] * last[:, 0]
        order = np.argsort(corner[:, :, 2].mean(axis=1), kind="stable")
        order = order[seen[order]] if view.closed else order
        face = scale.to_rgba(np.ma.masked_invalid(value[order]))
        edge = (0.0, 0.0, 0.0, 0.12) if len(order) < 8000 else face
        axes.add_collection(
            PolyCollection(list(corner[order][:, :, :2]), facecolors=face, edgecolors=edge, linewidths=0.3)
        )
        shown = np.isin(view.edges, view.facet[order]).all(axis=1)
        axes.add_collection(
            LineCollection((view.node @ view.axes[:2].T)[view.edges[shown]], colors="#303030", linewidths=0.6)
        )
    if len(view.before):
        axes.add_collection(
            LineCollection(
                view.before @ view.axes[:2].T, colors="#303030", linewidths=0.7, linestyles=(0, (4, 3))
            )
        )
    if view.mark is not None:
        axes.plot(
            *(view.axes[:2] @ view.mark),
            "o",
            markersize=14,
            markerfacecolor="none",
            markeredgecolor="white",
            markeredgewidth=3.5,
        )
        axes.plot(
            *(view.axes[:2] @ view.mark),
            "o",
            markersize=14,
            markerfacecolor="none",
            markeredgecolor="black",
            markeredgewidth=1.2,
        )
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", title=view.title)
    axes.set_axis_off()
    _bar_of_length(axes, float(2.0 * half[0]))
    _triad(axes, view.axes)
    return scale


def _bar_of_length(axes: Any, width: float) -> None:
    """A bar below the body, some fifth of its width, with its length."""
    bar = round_below(0.3 * width)
    label = f"{bar:g} m" if bar >= 1.0 else f"{1e3 * bar:g} mm"
    place = axes.inset_axes([1.0 - bar / width, -0.075, bar / width, 0.012], transform=axes.transAxes)
    place.set(xlim=(0, 1), ylim=(0, 1))
    place.set_axis_off()
    place.fill_between([0, 1], 0, 1, color="black")
    axes.annotate(
        label, (1.0 - 0.5 * bar / width, -0.08), xycoords="axes fraction", ha="center", va="top", fontsize=9
    )


def _triad(axes: Any, frame: np.ndarray) -> None:
    """Arrows along x, y and z below the body at the left; one that points at the reader is a ring."""
    start = np.array([26.0, -30.0])  # points from the lower left corner
    for k, (name, colour) in enumerate((("x", "#c0392b"), ("y", "#27803b"), ("z", "#2456a6"))):
        arrow = 22.0 * frame[:2, k]
        if np.hypot(*arrow) < 4.0:
            axes.annotate("", start, xytext=start, xycoords="axes points", textcoords="axes points")
            axes.annotate(
                "⊙" if frame[2, k] > 0 else "⊗",
                start,
                xycoords="axes points",
                color=colour,
                ha="center",
                va="center",
                fontsize=10,
            )
            axes.annotate(
                name,
                start + (-9.0, -9.0),
                xycoords="axes points",
                color=colour,
                ha="center",
                va="center",
                fontsize=9,
            )
            continue
        axes.annotate(
            "", start + arrow, xytext=start, xycoords="axes points", textcoords="axes points",
            arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.4, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
        place = start + arrow * (1.0 + 7.0 / np.hypot(*arrow))
        axes.annotate(name, place, xycoords="axes points", color=colour, ha="center", va="center", fontsize=9)


def round_below(value: float) -> float:
    """The largest of 1, 2 and 5 x 10^k that is not above a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-12)) * power)


if __name__ == "__main__":
    _shade_here(Path(sys.argv[1]))
