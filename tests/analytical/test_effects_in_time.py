"""Effects integrated along the history of a point, against closed forms of d(depth)/d(progress) = k x factor."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from wearfem.wear import effects
from wearfem.wear.effect import all_factors

K, END = 1e-9, 2e7  # [m/kg] and [kg]: 20 mm without effects
LOADS = {"impact_work": 0.0}


def worn(*acting, exposure=1.0):
    """Depth [m] after END / exposure, integrated; the energy of impacts grows by 1 J/m2 with each kg."""

    def slope(mass, depth):
        known = {"depth": depth, "throughput": mass, "impact_work": mass}
        return K * exposure * all_factors(acting, known)

    end = END / exposure
    path = solve_ivp(slope, (0.0, end), [0.0], rtol=1e-10, atol=1e-14, max_step=end / 2000.0)
    return float(path.y[0, -1])


G, A, D, M, T1 = 20.0, 1.5, 4e-3, 3e6, 5e6
KM = K * END
B = 1.0 - 0.4


@pytest.mark.parametrize(
    ("effect", "expected"),
    [
        # d - g d^2 / 2 = k M
        (effects.HardnessGradient(G, core=0.01), (1.0 - math.sqrt(1.0 - 2.0 * G * KM)) / G),
        # exp(d/d0) = (1 + A) exp(k M / d0) - A
        (effects.RunningIn(A, D), D * math.log((1.0 + A) * math.exp(KM / D) - A)),
        # d = k (M + A M0 (1 - exp(-M/M0)))
        (effects.RunningInByThroughput(A, M), K * (END + A * M * -math.expm1(-END / M))),
        # with b = 1 - g: exp(d/d0) = (exp(b k M / d0) - g) / b
        (effects.WorkHardeningByDepth(0.4, D), D * math.log((math.exp(B * KM / D) - 0.4) / B)),
        # w = M x 1 J/m2 per kg: d = k (M - g (M - w0 (1 - exp(-M/w0))))
        (effects.WorkHardening(0.4, M), K * (END - 0.4 * (END - M * -math.expm1(-END / M)))),
        # two straight lines
        (effects.OreChange((T1,), (1.7,)), K * (T1 + 1.7 * (END - T1))),
        (effects.Overlay(6e-3, 2.5), 6e-3 + 2.5 * (KM - 6e-3)),
    ],
    ids=lambda x: type(x).__name__ if not isinstance(x, float) else "",
)
def test_closed_form(effect, expected):
    # 1e-9 by the integrator where the factor is smooth; where it jumps, part of one step of 1/2000 in error control
    jumps = isinstance(effect, effects.OreChange | effects.Overlay)
    assert worn(effect) == pytest.approx(expected, rel=1e-5 if jumps else 1e-8)


def test_depth_is_a_clock_of_its_own():
    """Twice the exposure for half the mass gives the same depth by an effect of depth, and another by one of throughput."""
    by_depth, by_mass = effects.RunningIn(A, D), effects.RunningInByThroughput(A, M)
    assert worn(by_depth, exposure=2.0) == pytest.approx(
        worn(by_depth), rel=1e-8
    )  # the integrator's tolerance
    # k e (M/e + A M0 (1 - exp(-M/(e M0)))) with e = 2
    expected = K * (END + 2.0 * A * M * -math.expm1(-END / (2.0 * M)))
    assert worn(by_mass, exposure=2.0) == pytest.approx(expected, rel=1e-8)


def test_running_in_and_hardening_by_depth_are_one_curve():
    """1 - g (1 - exp(-d/d0)) is (1 - g) [1 + g/(1 - g) exp(-d/d0)]: nobody can tell them apart by depth."""
    depth = np.linspace(0.0, 0.02, 50)
    hardening = effects.WorkHardeningByDepth(0.4, D).factor(depth=depth)
    running_in = effects.RunningIn(0.4 / 0.6, D).factor(depth=depth)
    np.testing.assert_allclose(hardening, 0.6 * running_in, rtol=1e-14)  # rounding
