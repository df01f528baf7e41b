"""What a sample of the flow tells of a rate: its mean, how far to trust it, and from when on the flow was steady."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wearfem.errors import UserError

ROUNDING = 1e-24  # relative variance below which blocks are equal
FEWEST_BLOCKS = 4  # below, the scatter of the blocks says nothing of the error of their mean


@dataclass(frozen=True)
class Sample:
    """The rates of one window of steady flow over one geometry. A value: nothing ever changes it.

    Raises `UserError` for fewer than four blocks, blocks of different length, and rates that are no numbers.
    """

    service_time: float  # [s] of the liner whose geometry the flow met
    rate: np.ndarray  # (b, f) [m/s] depth rate by block and facet, warm-up left out
    block: float  # [s] length of each block
    warm_up: float = 0.0  # [s] of flow that was thrown away before

    def __post_init__(self) -> None:
        shape = np.shape(self.rate)
        if len(shape) != 2 or shape[0] < FEWEST_BLOCKS:
            raise UserError(
                f"a sample of rates has the shape {shape}; (blocks, facets) with at least {FEWEST_BLOCKS} blocks are "
                "needed to know the error of the mean: sample longer or in shorter blocks."
            )
        if not np.isfinite(self.rate).all():
            raise UserError(
                "a sample has rates that are not numbers; look for the facet and block that made them."
            )
        if not self.block > 0.0:
            raise UserError(f"the length of a block is {self.block!r} s; it must be above 0.")

    @property
    def window(self) -> float:
        """Length of the steady flow that was sampled [s]"""
        return self.block * len(self.rate)

    @cached_property
    def mean(self) -> np.ndarray:
        """(f,) [m/s]"""
        return self.rate.mean(axis=0)

    @cached_property
    def error(self) -> np.ndarray:
        """(f,) [m/s] standard error of `mean`"""
        return standard_error(self.rate)

    def weighted(self, weight: np.ndarray) -> tuple[float, float]:
        """Mean and standard error of the sum of rates times weights (f,), with what neighbours have in common."""
        series = self.rate @ weight
        return float(series.mean()), float(standard_error(series[:, None])[0])


def standard_error(block_rate: np.ndarray) -> np.ndarray:
    """Standard error of the mean of blocks that may remember one another.

        error^2 = g C_0 / (n - g)

    with the variance C_0 of the n blocks of each facet around their mean, and the statistical inefficiency g of all facets together.
    Around their own mean C_0 is too small by the part g/n; the divisor n - g makes up for it.

    Parameters
    ----------
    block_rate
        (b, f) means of consecutive blocks of equal length, any unit.

    Returns
    -------
    np.ndarray
        (f,) in the same unit; zero where every block is the same.

    **Source** variance of the mean of a correlated series: Straatsma, Berendsen and Stam, Mol. Phys. 57 (1986) 89-95, eq. 19.
    **Valid for** a stationary series some ten times longer than its correlation time; shorter ones hide their slow part and the
    error comes out too small (`tests/analytical/test_sampling.py` shows by how much).
    """
    blocks = len(block_rate)
    inefficiency = statistical_inefficiency(block_rate)
    return np.sqrt(inefficiency * block_rate.var(axis=0) / (blocks - inefficiency))


def statistical_inefficiency(series: np.ndarray) -> float:
    """How many consecutive blocks tell as much as one independent one: g = 1 + 2 sum_k (1 - k/n) C_k / C_0.

    The sum ends before the first pair C_2j + C_2j+1 that is not positive. Covariances of all columns are added before they are
    divided, so that many noisy facets give one firm answer. Around the sample's own mean every covariance is too small by the
    variance of that mean, g C_0 / n; it is added back and the sum taken anew, three times.

    Parameters
    ----------
    series
        (b, f) or (b,), any unit.

    Returns
    -------
    float
        1 (independent) to b/2.

    **Source** Geyer, Statistical Science 7 (1992) 473-483, initial positive sequence; Chodera et al., J. Chem. Theory Comput. 3
    (2007) 26-41, eq. 20-22; for what is added back, Anderson, The Statistical Analysis of Time Series (1971), section 8.2. **Valid
    for** correlation that is positive and decays; an oscillating flow sampled for less than a few periods is not seen.
    """
    rows = np.asarray(series, float).reshape(len(series), -1)
    blocks = len(rows)
    spectrum = np.abs(np.fft.rfft(rows - rows.mean(axis=0), 2 * blocks, axis=0)) ** 2
    lag = np.arange(blocks)
    covariance = np.fft.irfft(spectrum.sum(axis=1))[:blocks] / (blocks - lag)
    if covariance[0] <= ROUNDING * np.square(rows).sum() / blocks:
        return 1.0
    g = 0.0
    for _ in range(4):
        added = covariance + covariance[0] * g / (blocks - g)
        pairs = added[: 2 * (blocks // 2)].reshape(-1, 2).sum(axis=1)
        last = 2 * int(np.argmax(pairs <= 0.0)) if (pairs <= 0.0).any() else blocks
        last = min(last, blocks // 2)
        g = 1.0 + 2.0 * float(((1.0 - lag / blocks) * added)[1:last].sum()) / added[0]
        g = min(max(g, 1.0), 0.5 * blocks)
    return g


def steady_from(series: np.ndarray) -> int:
    """The first block from which the flow is steady: the start that leaves the most independent blocks.

    A start too early keeps a drift, which looks like a long correlation; a start too late throws good blocks away. Both
    leave few effective blocks (n - start) / g(start), so the largest number of them marks the end of the warm-up. Starts are tried up
    to three quarters.

    Parameters
    ----------
    series
        (b,) one number per block that the geometry changes: the rate summed over the facets that matter.

    Returns
    -------
    int
        Index of the first steady block; 0 for a series shorter than eight blocks or without scatter.

    **Source** Chodera, J. Chem. Theory Comput. 12 (2016) 1799-1805, eq. 10-12. **Valid for** a warm-up that ends within the series:
    one that fills all of it cannot be told from a steady, slowly correlated flow.
    """
    series = np.asarray(series, float)
    blocks = len(series)
    if blocks < 8:
        return 0
    starts = np.unique(np.linspace(0, 3 * blocks // 4, min(blocks, 60)).astype(int))
    effective = [(blocks - start) / statistical_inefficiency(series[start:]) for start in starts]
    return int(starts[int(np.argmax(effective))])
