"""What disturbs readings and is no physics: zero errors, new thickness, the tonnage book, scatter from place to place; shrunk to zero.

A reading is what the model says plus what a campaign reads too high (by the same everywhere, or in proportion to wear: the velocity of
sound, or another place along a belt), what the plate measured other than told, the plate's own scatter of the rate, the tonnage book's
error in each interval, what neighbours have in common (the model's rate is off by a smooth function of place, all points lie beside
where they are told to be, a campaign's readings are off by a smooth function of place), the change of each place's rate with depth by
its own shape, what a run has not seen of its own flow, and the gauge's error:

    y = d + z[occasion] + s[occasion] d + h[life] + u[life] d + f(place) d + (shift . grad ln d) d + g[life] d^2 + w[occasion](place)
      + sum over intervals of (b[interval] + r[life, interval]) (growth of d in it) + e.

All are normal with standard deviations that the data tell (by marginal likelihood), under exponential priors that pull those to zero that
are not needed; but the covariance of r, what the run itself does not know, the run tells (`course.Sampling`), and no reading changes it.
They are integrated out, not fitted: points read many times count as one where the scatter between points is what matters.

**Source** linear mixed models, Laird and Ware, Biometrics 38 (1982) 963-974; matrix identity of Woodbury.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.linalg.lapack import dtrtri
from scipy.optimize import minimize

from wearfem.survey.history import History
from wearfem.survey.survey import Survey

SCATTER_PRIOR = 0.1  # [-] mean of the exponential prior of the scatter of the rate between places
SCALE_PRIOR = 0.02  # [-] of what a campaign reads too much of the wear
SMOOTH_PRIOR = 0.02  # [-] of a smooth error of the rate
BEND_PRIOR = 0.03  # [-] of the rate's change with depth from place to place
SHIFT_PRIOR = 0.01  # [m] of where all points are
BOOK_PRIOR = 0.02  # [-] and of the error of the tonnage book in an interval
OFFSET_PRIOR = 1.0  # [gauge errors] and of zero errors and new thicknesses
GAUGE_PRIOR = 0.15  # [-] standard deviation of the logarithm of the gauge error about what was given
GUESS_PRIOR = 0.7  # the same about a guess
FREE = 1e3  # [gauge errors] standard deviation of the mean new thickness where only readings tell it
SAMPLING = 10  # group of the run's own sampling
KNOWN = 1.0  # [-] standard deviation of what has its size in its columns
LEAST_SHARE = 1e-3  # of a prior's mean: what counts as zero


@dataclass(frozen=True)
class Spread:
    """Standard deviations of what disturbs readings.

    Parameters
    ----------
    gauge
        [SI unit of the reading] of one reading.
    zero, initial
        [same] of the zero error of a campaign, and of a plate's new thickness about what is told, or about the mean of all plates.
    scatter, book, scale
        [-] of the rate between places, of the tonnage book's error in an interval, and of a campaign's error in proportion to wear.
    smooth
        [-] of the rate, as a smooth function of place.
    warp
        [SI unit of the reading] of what a campaign reads too high, as a smooth function of place.
    shift
        [m] of all points together, along each axis.
    bend
        [-] of the rate between places, by which it has changed at the deepest wear: each place's own shape.
    """

    gauge: float
    zero: float
    initial: float
    scatter: float
    book: float
    scale: float
    smooth: float
    warp: float
    shift: float
    bend: float


@dataclass(frozen=True)
class Disturbance:
    """How nuisances enter the readings: (n, q) columns, and which standard deviation each has.

    `weight` (n,) is the variance of a reading over gauge squared; `group` (q,) is 0 zero error, 1 new thickness, 2 scatter, 3 book, 4
    mean new thickness of all plates where only readings tell it (its label: the number of lives), 5 a campaign's error in proportion, 6
    smooth error of the rate, 7 of a campaign, 8 shift, 9 bend, 10 the run's own sampling; `label` (q,) the occasion, life, interval,
    function, axis or mode.
    """

    column: np.ndarray
    group: np.ndarray
    label: np.ndarray
    weight: np.ndarray

    def deviation(self, spread: Spread) -> np.ndarray:
        """(q,) standard deviation of each nuisance."""
        each = [spread.zero, spread.initial, spread.scatter, spread.book, FREE * spread.gauge, spread.scale]
        each += [spread.smooth, spread.warp, spread.shift, spread.bend, KNOWN]
        return np.array(each)[self.group]


def disturbance(
    survey: Survey, past: History, depth: np.ndarray, told: float, thickness_free: bool
) -> Disturbance:
    """The columns of all nuisances, where a model says that depth (l, m) is worn.

    Parameters
    ----------
    told
        Gauge error that weights refer to (readings with larger sigma weigh less).
    thickness_free
        Whether the new thickness is known from readings only.
    """
    rows = survey.size
    lives, occasions = len(survey.life_point), len(survey.occasion_names)
    growth = np.diff(depth, axis=1, prepend=0.0)
    at = past.of_rows(depth)
    columns, groups, labels = [], [], []

    def add(values: np.ndarray, group: int) -> None:
        used = np.flatnonzero(np.abs(values).max(axis=0) > 0.0)
        columns.append(values[:, used])
        groups.append(np.full(len(used), group))
        labels.append(used)

    by_life = np.zeros((rows, lives))
    by_life[np.arange(rows), survey.life] = 1.0
    if lives > 2:
        zero = np.zeros((rows, occasions))
        zero[np.arange(rows), survey.occasion] = 1.0
        add(zero, 0)
        add(zero * at[:, None], 5)
        add(by_life * at[:, None], 2)
        passed = np.arange(growth.shape[1])[None, :] <= past.row_interval[:, None]
        book = np.zeros((rows, occasions))
        for j in range(growth.shape[1]):
            np.add.at(
                book, (np.arange(rows), past.occasion[survey.life, j]), passed[:, j] * growth[survey.life, j]
            )
        add(book, 3)
        if past.smooth.shape[1]:
            add(past.smooth[survey.life] * at[:, None], 6)
        if past.warped.shape[1]:
            add((zero[:, :, None] * past.warped[survey.life][:, None, :]).reshape(rows, -1), 7)
        if past.bent > 0.0:
            add(by_life * (at**2 / past.bent)[:, None], 9)
        if past.steepness.any():
            add(past.steepness[survey.life] * at[:, None], 8)
    if past.sampled.shape[2]:  # an interval to come errs as the last
        error = past.sampled[:, np.minimum(np.arange(growth.shape[1]), past.sampled.shape[1] - 1)]
        by_end = np.cumsum(growth[:, :, None] * error, axis=1)
        add(np.where(past.row_interval[:, None] < 0, 0.0, by_end[past.row_life, past.row_interval]), SAMPLING)
    add(by_life, 1)
    if thickness_free:
        add(np.ones((rows, 1)), 4)
        labels[-1] = np.array([lives])  # common to all plates, and of none
    weight = np.where(np.isfinite(survey.sigma), survey.sigma / told, 1.0) ** 2
    return Disturbance(np.concatenate(columns, 1), np.concatenate(groups), np.concatenate(labels), weight)


@dataclass(frozen=True)
class Covariance:
    """Gauge error and nuisances together: C = gauge^2 W + Z T^2 Z'."""

    gauge: float
    weight: np.ndarray
    scaled: np.ndarray  # (n, q) W^-1/2 Z T / gauge
    factor: np.ndarray  # (q, q) Cholesky factor of 1 + scaled' scaled, lower

    def whiten(self, values: np.ndarray) -> np.ndarray:
        """Values (n,) or (n, c) with W^-1/2 / gauge applied; the rest of C is in `product`."""
        root = self.gauge * np.sqrt(self.weight)
        return values / (root if values.ndim == 1 else root[:, None])

    def square(self, values: np.ndarray) -> float:
        """values' C^-1 values"""
        white = self.whiten(values)
        inner = solve_triangular(self.factor, self.scaled.T @ white, lower=True, check_finite=False)
        return float(white @ white - inner @ inner)

    def root(self) -> np.ndarray:
        """(n, n) matrix R with R' R = C^-1"""
        # with L L' = 1 + S' S and K = (1 + L')^-1 L^-1:  K + K' - K' S' S K = (L L')^-1, so (1 - S K S')' (1 - S K S') = (1 + S S')^-1
        half = solve_triangular(self.factor, self.scaled.T, lower=True, check_finite=False)
        one = np.eye(len(self.factor))
        half = solve_triangular(one + self.factor.T, half, lower=False, check_finite=False)
        inner = np.eye(len(self.weight)) - self.scaled @ half
        return inner / (self.gauge * np.sqrt(self.weight))

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant of C"""
        own = np.log(self.weight).sum() + 2.0 * len(self.weight) * np.log(self.gauge)
        return float(own + 2.0 * np.log(np.diag(self.factor)).sum())


def covariance(found: Disturbance, spread: Spread) -> Covariance:
    """The covariance of the readings about the model."""
    scaled = found.column * found.deviation(spread) / (spread.gauge * np.sqrt(found.weight)[:, None])
    inner = scaled.T @ scaled
    inner[np.diag_indices_from(inner)] += 1.0
    return Covariance(spread.gauge, found.weight, scaled, np.linalg.cholesky(inner))


def nuisances(found: Disturbance, spread: Spread, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The most probable nuisances (q,) and their standard deviations, given what is left of the readings (n,)."""
    c = covariance(found, spread)
    deviation = found.deviation(spread)
    factor = (c.factor, True)
    value = deviation * cho_solve(factor, c.scaled.T @ c.whiten(residual))
    inverse = cho_solve(cho_factor(c.factor @ c.factor.T), np.eye(len(value)))
    return value, deviation * np.sqrt(np.diag(inverse))


