"""What a result tends to as a size goes to zero, how fast, and how far off the finest one is: Richardson's extrapolation."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, nan

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares
from scipy.stats import chi2

from wearfem.errors import UserError

SAFETY = 1.25  # [-] Roache's factor for three grids and more
SLOWEST, FASTEST = (
    0.5,
    8.0,
)  # [-] orders that are believed; outside, the sizes are not in the asymptotic range
STARTS = (0.7, 1.0, 2.0, 4.0)  # [-] orders from which the fit sets out
SURE = 0.95  # a dependence that noise alone would show more seldom than once in 20 is believed


@dataclass(frozen=True)
class Converged:
    """What a result tends to; see `converged`."""

    value: float  # [unit of the result] at size zero; not a number where that cannot be told
    order: float  # [-] observed; not a number where none is seen
    error: float  # [unit of the result] of the finest value, from its size
    noise: float  # [unit of the result] one standard error of `value`, from the noise of the results
    reason: str = ""  # why there is no order, or no value; empty where all is well

    @property
    def told(self) -> bool:
        """Whether there is a converged answer."""
        return isfinite(self.value)


def converged(
    size: Sequence[float] | np.ndarray,
    value: Sequence[float] | np.ndarray,
    noise: ArrayLike | None = None,
    formal_order: float = 2.0,
) -> Converged:
    r"""The converged answer f0 and the observed order p of results f at sizes h: f(h) = f0 + C h^p by least squares.

    With three sizes the curve goes through all results, which is Richardson's extrapolation; with more it is fitted, each result
    weighted with the inverse of its noise where that is given. The error of the finest result is 1.25 abs(f_finest - f0), with f0
    by the observed order or by the formal one, whichever is farther; with more than three sizes the root mean square misfit of the
    curve is added.

    Parameters
    ----------
    size
        (n,) at least three different sizes above zero [any unit]: of elements, time steps, smoothing lengths.
    value
        (n,) results [any unit].
    noise
        (n,) or one for all: standard error of each result [its unit], independent of the others'; None for results without noise.
    formal_order
        Order of the scheme in theory [-]. A faster one is not trusted in the error.

    Returns
    -------
    Converged
        With `reason` and no value where the results do not approach an answer from one side, or by an order below 0.5. Where they do not
        depend on size, or by no more than their noise (chi-squared at 95 %), the value is their mean and there is no order.

    Raises
    ------
    UserError
        for fewer than three sizes, or numbers that are not finite.

    Notes
    -----
    **Source** P. J. Roache, J. Fluids Eng. 116 (1994) 405-413 (the factor 1.25); I. B. Celik et al., J. Fluids Eng. 130 (2008)
    078001 (three sizes of any ratio); L. Eca, M. Hoekstra, J. Comput. Phys. 262 (2014) 104-130 (least squares with more). The limits
    of the order and the test against noise are ours.

    **Valid for** sizes in the asymptotic range, where one power of h rules the error; at least a factor 1.3 between neighbours is advised.
    """
    h, f, s = _in_order(size, value, noise)
    mean = float(np.average(f, weights=None if s is None else s**-2.0))
    if np.ptp(f) <= 1e-13 * np.abs(f).max():
        return Converged(mean, nan, 0.0, _of_mean(s), "it does not depend on the size")
    if s is not None:
        misfit = float((((f - mean) / s) ** 2).sum())
        if misfit <= chi2.ppf(SURE, len(f) - 1):
            return Converged(mean, nan, 0.0, _of_mean(s), "its noise hides any dependence on the size")
    step = np.diff(f)
    if s is None and not (np.all(step > 0.0) or np.all(step < 0.0)):
        return Converged(nan, nan, inf, nan, "the results do not approach an answer from one side")

    order = _order(h, f, s)
    limit, factor = _line(h, f, s, order)
    if not SLOWEST <= order < 0.999 * FASTEST:
        how = f"by the order {order:.2g}" if order < SLOWEST else "faster than any power that is believed"
        return Converged(nan, order, inf, nan, f"the results change {how}: the sizes are too large to tell")
    slow, _ = _line(h, f, s, min(order, formal_order))
    left = f - limit - factor * h**order
    spread = float(np.sqrt((left**2).sum() / (len(f) - 3))) if len(f) > 3 else 0.0
    error = SAFETY * max(abs(f[0] - limit), abs(f[0] - slow)) + spread
    return Converged(limit, order, float(error), _noise_of_limit(h, s, order, factor))


def _in_order(
    size: ArrayLike, value: ArrayLike, noise: ArrayLike | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Checked, the finest first."""
    h, f = np.asarray(size, float).ravel(), np.asarray(value, float).ravel()
    if h.shape != f.shape or len(np.unique(h)) < 3:
        raise UserError(
            f"a converged answer was asked of {len(np.unique(h))} different sizes and {len(f)} results: it needs at least three sizes, "
            "and one result for each"
        )
    if not (np.all(np.isfinite(h) & (h > 0.0)) and np.all(np.isfinite(f))):
        raise UserError(
            "a converged answer was asked of sizes that are not above zero, or of results that are not finite"
        )
    order = np.argsort(h, kind="stable")
    if noise is None:
        return h[order], f[order], None
    s = np.broadcast_to(np.asarray(noise, float), h.shape)
    if not np.all(np.isfinite(s) & (s > 0.0)):
        raise UserError(
            "a converged answer was given a noise that is not above zero: leave it out where there is none"
        )
    return h[order], f[order], s[order]


def _line(h: np.ndarray, f: np.ndarray, s: np.ndarray | None, order: float) -> tuple[float, float]:
    """f0 and C of the best f0 + C h^order."""
    weight = np.ones_like(h) if s is None else 1.0 / s
    matrix = np.column_stack([np.ones_like(h), (h / h[-1]) ** order]) * weight[:, None]
    limit, factor = np.linalg.lstsq(matrix, f * weight, rcond=None)[0]
    return float(limit), float(factor / h[-1] ** order)


def _order(h: np.ndarray, f: np.ndarray, s: np.ndarray | None) -> float:
    """The order whose best line misses least."""
    scale = np.ptp(f) if s is None else s

    def misfit(p: np.ndarray) -> np.ndarray:
        limit, factor = _line(h, f, s, p[0])
        return (limit + factor * h ** p[0] - f) / scale

    fits = [
        least_squares(misfit, [p], bounds=(0.01, FASTEST), xtol=1e-14, ftol=1e-14, gtol=1e-14) for p in STARTS
    ]
    return float(min(fits, key=lambda fit: fit.cost).x[0])


def _of_mean(s: np.ndarray | None) -> float:
    return 0.0 if s is None else float((s**-2.0).sum() ** -0.5)


def _noise_of_limit(h: np.ndarray, s: np.ndarray | None, order: float, factor: float) -> float:
    """One standard error of f0, the order being fitted too: (J^T J)^-1 with rows df/d(f0, C, p) / s."""
    if s is None:
        return 0.0
    power = (h / h[-1]) ** order
    jacobian = np.column_stack([np.ones_like(h), power, factor * h**order * np.log(h / h[-1])]) / s[:, None]
    return float(np.sqrt(np.linalg.pinv(jacobian.T @ jacobian)[0, 0]))
