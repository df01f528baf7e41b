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
    # chance is taken for spread in some draws
    assert told == pytest.approx(100.0, abs=0.3)


def test_weights_that_are_noisy_do_not_lower_the_mean():
    """Equal lives with a noise of 4 %: weights of the eighth power alone lower their mean by 8 0.04^2 = 1.3 %."""
    random, told = np.random.default_rng(9), []
    for _ in range(400):
        found = without_noise(100.0 + 4.0 * random.normal(size=200), 1.0, 16.0, 200.0)
        told.append(found.time[np.isfinite(found.time)].max())  # drawn in towards the mean, all of them
    # the mean of a draw is known to 4 / sqrt(200) = 0.28, of 400 draws to 0.014; the second order of the weights is 0.04^2 of what is added
    assert np.median(told) == pytest.approx(100.0, abs=0.2)


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
