"""The course of a run of the model at each point of a survey: how fast it wears there, and in which state, along its service.

A run whose surface moves has a rate that changes with the shape. Let D(s) be the depth that it reaches at a point after the service s.
Wear k times as fast meets the same shapes k times as early, so a plate is at D(k s): the coefficient changes the pace at which the run's
own course is walked. That is exact where all points change their pace alike; where an effect hits some points only, each point walks its
own course, as if its neighbours were as far as it is.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

FAINT = 1e-9  # [-] of the largest rate: what does not wear needs no time to be told


@dataclass(frozen=True)
class Sampling:
    """What a run does not know of its own rates: each is the mean over a window of a flow that fluctuates.

    The relative error of the rate of life i in sample c has a mean of 0 and

        cov(e_ic, e_jd) = density_ij / window_c   where c = d, else 0,

    so a run that is sampled n times as long has 1/n of the variance. Smoothing makes neighbours err alike.

    Parameters
    ----------
    density
        (l, l) [s] variance of the mean rates of lives, relative to them, times the window.
    window
        (c,) [s] of steady flow in each sample.
    part
        (l, k, c) of each sample in the rate at each `progress` of the course; they sum to 1.
    """

    density: np.ndarray
    window: np.ndarray
    part: np.ndarray

    @property
    def modes(self) -> np.ndarray:
        """(l, p) whose sum of squares is the density"""
        size, mode = np.linalg.eigh(self.density)
        kept = size > 1e-12 * max(float(size[-1]), 1e-300)
        return mode[:, kept] * np.sqrt(size[kept])


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
    service
        (l, c) service of the run at `progress`, where something in the run changed its pace: see `at_own_pace`; None where both are one.
    sampling
        How well the run knows its own rates; None where they are taken to be exact.
    """

    progress: np.ndarray
    rate: np.ndarray
    state: Mapping[str, np.ndarray]
    steepness: np.ndarray
    follows_shape: bool
    notes: tuple[str, ...] = ()
    service: np.ndarray | None = None
    sampling: Sampling | None = None
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
        """A feature (l, m) after service (l, m) of the run, straight between samples."""
        clock = np.broadcast_to(self.progress, self.rate.shape) if self.service is None else self.service
        return np.stack(
            [
                np.interp(at, when, own)
                for at, when, own in zip(progress, clock, self.state[name], strict=True)
            ]
        )

    def grown(self, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Depth (l, m) from one service to another (l, m)."""
        return self.depth_at(end) - self.depth_at(begin)

    def own_errors(self, begin: np.ndarray, end: np.ndarray, least: float = 0.0) -> np.ndarray:
        """(l, m, q) relative errors of the growth in intervals (l, m) by the run's own sampling, for q independent standard normals.

        What a sample errs by acts on all growth that it stands for, and stays in every later depth. Of all combinations of samples and
        places those are left out that make no more than `least` of depth, root of the sum of squares over all lives and intervals.
        """
        if self.sampling is None:
            return np.zeros((*begin.shape, 0))
        end = np.maximum(end, begin + 1e-6 * float(end.max()))  # of an empty interval, the rate there
        growth = self.grown(begin, end)
        of_sample = np.stack(
            [replace(self, rate=self.rate * part).grown(begin, end) for part in np.moveaxis(self.sampling.part, -1, 0)], axis=-1
        )  # fmt: skip
        share = np.divide(
            of_sample, growth[..., None], out=np.zeros_like(of_sample), where=growth[..., None] > 0.0
        )
        share = share / np.sqrt(self.sampling.window)
        error = (share[:, :, :, None] * self.sampling.modes[:, None, None, :]).reshape(*growth.shape, -1)
        depth = np.cumsum(growth[..., None] * error, axis=1).reshape(growth.size, -1)
        size, mode = np.linalg.svd(depth, full_matrices=False)[1:]
        return error @ mode[size > max(least, 1e-12 * size.max(initial=0.0))].T

    @property
    def _bend(self) -> np.ndarray:
        """(l, c) change of the rate by progress after each sample; none after the last, nor before the first"""
        steps = np.diff(self.rate, axis=1) / np.diff(self.progress)
        return np.concatenate([steps, np.zeros((len(self.rate), 1))], axis=1)


def at_own_pace(course: Course, pace: np.ndarray) -> Course:
    """The course by the service in which the case alone would have walked it, where the run walked at a pace (l, c) of its own.

    A run with effects in it goes from shape to shape at the pace p of its factor and effects. After S = integral of p over service the
    case alone would be there too, at its own rate. What is fitted along this course is the whole pace again; where that is the one which
    the run had, the fit's depth is the run's.
    """
    steps = 0.5 * np.diff(course.progress) * (pace[:, 1:] + pace[:, :-1])
    first = pace[:, :1] * course.progress[0]
    walked = first + np.concatenate([np.zeros_like(first), np.cumsum(steps, axis=1)], axis=1)  # (l, c) S
    common = np.unique(walked)

    def on_common(value: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(common, own, v) for own, v in zip(walked, value, strict=True)])

    service = on_common(np.broadcast_to(course.progress, pace.shape))
    beyond = common > walked[:, -1:]
    service = np.where(beyond, course.progress[-1] + (common - walked[:, -1:]) / pace[:, -1:], service)
    sampling = course.sampling
    if sampling is not None:
        parts = [on_common(part) for part in np.moveaxis(sampling.part, -1, 0)]
        sampling = replace(sampling, part=np.stack(parts, axis=-1))
    return replace(
        course, progress=common, rate=on_common(course.rate), service=service, sampling=sampling,
        state={name: on_common(value) for name, value in course.state.items()},
    )  # fmt: skip
