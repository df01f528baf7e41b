"""The course of a run of the model at each point of a survey: how fast it wears there, and in which state, along its service.

A run whose surface moves has a rate that changes with the shape. Let D(s) be the depth that it reaches at a point after the service s.
Wear k times as fast meets the same shapes k times as early, so a plate is at D(k s): the coefficient changes the pace at which the run's
own course is walked. That is exact where all points change their pace alike; where an effect hits some points only, each point walks its
own course, as if its neighbours were as far as it is.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

FAINT = 1e-9  # [-] of the largest rate: what does not wear needs no time to be told


@dataclass(frozen=True)
class Course:
    """What a run tells of each life.

    Parameters
    ----------
    progress
        (c,) service at which the run was sampled, rising, in the unit of the survey; 0 is a new plate.
    rate
        (l, c) depth by unit of progress; straight between samples, constant beyond them.
    state
        (l, c) by name: features of the state, such as pressure.
    steepness
        (l, 3) [1/m] gradient along the face of the logarithm of the depth at the end: by how much a reading errs that was taken
        beside the point.
    follows_shape
        Whether the run's surface moved while it wore.
    notes
        What a reader must know of it, in sentences.
    """

    progress: np.ndarray
    rate: np.ndarray
    state: Mapping[str, np.ndarray]
    steepness: np.ndarray
    follows_shape: bool
    notes: tuple[str, ...] = ()
    depth: np.ndarray = field(init=False)  # (l, c) at the samples

    def __post_init__(self) -> None:
        if len(self.progress) < 1 or (np.diff(self.progress) <= 0.0).any():
            raise ValueError("the progress of a course rises from sample to sample")
        part = 0.5 * np.diff(self.progress) * (self.rate[:, 1:] + self.rate[:, :-1])
        first = self.rate[:, :1] * self.progress[0]
        object.__setattr__(
            self, "depth", first + np.concatenate([np.zeros_like(first), np.cumsum(part, axis=1)], axis=1)
        )

    def depth_at(self, progress: np.ndarray) -> np.ndarray:
        """Depth (l, m) after service (l, m): the integral of rates that are straight between samples."""
        place = np.clip(np.searchsorted(self.progress, progress, "right") - 1, 0, None)
        life = np.arange(len(self.rate))[:, None]
        past = progress - self.progress[place]
        bend = 0.5 * np.maximum(past, 0.0) * self._bend[life, place]
        return self.depth[life, place] + past * (self.rate[life, place] + bend)

    def progress_at(self, depth: np.ndarray) -> np.ndarray:
        """Service (l, m) after which a depth (l, m) is reached: the inverse of `depth_at`; far off where nothing wears."""
        place = np.stack([np.searchsorted(own, d, "right") for own, d in zip(self.depth, depth, strict=True)])
        place = np.clip(place - 1, 0, None)
        life = np.arange(len(self.rate))[:, None]
        more = depth - self.depth[life, place]
        bend = np.where(more > 0.0, self._bend[life, place], 0.0)
        rate = np.maximum(self.rate[life, place], FAINT * float(self.rate.max()))
        return self.progress[place] + 2.0 * more / (
            rate + np.sqrt(np.maximum(rate**2 + 2.0 * bend * more, FAINT * rate**2))
        )

    def state_at(self, name: str, progress: np.ndarray) -> np.ndarray:
        """A feature (l, m) after service (l, m), straight between samples."""
        return np.stack(
            [np.interp(at, self.progress, own) for at, own in zip(progress, self.state[name], strict=True)]
        )

    @property
    def _bend(self) -> np.ndarray:
        """(l, c) change of the rate by progress after each sample; none after the last, nor before the first"""
        steps = np.diff(self.rate, axis=1) / np.diff(self.progress)
        return np.concatenate([steps, np.zeros((len(self.rate), 1))], axis=1)
