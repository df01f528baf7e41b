"""Forecasts of lives that are known, what the draws are made of, and what a change costs: beside closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wearfem.case import Stop
from wearfem.costs import Prices, costs
from wearfem.cycle import worn_to
from wearfem.errors import UserError
from wearfem.forecast import WHOLE, Known, forecast, thickness_at_stress
from wearfem.proofs.cycle import ALLOWED, QUIET, RATE, lived, plate
from wearfem.proofs.forecast import Feedback
from wearfem.units import MPa, day, mm
from wearfem.wear.sampling import Sample
from wearfem.wear.trend import FINE, Course, Draws, Noise, ratio_courses, zone_courses

CASES = Path(__file__).parents[2] / "cases"


def so_far(law, stop, **settings):
    """A plate without noise after some service, and the module with its closed forms."""
    case, formulas = plate(law=law, tolerance=1e-2, **{**QUIET, **settings})
    return case, lived(replace(case, stop=Stop(stop))), formulas


@pytest.fixture(scope="module")
def constant():
    return so_far("constant", 40 * day)


@pytest.fixture(scope="module")
def two_zones():
    """A plate of which the right half is worn twice as fast, without noise; nothing moves."""
    case, _ = plate(law="constant", **QUIET)
    mesh = case.liner.mesh
    right = mesh.node[mesh.wear].mean(axis=1)[:, 0] > 0.1
    mesh = replace(mesh, group={**mesh.group, "left": mesh.wear[~right], "right": mesh.wear[right]})
    liner = replace(case.liner, mesh=mesh)
    flow = replace(
        case.sampler, intensity=lambda surface: np.where(right[surface.facet], 2.0, 1.0)[: len(right)]
    )
    case = replace(
        case, liner=liner, goal=worn_to(liner, 10 * mm), sampler=flow, frozen=True, longest_jump=1e6
    )
    return lived(replace(case, stop=Stop(2.5e6)))


def test_a_rate_that_stays_is_told_to_stay(constant):
    case, history, _ = constant
    to_limit, through = forecast(history, case=case).zone
    assert (to_limit.zone, through.until) == (WHOLE, "breakthrough")
    for life, depth in ((to_limit, ALLOWED), (through, 20 * mm)):
        # closed form: depth over rate; without noise the straight line and the frozen geometry are right as well, to rounding
        assert life.quantile[1] == pytest.approx(
            depth / RATE, rel=2e-3
        )  # what 3 and more exact samples leave open
        assert life.straight_line == pytest.approx(depth / RATE, rel=1e-9)
        assert life.frozen == pytest.approx(depth / RATE, rel=1e-9)
        assert sum(life.share.values()) == pytest.approx(1.0)


@pytest.mark.parametrize("law", ["hardness_gradient", "running_in"])
def test_the_effects_of_the_case_go_on_as_they_are_known_to(law):
    case, history, formulas = so_far(law, 30 * day)
    known, unknown = (forecast(history, case=one).zone[0] for one in (case, None))
    end = formulas.life(law, ALLOWED, RATE)
    assert known.quantile[1] == pytest.approx(end, rel=3e-3)  # 1 % asked of the jumps, half of it by bias
    assert known.quantile[2] - known.quantile[0] < 0.01 * end < unknown.quantile[2] - unknown.quantile[0]
    assert abs(known.straight_line / end - 1.0) > 0.05  # the effect is there to be seen


def test_each_zone_has_its_own_life(two_zones):
    told = {zone.zone: zone for zone in forecast(two_zones, limit=12 * mm).zone if zone.until == "12 mm left"}
    assert list(told) == [WHOLE, "left", "right"]
    for name, rate in (("left", RATE), ("right", 2.0 * RATE), (WHOLE, 2.0 * RATE)):
        assert told[name].quantile[1] == pytest.approx(8 * mm / rate, rel=2e-3)  # 20 mm less 12 over the rate
        assert told[name].probability_to_reach(8 * mm / RATE * 0.9) == (1.0 if name == "left" else 0.0)


def test_doubt_of_the_coefficient_is_a_lognormal(constant):
    case, history, _ = constant
    life = forecast(history, known=Known(coefficient_error=0.1, mesh_error=0.0), case=case, draws=4000).zone[
        0
    ]
    low, middle, high = life.quantile
    # 1.2816 deviations to 90 %; a quantile of 2000 draws is known to 0.1 sqrt(0.09 / 2000) / 0.1755 = 0.4 %, three of these
    assert np.log([low / middle, high / middle]) == pytest.approx([-0.12816, 0.12816], abs=0.012)
    assert life.share["wear coefficient"] > 0.99
    assert forecast(history, case=case).left_out == ("the wear coefficient", "the mesh")
    assert forecast(history, known=Known(0.1, 0.0), case=case).left_out == ()


def test_the_same_seed_gives_the_same_lives(constant):
    case, history, _ = constant
    one, two, other = (forecast(history, case=case, seed=seed).zone[0].draw for seed in (1, 1, 2))
    assert np.array_equal(one, two) and not np.array_equal(one, other)


@pytest.mark.parametrize(
    ("wish", "sentence"),
    [
        (
            {"limit": 19 * mm},
            "the limit is 19 mm, and the least thickness left is 16.54 mm: give a limit of 0 mm",
        ),
        ({"limit": -1 * mm}, "the limit is -1 mm"),
        ({"stress_limit": 100 * MPa}, "0 cycles tell a stress: 3 are needed"),
    ],
)
def test_wishes_that_make_no_sense(constant, wish, sentence):
    case, history, _ = constant
    with pytest.raises(UserError, match=sentence):
        forecast(history, **wish, case=case)


def test_one_cycle_is_too_few():
    case, _ = plate(law="constant", **QUIET)
    from wearfem.cycle import cycle, first_state
    from wearfem.history import history_of

    state, report = cycle(case, first_state(case))
    with pytest.raises(UserError, match="asked of 1 cycle, and two that were kept are needed"):
        forecast(history_of(state, (report,)), case=case)


@pytest.mark.parametrize("error", [-0.1, 1.0, float("nan")])
def test_doubts_are_parts(error):
    with pytest.raises(UserError, match="as a part of 1, such as 0.1 for 10 %"):
        Known(coefficient_error=error)


# Stress


def test_stress_that_follows_a_power_is_found_again():
    thickness = np.array([20.0, 18.0, 15.0, 13.0]) * mm
    stress = 50 * MPa * (20 * mm / thickness) ** 2  # bending
    at = thickness_at_stress(thickness, stress, 200 * MPa, np.random.default_rng(0), 50)
    assert at == pytest.approx(10 * mm, rel=1e-6)  # half the thickness, four times the stress; rounding
    falling = 50 * MPa * thickness / (20 * mm)
    assert (
        thickness_at_stress(thickness, falling, 400 * MPa, np.random.default_rng(0), 50) == 0.0
    ).all()  # never
    with pytest.raises(UserError, match="the last cycle had 118.3 MPa: give a limit above it"):
        thickness_at_stress(thickness, stress, 100 * MPa, np.random.default_rng(0), 50)


def test_noisy_stresses_are_told_with_their_doubt():
    random, inside = np.random.default_rng(7), 0
    thickness = np.linspace(20.0, 14.0, 8) * mm
    for _ in range(200):
        stress = 50 * MPa * (20 * mm / thickness) ** 2 * np.exp(0.05 * random.normal(size=8))
        at = thickness_at_stress(thickness, stress, 150 * MPa, random, 400)
        low, high = np.quantile(at, [0.1, 0.9])
        inside += low < 20 * mm / np.sqrt(3.0) < high
    # 80 % of 200 are 160, give or take 5.7: three of these
    assert 143 <= inside <= 177


def test_a_stress_limit_is_a_thickness(constant):
    case, history, _ = constant
    bending = replace(history, largest_von_mises=50 * MPa * (20 * mm / history.thickness.min(axis=1)) ** 2)
    told = {zone.until: zone for zone in forecast(bending, stress_limit=100 * MPa, case=case).zone}
    # twice the stress at 20 mm / sqrt(2): 5.858 mm at the rate of the plate; what exact samples leave open
    end = (1.0 - 0.5**0.5) * 20 * mm / RATE
    assert told["100 MPa von Mises"].quantile[1] == pytest.approx(end, rel=3e-3)
    assert told["100 MPa von Mises"].straight_line == pytest.approx(end, rel=1e-6)


# What draws are made of


def test_a_course_given_its_samples_is_the_textbook_gaussian():
    u, y, variance = np.array([0.0, 0.1, 0.3]), np.array([0.0, 0.1, 0.15]), np.array([0.01, 0.02, 0.01])
    course, count = Course(1.0, 0.7, 2.0), 20000
    draws = Draws.of(course, np.ones(1), u, y[:, None], variance, FINE, np.random.default_rng(3), count)
    value = draws.value(unseen=True, noise=True)[:, :, 0]
    # another route: the joint precision of grid and samples, its block of the grid inverted
    both = np.concatenate([FINE[1:], u])
    joint = course.covariance(both, both)
    joint[-3:, -3:] += np.diag(variance)
    covariance = joint[:-3, :-3] - joint[:-3, -3:] @ np.linalg.inv(joint[-3:, -3:]) @ joint[-3:, :-3]
    mean = joint[:-3, -3:] @ np.linalg.inv(joint[-3:, -3:]) @ y
    assert draws.mean[0, 1:, 0] == pytest.approx(mean, abs=1e-9)
    spread = np.sqrt(np.diag(covariance))
    # means and deviations of 20000 draws are known to 0.7 % and 0.5 % of a deviation: five of these
    assert np.abs(value.mean(axis=0)[1:] - mean).max() < 0.035 * spread.max()
    assert value.std(axis=0)[1:] == pytest.approx(spread, rel=0.025)


def test_a_course_is_the_integral_of_a_slope_that_is_forgotten():
    course = Course(0.0, 0.8, 0.5)
    # another route: the double sum of slope^2 exp(-|u - v| / l) over a fine grid
    at = (np.arange(400) + 0.5) * 1e-3
    slope = 0.8**2 * np.exp(-np.abs(at[:, None] - at[None, :]) / 0.5)
    double = 1e-6 * np.cumsum(np.cumsum(slope, axis=0), axis=1)
    found = course.covariance(np.array([0.2, 0.4]), np.array([0.3, 0.4]))
    assert found == pytest.approx(double[np.ix_([199, 399], [299, 399])], rel=1e-4)  # midpoint rule on 1e-3


def test_equal_facets_with_noise_are_taken_for_equal():
    random, facets, samples = np.random.default_rng(5), 36, 4
    u, window = np.linspace(0.0, 0.3, samples), np.full(samples, 10.0)
    density = 0.1 * np.eye(facets)
    place = np.stack(np.meshgrid(range(6), range(6), [0]), axis=-1).reshape(-1, 3).astype(float)
    noise = np.sqrt(0.1 / window)[:, None] * random.normal(size=(samples, facets))
    draws = ratio_courses(u, noise, window, density, place, random, 400)
    naive = noise.mean(axis=0).std()
    assert draws.value(unseen=True, noise=True)[:, 0].std() < 0.5 * naive
    # facets that differ by ten times their noise keep what they were sampled to be
    differ = 0.5 * random.normal(size=facets)
    draws = ratio_courses(u, noise + differ, window, density, place, random, 400)
    assert draws.mean[:, 0].mean(axis=0) == pytest.approx(
        differ, abs=4.0 * 0.05
    )  # noise of a mean of four is 0.05


def test_the_noise_of_samples_is_the_one_they_were_made_with():
    random, blocks, facets = np.random.default_rng(8), 100, 5
    common, own = 0.1, 0.2
    weight, zone, ratio = np.full(facets, 0.2), [], []
    for _ in range(20):
        samples = []
        for _ in range(5):
            unit = common * random.normal(size=(blocks, 1)) + own * random.normal(size=(blocks, facets))
            samples.append(Sample(0.0, RATE * (1 + unit), 0.5))
        noise = Noise.seen_in(samples, np.arange(facets), weight)
        zone.append(noise.zone)
        ratio.append(np.diag(noise.ratio).mean())
    # variance times length of a block: 0.5 s (0.1^2 + 0.2^2 / 5), and 0.5 s 0.2^2 (1 - 1/5) of a ratio. The correlation of blocks is
    # found from them and never below none, so independent ones are told too noisy, never too quiet: by at most a quarter
    assert 0.95 < np.mean(zone) / (0.5 * (0.01 + 0.04 / 5)) < 1.25
    assert 0.95 < np.mean(ratio) / (0.5 * 0.04 * 0.8) < 1.25


def test_a_rate_that_was_seen_to_stay_is_doubted_less_with_every_sample():
    random = np.random.default_rng(2)
    spread = []
    for count in (2, 4, 8):
        u = np.linspace(0.0, 0.5, count)
        draws = zone_courses(u, np.zeros(count), np.full(count, 1e-4), 100.0, random, 2000)
        spread.append(draws.value(unseen=True, noise=True)[:, 40, 0].std())
    assert spread[0] > spread[1] > spread[2]


# Costs


def test_age_replacement_of_exponential_lives_is_the_closed_form():
    theta, prices = 100 * day, Prices(1000.0, 3000.0)
    lives = theta * np.random.default_rng(1).exponential(size=200_000)
    at = np.array([30.0, 100.0]) * day
    told = costs(lives, prices, at)
    fails = 1.0 - np.exp(-at / theta)
    closed = (1000.0 * (1.0 - fails) + 4000.0 * fails) / (theta * fails)
    assert told.rate == pytest.approx(closed, rel=0.01)  # 200000 draws: 0.2 %, five of these
    assert told.to_the_end == pytest.approx(4000.0 / theta, rel=0.01)
    assert costs(lives, prices).best == np.inf  # without memory there is nothing to plan


def test_a_life_that_is_sure_is_changed_just_before_its_end():
    lives = np.full(100, 50 * day)
    told = costs(lives, Prices(100.0, 900.0, 10.0, 5.0, 20.0, "EUR"), np.array([25.0, 49.0, 51.0]) * day)
    # 100 + 10 x 5 planned, 100 + 900 + 10 x 20 unplanned
    assert told.rate * day == pytest.approx([150.0 / 25.0, 150.0 / 49.0, 1200.0 / 50.0])
    assert told.best == 49 * day


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"liner": -1.0}, "the price of a liner was given as -1: it must be 0 or more"),
        ({"liner": 1.0, "standing_hour": 5.0}, "together with at least one of the two times"),
        ({"liner": 1.0, "unplanned_hours": 5.0}, "together with at least one of the two times"),
        ({"liner": float("inf")}, "must be 0 or more"),
    ],
)
def test_prices_that_make_no_sense(given, sentence):
    with pytest.raises(UserError, match=sentence):
        Prices(**given)


def test_a_feedback_is_what_its_formula_says():
    case, _ = plate(law="constant", **QUIET)
    from wearfem.liner.liner import wear_surface

    surface = wear_surface(case.liner)
    sunk = replace(surface, point=surface.point - np.array([0.0, 0.0, 5 * mm]))
    told = Feedback(rise=1.0, power=2.0, bulge=0.5)(sunk)
    assert told == pytest.approx(1.0 + 0.25 + 0.5)  # half of the depth allowed


def test_the_noise_of_short_samples_is_told_in_full():
    """Eight blocks with a memory of 0.5 do not show it by themselves: with a first sample of forty they are told its noise."""
    random, facets = np.random.default_rng(11), 16
    found = []
    for _ in range(30):
        samples = []
        for blocks in (40, 8, 8, 8, 8):
            wander = random.normal(size=facets)
            rows = np.empty((blocks, facets))
            for row in rows:
                wander = 0.5 * wander + np.sqrt(0.75) * random.normal(size=facets)
                row[:] = RATE * (1.0 + 0.2 * wander)
            samples.append(Sample(0.0, rows, 0.25))
        found.append(
            np.diag(Noise.seen_in(samples, np.arange(facets), np.full(facets, 1.0 / facets)).ratio).mean()
        )
    true = 3.0 * 0.25 * 0.2**2 * (1.0 - 1.0 / facets)  # (1 + 0.5) / (1 - 0.5) blocks tell as much as one
    # thirty runs of 72 blocks know the memory of 16 facets to some 5 %; from each sample by itself it was 0.69
    assert np.mean(found) == pytest.approx(true, rel=0.15)
