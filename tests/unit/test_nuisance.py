"""What disturbs readings, integrated out: the covariance, its root and the slope of its likelihood against plain linear algebra."""

import numpy as np
import pytest
from identification import other_plants, plants

from wearfem.survey import nuisance
from wearfem.survey.calibrate import calibrate
from wearfem.survey.history import Model, depths, smooth_functions, steepness
from wearfem.survey.identify import _Problem, model_at, readings, small_spread
from wearfem.survey.survey import read_survey


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Readings with all nuisances in them, and the columns of those"""
    survey, exposure = plants.plant("none", 3, points=14, occasions=5).write(tmp_path_factory.mktemp("plant"))
    data = readings(read_survey(survey, exposure=exposure))
    data.past.__dict__.update(bent=data.deepest, warped=data.past.smooth)
    depth = depths(data.past, Model(data.coefficient))
    found = nuisance.disturbance(data.survey, data.past, depth, data.reference, data.thickness_free)
    return data, found, data.worn - data.past.of_rows(depth)


def test_all_nuisances_are_there(made):
    assert set(made[1].group.tolist()) == {0, 1, 2, 3, 5, 6, 7, 8, 9}  # 4 is for thicknesses


def test_the_root_of_the_inverse_is_one(made):
    data, found, _ = made
    spread = small_spread(data)
    c = nuisance.covariance(found, spread)
    full = c.gauge**2 * np.diag(c.weight) + (found.column * found.deviation(spread) ** 2) @ found.column.T
    root = c.root()
    assert root.T @ root @ full == pytest.approx(np.eye(len(full)), abs=1e-10)  # rounding of 70 x 70
    assert c.log_determinant == pytest.approx(np.linalg.slogdet(full)[1], rel=1e-12)  # rounding


def test_the_slope_of_the_likelihood_is_that_of_differences(made, monkeypatch):
    data, found, left = made
    seen = {}

    def watched(function, start, **rest):
        seen.update(function=function, start=start)
        return minimize(function, start, **rest)

    minimize = nuisance.minimize
    monkeypatch.setattr(nuisance, "minimize", watched)
    nuisance.fit_spread(found, left, small_spread(data), data.gauge, data.reference)
    function, start = seen["function"], seen["start"]
    steps = 1e-5 * np.eye(len(start))
    slope = [(function(start + step)[0] - function(start - step)[0]) / 2e-5 for step in steps]
    assert function(start)[1] == pytest.approx(
        slope, abs=1e-5
    )  # central differences of 1e-5 of values of 1e3


def test_smooth_functions_have_no_mean_and_one_square():
    place = np.random.default_rng(1).uniform(0.0, 2.0, (30, 3))
    function = smooth_functions(place)
    assert function.mean(axis=0) == pytest.approx(np.zeros(function.shape[1]), abs=1e-12)  # rounding
    assert np.mean(np.sum(function**2, axis=1)) == pytest.approx(1.0, rel=1e-12)  # rounding


def test_steepness_of_an_exponential_is_its_rate():
    place = np.random.default_rng(1).uniform(0.0, 2.0, (30, 3))
    told = steepness(place, np.exp(place @ [0.3, -0.2, 0.1]))
    assert told == pytest.approx(
        np.tile([0.3, -0.2, 0.1], (30, 1)), abs=1e-9
    )  # planes through logarithms are exact


def test_two_mechanisms_are_told_apart(tmp_path):
    plant = other_plants.plant("two_mechanisms", 1, points=24, occasions=6)
    survey, exposure = plant.write(tmp_path)
    read = read_survey(survey, exposure=exposure)
    assert read.mechanisms == ("sliding", "impact")
    found = calibrate(read)
    impact, (low, high) = found.others["impact"]
    error = 1e-3 * (high - low) / 3.29
    # 144 readings: four standard errors
    assert 1e3 * found.coefficient == pytest.approx(
        0.7, abs=4e3 * (found.interval[1] - found.interval[0]) / 3.29
    )
    assert 1e3 * impact == pytest.approx(1.6, abs=4e6 * error)
    assert found.correlation[0, 1] < 0.0  # what one takes the other lacks


@pytest.fixture
def uneven(tmp_path):
    """Readings of four plates by a good gauge and a poor one, in turn; 0.04 and 0.2 mm"""
    random = np.random.default_rng(4)
    rows = ["point,occasion,tonnage_kt,depth_mm,sigma_mm,exposure"]
    for j in range(1, 7):
        for i, rate in enumerate((0.010, 0.014, 0.020, 0.025)):
            sigma = (0.04, 0.2)[(i + j) % 2]
            rows.append(f"P{i},{j},{100 * j},{100 * j * rate + sigma * random.normal():.6f},{sigma},{rate}")
    (tmp_path / "survey.csv").write_text("\n".join(rows) + "\n")
    return readings(read_survey(tmp_path / "survey.csv"))


def alone(data):
    """Only the gauge errs, by as much as was told"""
    none = dict.fromkeys(small_spread(data).__dict__, 1e-09)
    return nuisance.Spread(**(none | {"gauge": data.reference}))


def test_a_reading_weighs_as_the_square_of_its_sigma(uneven):
    # written down without the code: independent normal errors, ln p = sum of -(r/s)^2/2 - ln s - ln(2 pi)/2
    depth = depths(uneven.past, Model(uneven.coefficient))
    found = nuisance.disturbance(uneven.survey, uneven.past, depth, uneven.reference, uneven.thickness_free)
    left = uneven.worn - uneven.past.of_rows(depth)
    sigma = uneven.survey.sigma
    assert np.unique(sigma) == pytest.approx([0.04e-3, 0.2e-3])
    expected = np.sum(-0.5 * (left / sigma) ** 2 - np.log(sigma) - 0.5 * np.log(2.0 * np.pi))
    told = nuisance.log_likelihood(found, alone(uneven), left)
    assert told == pytest.approx(expected, rel=1e-6)  # nuisances of 1e-9 leave 1e-7
    root = nuisance.covariance(found, alone(uneven)).root()
    assert root @ left == pytest.approx(left / sigma, rel=1e-5)


def test_a_coefficient_is_the_weighted_mean_of_textbooks(uneven):
    # k = sum(e t y / s^2) / sum((e t)^2 / s^2), for straight wear y = k e t
    problem = _Problem(uneven, ())
    served = uneven.survey.exposure * uneven.survey.progress
    weight = 1.0 / uneven.survey.sigma**2
    expected = np.sum(weight * served * uneven.worn) / np.sum(weight * served**2)
    found, _ = problem.search(np.zeros(1), problem.root(np.zeros(1), alone(uneven)), most=60)
    k = model_at(uneven, (), found).coefficient
    # the prior of the coefficient, 1.5 in logarithms, pulls by its own variance over the readings': 1e-6
    assert k == pytest.approx(expected, rel=1e-5)
    for power in (1.0, 4.0):  # other powers of sigma give another mean
        weight = uneven.survey.sigma**-power
        other = np.sum(weight * served * uneven.worn) / np.sum(weight * served**2)
        assert abs(other / expected - 1.0) > 5e-5  # five times the tolerance above
