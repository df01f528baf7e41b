"""The jump: its bounds, its words, and that it changes nothing that it is given."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.wear.jump import Bounds, Goal, choose_jump, end_of_life, is_trusted
from wearfem.wear.sampling import Sample, corrected_depth

RATE = 1e-9  # [m/s]
GOAL = Goal(np.array([0.01, 0.01]))  # 1e7 s at RATE
EXACT = 1e-12  # relative: a few roundings


def sample(time, rate, blocks=80, noise=0.0, seed=0, warm_up=2.0):
    random = np.random.default_rng(seed)
    rows = np.asarray(rate) * (1.0 + noise * random.normal(size=(blocks, 2)))
    return Sample(time, rows, 0.25, warm_up)


STEADY = sample(0.0, [RATE, 0.5 * RATE])
NOTHING = np.zeros(2)


@pytest.mark.parametrize(
    ("bounds", "name", "duration"),
    [
        (Bounds(edge_length=np.array([1e-3, 1e-4])), "edge length", 5e4),  # 1e-4 / 4 at 0.5e-9 m/s
        (Bounds(particle_radius=4e-4), "particle radius", 1e5),  # 4e-4 / 4 at 1e-9 m/s
        (Bounds(curvature=np.array([1.0, 1000.0])), "curvature", 5e5),  # 1e-3 / 4 at 0.5e-9 m/s
    ],
)
def test_lengths(bounds, name, duration):
    jump = choose_jump([STEADY], NOTHING, GOAL, bounds)
    assert jump.limited_by == name
    # equal parts of what is left are taken, so a jump may be shorter by one part in their number (20 at least)
    assert duration * 20 / 21 <= jump.duration <= duration * (1 + EXACT)
    np.testing.assert_allclose(jump.recession, jump.duration * STEADY.mean, rtol=EXACT)
    assert jump.acceleration == pytest.approx(jump.duration / 22.0, rel=EXACT)


def test_asked_and_growth():
    assert choose_jump([STEADY], NOTHING, GOAL, at_most=1e5).limited_by == "asked"
    stopped = choose_jump([STEADY], NOTHING, GOAL, stop=1.7e5)  # no even part of the life
    assert (stopped.limited_by, stopped.duration) == ("asked", 1.7e5)
    assert choose_jump([STEADY], NOTHING, GOAL, at_most=1e5, stop=1.7e5).duration == 0.85e5
    second = sample(1e4, [RATE, 0.5 * RATE])
    jump = choose_jump(
        [STEADY, second, sample(2e4, [RATE, 0.5 * RATE])], corrected_depth([STEADY, second]), GOAL
    )
    assert jump.limited_by == "growth"
    assert jump.duration <= 2e4 * (1.0 + 1e-8)  # the number of equal parts is rounded with 1e-9


def test_noise_lengthens_the_sample_and_not_the_jump():
    noisy = sample(0.0, [RATE, 0.5 * RATE], blocks=30, noise=1.0)
    jump = choose_jump([noisy], NOTHING, GOAL)
    assert (jump.limited_by, jump.duration) == ("noise", 0.0)
    assert jump.window > noisy.window
    assert (jump.recession == 0.0).all()
    enough = sample(0.0, [RATE, 0.5 * RATE], blocks=int(8 * jump.window), noise=1.0)
    assert choose_jump([enough], NOTHING, GOAL).limited_by == "jump error"


def test_sampling_grows_with_the_square_of_noise():
    jumps = [
        choose_jump([sample(0.0, [RATE, 0.5 * RATE], 8000, noise)], NOTHING, GOAL) for noise in (0.4, 0.8)
    ]
    part = [
        jump.window / jump.duration for jump in jumps
    ]  # the number of jumps grows too, as warm-ups get cheap beside samples
    # the split between bias and noise moves a little as samples get dearer; each noise is known to 1 / sqrt(8000)
    assert part[1] / part[0] == pytest.approx(4.0, rel=0.15)


def test_a_constant_rate_is_exact():
    later = sample(4e6, [RATE, 0.5 * RATE])
    np.testing.assert_allclose(corrected_depth([STEADY, later]), [4e-3, 2e-3], rtol=EXACT)
    life = end_of_life([STEADY, later], GOAL)
    assert (life.time, life.facet) == (pytest.approx(1e7, rel=EXACT), 0)
    assert life.error() == pytest.approx(0.0, abs=1.0)  # [s] rounding of 1e7


def test_a_rate_linear_in_time_is_exact():
    """The trapezoid rule has no error there: r = r0 (1 + t / 1e7), life = 1e7 (sqrt(3) - 1)."""
    samples = [sample(t, [RATE * (1 + t / 1e7), 1e-3 * RATE]) for t in (0.0, 3e6, 5e6, 9e6)]
    assert end_of_life(samples, GOAL).time == pytest.approx(1e7 * (np.sqrt(3.0) - 1.0), rel=EXACT)


def test_what_the_mesh_refused_is_made_good():
    first = choose_jump([STEADY], NOTHING, GOAL, at_most=1e6)
    samples = [STEADY, sample(first.duration, [RATE, 0.5 * RATE])]
    whole = choose_jump(samples, first.recession, GOAL, at_most=1e6)
    half = choose_jump(samples, 0.5 * first.recession, GOAL, at_most=1e6)
    np.testing.assert_allclose(
        half.recession - whole.recession, 0.5 * first.recession, rtol=1e-9
    )  # differences
    ahead = choose_jump(samples, 10.0 * first.recession, GOAL, at_most=1e6)
    assert (ahead.recession == 0.0).all()  # a surface never grows back


def test_a_sudden_change_is_refused_and_leaves_no_trace():
    calm = (STEADY, sample(1e6, [RATE, 0.5 * RATE]), sample(2e6, [RATE, 0.5 * RATE]))
    sudden = (*calm[:2], sample(2e6, [3 * RATE, 1.5 * RATE]))
    copy = [s.rate.copy() for s in sudden]
    before = choose_jump(sudden[:2], corrected_depth(sudden[:2]), GOAL)
    assert is_trusted(calm, GOAL)
    assert not is_trusted(sudden, GOAL)
    after = choose_jump(sudden[:2], corrected_depth(sudden[:2]), GOAL)
    assert replace(before, recession=None) == replace(after, recession=None)
    assert (before.recession == after.recession).all()
    assert all((a == s.rate).all() for a, s in zip(copy, sudden, strict=True))


def test_noise_is_not_taken_for_a_sudden_change():
    """Sampling variance is subtracted: of jumps over a constant rate, few are refused (three deviations: 0.3 %)."""
    refused = 0
    for seed in range(100):
        samples = [sample(i * 1e6, [RATE, 0.5 * RATE], 40, 0.3, 10 * seed + i) for i in range(3)]
        refused += not is_trusted(samples, GOAL)
    assert refused <= 4  # the noise itself is known to a fifth only, which widens the tails


def test_bad_goals():
    with pytest.raises(UserError, match="parts of 1"):
        Goal(np.array([0.01]), tolerance=2.0)
    with pytest.raises(UserError, match="above 0 m"):
        Goal(np.array([0.0, 0.01]))
    with pytest.raises(UserError, match="no facet"):
        choose_jump([sample(0.0, [0.0, 0.0])], NOTHING, GOAL)
