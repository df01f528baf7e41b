"""The wear laws hold what `wearfem verify wear_laws` claims."""

import math

import numpy as np
import pytest

from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.particles import spheres
from wearfem.dem.sample import sample
from wearfem.material import Interaction, Material
from wearfem.proofs import wear_laws
from wearfem.surface import rectangle
from wearfem.wear.impact_laws import KineticEnergy

GRAIN = Material("grain", 2650.0, 1e7, 0.25)
STEEL = Material("steel", 7850.0, 7.8e10, 0.3)


def one_grain(height, velocity, duration, time_step, restitution):
    """A sphere of 3 mm, `height` above a plate of 40 squares; its kinetic energy at the start, and the loads."""
    plate = rectangle((0.0, -0.05), (0.4, 0.05), (40, 1), STEEL)
    domain = Domain((-0.1, -0.1, -0.1), (0.5, 0.1, 0.2))
    touch = Interaction(GRAIN, STEEL, restitution, 0.0)
    particles = spheres([[0.0513, 0.0077, 3e-3 + height]], 3e-3, 2650.0, velocity=velocity)
    model = Model((GRAIN, STEEL), time_step, domain, (Wall(plate),), (touch,))
    _, loads, _ = sample(Flow(particles), model, wear_laws.Window(duration))
    return 0.5 * float(particles.mass[0]) * float(np.dot(velocity, velocity)), loads


def test_the_engine_keeps_angle_and_speed_of_an_impact():
    height, v = 1e-4, (2.0, 0.0, -1.5)
    _, loads = one_grain(height, v, 1.5e-3, 1e-6, 0.6)
    down = math.sqrt(1.5**2 + 2.0 * 9.81 * height)
    angle, log = math.atan2(down, 2.0), 0.5 * math.log(4.0 + down**2)
    kept = loads.impact_moment[0].sum(axis=(0, 1, 2)) / loads.impact_energy.sum()
    # first touch is seen up to one step late: 9.81 m/s2 x 1e-6 s of 1.5 m/s is 7e-6
    np.testing.assert_allclose(kept, [angle, angle**2, log, log**2, angle * log], rtol=2e-5)
    assert (
        loads.impact_energy[0].sum(axis=0)[3, 3] == loads.impact_energy.sum()
    )  # 30 to 40 degrees, 1 to 10 m/s


@pytest.mark.parametrize("time_step", [2e-6, 4e-6])
def test_a_contact_that_endures_is_one_impact(time_step):
    """A grain slides over 20 facets without leaving the plate: it counts once, however small the step."""
    energy, loads = one_grain(0.0, (2.0, 0.0, 0.0), 0.05, time_step, 0.05)
    assert loads.contact_time.sum() > 0.0499  # it does not leave it
    assert (loads.load_distance.sum(axis=0) > 0.0).sum() >= 10
    assert loads.contact_count.sum() == pytest.approx(1.0, rel=1e-12)  # shares of one touch, summed
    # the fall of a step adds (g dt)^2 to v^2: 4e-10 of it
    assert KineticEnergy(1e-11).volume(loads).sum() == pytest.approx(2e-11 * energy, rel=1e-8)


def test_formulas_by_another_route():
    failed = [claim for claim in wear_laws.formulas() if not claim.holds]
    assert not failed, failed


def test_classes_with_moments_lose_less_than_a_hundredth():
    """The bound, 1 %, is what is asked; without moments a narrow beam is off by tens of per cent, so the beams do ask something."""
    claims = list(wear_laws.classes())
    failed = [claim for claim in claims if not claim.holds]
    assert not failed, failed
    bare = [claim.computed for claim in claims if "without moments" in claim.claim]
    assert max(bare) > 0.3


def test_the_m_v2_law_needs_no_classes():
    beam = next(wear_laws.beams())
    kept = beam.loads(angles=3, per_decade=1)
    # a sum of 20 000 terms in another order
    assert KineticEnergy(1e-11).volume(kept)[0] == pytest.approx(2e-11 * beam.energy.sum(), rel=1e-12)


def test_tied_angles_and_speeds_are_among_the_beams():
    tied = [np.corrcoef(beam.angle, np.log(beam.speed))[0, 1] for beam in wear_laws.beams()]
    assert max(tied) > 0.75


@pytest.mark.slow
def test_stored_statistics_and_sums_on_the_fly():
    failed = [claim for claim in wear_laws.rain() if not claim.holds]
    assert not failed, failed
