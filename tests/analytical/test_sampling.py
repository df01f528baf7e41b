"""The error of a mean of blocks with a known memory, and the end of a known warm-up."""

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.wear.sampling import (
    Sample,
    corrected_depth,
    depth_at,
    inefficiency,
    lag_products,
    noise_density,
    passage,
    standard_error,
    statistical_inefficiency,
    steady_from,
)


def remembering(blocks, columns, memory, seed):
    """An AR(1) series of unit variance."""
    random = np.random.default_rng(seed)
    x = random.normal(size=(blocks, columns))
    for i in range(1, blocks):
        x[i] = memory * x[i - 1] + np.sqrt(1.0 - memory**2) * x[i]
    return x


def true_error(blocks, memory):
    """Of the mean of n AR(1) values: sqrt((1 + 2 sum (1 - k/n) memory^k) / n)"""
    k = np.arange(1, blocks)
    return np.sqrt((1.0 + 2.0 * ((1.0 - k / blocks) * memory**k).sum()) / blocks)


@pytest.mark.parametrize(
    ("memory", "blocks", "tolerance"),
    [
        (0.0, 20, 0.05),  # 2000 columns settle the mean within 2 %; the rest is g >= 1
        (0.5, 50, 0.05),
        (0.5, 200, 0.05),
        (0.8, 200, 0.10),  # 20 correlation times
        (0.8, 20, 0.40),  # 2 correlation times: too small by a quarter, as the docstring warns
    ],
)
def test_error_of_the_mean(memory, blocks, tolerance):
    errors = [standard_error(remembering(blocks, 100, memory, seed)).mean() for seed in range(20)]
    assert np.mean(errors) == pytest.approx(true_error(blocks, memory), rel=tolerance)


def test_inefficiency_of_a_long_series():
    # (1 + m) / (1 - m) = 3 for m = 0.5; 40000 values in all leave 3 %
    assert statistical_inefficiency(remembering(2000, 20, 0.5, 3)) == pytest.approx(3.0, rel=0.1)


def test_equal_blocks_have_no_error():
    assert (standard_error(np.full((6, 3), 0.1)) == 0.0).all() or standard_error(
        np.full((6, 3), 0.1)
    ).max() < 1e-16


def test_units_do_not_matter():
    x = 1.0 + 0.1 * remembering(40, 5, 0.5, 1)
    np.testing.assert_allclose(standard_error(1e-9 * x), 1e-9 * standard_error(x), rtol=1e-12)  # rounding
    assert steady_from(1e-9 * x[:, 0]) == steady_from(x[:, 0])


@pytest.mark.parametrize(("delay", "height"), [(5, 5.0), (20, 3.0)])
def test_warm_up_is_found(delay, height):
    """Better than nothing by half, and never far beyond the warm-up for most."""
    blocks, starts, left, all_of_it = 200, [], [], []
    for seed in range(60):
        series = remembering(blocks, 1, 0.3, seed)[:, 0] + height * np.exp(-np.arange(blocks) / delay)
        starts.append(steady_from(series))
        left.append(series[starts[-1] :].mean())
        all_of_it.append(series.mean())
    assert delay * 0.5 < np.median(starts) < delay * 4.0  # e^-4 of the height is below the noise of a block
    # noise alone: sqrt(1.86 / 200) = 0.1, so a bias of 0.13 and 0.30 is cut to about noise
    assert np.sqrt(np.mean(np.square(left))) < 0.75 * np.sqrt(np.mean(np.square(all_of_it)))


def test_steady_from_the_start():
    assert steady_from(np.ones(50)) == 0
    assert steady_from(np.arange(5.0)) == 0  # too short to tell
    starts = [steady_from(remembering(200, 1, 0.0, seed)[:, 0]) for seed in range(40)]
    assert np.median(starts) <= 20  # a tenth is lost for nothing, at most, by half of the series


