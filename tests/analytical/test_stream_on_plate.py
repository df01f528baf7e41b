"""The stream on a plate: impacts of rigid spheres, energy, and the whole of the wear on a level plate in closed form."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from wearfem.case import Window, load_any_case, parts_of
from wearfem.formula import FormulaFlow, Sliding
from wearfem.liner.liner import wear_surface
from wearfem.loads import in_one_block
from wearfem.verification.impact_theory import Plane, Sphere
from wearfem.verification.rigid_impact import Impact, kinetic_energy, rigid_rebound
from wearfem.wear.features import features

CASE = Path(__file__).parents[2] / "cases" / "stream_on_plate"
SILENT = {"noise": 0.0, "delay": 0.0}


def struck(**settings):
    """Case, module, surface, and the loads of one second"""
    case = load_any_case(CASE, SILENT | settings)
    surface = wear_surface(case.liner)
    _, loads = case.sampler.sample(FormulaFlow(), surface, Window(1.0))
    return case, parts_of(CASE), surface, in_one_block(loads)


@pytest.mark.parametrize("degrees", [10.0, 20.0, 35.0, 60.0, 85.0])
def test_each_grain_rebounds_as_a_rigid_sphere(degrees):
    """Against formulas written down for impact tests of the engine; both regimes, sliding and sticking"""
    _, module, _, _ = struck()
    angle = np.radians(degrees)
    stream = module.Stream(Sliding(1.0, 1.0), angle, 6.0, 1.0)
    ball, plane = Sphere(5e-3, 2650.0, 5e10, 0.2), Plane()
    shown = replace(struck()[3], normal_impulse=np.array([[ball.mass]]))  # one grain arrives
    loads = stream.loads(shown, np.array([[0.0, 0.0, 1.0]]))
    impact = Impact(6.0 * np.sin(angle), (6.0 * np.cos(angle), 0.0))
    after = rigid_rebound(ball, plane, impact, stream.friction, stream.restitution)
    lost = kinetic_energy(ball, plane, impact) - kinetic_energy(ball, plane, after)
    by_dashpot = 0.5 * ball.mass * impact.approach_speed**2 * (1.0 - stream.restitution**2)
    exact = 1e-12  # relative: some ten roundings
    assert loads.normal_impulse[0, 0] == pytest.approx(
        ball.mass * (impact.approach_speed + after.separation_speed), rel=exact
    )
    assert np.linalg.norm(loads.tangential_impulse[0, 0]) == pytest.approx(
        -after.tangential_impulse, rel=exact
    )
    assert loads.friction_work[0, 0] == pytest.approx(lost - by_dashpot, rel=exact)


def test_a_level_plate_wears_as_the_mass_that_meets_it():
    case, module, surface, loads = struck(cells=40)
    stream = case.sampler
    sine, cosine = np.sin(stream.angle), np.cos(stream.angle)
    along = (np.array([0.0, module.LENGTH]) - stream.middle[0]) * sine / stream.thick
    across = (np.array([0.0, module.WIDTH]) - stream.middle[1]) / stream.wide
    met = stream.mass_rate * np.diff(norm.cdf(along))[0] * np.diff(norm.cdf(across))[0]
    push = (1.0 + stream.restitution) * stream.speed * sine
    pull = min(stream.friction * push, 2.0 / 7.0 * stream.speed * cosine)
    worn = case.wear_law.specific_wear_rate * met * push * (stream.speed * cosine - 1.75 * pull)
    rate = case.wear_law.depth_rate(loads)[0] @ surface.facet_area
    assert rate == pytest.approx(worn, rel=2e-3)  # middles of facets of 10 mm stand for the mass on them
    assert loads.impact_energy.sum() == pytest.approx(0.5 * met * stream.speed**2, rel=2e-3)
    angle = features(("impact_angle",), loads, case.liner)["impact_angle"]
    np.testing.assert_allclose(angle, stream.angle, rtol=1e-6)  # the root of a rounding


def test_one_degree_of_slope_changes_the_rate_by_some_7_percent():
    rates = [struck(angle=np.radians(a))[0::3] for a in (19.5, 20.5)]
    low, high = (case.wear_law.depth_rate(loads)[0].max() for case, loads in rates)
    assert np.log(high / low) == pytest.approx(0.07, abs=0.01)  # as its docstring says, rounded
