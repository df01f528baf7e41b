"""The whole cycle on the wearing plate beside its closed forms."""

import numpy as np
import pytest

from wearfem.proofs import cycle as proof
from wearfem.proofs.cycle import ALLOWED, QUIET, RATE, lived, plate


@pytest.mark.parametrize("law", proof.LAWS)
def test_lives_and_depths_by_formula(law):
    for claim in proof.closed_form(law):
        assert claim.holds, claim


def test_frozen_geometry_wears_by_depth_alone():
    from dataclasses import replace

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
