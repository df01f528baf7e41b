"""The least of noisy lives beside the least of the true ones."""

import numpy as np
import pytest

from wearfem.wear.first_failure import without_noise


def least(true, noise, draws=200):
    """Mean least life as told, and as the noisy lives have it"""
    random = np.random.default_rng(7)
    told, raw = [], []
    for _ in range(draws):
        noisy = true + noise * random.normal(size=len(true))
        told.append(without_noise(noisy, 1.0, noise**2, len(true)).time.min())
        raw.append(noisy.min())
    return np.mean(told), np.mean(raw)


def test_equal_lives_are_told_as_their_mean():
    told, raw = least(np.full(64, 100.0), 1.0)
    assert raw < 97.8  # expected least of 64 normal numbers: 2.35 deviations below their mean
    # weights of the eighth power lower the mean by 8 noise^2 / life = 0.08; chance is taken for spread in some draws
    assert told == pytest.approx(100.0, abs=0.4)


def test_lives_far_apart_stay():
    true = np.linspace(100.0, 160.0, 64)
    told, _ = least(true, 0.1)
    assert told == pytest.approx(100.0, abs=0.1)  # one deviation of the noise


def test_a_facet_that_never_fails_never_does():
    ensemble = without_noise(np.array([10.0, 10.1, np.inf]), 1.0, 1.0, 3.0)
    assert np.isinf(ensemble.time[2])
    assert np.isfinite(ensemble.time[:2]).all()
    assert ensemble.kept == 0.0  # a spread of 0.1 beside a noise of 1 is none


def test_without_noise_nothing_is_drawn_in():
    time = np.array([10.0, 12.0, 15.0])
    ensemble = without_noise(time, 1.0, 0.0, 3.0)
    assert (ensemble.time == time).all()
    assert ensemble.doubt == 0.0
