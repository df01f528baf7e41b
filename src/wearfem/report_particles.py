"""Pictures of particles seen from the side."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Moment:
    """What one panel of a picture shows, in the plane of the first and third axis."""

    title: str
    position: np.ndarray  # (n, 3) [m]
    radius: np.ndarray  # (n,) [m]
    speed: np.ndarray  # (n,) [m/s]
    walls: Sequence[tuple[tuple[float, float], tuple[float, float]]] = ()  # [m] segments
    lines: Sequence[tuple[tuple[float, float], tuple[float, float]]] = ()  # [m] fitted


def draw_moments(file: Path, moments: Sequence[Moment]) -> None:
    """One panel for each moment, at one scale: particles by speed, walls grey, fitted lines red."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot
    from matplotlib.collections import EllipseCollection, LineCollection

    figure, panels = pyplot.subplots(
        1, len(moments), figsize=(5.2 * len(moments), 4.8), sharex=True, sharey=True, layout="constrained"
    )
    for panel, moment in zip(np.atleast_1d(panels), moments, strict=True):
        order = np.argsort(-moment.position[:, 1])  # the nearest are drawn last
        diameter = 2000.0 * moment.radius[order]
        circles = EllipseCollection(
            diameter,
            diameter,
            np.zeros(len(order)),
            units="xy",
            offsets=1000.0 * moment.position[order][:, [0, 2]],
            offset_transform=panel.transData,
            array=moment.speed[order],
            cmap="viridis",
            clim=(0.0, 1.0),
            edgecolors="black",
            linewidths=0.15,
        )
        panel.add_collection(circles)
        panel.add_collection(
            LineCollection(list(1000.0 * np.array(moment.walls)), colors="dimgray", linewidths=2)
        )
        panel.add_collection(
            LineCollection(list(1000.0 * np.array(moment.lines)), colors="red", linewidths=2.5)
        )
        panel.set(title=moment.title, xlabel="x [mm]", aspect="equal")
        panel.autoscale_view()
    np.atleast_1d(panels)[0].set_ylabel("z [mm]")
    figure.colorbar(circles, ax=panels, label="speed [m/s], 1 and above alike", shrink=0.8)
    figure.savefig(file, dpi=130)
    pyplot.close(figure)
