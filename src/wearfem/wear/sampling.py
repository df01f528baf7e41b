"""What a sample of the flow tells of a rate: its mean, how far to trust it, and from when on the flow was steady."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wearfem.errors import UserError

ROUNDING = 1e-24  # relative variance below which blocks are equal
EARLIEST = 0.1  # [-] of a jump, in which the liner comes through the next shape at the earliest: noise may have moved a shape far
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
    depth: np.ndarray | None = (
        None  # (f,) [m] by which the shape that the flow met had receded since the first sample
    )

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

    @cached_property
    def squares(self) -> np.ndarray:
        """(f,) sum over blocks of the relative distances from the mean, squared; zero where nothing wears"""
        return len(self.rate) * np.divide(
            self.rate.var(axis=0), self.mean**2, out=np.zeros_like(self.mean), where=self.mean > 0.0
        )

    @cached_property
    def lag_products(self) -> np.ndarray:
        """(b,) of all facets together"""
        return lag_products(self.rate)


def passage(samples: Sequence[Sample]) -> tuple[np.ndarray, np.ndarray]:
    """When the liner came through the shape of each sample, and what had worn off by then: the trapezoid rule over all rates.

    A jump moves the surface by what it foretells, so the shape of the next sample is never quite that of its service time. The shape is
    known exactly, the time is not. With g the mean of two rates, the step between two shapes is the one that brings the facets there,

        depth + step g = shape,        step = g . (shape - depth) / (g . g)        (least squares over facets)

    where samples keep their shapes; those that keep none are taken at their service times.

    Returns
    -------
    time, depth
        (n,) [s] and (n, f) [m] since the first sample.
    """
    time, depth = [samples[0].service_time], [np.zeros_like(samples[0].mean)]
    for before, after in zip(samples[:-1], samples[1:], strict=True):
        gain = 0.5 * (before.mean + after.mean)
        step = after.service_time - before.service_time
        if after.depth is not None and before.depth is not None and gain.any():
            step = max(float(gain @ (after.depth - depth[-1]) / (gain @ gain)), EARLIEST * step)
        time.append(time[-1] + step)
        depth.append(depth[-1] + step * gain)
    return np.array(time), np.array(depth)


def corrected_depth(samples: Sequence[Sample]) -> np.ndarray:
    """(f,) [m] worn off at the service time of the last sample"""
    time, depth = passage(samples)
    return depth[-1] + (samples[-1].service_time - time[-1]) * samples[-1].mean


def depth_at(samples: Sequence[Sample], time: float) -> np.ndarray:
    """(f,) [m] worn off since the first sample at a service time [s], the rate a straight line between the shapes that the liner came
    through; beyond the last one its rate is taken to stay.
    """
    when, depth = passage(samples)
    last = int(np.clip(np.searchsorted(when, time, side="right") - 1, 0, len(when) - 1))
    before, gone = samples[last].mean, time - when[last]
    change = samples[min(last + 1, len(samples) - 1)].mean - before
    step = when[last + 1] - when[last] if last + 1 < len(when) else np.inf
    return depth[last] + gone * (before + 0.5 * change * gone / step)


@dataclass(frozen=True)
class Measured:
    """A mean and its standard error, both in one unit."""

    value: float
    error: float = 0.0

    def over(self, other: "Measured") -> "Measured":
        """The quotient of two that do not depend on one another."""
        quotient = self.value / other.value
        return Measured(
            quotient, abs(quotient) * float(np.hypot(self.error / self.value, other.error / other.value))
        )


def mean_of(block_value: np.ndarray) -> Measured:
    """The mean of consecutive blocks (b,), with its standard error."""
    return Measured(float(block_value.mean()), float(standard_error(block_value[:, None])[0]))


def ratio(top: np.ndarray, bottom: np.ndarray) -> Measured:
    """Sum of `top` (b,) over sum of `bottom` (b,) for consecutive blocks; its standard error to first order."""
    value = float(top.sum() / bottom.sum())
    residual = (top - value * bottom) / bottom.mean()
    return Measured(value, float(standard_error(residual[:, None])[0]))


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
    return inefficiency([lag_products(np.asarray(series, float).reshape(len(series), -1))])


def lag_products(rows: np.ndarray) -> np.ndarray:
    """(b,) sums over time and columns of x_t x_t+k at the lags k = 0 ... b - 1, x the rows (b, f) around their mean; rounding is 0."""
    blocks = len(rows)
    spectrum = np.abs(np.fft.rfft(rows - rows.mean(axis=0), 2 * blocks, axis=0)) ** 2
    products = np.fft.irfft(spectrum.sum(axis=1))[:blocks]
    return products if products[0] > ROUNDING * np.square(rows).sum() else np.zeros(blocks)


def inefficiency(windows: Sequence[np.ndarray]) -> float:
    """The statistical inefficiency of several windows of one flow, by their `lag_products`: many short ones tell what each hides."""
    longest = max(map(len, windows))
    total, pairs, means = np.zeros(longest), np.zeros(longest), np.zeros(longest)
    for products in windows:
        blocks = len(products)
        total[:blocks] += products
        pairs[:blocks] += blocks - np.arange(blocks)
        means[:blocks] += 1.0 - np.arange(blocks) / blocks
    if total[0] <= 0.0:
        return 1.0
    covariance, g = total / pairs, 0.0
    for _ in range(4):
        added = covariance + covariance[0] * g * (means / pairs) / (1.0 - g * means[0] / pairs[0])
        couples = added[: 2 * (longest // 2)].reshape(-1, 2).sum(axis=1)
        last = 2 * int(np.argmax(couples <= 0.0)) if (couples <= 0.0).any() else longest
        last = min(last, longest // 2)
        g = 1.0 + 2.0 * float(((pairs / pairs[0]) * added)[1:last].sum()) / added[0]
        g = min(max(g, 1.0), 0.5 * pairs[0] / len(windows))
    return g


def noise_density(windows: Sequence[np.ndarray], squares: np.ndarray | float, block: float) -> np.ndarray:
    """Variance of a mean times the length of its window: g block sum(x^2) / (n - m g) of the n blocks of m windows.

    Parameters
    ----------
    windows
        `lag_products` of each.
    squares
        (f,) or one: sums of squares of all windows, each around its own mean, any unit.
    block
        [s]
    """
    g = inefficiency(windows)
    return np.asarray(g * block * squares / (sum(map(len, windows)) - g * len(windows)))


def steady_from(series: np.ndarray) -> int:
    """The first block from which the flow is steady: the start from which the mean is known best.

        start = argmin_s  sum_{i >= s} (x_i - mean_s)^2 / (n - s)^2,   s <= n/2

    A start too early keeps a drift, which scatters; a start too late throws good blocks away. Either makes the variance of the mean
    larger. No start beyond the half is tried: the mean of a few last blocks looks sure by chance.

    Parameters
    ----------
    series
        (b,) one number per block that the geometry changes: the rate summed over the facets that matter.

    Returns
    -------
    int
        Index of the first steady block; 0 for a series shorter than eight blocks or without scatter.

    **Source** marginal standard error rule: White, Simulation 69 (1997) 323-334; chosen among 42 methods by Hoad, Robinson and Davies,
    J. Oper. Res. Soc. 61 (2010) 1632-1644. **Valid for** a warm-up that ends within the first half: one that fills more cannot be
    told from a steady, slowly correlated flow.
    """
    series = np.asarray(series, float)
    blocks = len(series)
    if blocks < 8:
        return 0
    centred = (series - series.mean())[::-1]
    left = np.arange(1, blocks + 1)
    scatter = np.cumsum(centred**2) - np.cumsum(centred) ** 2 / left
    if scatter[-1] <= ROUNDING * np.square(series).sum():
        return 0
    return int(np.argmin((scatter / left**2)[::-1][: blocks // 2 + 1]))
