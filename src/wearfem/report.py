"""Pictures of what a run has shown. Cases call these from their `draw`; nothing is drawn on a screen."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.record import whole_file
from wearfem.surface import Surface


@contextmanager
def picture(
    path: Path, columns: int = 1, rows: int = 1, *, size: tuple[float, float] = (6.0, 4.5)
) -> Iterator[Any]:
    """Axes to draw on, row by row in one array; they become the PNG `path`. `size` is that of each [inch]."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(columns * size[0], rows * size[1]), layout="constrained")
    FigureCanvasAgg(figure)
    yield figure.subplots(rows, columns, squeeze=False).ravel()
    with whole_file(path) as temporary:
        figure.savefig(temporary, format="png", dpi=150)


def draw_surface(axes: Any, surface: Surface, value: np.ndarray, label: str) -> None:
    """A surface from above, coloured by a value (f,) of its facets, with a colour bar.

    Facets that face away are left out, facets of value 0 are grey. Axes are in mm.
    """
    from matplotlib.colors import ListedColormap

    seen = surface.normal[:, 2] > 1e-6
    corner, of_triangle = surface.corner[seen][:, :, :2] * 1e3, value[surface.facet[seen]]
    x, y = corner.reshape(-1, 2).T
    triangle = np.arange(len(x)).reshape(-1, 3)
    edge = {"edgecolors": "white", "linewidth": 0.15}
    axes.tripcolor(x, y, triangle, facecolors=np.zeros(len(triangle)), cmap=ListedColormap(["0.85"]), **edge)
    touched = of_triangle != 0.0
    if touched.any():
        drawn = axes.tripcolor(
            x, y, triangle[touched], facecolors=of_triangle[touched], cmap="inferno_r", vmin=0.0
        )
        axes.figure.colorbar(drawn, ax=axes, label=label, shrink=0.85)
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")


def draw_lines(
    axes: Any, x: np.ndarray, lines: dict[str, np.ndarray], x_label: str, y_label: str, style: str = "-"
) -> None:
    """Lines over x, each with a name; one name needs no legend. `style` is matplotlib's, such as `o-`."""
    for name, y in lines.items():
        axes.plot(x, y, style, label=name, linewidth=1.0)
    axes.set(xlabel=x_label, ylabel=y_label)
    axes.grid(alpha=0.3)
    if len(lines) > 1:
        axes.legend(frameon=False)
