"""A patch and a date, which are looked for on lists and from several starts: their probabilities, and that the best is found."""

import numpy as np
import pytest
from identification import plants
from scipy.optimize import least_squares
from scipy.special import ndtri

from wearfem.proofs.survey_life import surveyed
from wearfem.survey.candidates import candidates
from wearfem.survey.diagnose import diagnose
from wearfem.survey.identify import COEFFICIENT_PRIOR, _Problem, fit, readings


def suspect(data, name):
    return next(candidate for candidate in candidates(data.past, data.deepest) if candidate.name == name)


def test_a_set_of_points_is_as_probable_as_patches_thrown_at_random_that_cover_it():
    plant = plants.plant("build_up", 1, points=12, occasions=4)
    patch = suspect(readings(surveyed(plant, 4)), "BuildUp")
    low, high = plant.point.min(axis=0), plant.point.max(axis=0)
    random = np.random.default_rng(3)
    beyond = 0.5 * (high - low) / np.sqrt(12)  # a liner does not end at its last marked point
    centre = random.uniform(low - beyond, high + beyond, (40000, 3))[:, :2]
    at_points = random.uniform(size=40000) < 12 / (12 + 28**2)  # 28 middles a side, 8 from point to point
    centre[at_points] = plant.point[random.integers(12, size=at_points.sum()), :2]
    radius = random.uniform(0.0, np.linalg.norm(high - low), (40000, 1))
    inside = np.linalg.norm(plant.point[None, :, :2] - centre[:, None], axis=2) <= radius
    kept = inside[(inside.sum(axis=1) >= 2) & (inside.sum(axis=1) <= 4)]  # 2 to a third of the points
    thrown: dict[bytes, int] = {}
    for row in kept:
        thrown[row.tobytes()] = thrown.get(row.tobytes(), 0) + 1
    assert patch.share.sum() == pytest.approx(1.0, rel=1e-12)  # rounding
    number = patch.starts[:, -1]
    for entry in np.argsort(-patch.share)[:10]:
        effect = patch.effect(patch.starts[np.flatnonzero(number == entry)[0]])
        covered = np.linalg.norm(plant.point - np.array(effect.centre), axis=1) <= effect.radius
        count = thrown.get(covered.tobytes(), 0)
        expected = patch.share[entry] * len(kept)
        # standard deviations of a count, 10 of them are looked at; and what a grid of middles, not a plan, errs by
        assert abs(count - expected) < 4.0 * np.sqrt(expected) + 0.03 * expected


def test_points_at_the_border_of_a_patch_that_are_not_fitted_are_told():
    plant = plants.plant("build_up", 1, points=24, occasions=6)
    found = diagnose(surveyed(plant, 6), name_without=False)
    assert [effect.name for effect in found.effects] == ["BuildUp"]
    assert found.improved.heldout_rmse > 5.0 * plant.sigma  # one point decides that: see below
    assert {point for point, _ in found.heldout.undecided} == {"P013"}
    assert "P013" in found.heldout.points
    # some 50 readings know their standard deviation to 10 %: 3 of these
    assert found.heldout.decided_rmse == pytest.approx(plant.sigma, rel=0.3)


def test_doubt_of_a_coefficient_is_that_of_its_logarithm():
    data = readings(surveyed(plants.plant("none", 2, points=10, occasions=4), 4))
    fitted = fit(data)
    expected = data.past.of_rows(fitted.depth) * COEFFICIENT_PRIOR * np.sqrt(fitted.deviation[0, 0])
    assert fitted.doubt(data) == pytest.approx(expected, rel=1e-3)  # differences of 1e-2 of a width of 1e-3


def test_the_best_of_two_dates_is_found():
    # its likelihood has a kink at the third occasion and a maximum on either side; the lesser was taken once
    plant = plants.plant("ore_change", 3057, points=24, occasions=6)
    data = readings(surveyed(plant, 6))
    candidate = suspect(data, "OreChange")
    fitted = fit(data, [candidate], fit(data))
    problem = _Problem(data, (candidate,))
    root = problem.root(fitted.coordinate, fitted.spread)

    def cost(coordinate):
        left = problem.residual(coordinate, root)
        return 0.5 * float(left @ left + coordinate @ coordinate)

    first, last = float(data.past.begin.min()), float(data.past.end.max())
    profile = []
    for date in np.arange(440.0, 620.0, 10.0):
        u = ndtri((date - first) / (last - first))
        rest = least_squares(
            lambda x, u=u: np.concatenate([problem.residual(np.array([x[0], u, x[1]]), root), [x[0], u, x[1]]]),
            fitted.coordinate[[0, 2]], method="lm",
        ).x  # fmt: skip
        profile.append(cost(np.array([rest[0], u, rest[1]])))
    assert cost(fitted.coordinate) <= min(profile) + 1e-3  # searches stop at 1e-6 of 70
    date = candidate.effect(fitted.coordinate[1:]).throughput[0]
    width = np.sqrt(fitted.deviation[1, 1])
    ends = [candidate.free[0].value(fitted.coordinate[1] + side * 1.645 * width) for side in (-1, 1)]
    assert ends[0] <= plant.parameter["at_kt"] <= ends[1] and date > plant.tonnage[2]
