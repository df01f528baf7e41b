"""Wear integrated along the life of plates, beside closed forms; nuisances beside dense matrices."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.survey.history import History, Model, depths
from wearfem.survey.nuisance import (
    Disturbance,
    Spread,
    covariance,
    fit_spread,
    log_likelihood,
    log_prior,
    nuisances,
)
from wearfem.wear.effects import (
    Corrosion,
    HardnessGradient,
    OreChange,
    Overlay,
    RunningIn,
    RunningInByThroughput,
    Temperature,
)


def service(**feature):
    """Two plates exposed 1 and 3, read at 2, 5 and 9"""
    end = np.array([[2.0, 5.0, 9.0]] * 2)
    begin = np.array([[0.0, 2.0, 5.0]] * 2)
    exposure = np.array([[1.0] * 3, [3.0] * 3])
    index = np.array([[0, 1, 2]] * 2)
    return History(
        begin, end, np.zeros(2), exposure, feature, 10.0 * (end - begin), index, np.array([0]), np.array([0])
    )


PAST = service()
GROWN = 0.1 * np.array([1.0, 3.0])[:, None] * PAST.end


def test_hardness_that_falls():
    g = 0.15  # d' = e / (1 - g d): d - g d^2 / 2 = e M
    expected = (1.0 - np.sqrt(1.0 - 2.0 * g * GROWN)) / g
    got = depths(PAST, Model(0.1, (HardnessGradient(g, core=0.01),)))
    assert got == pytest.approx(expected, rel=2e-4)  # the table has 240 cells


def test_a_layer():
    got = depths(PAST, Model(0.1, (Overlay(0.7, 2.5),)))
    assert got == pytest.approx(
        np.where(GROWN < 0.7, GROWN, 0.7 + 2.5 * (GROWN - 0.7)), rel=1e-9
    )  # exact but for rounding


def test_running_in_by_depth():
    a, d0 = 1.5, 0.4  # d' = e (1 + a exp(-d/d0)): d + d0 ln((1 + a exp(-d/d0)) / (1 + a)) = e M
    got = depths(PAST, Model(0.1, (RunningIn(a, d0),)))
    assert got + d0 * np.log((1 + a * np.exp(-got / d0)) / (1 + a)) == pytest.approx(
        GROWN, rel=1e-3
    )  # table of 240 cells


def test_what_knows_the_date():
    got = depths(PAST, Model(0.1, (OreChange((3.3,), (2.0,)),)))
    length = PAST.end + np.maximum(PAST.end - 3.3, 0.0)
    assert got == pytest.approx(
        0.1 * np.array([[1.0], [3.0]]) * length, rel=1e-12
    )  # intervals are cut at the jump
    got = depths(PAST, Model(0.1, (RunningInByThroughput(1.5, 4.0),)))
    length = PAST.end + 1.5 * 4.0 * (1.0 - np.exp(-PAST.end / 4.0))
    assert got == pytest.approx(
        0.1 * np.array([[1.0], [3.0]]) * length, rel=1e-5
    )  # three Gauss points an interval


def test_a_log_and_corrosion():
    warm = np.array([[10.0, 20.0, 30.0]] * 2)
    past = service(temperature=warm)
    got = depths(past, Model(0.1, (Temperature(0.05, 10.0),), (Corrosion(2e-3),)))
    own = np.cumsum(np.exp(0.05 * (warm - 10.0)) * (past.end - past.begin), axis=1)
    assert got == pytest.approx(0.1 * np.array([[1.0], [3.0]]) * own + 2e-2 * past.end, rel=1e-12)  # rounding


def test_corrosion_beside_a_factor_of_depth():
    g, c = 0.15, 0.02  # checked against many small steps
    got = depths(PAST, Model(0.1, (HardnessGradient(g, core=0.01),), (Corrosion(c / 10.0),)))
    depth, steps = np.zeros(2), 90_000
    for _ in range(steps):
        depth = depth + 9.0 / steps * (0.1 * np.array([1.0, 3.0]) / (1 - g * depth) + c)
    assert got[:, -1] == pytest.approx(depth, rel=1e-4)  # explicit steps of 1e-4


def test_nuisances_beside_dense_matrices():
    rng = np.random.default_rng(3)
    n, q = 40, 20
    found = Disturbance(rng.normal(size=(n, q)), np.arange(q) % 10, np.arange(q), rng.uniform(0.5, 2.0, n))
    spread = Spread(0.3, 0.5, 0.2, 0.4, 0.6, 0.7, 0.35, 0.45, 0.55, 0.65)
    t2 = found.deviation(spread) ** 2
    dense = 0.09 * np.diag(found.weight) + (found.column * t2) @ found.column.T
    residual = rng.normal(size=n)
    c = covariance(found, spread)
    close = 1e-5  # a free new thickness has a variance 1e6 times the gauge's
    assert c.log_determinant == pytest.approx(np.linalg.slogdet(dense)[1], rel=close)
    assert c.square(residual) == pytest.approx(residual @ np.linalg.solve(dense, residual), rel=close)
    assert c.root().T @ c.root() @ dense == pytest.approx(np.eye(n), abs=close)
    value, deviation = nuisances(found, spread, residual)
    gain = t2[:, None] * found.column.T @ np.linalg.inv(dense)
    assert value == pytest.approx(gain @ residual, rel=1e-3, abs=1e-6)
    information = found.column.T @ (found.column / (0.09 * found.weight)[:, None]) + np.diag(1.0 / t2)
    assert deviation**2 == pytest.approx(np.diag(np.linalg.inv(information)), rel=1e-6)  # rounding, as above


def test_standard_deviations_are_the_most_probable():
    rng = np.random.default_rng(4)
    n, q = 120, 20
    column = np.zeros((n, q))
    column[np.arange(n), np.arange(n) % q] = 1.0
    found = Disturbance(column, np.zeros(q, int), np.arange(q), np.ones(n))
    residual = rng.normal(0, 0.1, n) + column @ rng.normal(0, 0.3, q)
    best = fit_spread(found, residual, Spread(0.1, 0.1, *(8 * [1e-4])), None, 0.1)

    def density(gauge, zero):
        s = replace(best, gauge=gauge, zero=zero)
        return log_likelihood(found, s, residual) + log_prior(s, None, 0.1)

    for factor in (0.97, 1.03):
        assert density(best.gauge, best.zero) > density(factor * best.gauge, best.zero)
        assert density(best.gauge, best.zero) > density(best.gauge, factor * best.zero)
    assert best.gauge == pytest.approx(0.1, rel=0.25)  # 100 degrees of freedom: 7 % standard error
