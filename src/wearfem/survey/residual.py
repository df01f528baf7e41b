"""Is this just noise? What is left of the readings, tested against every quantity that could carry it.

A test asks whether a smooth function of one quantity (depth, date, place, a column) would take more out of the residual than noise lets it.
Noise is the gauge's error, zero errors of campaigns, and as much error of the tonnage book and scatter between places as a careful
plant has; points that are read again and again count as one where scatter between points is concerned, since their readings are
correlated in the covariance. The level is divided by the number of tests (Bonferroni), so false alarms over all stay below it.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from wearfem.survey.candidates import curves
from wearfem.survey.history import depths
from wearfem.survey.identify import Fit, fit, model_at
from wearfem.survey.nuisance import BOOK_PRIOR, SCALE_PRIOR, SHIFT_PRIOR, Spread, covariance, disturbance

CAREFUL_SCATTER = 0.03  # [-] between places that are exposed alike


@dataclass(frozen=True)
class NoiseTest:
    """Whether what is left depends on a quantity.

    Parameters
    ----------
    quantity
        depth, date, x, y, z or a column.
    statistic, freedom
        Chi-squared by as many directions.
    p
        Probability of as much by noise, over all tests together.
    """

    quantity: str
    statistic: float
    freedom: int
    p: float


def noise_spread(fitted: Fit) -> Spread:
    """Noise as a careful campaign has it: no more than the fit found, and no more than the gauge and the book allow."""
    found, data = fitted.spread, fitted.readings
    guess = min(found.gauge, data.reference) if data.reference_known else found.gauge
    initial = found.initial if data.thickness_free else min(found.initial, data.reference)
    return Spread(
        data.gauge or guess, found.zero, initial, min(found.scatter, CAREFUL_SCATTER),
        min(found.book, BOOK_PRIOR), min(found.scale, SCALE_PRIOR), min(found.smooth, CAREFUL_SCATTER), found.warp,
        min(found.shift, SHIFT_PRIOR), min(found.bend, CAREFUL_SCATTER),
    )  # fmt: skip


def noise_tests(fitted: Fit) -> tuple[NoiseTest, ...]:
    """A test for each quantity that the survey knows; the smallest p first."""
    data = fitted.readings
    spread = noise_spread(fitted)
    plain = fit(replace(data, gauge=spread.gauge)) if not fitted.suspects else fitted
    found = disturbance(data.survey, data.past, plain.depth, data.reference, data.thickness_free)
    root = covariance(found, spread).root()

    def white(coordinate: np.ndarray, suspects: tuple) -> np.ndarray:
        return root @ data.left(depths(data.past, model_at(data, suspects, coordinate)))

    own = white(plain.coordinate, plain.suspects)
    tangent = []
    for i in range(len(plain.coordinate)):
        step = np.zeros(len(plain.coordinate))
        step[i] = 1e-3
        tangent.append((white(plain.coordinate + step, plain.suspects) - own) / 1e-3)
    basis = np.linalg.qr(np.stack(tangent, axis=1))[0]
    left = own - basis @ (basis.T @ own)
    all_curves = curves(data.past, data.depth_knots)
    tests = []
    for curve in all_curves:
        change = []
        for i in range(len(curve.free)):
            coordinate = np.concatenate([plain.coordinate, np.zeros(len(curve.free))])
            coordinate[len(plain.coordinate) + i] = 0.05
            change.append(white(coordinate, (*plain.suspects, curve)) - own)
        direction = np.stack(change, axis=1)
        direction -= basis @ (basis.T @ direction)
        u, s, _ = np.linalg.svd(direction, full_matrices=False)
        u = u[:, s > 1e-6 * max(s[0], 1e-300)] if s[0] > 1e-9 else u[:, :0]
        statistic = float(np.sum((u.T @ left) ** 2))
        p = float(chi2.sf(statistic, u.shape[1])) if u.shape[1] else 1.0
        tests.append(NoiseTest(curve.quantity, statistic, u.shape[1], min(1.0, p * len(all_curves))))
    return tuple(sorted(tests, key=lambda test: test.p))
