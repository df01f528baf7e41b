"""What a case knows of its liner: plain depths beside integrals by hand, layers, calendars, and facets that are not worn alike."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.case import Stop
from wearfem.forecast import forecast, known_effects
from wearfem.known import PlainDepth
from wearfem.proofs.cycle import ALLOWED, QUIET, RATE, lived, plate
from wearfem.units import day, mm
from wearfem.wear.effects import HardnessGradient, OreChangeByTime, Overlay

ROW = 1e-3  # [-] of the reach: two thousand rows, the factor of each taken at its middle


def plate_with(*effects, stop=30 * day, **settings):
    """A plate without noise with these effects after some service"""
    case, _ = plate(law="constant", tolerance=1e-2, **{**QUIET, **settings})
    case = replace(case, effects=effects)
    return case, lived(replace(case, stop=Stop(stop)))


def table(case, history, reach=10 * mm):
    return known_effects(history, case).by_depth(np.full(len(history.area), reach))


def test_plain_depth_is_the_integral_of_the_hardness():
    case, history = plate_with(HardnessGradient(50.0))
    plain, depth = table(case, history), np.linspace(0.0, 9 * mm, 7)[:, None] * np.ones(len(history.area))
    exact = depth - 25.0 * depth**2  # int (1 - g d) dd, g = 50 / m
    assert plain.without(depth) == pytest.approx(exact, abs=ROW**2 * ALLOWED)  # midpoint rule
    factor = known_effects(history, case).at(depth)
    assert factor == pytest.approx(1.0 / (1.0 - 50.0 * depth), rel=1e-12)  # the formula itself
    assert plain.depth(plain.without(depth)[3]) == pytest.approx(depth[3], rel=1e-12)  # there and back


def test_a_layer_is_met_where_it_is():
    case, history = plate_with(Overlay(4.3 * mm, 3.0))
    depth = np.full(len(history.area), ALLOWED)
    assert table(case, history).without(depth) == pytest.approx(4.3 * mm + 5.7 * mm / 3.0, abs=ROW * ALLOWED)


def test_plain_depths_are_kept_where_nothing_is_known():
    same, depth = PlainDepth.same(3), np.array([0.0, 4 * mm, np.inf])
    assert np.array_equal(same.without(depth), depth)


@pytest.mark.parametrize("where", [2 * mm, 4.3 * mm])
def test_a_layer_still_to_come_is_in_the_forecast(where):
    case, history = plate_with(Overlay(where, 3.0), stop=40 * day)
    told = forecast(history, case=case).zone[0]
    end = (where + (ALLOWED - where) / 3.0) / RATE  # each layer at its rate
    # the rate is known to 1e-3 or so from few exact samples; a layer within a row of the table
    assert told.quantile[1] == pytest.approx(end, rel=4e-3)
    blind = forecast(history, case=None).zone[0]
    assert where < 3 * mm or blind.quantile[1] > 1.2 * end  # who does not know the layer is late


def test_a_change_of_ore_at_a_date_is_in_the_forecast():
    case, history = plate_with(OreChangeByTime((60 * day,), (2.0,)), stop=30 * day)
    told = forecast(history, case=case).zone[0]
    end = 60 * day + (ALLOWED - RATE * 60 * day) / (2.0 * RATE)
    assert told.quantile[1] == pytest.approx(
        end, rel=5e-3
    )  # the date within a part of 200 of two lives, half of it at most


def test_facets_that_are_deeper_are_not_taken_for_others():
    """Half of a plate is worn twice as fast under a known gradient: the plain rates stay two to one, though the rates do not."""
    case, _ = plate(law="hardness_gradient", tolerance=1e-2, **QUIET)
    mesh = case.liner.mesh
    right = mesh.node[mesh.wear].mean(axis=1)[:, 0] > 0.1
    flow = replace(case.sampler, intensity=lambda surface: np.where(right, 2.0, 1.0))
    history = lived(replace(case, sampler=flow, frozen=True, longest_jump=1e6, stop=Stop(2.5e6)))
    worn = np.array([report.depth for report in history.reports if report.kept])
    plain = history.rate / known_effects(history, case).at(worn)
    assert plain == pytest.approx(np.where(right, 2.0, 1.0) * RATE * np.ones_like(worn), rel=1e-12)
    rate = history.rate[-1]
    assert rate[right].mean() / rate[~right].mean() > 2.2  # deeper, so softer
    end = (ALLOWED - 25.0 * ALLOWED**2) / (2.0 * RATE)
    assert forecast(history, case=case).zone[0].quantile[1] == pytest.approx(
        end, rel=2e-3
    )  # as for a rate that stays
