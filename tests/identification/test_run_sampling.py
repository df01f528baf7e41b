"""What a run has not seen of its own flow: its covariance by other routes, and a diagnosis that does not call it an effect."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.exposure import Foot, sampling
from wearfem.improve import coefficient_alone, own_sampling
from wearfem.survey.course import Course, Sampling, at_own_pace
from wearfem.survey.diagnose import diagnose
from wearfem.survey.history import Model, depths
from wearfem.survey.identify import readings, small_spread
from wearfem.survey.nuisance import SAMPLING, covariance, disturbance
from wearfem.survey.survey import read_survey
from wearfem.wear.effects import HardnessGradient
from wearfem.wear.sampling import Sample

POINTS, OCCASIONS, SAMPLES = 24, 7, 12
PLACE = np.linspace(0.0, 1.0, POINTS)  # [m]
SERVICE = np.linspace(0.0, 110.0, SAMPLES)  # [kt] of the samples
WINDOW = np.linspace(0.4, 0.8, SAMPLES)  # [s]
LIKE = np.exp(-0.5 * ((PLACE[:, None] - PLACE) / 0.1) ** 2)  # errors are alike over 0.1 m
DENSITY = (
    0.12**2 * 0.5 * (0.9 * LIKE + 0.1 * np.eye(POINTS))
)  # [s]: 12 % in half a second, 5 % of the depth in the end


def run(random=None, window=WINDOW):
    """A run whose rates fall as it wears, by 60 % and each in its own way; with errors of sampling, or exact. Per kt, in m"""
    rate = 1e-4 * (0.3 + PLACE[:, None]) * np.exp(-SERVICE / 120.0 * (0.5 + PLACE[:, None]))
    if random is not None:
        root = np.linalg.cholesky(DENSITY)
        rate = rate * (1.0 + root @ random.standard_normal((POINTS, SAMPLES)) / np.sqrt(window))
    part = np.broadcast_to(np.eye(SAMPLES), (POINTS, SAMPLES, SAMPLES))
    told = Sampling(DENSITY, window, part)
    return Course(SERVICE, rate, {}, np.zeros((POINTS, 3)), True, sampling=told)


def survey_along(folder, course, depth, random, sigma):
    """Readings of a plant whose depth (l, m) [m] is this, held against a course"""
    when = 100.0 * np.arange(1, OCCASIONS + 1) / OCCASIONS
    rows = ["point,occasion,tonnage_kt,depth_mm,sigma_mm,x_m,y_m,z_m"]
    deep = 1e3 * depth(np.tile(when, (POINTS, 1)))
    deep = deep + sigma * random.standard_normal(deep.shape)
    for j, tonnage in enumerate(when):
        rows += [f"P{i},{j},{tonnage},{deep[i, j]:.5f},{sigma},{x:.5f},0,0" for i, x in enumerate(PLACE)]
    (folder / "survey.csv").write_text("\n".join(rows) + "\n")
    return replace(read_survey(folder / "survey.csv"), course=course, exposure_known=True)


def by_differences(course, at):
    """(l m, l m) covariance of depths: each rate of each sample changed by hand, which is another route to it"""
    columns = []
    root = np.linalg.cholesky(DENSITY)
    for c in range(len(WINDOW)):
        for mode in root.T:
            rate = course.rate.copy()
            rate[:, c] *= 1.0 + 1e-4 * mode / np.sqrt(WINDOW[c])
            columns.append((replace(course, rate=rate).depth_at(at) - course.depth_at(at)).ravel() / 1e-4)
    return np.array(columns).T @ np.array(columns)


def by_modes(course, at, least=0.0):
    begin = np.concatenate([np.zeros((POINTS, 1)), at[:, :-1]], axis=1)
    error = np.cumsum(course.grown(begin, at)[:, :, None] * course.own_errors(begin, at, least), axis=1)
    error = error.reshape(at.size, -1)
    return error @ error.T, error.shape[1]


def test_the_modes_are_the_covariance_of_depths():
    at = np.tile(100.0 * np.arange(1, OCCASIONS + 1) / OCCASIONS, (POINTS, 1))
    expected, (found, _) = by_differences(run(), at), by_modes(run(), at)
    np.testing.assert_allclose(
        found, expected, atol=1e-7 * expected.max()
    )  # differences of 1e-4 are linear to that
    least = 0.2 * np.sqrt(np.trace(expected))
    few, modes = by_modes(run(), at, least)
    size = np.linalg.eigvalsh(expected - few)
    assert size.max() < least**2  # what is left out is small in every direction
    assert size.min() > -1e-7 * expected.max()  # and nothing is added, but rounding of the differences
    assert 0 < modes < 20


def test_a_run_sampled_four_times_as_long_has_a_quarter_of_the_variance():
    at = np.tile(100.0 * np.arange(1, OCCASIONS + 1) / OCCASIONS, (POINTS, 1))
    once, _ = by_modes(run(), at)
    longer, _ = by_modes(run(window=4.0 * WINDOW), at)
    np.testing.assert_allclose(longer, once / 4.0, atol=1e-9 * once.max())  # rounding of the decomposition


def test_another_pace_keeps_the_errors_at_the_same_shapes():
    """A run at twice the pace is at each shape after half the service: there its depths err by the same"""
    course = run()
    quick = at_own_pace(course, np.full(course.rate.shape, 2.0))
    at = np.tile(100.0 * np.arange(1, OCCASIONS + 1) / OCCASIONS, (POINTS, 1))
    own = replace(course, progress=2.0 * course.progress, rate=0.5 * course.rate)
    np.testing.assert_allclose(
        by_modes(quick, at)[0], by_modes(replace(own, rate=course.rate), at)[0], atol=1e-12
    )  # the same up to rounding


@pytest.mark.parametrize("memory", [0.0, 0.5])
def test_the_noise_of_samples_is_told(memory):
    """Blocks with a known covariance, and with a memory of one half from block to block, which triples it"""
    random = np.random.default_rng(3)
    block, scatter = 0.05, np.linalg.cholesky(DENSITY / 0.5)
    samples = []
    for c in range(20):
        noise = scatter @ random.standard_normal((POINTS, 200))
        for b in range(1, 200):
            noise[:, b] = memory * noise[:, b - 1] + np.sqrt(1.0 - memory**2) * noise[:, b]
        samples.append(Sample(float(c), 2e-9 * (1.0 + noise.T), block))
    nothing = np.zeros(0, int)
    feet = [Foot(i, np.zeros(3), i, nothing, np.zeros(3), np.zeros((3, 0))) for i in range(POINTS)]
    found = sampling(samples, feet)
    expected = (1.0 + memory) / (1.0 - memory) * block * DENSITY / 0.5
    assert found.window == pytest.approx(10.0)
    # 4000 blocks tell a variance to 2.2 %, with memory a third of them to 4 %; three of these
    assert np.trace(found.density) == pytest.approx(np.trace(expected), rel=0.12 if memory else 0.07)
    assert np.abs(found.density - expected).max() < 0.2 * expected.max()


def test_a_place_beside_the_facet_takes_part_in_the_noise_of_its_neighbours():
    rate = np.array([[1.0, 2.0], [3.0, 2.0], [1.0, 4.0], [2.0, 3.0]])
    half = Foot(0, np.zeros(3), 0, np.array([1]), np.array([0.5, 0.0, 0.0]), np.array([[1.0], [0.0], [0.0]]))
    assert half.values(rate) == pytest.approx(rate.mean(axis=1))  # midway: the mean, to rounding
    assert [half.value(one) for one in rate] == pytest.approx(rate.mean(axis=1))


def test_chi_squared_is_calibrated(tmp_path):
    random = np.random.default_rng(11)
    known, unknown, draws = [], [], 60
    for _ in range(draws):
        data = readings(survey_along(tmp_path, run(random), run().depth_at, random, 0.1))
        exact = small_spread(data)
        quiet = replace(
            exact, gauge=1e-4, zero=1e-9, initial=1e-9, scatter=1e-9, book=1e-9, scale=1e-9, smooth=1e-9, warp=1e-9, shift=1e-9, bend=1e-9
        )  # fmt: skip
        depth = depths(data.past, Model(1.0))
        left = data.worn - data.past.of_rows(depth)
        found = disturbance(data.survey, data.past, depth, data.reference, False)
        known.append(covariance(found, quiet).square(left) / len(left))
        assert (found.group == SAMPLING).any()
        unknown.append(float(left @ left) / 1e-8 / len(left))
    # the mean of 60 x 168 squares errs by sqrt(2 / 10080) = 1.4 %; four of these. What is left out adds next to nothing
    assert np.mean(known) == pytest.approx(1.0, abs=0.056)
    assert np.mean(unknown) > 2.0


def test_a_coefficient_knows_what_the_run_does_not(tmp_path):
    """The scatter of the coefficient alone over runs, beside the standard deviation that each tells"""
    random = np.random.default_rng(13)
    found = []
    for _ in range(60):
        data = readings(survey_along(tmp_path, run(random), run().depth_at, random, 0.1))
        told = coefficient_alone(data, None)
        found.append((told.place[0], told.deviation[0]))
    place, deviation = np.array(found).T
    # 60 draws tell a standard deviation to 9 %; three of these. Noise of each place by itself is counted in the scatter too: 5 % more
    assert np.sqrt(np.mean(deviation**2)) == pytest.approx(np.std(place), rel=0.32)
    assert abs(place.mean()) < 4.0 * np.std(place) / np.sqrt(60)  # and it is not biased: four standard errors


@pytest.mark.parametrize("loss", [0.0, 40.0])
def test_softer_metal_makes_more_of_what_a_run_does_not_know(tmp_path, loss):
    """Sampled rates changed by hand, and the depths by the closed form of a gradient, p = d - g d^2 / 2; what the report tells beside it"""
    survey = survey_along(tmp_path, run(), run().depth_at, np.random.default_rng(2), 0.01)
    data = readings(survey)
    past, depth = data.past, depths(data.past, Model(1.0))

    def metal(plain):
        return plain if loss == 0.0 else (1.0 - np.sqrt(1.0 - 2.0 * loss * plain)) / loss

    growth = np.diff(depth - 0.5 * loss * depth**2, axis=1, prepend=0.0)
    small, change = 1e-4, []
    for mode in np.moveaxis(past.sampled, 2, 0):
        there = metal(np.cumsum(growth * (1.0 + small * mode), axis=1))
        change.append((there - metal(np.cumsum(growth, axis=1)))[past.row_life, past.row_interval] / small)
    held = survey.progress > 50.0
    expected = np.sqrt(np.square(change).sum(axis=0)[held].mean())
    effects = (HardnessGradient(loss),) if loss else ()
    # halves of rows of the metal's table, 1e-3 of its reach or 1 % of 1/E from row to row
    assert own_sampling(survey, held, effects) * survey.measured_factor == pytest.approx(expected, rel=5e-3)
    assert loss == 0.0 or own_sampling(survey, held, effects) > own_sampling(survey, held, ())


def test_a_table_of_exposures_has_none(tmp_path):
    random = np.random.default_rng(2)
    survey = replace(survey_along(tmp_path, run(), run().depth_at, random, 0.1), course=None)
    data = readings(survey)
    depth = depths(data.past, Model(1.0))
    assert not (disturbance(survey, data.past, depth, data.reference, False).group == SAMPLING).any()


def test_the_runs_own_sampling_is_called_so_and_no_effect(tmp_path):
    random = np.random.default_rng(5)
    survey = survey_along(tmp_path, run(random), run().depth_at, random, 0.05)
    found = diagnose(survey, name_without=False)
    assert (found.verdict, found.effects) == ("adequate", ())
    expected = np.sqrt(np.diag(by_differences(run(), np.full((POINTS, 1), 100.0))))
    expected = np.median(expected / run().depth_at(np.full((POINTS, 1), 100.0))[:, 0])
    assert found.nuisance["run_own_sampling"] == pytest.approx(
        expected, rel=0.1
    )  # a median of draws, without the smallest modes
    spread = found.choice.best.spread
    blind = diagnose(replace(survey, course=replace(survey.course, sampling=None)), name_without=False)
    taken_for = blind.choice.best.spread
    assert (
        max(spread.scatter, spread.smooth) < 0.01 < max(taken_for.scatter, taken_for.smooth)
    )  # of 4 % that are there


@pytest.mark.slow
def test_the_runs_own_sampling_is_seldom_called_an_effect(tmp_path):
    random = np.random.default_rng(77)
    named = {True: 0, False: 0}
    for _ in range(40):
        survey = survey_along(tmp_path, run(random), run().depth_at, random, 0.05)
        for told in named:
            given = survey if told else replace(survey, course=replace(survey.course, sampling=None))
            named[told] += diagnose(given, name_without=False).verdict != "adequate"
    assert named[True] <= 5  # 5 % of 40 is 2; a binomial count is beyond 5 in 1.4 % of trials
    assert named[False] > 2 * named[True]
