"""The file of trials: what it says is what was tried, it goes on where it was, and what is counted is what is there."""

from dataclasses import replace

import numpy as np
import pytest
from identification import plants

from wearfem.proofs._trials import Design, designs, measure, read
from wearfem.proofs.diagnosis import TOLD, Trial, confusion, degraded, intervals, trial

MAKE = {"points": 8, "occasions": 4}


def test_a_row_is_the_trial_and_nothing_is_tried_twice(tmp_path):
    file = tmp_path / "trials.csv"
    few = Design("few", ("none", "lateral_bias"), (3,), MAKE)
    (row,) = measure(file, [replace(few, plants=("none",))])
    (more,) = measure(file, [few])  # the first is there already
    assert (row.trial.plant, more.trial.plant) == ("none", "lateral_bias")
    assert list(measure(file, [few])) == []
    for made, told in zip((row.trial, more.trial), read(file), strict=True):
        exact = trial(made.plant, 3, **MAKE)
        for one in (made, told.trial):
            same = ("plant", "seed", "truth", "verdict", "named", "right", "covered")
            assert [getattr(one, name) for name in same] == [getattr(exact, name) for name in same]
            # the file has four digits
            assert one.error_over_noise == pytest.approx(exact.error_over_noise, rel=1e-3)
            assert one.decided_over_noise == pytest.approx(exact.decided_over_noise, rel=1e-3)
        assert [set(a) for a in told.trial.alike] == [set(a) for a in exact.alike]


def test_right_effects_that_are_given_are_told_by_their_intervals(tmp_path):
    design = Design("given", ("ore_hardness", "two_effects"), (5,), MAKE, given=True)
    told = {row.trial.plant: dict(row.trial.covered) for row in measure(tmp_path / "trials.csv", [design])}
    assert set(told["two_effects"]) == {"HardnessGradient loss", "OreHardness exponent"}
    assert told["ore_hardness"] == dict(intervals("ore_hardness", 5, **MAKE))


def test_every_design_is_of_plants_that_there_are_and_seeds_are_its_own():
    for design in designs():
        assert design.plants and len(set(design.seeds)) == len(design.seeds)
    whole = next(design for design in designs() if design.name == "whole")
    assert set(whole.plants) == set(plants.NAMES)
    assert len(next(design for design in designs() if design.name == "noise").seeds) == 200  # as asked


def made(plant, verdict, *named, right=False):
    return Trial(plant, 1, (), verdict, named, (), right, 1.0, 1.0, ())


def test_what_is_counted_is_what_is_there():
    trials = [
        made("a", "effect_found", "A", right=True),
        made("b", "adequate", right=True),
        made("a", "cannot_tell", "B"),
        made("a", "effect_found", "B", "C"),
        made("a", "effect_found", "A", right=True),
    ]
    assert confusion(trials) == [
        ("a", "2 of 4", "A 2, B (cannot_tell) 1, B + C 1"),
        ("b", "1 of 1", "nothing 1"),
    ]
    found = degraded([t for t in trials if t.plant == "a"])
    assert (found.named, found.refused, found.wrong) == (0.5, 0.25, 0.25)


def test_truths_of_plants_are_the_same_curves_in_the_words_of_effects():
    slip = plants.plant("three_body", 4)
    ratio, most = slip.parameter["rolling_ratio"], slip.point_column["mobilised_friction"].max()
    # grains that roll (nothing mobilised) over those that slide most: r / (r + (1 - r) m / 0.46), by the plant's own line
    expected = ratio / (ratio + (1.0 - ratio) * most / 0.46)
    assert TOLD["SlipShare", "rolling_ratio"](slip) == pytest.approx(expected, rel=1e-12)  # rounding
    bias = plants.plant("lateral_bias", 4)
    across, slope = bias.point[:, 1], bias.parameter["slope"]
    own = TOLD["LateralBias", "slope"](bias)
    effect = 1.0 + own * (across - 0.5 * (across.min() + across.max()))
    shape = (1.0 + slope * across) / effect
    assert np.ptp(shape) < 1e-12 * shape.mean()  # one factor everywhere, which the coefficient takes
