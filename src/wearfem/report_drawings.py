"""The pictures of a report, as data addresses that a page carries in itself: maps of thickness, and curves."""

import base64
import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wearfem.liner.mesh import LinerMesh
from wearfem.pictures import view_direction
from wearfem.render import View, paint

COLOURS = "viridis"  # of thickness, as in the pictures of the liner: what is thin is dark
INK, ACCENT = "#1f2a36", "#0b5c8a"


@dataclass(frozen=True)
class Curve:
    """A line over throughput or service time."""

    title: str
    x: np.ndarray  # (c,)
    y: np.ndarray  # (c,)
    x_label: str
    y_label: str
    error: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (c,) half the interval, in the unit of y


@contextmanager
def page_figure(
    found: list[str], width: float, height: float, columns: int = 1, *, image: str = "svg"
) -> Iterator[Any]:
    """Axes to draw on; the data address of the picture is added to `found`. Sizes in inch."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    style: Any = {
        "svg.hashsalt": "wearfem",
        "font.size": 9,
        "axes.edgecolor": "#8a949e",
        "axes.labelcolor": INK,
        "text.color": INK,
    }
    with rc_context(style):
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure.subplots(1, columns, squeeze=False)[0]
        drawn = io.BytesIO()
        nothing = {"Date": None, "Creator": None, "Format": None, "Type": None} if image == "svg" else None
        figure.savefig(drawn, format=image, dpi=160, metadata=nothing)
    kind = "image/svg+xml" if image == "svg" else "image/png"
    found.append(f"data:{kind};base64,{base64.b64encode(drawn.getvalue()).decode()}")


def draw_curve(curve: Curve) -> str:
    """A curve as the data address of an SVG; the error is a band."""
    found: list[str] = []
    with page_figure(found, 4.6, 2.7) as (axes,):
        if len(curve.error):
            axes.fill_between(
                curve.x,
                curve.y - curve.error,
                curve.y + curve.error,
                color=ACCENT,
                alpha=0.18,
                linewidth=0,
            )
        axes.plot(curve.x, curve.y, "o-", color=ACCENT, markersize=3.5, linewidth=1.4)
        axes.set(xlabel=curve.x_label, ylabel=curve.y_label)
        axes.set_title(curve.title, loc="left", fontsize=10, fontweight="bold")
        axes.grid(color="#d9dee3", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        if 0.0 <= curve.y.min() < 0.5 * curve.y.max():
            axes.set_ylim(bottom=0.0)
    return found[0]


def draw_maps(mesh: LinerMesh, maps: Sequence[tuple[str, np.ndarray]], limits: tuple[float, float]) -> str:
    """The thickness (f,) [m] of the worn face at several times beside one another, each with its title; PNG."""
    found: list[str] = []
    views = [
        View(mesh.node, mesh.wear, 1e3 * value, view_direction(mesh), closed=False, title=title)
        for title, value in maps
    ]
    half = views[0].frame[1]
    width = 3.6
    height = float(np.clip(width * half[1] / half[0], 1.0, 5.0)) + 1.2
    with page_figure(found, width * len(views) + 0.9, height, len(views), image="png") as axes:
        for place, view in zip(axes, views, strict=True):
            scale = paint(place, view, None, (1e3 * limits[0], 1e3 * limits[1]), COLOURS)
            place.title.set(fontsize=10, fontweight="bold", color=INK)
        axes[0].figure.colorbar(scale, ax=list(axes), label="thickness left [mm]", shrink=0.9, aspect=20)
    return found[0]


def colour_table() -> np.ndarray:
    """(256, 3) uint8 red, green, blue of `COLOURS` from the lowest value to the highest"""
    from matplotlib import colormaps

    return np.round(255.0 * colormaps[COLOURS](np.linspace(0.0, 1.0, 256))[:, :3]).astype(np.uint8)
