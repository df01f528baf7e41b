"""Virtual plants whose shape wears with them: the truth is a coupled run with a hidden effect, another seed and another mesh.

What the diagnosis is given is a survey (CSV): points, occasions, tonnage, readings with the gauge's noise. Nothing of `wearfem.survey` is
used here; depths are read off the run by splines of this file's own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline, LinearNDInterpolator

from wearfem.case import LifeCase, Stop, load_any_case
from wearfem.cycle import cycle, first_state
from wearfem.history import History, history_of
from wearfem.liner.liner import wear_surface
from wearfem.surface import Surface
from wearfem.units import kt, mm
from wearfem.wear.laws import Scaled


@dataclass(frozen=True)
class CoupledPlant:
    """What a survey of the plant looks like, and what nobody is told."""

    point: np.ndarray  # (p, 3) m
    tonnage: np.ndarray  # (o,) kt
    clean: np.ndarray  # (p, o) mm worn
    reading: np.ndarray  # (p, o) mm as read
    sigma: float  # mm
    truth: History

    def write(self, folder: Path) -> Path:
        """The survey as CSV."""
        folder.mkdir(parents=True, exist_ok=True)
        rows = ["point,occasion,tonnage_kt,depth_mm,sigma_mm,x_m,y_m,z_m"]
        for j, tonnage in enumerate(self.tonnage):
            for i, place in enumerate(self.point):
                told = [tonnage, self.reading[i, j], self.sigma, *place]
                rows.append(f"P{i:03d},{j + 1}," + ",".join(f"{value:.6g}" for value in told))
        (folder / "survey.csv").write_text("\n".join(rows) + "\n")
        return folder / "survey.csv"


def lived(case: LifeCase) -> History:
    """The whole life of a case, in memory."""
    state, reports = first_state(case), []
    while not state.ended:
        state, report = cycle(case, state)
        reports.append(report)
    return history_of(state, reports)


def coupled_plant(
    folder: Path,
    settings: Mapping[str, Any],
    seed: int,
    *,
    effects: Sequence[Any] = (),
    factor: float = 1.0,
    served: float,
    within: tuple[tuple[float, float], tuple[float, float]] | None = None,
    points: int = 40,
    occasions: int = 8,
    sigma: float = 0.1,
    jumps: int = 20,
) -> CoupledPlant:
    """Run a case with something in it that nobody is told, and read its wear at places scattered over the face.

    Parameters
    ----------
    folder, settings
        The case and its keywords.
    seed
        Of the run, the places and the gauge.
    effects, factor
        What is hidden.
    served
        Service time [s] at the last occasion.
    within
        Ranges of x and y [m] of the places on a level face; without it, middles of facets, drawn in proportion to their wear: people
        read where it wears.
    jumps
        At least, up to then.
    """
    case = load_any_case(folder, {**settings, "seed": 1000 + seed})
    assert isinstance(case, LifeCase)
    case = replace(
        case,
        wear_law=Scaled(case.wear_law, factor),
        effects=tuple(effects),
        stop=Stop(service_time=served),
        longest_jump=1.0001 * served / jumps,
    )
    truth = lived(case)
    middle = middles(wear_surface(case.liner))
    random = np.random.default_rng([seed, 7])
    when = np.sort(served * (np.arange(1, occasions + 1) + random.uniform(-0.2, 0.0, occasions)) / occasions)
    when[-1] = served
    at = CubicHermiteSpline(truth.service_time, truth.depth, truth.rate)(when) / mm  # (o, f)
    if within is None:
        chosen = random.choice(len(middle), points, replace=False, p=at[-1] / at[-1].sum())
        place, clean = middle[chosen], at[:, chosen].T
    else:
        flat = np.stack([random.uniform(*axis, size=points) for axis in within], axis=1)
        place = np.column_stack([flat, LinearNDInterpolator(middle[:, :2], middle[:, 2])(flat)])
        clean = np.stack([LinearNDInterpolator(middle[:, :2], depth)(flat) for depth in at], axis=1)
    reading = np.round(clean + random.normal(0.0, sigma, clean.shape), 2)
    tonnage = when * case.throughput_rate / kt
    return CoupledPlant(place, tonnage, clean, reading, sigma, truth)


def middles(surface: Surface) -> np.ndarray:
    """(f, 3) [m] of the facets"""
    weighed = surface.area[:, None] * surface.corner.mean(axis=1)
    total = np.stack([np.bincount(surface.facet, part, surface.facet_count) for part in weighed.T], axis=1)
    return total / surface.facet_area[:, None]
