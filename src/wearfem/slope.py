"""The free surface of a heap and its slope, measured the same way everywhere: no eye, no ruler."""

from dataclasses import dataclass

import numpy as np

from wearfem.errors import UserError

WINDOW = (
    0.15,
    0.85,
)  # part of the height from toe to crest that a line is fitted to: away from both roundings
FEWEST = 4  # columns that a line needs
RESAMPLES = 400  # of the bootstrap


@dataclass(frozen=True)
class Profile:
    """Height of the free surface over a horizontal direction, by column."""

    along: np.ndarray  # (c,) [m] middle of each column, rising
    height: np.ndarray  # (c,) [m]

    def between(self, low: float, high: float) -> "Profile":
        """The columns with middles from `low` to `high` [m]."""
        inside = (self.along >= low) & (self.along <= high)
        return Profile(self.along[inside], self.height[inside])


@dataclass(frozen=True)
class Line:
    """A straight line fitted to a free surface."""

    angle: float  # [degree] above the horizontal, positive where it falls with `along`
    low: float  # [degree] 95 % interval of the fit, see `fit_line`
    high: float  # [degree]
    start: tuple[float, float]  # [m] along and height of its first point
    end: tuple[float, float]  # [m]
    column_count: int


def free_surface(
    along: np.ndarray,
    across: np.ndarray,
    height: np.ndarray,
    radius: np.ndarray,
    *,
    cell: float,
    width: float,
) -> Profile:
    """The profile of a heap: by column of length `cell`, the median over strips across of the topmost particle's top.

    Parameters
    ----------
    along, across, height
        (n,) [m] centres of the particles; `across` from 0 to `width`.
    radius
        (n,) [m]
    cell
        Length of a column and about the width of a strip [m]; one largest diameter leaves no holes.
    width
        Of the heap across [m].
    """
    if not len(along):
        return Profile(np.zeros(0), np.zeros(0))
    strips = max(1, round(width / cell))
    strip = np.clip((across / width * strips).astype(int), 0, strips - 1)
    column = np.floor(along / cell).astype(int)
    first = column.min()
    top = np.full((column.max() - first + 1, strips), -np.inf)
    np.maximum.at(top, (column - first, strip), height + radius)
    covered = np.isfinite(top).sum(axis=1) * 2 > strips
    top[~np.isfinite(top)] = np.nan
    return Profile((np.flatnonzero(covered) + first + 0.5) * cell, np.nanmedian(top[covered], axis=1))


def fit_line(profile: Profile, *, seed: int = 0) -> Line:
    """A line through the free surface between 15 and 85 % of its height: Theil and Sen's, the median of all slopes between two columns.

    The interval holds 95 % of the slopes of 400 bootstrap samples of the columns. It tells how well a line describes this surface, not
    how another heap of the same grains would stand.

    **Source** Sen, Journal of the American Statistical Association 63 (1968) 1379-1389; Efron and Tibshirani, An Introduction
    to the Bootstrap (1993), ch. 13 (percentile interval).
    """
    along, height = profile.along, profile.height
    if len(along):
        toe, crest = height.min(), height.max()
        inside = (height >= toe + WINDOW[0] * (crest - toe)) & (height <= toe + WINDOW[1] * (crest - toe))
        along, height = along[inside], height[inside]
    if len(along) < FEWEST:
        raise UserError(
            f"A slope has {len(along)} columns between 15 and 85 % of its height; a line needs {FEWEST}: take smaller particles."
        )
    slope = _median_slope(along, height)
    random = np.random.default_rng(seed)
    samples = (random.integers(0, len(along), len(along)) for _ in range(RESAMPLES))
    resampled = [_median_slope(along[k], height[k]) for k in samples if len(np.unique(k)) > 2]
    low, high = np.percentile(_degrees(np.array(resampled)), [2.5, 97.5])
    middle = float(np.median(height - slope * along))
    first, last = float(along[0]), float(along[-1])
    return Line(
        float(_degrees(slope)),
        float(low),
        float(high),
        (first, middle + slope * first),
        (last, middle + slope * last),
        len(along),
    )


def _degrees(slope: float | np.ndarray) -> np.ndarray:
    return -np.degrees(np.arctan(slope))


def _median_slope(along: np.ndarray, height: np.ndarray) -> float:
    i, j = np.triu_indices(len(along), 1)
    run = along[j] - along[i]
    return float(np.median((height[j] - height[i])[run != 0.0] / run[run != 0.0]))
