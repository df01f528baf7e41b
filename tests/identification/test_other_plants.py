"""Plants written after the diagnosis was: what neighbours share, where points are not, and shapes that wear."""

import pytest

from wearfem.proofs.diagnosis import SMALL, trial


def test_what_neighbours_share_in_a_campaign_is_no_physics():
    assert trial("bent_scans", 1, **SMALL).named == ()


def test_points_elsewhere_than_told_are_no_physics():
    assert trial("elsewhere", 1, **SMALL).named == ()


def test_a_material_is_named_through_bent_scans():
    assert trial("bent_scans_gradient", 1, **SMALL).named == ("HardnessGradient",)


def test_a_shape_that_wears_is_not_passed_off_as_a_material():
    assert trial("hollow", 1, **SMALL).right


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bent_scans", "elsewhere"])
def test_correlated_noise_is_named_in_under_5_percent_of_200_draws(name):
    named = sum(not trial(name, seed, noise=0.1, points=40, occasions=8).right for seed in range(200))
    assert named < 10  # 5 % of 200, as asked
