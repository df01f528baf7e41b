"""Patches that stick: which points a circle can hold, told by circles thrown at random; and their wear, told plate by plate."""

import numpy as np
import pytest
from identification import plants

from wearfem.survey.candidates import _round_sets, candidates
from wearfem.survey.history import depths
from wearfem.survey.identify import _Problem, fit, model_at, readings, small_spread
from wearfem.survey.survey import read_survey

THROWN = 20_000


def patched(folder, seed, **design):
    plant = plants.plant("build_up", seed, **design)
    survey, exposure = plant.write(folder)
    data = readings(read_survey(survey, exposure=exposure))
    return plant, data, {one.name: one for one in candidates(data.past, data.deepest)}


def test_a_circle_thrown_at_random_is_on_the_list_as_often_as_it_says():
    random = np.random.default_rng(3)
    place = np.stack([random.uniform(0.0, 4.0, 24), random.uniform(-0.8, 0.8, 24), np.zeros(24)], axis=1)
    middles, radii, share = _round_sets(place)
    listed = np.linalg.norm(place - middles[:, None], axis=2) <= radii[:, None]
    number = {row.tobytes(): i for i, row in enumerate(listed)}
    assert len(number) == len(share)  # each set once
    assert share.sum() == pytest.approx(1.0, abs=1e-12)  # rounding of a sum
    assert listed.sum(axis=1).min() == 2 and listed.sum(axis=1).max() == 8  # to a third of 24
    low, high = place.min(axis=0), place.max(axis=0)
    beyond = 0.5 * (high - low) / np.sqrt(24)
    middle = random.uniform(low - beyond, high + beyond, (THROWN, 3))
    radius = random.uniform(0.0, 4.0, THROWN)
    held = np.linalg.norm(place - middle[:, None], axis=2) <= radius[:, None]
    held = held[(held.sum(axis=1) >= 2) & (held.sum(axis=1) <= 8)]
    at = np.array([number.get(row.tobytes(), -1) for row in held])
    # a set that the grid of an eighth of the spacing misses is smaller than its cells: few of those thrown
    assert np.mean(at < 0) < 0.02
    often = np.bincount(at[at >= 0], minlength=len(share)) / len(at)
    likely = np.argsort(-share)[:10]
    error = np.sqrt(share[likely].sum() / len(at))
    # three standard errors of counting, and 3 % since points are middles too
    assert often[likely].sum() == pytest.approx(
        share[likely].sum(), abs=3.0 * error + 0.03 * share[likely].sum()
    )


@pytest.mark.parametrize("names", [("BuildUp",), ("OreHardness", "BuildUp"), ("BuildUp", "Temperature")])
def test_plate_by_plate_is_as_model_by_model(tmp_path, names):
    """Squares of residuals from two models and a table of covered plates, beside a model for each patch"""
    _, data, known = patched(tmp_path, 5, points=24, occasions=4)
    problem = _Problem(data, tuple(known[name] for name in names))
    begins = np.array(problem.starts(None))
    begins = begins[np.random.default_rng(1).choice(len(begins), 60, replace=False)]
    root = problem.root(begins[0], small_spread(data))
    one_by_one = [
        np.sum((root @ data.left(depths(data.past, model_at(data, problem.suspects, own)))) ** 2)
        for own in begins
    ]
    assert problem.squares(begins, root) == pytest.approx(
        one_by_one, rel=1e-11
    )  # rounding of sums of 96 squares


def test_where_the_depth_acts_too_it_is_as_the_table_of_depths_is(tmp_path):
    _, data, known = patched(tmp_path, 5, points=24, occasions=4)
    problem = _Problem(data, (known["HardnessGradient"], known["BuildUp"]))
    begins = np.array(problem.starts(None))[::97]
    root = problem.root(begins[0], small_spread(data))
    one_by_one = [np.sum(problem.residual(own, root) ** 2) for own in begins]
    # the table of depths ends at the deepest plate, which may be covered or not: a few 1e-6 of the depth
    assert problem.squares(begins, root) == pytest.approx(one_by_one, rel=1e-4)


@pytest.mark.parametrize("seed", [3106, 3124])  # whose sets no circle about 16 x 16 middles held
def test_the_points_that_are_covered_are_found(tmp_path, seed):
    plant, data, known = patched(tmp_path, seed, points=24, occasions=6)
    found = fit(data, [known["BuildUp"]], fit(data))
    (patch,) = found.model.effects
    slow = plant.clean[:, -1] / plant.exposure
    truth = slow < 0.7 * np.median(slow)  # patches wear at 0.1 to 0.4 of the rate
    inside = np.linalg.norm(plant.point - patch.centre, axis=1) <= patch.radius
    assert inside.tolist() == truth.tolist()
    deviation = np.sqrt(found.deviation[1, 1])
    ends = [
        known["BuildUp"].effect(found.coordinate[1:] + [side * 3.0 * deviation, 0.0, 0.0]).ratio
        for side in (-1, 1)
    ]
    assert ends[0] < plant.parameter["ratio"] < ends[1]  # three standard errors
