"""The engine at single impacts: the eight tests of Chung and Ooi (2011), meshes beside planes, spheres of unlike size."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wearfem.dem.contact import HertzMindlin
from wearfem.jit import set_thread_count, thread_count
from wearfem.proofs import impacts
from wearfem.proofs._impact_rig import Rig, grid, scattered
from wearfem.verification import impact_tests as published
from wearfem.verification import impact_theory as theory
from wearfem.verification.impact_tests import Variant
from wearfem.verification.impact_theory import Plane, Sphere
from wearfem.verification.rigid_impact import Impact, rigid_rebound

BALL = Sphere(0.0025, 4000.0, 3.8e11, 0.23)
SOFT = Sphere(0.010, 1400.0, 2.0e7, 0.40)


@pytest.fixture(autouse=True)
def one_thread():
    """Two bodies give more threads nothing to do but wait."""
    threads = thread_count()
    set_thread_count(1)
    yield
    set_thread_count(threads)


@pytest.mark.parametrize(
    "claims",
    [
        impacts.normal_claims,
        impacts.restitution_claims,
        impacts.order_claims,
        impacts.sliding_claims,
        impacts.spinning_alike_claims,
        impacts.same_law_claims,
        impacts.mesh_claims,
    ],
    ids=lambda claims: claims.__name__,
)
def test_claims_hold(claims):
    """The tolerances and their reasons stand with the claims."""
    settled = list(claims())
    assert settled
    assert not [claim for claim in settled if not claim.holds]


def test_the_gap_to_partial_slip_is_that_of_a_spring_that_sticks_as_a_whole():
    shown = [claim for claim in impacts.partial_slip_claims() if "steel" in claim.claim]
    gaps = [claim.difference for claim in shown]
    assert 0.3 < max(gaps) < 0.5  # as between the two theories, test_impact_theory.py
    assert len(shown) > 10  # the sweep reaches from stick to sliding


@pytest.mark.parametrize("steps", [20, 50, 100])
def test_coarse_steps_still_meet_restitution(steps):
    """At 20 to 100 steps in a contact, as in practice."""
    variant = published.RESTITUTION.variants[0]
    impact = published.RESTITUTION.impacts[0]
    for restitution in (0.3, 0.6, 0.9, 1.0):
        one = Rig(variant, 0.0, restitution, steps=steps)
        got = one.rebound(impact).separation_speed / impact.approach_speed
        assert got == pytest.approx(restitution, abs=0.1 / steps)  # first order where the dashpot starts


# --------------------------------------------------------------------------------------- meshes and planes

FRAMES = [np.eye(3), *(Rotation.random(random_state=seed).as_matrix() for seed in (1, 2))]
CUTS = {
    "large": grid(2.0),
    "middle": grid(0.5, turn=0.3, mirrored=True),
    "small": grid(0.2, turn=1.1),
    "scattered": scattered(0.5, seed=3),
    "slivers": scattered(0.25, seed=4),
}
SPOTS = [
    (0.0, 0.0),
    (0.0, 0.07),
    (0.06, 0.06),
    (1e-6, 0.03),
    (0.02, 1e-9),
    (0.02, -1e-8),
    (1e-7, 0.02),
    (0.11, 0.037),
]
IMPACTS = {
    "normal": Impact(3.9),
    "oblique": Impact(3.0, (2.0, 0.0)),
    "grazing": Impact(1.0, (5.0, 0.0)),
    "spinning": Impact(2.0, (0.0, 0.0), (800.0, 0.0)),
    "rolling": Impact(2.0, (3.0, 0.0), (-1200.0, 0.0)),
}


@pytest.mark.parametrize("restitution", [1.0, 0.4])
@pytest.mark.parametrize("cut", CUTS.values(), ids=CUTS.keys())
def test_a_mesh_is_a_plane_wherever_it_is_hit(cut, restitution):
    for number, impact in enumerate(IMPACTS.values()):
        frame = FRAMES[number % len(FRAMES)]
        plane = Rig(Variant("ball", BALL, Plane()), 0.3, restitution, frame=frame, steps=100)
        for spot in SPOTS:
            apart = impacts.difference_from(plane, replace(plane, cut=cut), spot, impact)
            assert apart < 1e-9  # rounding of positions, 1e-16 of the frame, over an overlap of 1e-3 R


@pytest.mark.parametrize("frame", FRAMES[1:], ids=["first", "second"])
def test_no_direction_is_special(frame):
    for impact in IMPACTS.values():
        plane = Rig(Variant("ball", BALL, Plane()), 0.3, 0.6, steps=100)
        assert (
            impacts.difference_from(plane, replace(plane, frame=frame), (0.0, 0.0), impact) < 1e-9
        )  # rounding


@pytest.mark.parametrize("law", ["hertz", "linear"])
@pytest.mark.parametrize(("speed", "spin"), [(12.0, 0.0), (12.0, -1200.0)], ids=["sliding", "rolling"])
def test_nothing_happens_at_the_joints_that_are_crossed_in_contact(speed, spin, law):
    """A soft sphere in long contact crosses several triangles, sliding or rolling; the history goes with it."""
    plane = Rig(Variant("soft", SOFT, Plane()), 0.3, 0.8, frame=FRAMES[1], steps=300)
    if law == "linear":
        plane = replace(plane, law=impacts.linear_law(plane, 1.0))
    impact = Impact(1.0, (speed, 0.0), (spin, 0.0))
    cell = 0.2
    travelled = speed * plane.expected(1.0).duration / SOFT.radius
    assert travelled > 3.0 * cell  # at least three joints are crossed
    for cut in (grid(cell), grid(cell, turn=0.3), scattered(0.3, seed=5)):
        for spot in ((-0.5, 0.0), (-0.4, 0.013)):
            assert impacts.difference_from(plane, replace(plane, cut=cut), spot, impact) < 1e-9  # rounding


# ------------------------------------------------------------------------------------------ unlike spheres


@pytest.mark.parametrize("ratio", [1.0, 3.0, 10.0])
def test_unlike_spheres_meet_hertz(ratio):
    large = Sphere(ratio * BALL.radius, 7850.0, 2.1e11, 0.3)
    for variant in (Variant("up", BALL, large), Variant("down", large, BALL)):
        one = Rig(variant, 0.3, 1.0)
        found, told = one.watch(Impact(2.0)), one.expected(2.0)
        assert found.duration == pytest.approx(told.duration, rel=1e-4)  # second order, 500 steps
        assert found.maximum_force == pytest.approx(told.maximum_force, rel=1e-4)  # second order, 500 steps
        assert found.maximum_overlap == pytest.approx(
            told.maximum_overlap, rel=1e-4
        )  # second order, 500 steps
        assert found.restitution == pytest.approx(1.0, abs=1e-5)  # second order, 500 steps


@pytest.mark.parametrize("ratio", [1.0, 3.0, 10.0])
def test_unlike_spheres_slide_like_rigid_bodies(ratio):
    large = Sphere(ratio * BALL.radius, 7850.0, 2.1e11, 0.3)
    impact, friction, restitution = Impact(0.5, (0.0, 0.0), (1500.0, 300.0)), 0.2, 0.7
    after = Rig(Variant("spinning", BALL, large), friction, restitution).rebound(impact)
    told = rigid_rebound(BALL, large, impact, friction, restitution)
    assert told.sliding
    assert after.separation_speed == pytest.approx(
        told.separation_speed, rel=2e-3
    )  # the normal turns a little
    assert after.angular_velocity == pytest.approx(
        told.angular_velocity, rel=0.01
    )  # lever R - d, as in theory R
    assert after.tangential_velocity == pytest.approx(
        told.tangential_velocity, rel=0.01
    )  # the normal turns a little


def test_the_order_of_the_bodies_does_not_matter():
    """Turned by half a turn about the side, body 1 is below: the same impact with the bodies exchanged."""
    large = Sphere(3.0 * BALL.radius, 7850.0, 2.1e11, 0.3)
    impact, exchanged = Impact(1.0, (0.8, -0.2), (500.0, 90.0)), Impact(1.0, (0.2, -0.8), (90.0, 500.0))
    velocity, spin = Rig(Variant("", BALL, large), 0.3, 0.6).velocities(impact)
    other_velocity, other_spin = Rig(Variant("", large, BALL), 0.3, 0.6).velocities(exchanged)
    turn = np.array([-1.0, 1.0, -1.0])
    assert np.abs(other_velocity[::-1] * turn - velocity).max() < 1e-9  # rounding; speeds are 1 m/s
    assert np.abs(other_spin[::-1] * turn - spin).max() < 1e-9 * 500.0  # rounding; spins are 500 rad/s


@pytest.mark.parametrize("restitution", [0.4, 1.0])
def test_a_sphere_meets_its_mirror_image_like_a_rigid_wall(restitution):
    wall = Rig(Variant("wall", BALL, Plane()), 0.3, restitution).watch(Impact(2.0))
    mirror = Rig(Variant("mirror", BALL, BALL), 0.3, restitution).watch(Impact(4.0))
    assert mirror.restitution == pytest.approx(
        wall.restitution, rel=1e-7
    )  # a wall is 1e9 times stiffer, not rigid
    assert mirror.maximum_force == pytest.approx(wall.maximum_force, rel=1e-7)  # likewise
    assert mirror.maximum_overlap == pytest.approx(2.0 * wall.maximum_overlap, rel=1e-7)  # likewise
    assert mirror.duration == pytest.approx(wall.duration, rel=1e-7)  # likewise


def test_momentum_and_spin_are_handed_over_whole():
    large = Sphere(3.0 * BALL.radius, 7850.0, 2.1e11, 0.3)
    impact = Impact(1.0, (0.8, -0.2), (500.0, 90.0))
    after = Rig(Variant("", BALL, large), 0.3, 0.6, law=HertzMindlin()).rebound(impact)
    before = BALL.mass * 0.8 - large.mass * 0.2
    now = BALL.mass * after.tangential_velocity[0] + large.mass * after.tangential_velocity[1]
    assert now == pytest.approx(before, abs=1e-13 * BALL.mass)  # rounding; speeds are 1 m/s


# ------------------------------------------------------------------------------------------- linear springs


def test_linear_springs_slide_like_rigid_bodies():
    impact = Impact(1.0, (4.0, 0.0))
    for restitution in (0.3, 0.7, 1.0):
        base = Rig(Variant("ball", BALL, Plane()), 0.2, restitution)
        one = replace(base, law=impacts.linear_law(base, 1.0))
        after, told = one.rebound(impact), impacts.theory_of(one, impact)
        assert told.sliding
        assert after.slip_velocity == pytest.approx(
            told.slip_velocity, rel=0.01
        )  # lever R - d, as in theory R
        assert after.angular_velocity[0] == pytest.approx(told.angular_velocity[0], rel=0.01)  # likewise


@pytest.mark.parametrize("tangential", [0.01, 0.05])
def test_a_sticking_linear_spring_swings_as_it_must(tangential):
    """Undamped and never slipping, the tangent spring swings with m_t: slip' = slip cos(w_t T), w_t T = pi sqrt(2/7 m/m_t)."""
    base = Rig(Variant("ball", BALL, Plane()), 10.0, 1.0)
    one = replace(base, law=impacts.linear_law(base, 0.01))
    pair = theory.contact_pair(BALL, Plane())
    turn = math.pi * math.sqrt(one.law.shear_ratio * pair.effective_mass / pair.tangential_mass)
    after = one.rebound(Impact(0.01, (tangential * 0.01, 0.0)))
    # the lever is R - d, d = 1e-4 R; the end of contact slips when the push has gone
    assert after.slip_velocity / (tangential * 0.01) == pytest.approx(math.cos(turn), abs=1e-3)