def log_prior(spread: Spread, told: float | None, reference: float) -> float:
    """Logarithm of the prior density of standard deviations, up to a constant.

    `told` is the gauge error that was given, `reference` the size that zero errors are compared with.
    """
    value = -(spread.zero + spread.initial + spread.warp) / (OFFSET_PRIOR * reference)
    value -= spread.smooth / SMOOTH_PRIOR + spread.shift / SHIFT_PRIOR + spread.bend / BEND_PRIOR
    value -= spread.scatter / SCATTER_PRIOR + spread.book / BOOK_PRIOR + spread.scale / SCALE_PRIOR
    value -= 0.5 * (np.log(spread.gauge / (told or reference)) / (GAUGE_PRIOR if told else GUESS_PRIOR)) ** 2
    return float(value)


def log_likelihood(found: Disturbance, spread: Spread, residual: np.ndarray) -> float:
    """Logarithm of the density of the readings, with the nuisances integrated out."""
    c = covariance(found, spread)
    return -0.5 * (c.square(residual) + c.log_determinant + len(residual) * np.log(2.0 * np.pi))


def fit_spread(
    found: Disturbance, residual: np.ndarray, start: Spread, told: float | None, reference: float
) -> Spread:
    """The standard deviations that the residual (n,) makes most probable, with their priors."""
    root = np.sqrt(found.weight)
    z = found.column / root[:, None]
    r = residual / root
    inner, side, total = z.T @ z, z.T @ r, float(r @ r)
    unit = np.array(
        [reference] * 3
        + [SCATTER_PRIOR, BOOK_PRIOR, SCALE_PRIOR, SMOOTH_PRIOR, reference, SHIFT_PRIOR, BEND_PRIOR]
    )
    floor = np.log(LEAST_SHARE)

    def negative(log: np.ndarray) -> tuple[float, np.ndarray]:
        """Minus the logarithm of the posterior density, and its slope by the logarithms of the standard deviations"""
        size = unit * np.exp(log)
        spread = Spread(*size)
        g2 = spread.gauge**2
        t = found.deviation(spread) / spread.gauge
        turned, determinant = _inverse_root(inner * t * t[:, None])
        weighed = t * (turned.T @ (turned @ (t * side)))
        square = (total - side @ weighed) / g2
        value = 0.5 * (square + determinant + 2.0 * len(r) * log[0])
        taken = (side - inner @ weighed) / g2  # z' C^-1 r
        diagonal = np.einsum("ij,ij->j", turned, turned)
        own = (1.0 - diagonal) / (t * t * g2)  # diagonal of z' C^-1 z
        each = 0.5 * (own - taken**2)
        trace = (len(r) - len(t) + diagonal.sum()) / g2
        by_gauge = 0.5 * (trace - (total - 2.0 * weighed @ side + weighed @ inner @ weighed) / g2**2)
        slope = (
            2.0
            * size**2
            * np.array([by_gauge, *(each[found.group == k].sum() for k in (0, 1, 2, 3, 5, 6, 7, 8, 9))])
        )
        slope[0] += 2.0 * FREE**2 * g2 * each[found.group == 4].sum()
        slope += (
            size / unit / np.array([np.inf, *[OFFSET_PRIOR] * 2, 1.0, 1.0, 1.0, 1.0, OFFSET_PRIOR, 1.0, 1.0])
        )
        slope[0] += np.log(spread.gauge / (told or reference)) / (GAUGE_PRIOR if told else GUESS_PRIOR) ** 2
        return value - log_prior(spread, told, reference), slope

    first = np.log(np.maximum(np.array(list(_values(start).values())) / unit, 1.01 * LEAST_SHARE))
    limits = [(first[0] - 4.0, first[0] + 4.0)] + [(floor, np.log(100.0))] * 9
    limits[2] = (floor, np.log(1e5))  # plates of another kind
    best = minimize(
        negative, first, jac=True, method="L-BFGS-B", bounds=limits, options={"maxiter": 25, "ftol": 1e-7}
    )
    value = unit * np.exp(best.x)
    return Spread(*(float(v) for v in value))


def _inverse_root(square: np.ndarray) -> tuple[np.ndarray, float]:
    """The inverse (q, q) of the Cholesky factor of 1 + a matrix, and the logarithm of the determinant"""
    square[np.diag_indices_from(square)] += 1.0
    factor = np.linalg.cholesky(square)
    return dtrtri(factor, lower=1)[0], 2.0 * float(np.log(np.diag(factor)).sum())


def _values(spread: Spread) -> Mapping[str, float]:
    return dict(spread.__dict__)