@pytest.mark.parametrize("rate", [np.ones((3, 2)), np.ones(8), np.full((8, 2), np.nan)])
def test_bad_samples(rate):
    with pytest.raises(UserError):
        Sample(0.0, rate, 0.25)
    with pytest.raises(UserError, match="above 0"):
        Sample(0.0, np.ones((8, 2)), 0.0)


def test_inefficiency_of_many_short_windows():
    """400 windows of 12 blocks, four correlation times each, beside the closed form"""
    windows = [lag_products(remembering(12, 1, 0.5, seed)) for seed in range(400)]
    true = 12.0 * true_error(12, 0.5) ** 2
    # sums end at lag 5, which leaves out 1 %; the scatter of 4800 values is 5 %; three rounds leave some of what the mean takes away
    assert inefficiency(windows) == pytest.approx(true, rel=0.15)


def test_noise_density_of_many_windows():
    """Variance of a mean times its length, 3 blocks for a memory of 0.5"""
    rows = [remembering(20, 1, 0.5, seed) for seed in range(300)]
    squares = sum(float(np.square(row - row.mean()).sum()) for row in rows)
    density = noise_density([lag_products(row) for row in rows], squares, 0.25)
    assert density == pytest.approx(0.75, rel=0.15)  # 6000 values: 5 %


def test_the_liner_came_through_a_shape_when_the_rates_bring_it_there():
    """r = 1 + t / 10, d = t + t^2 / 20: the trapezoid rule is exact, whatever the service times say of the shapes."""
    true = np.array([0.0, 2.0, 5.0, 9.0])
    rates = [np.full((8, 2), [1.0 + t / 10.0, 2.0 + t / 5.0]) for t in true]
    depth = [np.array([1.0, 2.0]) * (t + t**2 / 20.0) for t in true]
    told = np.array([0.0, 2.2, 4.5, 9.9])  # where the jumps were to bring it
    samples = [Sample(t, rate, 0.25, depth=d) for t, rate, d in zip(told, rates, depth, strict=True)]
    time, passed = passage(samples)
    assert time == pytest.approx(true, rel=1e-12) and passed == pytest.approx(
        np.array(depth), rel=1e-12
    )  # rounding
    # at its service time 9.9 the liner is 0.9 past the last shape, at its rate of 1.9
    assert corrected_depth(samples)[0] == pytest.approx(9.0 + 81.0 / 20.0 + 0.9 * 1.9, rel=1e-12)
    for t in (0.0, 0.7, 2.0, 3.3, 9.0):  # a rate that is a straight line in time is met between shapes too
        assert depth_at(samples, t) == pytest.approx(np.array([1.0, 2.0]) * (t + t**2 / 20.0), rel=1e-12)
    assert depth_at(samples, 9.9)[0] == pytest.approx(
        9.0 + 81.0 / 20.0 + 0.9 * 1.9, rel=1e-12
    )  # the last rate stays
    assert depth_at(samples[:1], 2.0)[0] == pytest.approx(2.0, rel=1e-12)
    without = [Sample(t, rate, 0.25) for t, rate in zip(told, rates, strict=True)]
    assert np.array_equal(passage(without)[0], told)


def test_noise_does_not_make_the_passage_late_or_early():
    """Equal jumps of 1 s by the noisy rates themselves, noise 10 %: ten of them take 10 s in the mean."""
    random, ends = np.random.default_rng(4), []
    for _ in range(400):
        rate = 1.0 + 0.1 * random.normal(size=(11, 20))
        depth = np.vstack([np.zeros(20), np.cumsum(rate[:-1], axis=0)])
        samples = [
            Sample(float(n), np.tile(r, (8, 1)), 0.25, depth=d)
            for n, (r, d) in enumerate(zip(rate, depth, strict=True))
        ]
        ends.append(passage(samples)[0][-1])
    # one end scatters by 10 % / sqrt(20 facets) of the first and the last half jump: 0.016 s, the mean of 400 by 0.0008 s; three of these,
    # and a second order of noise of 0.1^2 / 20 / 11 per jump
    assert np.mean(ends) == pytest.approx(10.0, abs=0.0024 + 10.0 * 0.1**2 / 20.0)
