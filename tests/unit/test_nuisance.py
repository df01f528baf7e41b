"""What disturbs readings, integrated out: the covariance, its root and the slope of its likelihood against plain linear algebra."""

import numpy as np
import pytest
from identification import other_plants, plants

from wearfem.survey import nuisance
from wearfem.survey.calibrate import calibrate
from wearfem.survey.history import Model, depths, smooth_functions, steepness
from wearfem.survey.identify import readings, small_spread
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
