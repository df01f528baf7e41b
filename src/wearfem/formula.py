"""A flow by formula: loads of bulk material that slides over the worn face, with the noise and the delay of a sampled flow.

What a cycle does with the loads of particles it does with these: closed forms, kill tests and hundreds of synthetic lives are cheap.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wearfem.case import Window
from wearfem.errors import UserError
from wearfem.loads import FacetLoads
from wearfem.surface import Surface


@dataclass(frozen=True)
class FormulaFlow:
    """Where such a flow stands. `default` is an empty chute."""

    block: int = 0  # blocks so far: with the seed, all that the noise depends on
    shown: np.ndarray = field(
        default_factory=lambda: np.zeros(0)
    )  # (f,) [-] intensity shown; lags behind the geometry
    common: float = 0.0  # [-] unit noise of the last block, the same on all facets
    own: np.ndarray = field(
        default_factory=lambda: np.zeros(0)
    )  # (f,) [-] unit noise of the last block, of each facet


def everywhere(surface: Surface) -> np.ndarray:
    """(f,) [-] the same intensity on each facet"""
    return np.ones(surface.facet_count)


@dataclass(frozen=True)
class Sliding:
    """Material of one pressure that slides at one speed, more or less intense by place.

    Each block has the normal impulse p A T q (1 + s w + s_f w_f), with the intensity q as the flow shows it and unit noise, w common
    to all facets and w_f of each, that remembers the block before; load distance and friction work follow from speed and friction. No
    load is negative.
    """

    pressure: float  # [Pa]
    speed: float  # [m/s]
    friction: float = 0.5  # [-]
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)  # of sliding, a unit vector
    intensity: Callable[[Surface], np.ndarray] = everywhere  # (f,) [-] of the worn face as it is
    noise: float = 0.0  # [-] s, standard deviation of a block, common to all facets
    facet_noise: float = 0.0  # [-] s_f, standard deviation of a block, of each facet by itself
    memory: float = 0.0  # [-] correlation of one block with the next
    delay: float = 0.0  # [s] in which the flow forgets most (1 - 1/e) of the old geometry
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("pressure", "speed", "friction", "noise", "facet_noise", "delay"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise UserError(f"a sliding flow has {name} = {getattr(self, name)!r}; it must be 0 or more.")
        if not 0.0 <= self.memory < 1.0:
            raise UserError(f"a sliding flow has memory = {self.memory!r}; it must be 0 or more and below 1.")

    def sample(
        self, flow: FormulaFlow, surface: Surface, window: Window, tell: Any = None
    ) -> tuple[FormulaFlow, FacetLoads]:
        """The flow after the window, and its loads by block."""
        length, facets = window.duration / window.block_count, surface.facet_count
        meant = self.intensity(surface)
        new = len(flow.shown) != facets  # at the beginning, and after the liner was meshed again
        shown = np.zeros(facets) if new else flow.shown
        common, own = (*self._noise(-1, facets),) if new else (flow.common, flow.own)
        kept = np.exp(-length / self.delay) if self.delay else 0.0
        rows = np.empty((window.block_count, facets))
        for number, row in enumerate(rows):
            shown = meant + (shown - meant) * kept
            fresh = self._noise(flow.block + number, facets)
            part = np.sqrt(1.0 - self.memory**2)
            common, own = self.memory * common + part * fresh[0], self.memory * own + part * fresh[1]
            row[:] = np.maximum(shown * (1.0 + self.noise * common + self.facet_noise * own), 0.0)
        if tell is not None:
            tell(window.duration, "by formula")
        return FormulaFlow(flow.block + window.block_count, shown, common, own), self.loads(
            rows, surface, length
        )

    def _noise(self, block: int, facets: int) -> tuple[float, np.ndarray]:
        """Fresh unit noise of a block: one number for all, and one for each facet."""
        if not (self.noise or self.facet_noise):
            return 0.0, np.zeros(facets)
        random = np.random.default_rng([self.seed, block + 1])
        return float(random.normal()), random.normal(size=facets)

    def loads(self, rows: np.ndarray, surface: Surface, length: float) -> FacetLoads:
        """Of intensities (b, f) [-] in blocks of one length [s]."""
        area = surface.facet_area
        normal = self.pressure * area * length * rows
        distance = normal * self.speed
        nothing = np.zeros_like(normal)
        return FacetLoads(
            duration=np.full(len(rows), length),
            area=area,
            normal_impulse=normal,
            tangential_impulse=self.friction * normal[..., None] * np.asarray(self.direction),
            friction_work=self.friction * distance,
            load_distance=distance,
            slip_distance=np.where(rows > 0.0, self.speed * length, 0.0),
            contact_time=np.where(rows > 0.0, length, 0.0),
            contact_count=nothing,
            custom=nothing,
            force_time=np.zeros((*rows.shape, 0)),
            force_slip=np.zeros((*rows.shape, 0)),
            impact_energy=np.zeros((*rows.shape, 0, 0)),
            force_edge=np.zeros(1),
            angle_edge=np.zeros(1),
            speed_edge=np.zeros(1),
        )
