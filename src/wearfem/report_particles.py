"""Pictures of particles seen from the side, with what they move over."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.dem.particles import Particles
from wearfem.surface import Surface


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


def draw_side(
    axes: Any,
    particles: Particles,
    surface: Surface,
    row: np.ndarray,
    thickness: np.ndarray,
    *,
    whole: float,
    drawn: float = 1.0,
) -> None:
    """Particles by their speed over a row of facets by their thickness, seen along y.

    Parameters
    ----------
    axes
        Of matplotlib.
    row
        (k,) facets, in order along the flow.
    thickness
        (k,) [m] of the liner under each.
    whole
        [m] thickness when new, where the colours end.
    drawn
        [-] how much thicker the liner is drawn than it is.
    """
    from matplotlib.collections import EllipseCollection, PolyCollection

    circles = EllipseCollection(
        2e3 * particles.radius, 2e3 * particles.radius, np.zeros(particles.count), units="xy", offsets=1e3 * particles.position[:, [0, 2]],
        offset_transform=axes.transData, array=np.linalg.norm(particles.velocity, axis=1), cmap="viridis", edgecolors="black",
        linewidths=0.1,
    )  # fmt: skip
    plates = []
    for facet, left in zip(row, 1e3 * thickness, strict=True):
        chosen = surface.facet == facet
        corner = 1e3 * surface.corner[chosen].reshape(-1, 3)[:, [0, 2]]
        ends = corner[[corner[:, 0].argmin(), corner[:, 0].argmax()]]
        back = ends - drawn * left * surface.normal[chosen][0, [0, 2]]
        plates.append(np.concatenate([ends, back[::-1]]))
    liner = PolyCollection(
        plates,
        array=1e3 * thickness,
        cmap="inferno",
        edgecolors="face",
        linewidths=0.3,
        clim=(np.floor(1e3 * thickness.min()), 1e3 * whole),
    )
    axes.add_collection(liner)
    axes.add_collection(circles)
    axes.autoscale_view()
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="z [mm]")
    axes.figure.colorbar(circles, ax=axes, label="speed of the particles [m/s]", shrink=0.7)
    times = f", drawn {drawn:g} times" if drawn != 1.0 else ""
    axes.figure.colorbar(liner, ax=axes, label=f"thickness left [mm]{times}", shrink=0.7, location="left")
