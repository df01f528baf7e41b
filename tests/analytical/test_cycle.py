"""The whole cycle on the wearing plate beside its closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.liner.liner import wear_surface
from wearfem.proofs import cycle as proof
from wearfem.proofs.cycle import ALLOWED, QUIET, RATE, lived, plate
from wearfem.units import kPa, mm
from wearfem.wear.effects import FactorCurve, HardnessGradient, LateralBias
from wearfem.wear.smooth import HelmholtzFilter


@pytest.mark.parametrize("law", proof.LAWS)
def test_lives_and_depths_by_formula(law):
    for claim in proof.closed_form(law):
        assert claim.holds, claim


def test_frozen_geometry_wears_by_depth_alone():
    case, formula = plate(law="running_in", tolerance=1e-3, **QUIET)
    history = lived(replace(case, frozen=True))
    assert history.life[-1].time == pytest.approx(
        formula.life("running_in", ALLOWED, RATE),
        rel=1e-3,  # the controller's tolerance
    )
    assert history.worn_volume.max() == 0.0
    np.testing.assert_array_equal(history.state.now.liner.mesh.node, case.liner.mesh.node)
    np.testing.assert_allclose(
        history.thickness[-1], 20e-3 - history.state.now.receded, rtol=1e-12
    )  # rounding


def half_loaded(*effects):
    """A frozen plate whose right half sees twice the load, smoothed over 30 mm, and what the smoothed load alone would wear"""
    case, _ = plate(law="constant", tolerance=1e-3, **QUIET)
    middle = case.liner.mesh.node[case.liner.mesh.wear].mean(axis=1)
    load = np.where(middle[:, 0] > 0.1, 2.0, 1.0)
    flow = replace(case.sampler, intensity=lambda surface: load)
    case = replace(case, sampler=flow, effects=effects, smoothing_length=30 * mm, frozen=True)
    smooth = HelmholtzFilter(wear_surface(case.liner), 30 * mm)
    return lived(case), RATE * load, smooth, middle


def test_smoothing_mixes_loads_and_not_metals():
    """Each facet goes through its own hardness under its own smoothed load: d - g d^2 / 2 = r t, with g = 50 / m."""
    history, load, smooth, _ = half_loaded(HardnessGradient(50.0))
    d, rate = history.depth, smooth(load)
    assert np.ptp(rate) > 0.5 * RATE  # facets are not worn alike
    plain = rate * history.service_time[:, None]
    assert d - 25.0 * d**2 == pytest.approx(plain, abs=2e-3 * ALLOWED)  # 0.1 % in time is 0.2 % in depth


def test_effects_of_the_flow_are_smoothed_with_it():
    """A curve over pressure multiplies the load before it is smoothed; one over place what comes out of it."""
    doubled = FactorCurve(
        "pressure", (0.0, 15 * kPa, 15.01 * kPa), (1.0, 1.0, 2.0)
    )  # the right half has 20 kPa
    history, load, smooth, _ = half_loaded(doubled)
    steep = np.where(load > 1.5 * RATE, 2.0, 1.0) * load
    assert history.rate[0] == pytest.approx(smooth(steep), rel=1e-9)  # rounding of the solve
    history, load, smooth, middle = half_loaded(LateralBias(5.0, (1.0, 0.0, 0.0)))
    assert history.rate[0] == pytest.approx((1.0 + 5.0 * middle[:, 0]) * smooth(load), rel=1e-9)


def test_throughput_and_service_time_go_together():
    case, _ = plate(law="constant", tolerance=1e-2, **QUIET)
    history = lived(case)
    np.testing.assert_allclose(
        history.throughput, 100.0 * history.service_time, rtol=1e-12
    )  # 100 kg/s, rounding


@pytest.mark.slow
def test_noisy_lives():
    for claim in proof.promise():
        assert claim.holds, claim


@pytest.mark.slow
def test_a_few_hundred_real_particles():
    """The coupling with particles: the load on the new plate by formula, a life that ends, a plate that sinks where balls slide."""
    case, _ = plate(loads="particles", law="constant", tolerance=0.1)
    history = lived(case)
    figures = {figure.name: figure for figure in case.measure(history)}
    assert figures["load distance rate, new plate"].verdict == "agrees"
    assert history.ended == "end of life"
    # no slower than the fastest facet of the mean rate asked for, 1e-9 m/s over the plate, and no faster than twice that
    assert 0.5 * ALLOWED / RATE < history.life[-1].time < ALLOWED / RATE
