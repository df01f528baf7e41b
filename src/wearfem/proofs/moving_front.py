"""Moving front: a profile in a parallel stream follows its characteristics, and beyond their crossing the entropy solution."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wearfem.liner.block import Cut, Hexahedra, block, mapped
from wearfem.liner.corners import SHARP, facet_vector
from wearfem.liner.liner import Liner
from wearfem.liner.recede import recede
from wearfem.material import Material
from wearfem.proof import Claim

STEEL = Material("steel", density=7850.0, shear_modulus=80e9, poisson_ratio=0.3)
HEIGHT = 0.09  # [m] of the wave
SMOOTH, BEYOND = (
    0.1,
    0.6,
)  # [s] before the first crossing of characteristics, at 1 / (F'' z'') = 0.127 s, and well beyond


def erosion(slope: np.ndarray) -> np.ndarray:
    """F(p) = p^2 / (1 + p^2) [m/s]: a ductile solid under particles that fall along -z, which wears as the sine of the
    impact angle squared"""
    return slope**2 / (1.0 + slope**2)


def speed(slope: np.ndarray) -> np.ndarray:
    """dF / dp = 2 p / (1 + p^2)^2 [m/s] at which a slope travels; F is convex for |p| < 0.577, the wave has up to 0.565"""
    return 2.0 * slope / (1.0 + slope**2) ** 2


def wave(x: np.ndarray, sign: float) -> np.ndarray:
    """z [m] at time 0: a hill (sign 1) or a valley (-1) between flat ends of no slope"""
    return sign * HEIGHT * np.cos(np.pi * np.clip(2.0 * x - 1.0, -1.0, 1.0))


def wave_slope(x: np.ndarray, sign: float) -> np.ndarray:
    """dz/dx [-] at time 0"""
    phase = np.clip(2.0 * x - 1.0, -1.0, 1.0)
    return -sign * 2.0 * np.pi * HEIGHT * np.sin(np.pi * phase)


def entropy_solution(x: np.ndarray, time: float, sign: float) -> np.ndarray:
    """z(x, t) [m] of dz/dt = -F(dz/dx): of all characteristics through (x, t) the lowest, which for convex F is the entropy solution.

    On a characteristic, x = y + F'(p) t and z = z0(y) + (p F'(p) - F(p)) t with p = dz0/dx(y).

    Source
    ------
    Evans 2010, Partial Differential Equations, 2nd ed., section 3.3 (Hopf-Lax).
    """
    start = np.linspace(-0.5, 1.5, 40001)
    slope = wave_slope(start, sign)
    place = start + speed(slope) * time
    height = wave(start, sign) + (slope * speed(slope) - erosion(slope)) * time
    turns = np.flatnonzero(np.diff(np.sign(np.diff(place)))) + 1
    lowest = np.full(len(x), np.inf)
    for first, last in zip([0, *turns], [*turns, len(start) - 1], strict=True):
        branch = slice(first, last + 1)
        forward = 1 if place[last] > place[first] else -1
        along, up = place[branch][::forward], height[branch][::forward]
        lowest = np.minimum(lowest, np.interp(x, along, up, left=np.inf, right=np.inf))
    return lowest


@dataclass(frozen=True)
class Front:
    """A profile after a while, and how far it is from the entropy solution."""

    liner: Liner
    x: np.ndarray  # (k,) [m] of the worn nodes
    z: np.ndarray  # (k,) [m]
    mean_error: float  # [m]
    largest_error: float  # [m]


def erode(cells: int, time: float, sign: float, kind: Cut = Hexahedra, sharp: float = SHARP) -> Front:
    """Erode the wave with `cells` facets by F of each facet's own slope, to `time` [s], in steps of a quarter of a facet's length.

    A step is Heun's: the mean of the depths before and after a trial step. That is second order in time too.
    """
    flat = block((0.0, 0.0, 0.0), (1.0, 1.0 / cells, 1.0), (cells, 1, 2), kind, name="strip")
    body = mapped(flat, lambda x: np.column_stack([x[:, :2], x[:, 2] * (1.0 + wave(x[:, 0], sign))]))
    liner, steps = Liner(body, STEEL), max(1, round(4.0 * time * cells))
    for _ in range(steps):
        depth = _depth(liner, time / steps)
        trial = recede(liner, depth, sharp=sharp)
        liner = recede(liner, 0.5 * (depth + _depth(trial, time / steps)), sharp=sharp)
    x, _, z = liner.mesh.node[np.unique(liner.mesh.wear)].T
    error = np.abs(z - 1.0 - entropy_solution(x, time, sign))
    return Front(liner, x, z - 1.0, float(error.mean()), float(error.max()))


def _depth(liner: Liner, step: float) -> np.ndarray:
    """(f,) [m] along the normal of each facet, F of its slope x step along z"""
    x, _, z = facet_vector(liner.mesh.node, liner.mesh.wear).T
    slope = -x / z
    return erosion(slope) * step / np.sqrt(1.0 + slope**2)


def claims() -> Iterator[Claim]:
    """A hill, whose top becomes a shock, and a valley, which opens as a fan, before and beyond the first crossing."""
    for sign, shape in (
        (1.0, "hill (shock at the top)"),
        (-1.0, "valley (fan at the bottom, shocks at its shoulders)"),
    ):
        for time, when in ((SMOOTH, "before"), (BEYOND, "beyond")):
            coarse, fine = erode(12, time, sign), erode(24, time, sign)
            yield Claim(
                f"order of the mean error of a {shape}, {when} the first crossing", "characteristics; Hopf-Lax beyond", 2.0,
                float(np.log2(coarse.mean_error / fine.mean_error)), "-", 0.6, False,
                f"mean {fine.mean_error:.2g} m, largest {fine.largest_error:.2g} m of a wave of {2 * HEIGHT:g} m with 24 facets",
            )  # fmt: skip
