"""Each formula of the contact laws against values by hand, as plain Python."""

import math

import numpy as np
import pytest

from wearfem.dem import contact
from wearfem.dem.contact import (
    ConstantTorque,
    Contact,
    ElasticPlasticRolling,
    FrictionTwisting,
    HertzMindlin,
    Kinematics,
    LinearSpringDashpot,
    Memory,
    Pair,
    respond,
)

EXACT = {"rel": 1e-14}  # rounding
PAIR = Pair(
    effective_radius=0.01,
    effective_mass=0.002,
    effective_modulus=3e6,
    effective_shear_modulus=1e6,
    damping_ratio=0.2,
    friction=0.5,
    rolling_friction=0.1,
)
OVERLAP = 1e-4  # sqrt(R d) = 1 mm
NOTHING = Memory(*[0.0] * 8)


def touching(velocity=(0.0, 0.0, 0.0), turning=(0.0, 0.0, 0.0), spin=0.0) -> Kinematics:
    return Kinematics(OVERLAP, 0.0, 0.0, 1.0, *velocity, *turning, spin)


def test_hertz_mindlin_by_hand():
    law = HertzMindlin()
    assert law.elastic_force(OVERLAP, PAIR) == pytest.approx(0.4, **EXACT)  # 4/3 x 3e6 x 1e-3 x 1e-4
    assert law.elastic_energy(OVERLAP, PAIR) == pytest.approx(1.6e-5, **EXACT)  # 2/5 F d
    assert law.tangential_stiffness(OVERLAP, PAIR) == pytest.approx(8000.0, **EXACT)  # 8 x 1e6 x 1e-3
    root = 2 * math.sqrt(5 / 6) * 0.2
    assert law.normal_damping(OVERLAP, PAIR) == pytest.approx(root * math.sqrt(6000 * 0.002), **EXACT)
    assert law.tangential_damping(OVERLAP, PAIR) == pytest.approx(root * math.sqrt(8000 * 0.002), **EXACT)
    assert HertzMindlin(shear_damping=0.0).tangential_damping(OVERLAP, PAIR) == 0.0


def test_linear_spring_dashpot_by_hand():
    law = LinearSpringDashpot(4000.0)
    assert law.elastic_force(OVERLAP, PAIR) == pytest.approx(0.4, **EXACT)
    assert law.elastic_energy(OVERLAP, PAIR) == pytest.approx(2e-5, **EXACT)
    assert law.normal_damping(OVERLAP, PAIR) == pytest.approx(0.4 * math.sqrt(8.0), **EXACT)
    assert law.tangential_stiffness(OVERLAP, PAIR) == pytest.approx(8000.0 / 7.0, **EXACT)
    assert law.tangential_damping(OVERLAP, PAIR) == pytest.approx(0.4 * math.sqrt(16.0 / 7.0), **EXACT)


def test_rolling_and_twisting_by_hand():
    torque, spring, twist = ConstantTorque(), ElasticPlasticRolling(), FrictionTwisting()
    assert torque.rolling_limit(0.4, PAIR) == pytest.approx(4e-4, **EXACT)  # 0.1 x 0.4 x 0.01
    assert torque.rolling_damping(0.0, 1e-5, PAIR) == pytest.approx(0.028, **EXACT)  # 7/5 x 2e-7 / 1e-5
    assert spring.rolling_stiffness(4000.0, PAIR) == pytest.approx(9e-3, **EXACT)  # 2.25 x 4000 x 1e-6
    assert spring.rolling_damping(9e-3, 1e-5, PAIR) == pytest.approx(0.6 * math.sqrt(2.52e-9), **EXACT)
    assert twist.twisting_stiffness(8000.0, OVERLAP, PAIR) == pytest.approx(4e-3, **EXACT)  # 8000 x 1e-6 / 2
    assert twist.twisting_limit(0.4, OVERLAP, PAIR) == pytest.approx(4e-4 / 3, **EXACT)  # 2/3 x 1e-3 x 0.2


def test_a_contact_never_pulls():
    """Parting fast, the dashpot alone would pull with 0.04 x 20 = 0.8 N."""
    answer, _ = respond(Contact(), PAIR, touching((0.0, 0.0, 20.0)), NOTHING, 1e-5)
    assert answer.normal_force == 0.0
    answer, _ = respond(Contact(), PAIR, touching((0.0, 0.0, -1.0)), NOTHING, 1e-5)
    assert answer.normal_force == pytest.approx(0.4 + HertzMindlin().normal_damping(OVERLAP, PAIR), **EXACT)
    assert answer.damping_power == pytest.approx(HertzMindlin().normal_damping(OVERLAP, PAIR), **EXACT)


def test_friction_is_the_spring_until_it_slips_at_the_limit():
    law = Contact(HertzMindlin(shear_damping=0.0))
    held = NOTHING._replace(sx=1e-5, stiffness=8000.0)
    answer, kept = respond(law, PAIR, touching(), held, 1e-5)
    assert answer.fx == pytest.approx(-0.08, **EXACT)  # 8000 x 1e-5, below 0.2
    assert (answer.slip, kept.sx) == (0.0, 1e-5)
    answer, kept = respond(law, PAIR, touching(), held._replace(sx=1e-4), 1e-5)
    assert answer.fx == pytest.approx(-0.2, **EXACT)  # 0.5 x 0.4
    assert kept.sx == pytest.approx(2.5e-5, **EXACT)  # 0.2 / 8000
    assert answer.slip == pytest.approx(7.5e-5, **EXACT)
    assert answer.slip_power == pytest.approx(0.2 * 7.5e-5 / 1e-5, **EXACT)


def test_the_dashpot_adds_what_the_limit_leaves():
    """Spring 0.08 N, dashpot far above: together they are the limit, 0.2 N."""
    held = NOTHING._replace(sx=1e-5, stiffness=8000.0)
    answer, _ = respond(Contact(), PAIR, touching((5.0, 0.0, 0.0)), held, 1e-12)
    assert answer.fx == pytest.approx(-0.2, rel=1e-9)  # half a step of 1e-12 s more on the spring
    assert answer.damping_power == pytest.approx(5.0 * 0.12, rel=1e-6)  # as above


def test_force_kept_on_loading_and_displacement_on_unloading():
    law = Contact(HertzMindlin(shear_damping=0.0))
    answer, _ = respond(law, PAIR, touching(), NOTHING._replace(sx=1e-5, stiffness=4000.0), 1e-5)
    assert answer.fx == pytest.approx(-0.04, **EXACT)  # was 4000 x 1e-5
    assert answer.stiffness_power == pytest.approx((2e-7 - 1e-7) / 1e-5, **EXACT)  # f^2 / 2 (1/4000 - 1/8000)
    answer, _ = respond(law, PAIR, touching(), NOTHING._replace(sx=1e-5, stiffness=16000.0), 1e-5)
    assert answer.fx == pytest.approx(-0.08, **EXACT)  # 8000 x 1e-5
    assert answer.stiffness_power == pytest.approx(0.5 * 8000.0 * 1e-10 / 1e-5, **EXACT)


def test_history_turns_with_the_contact_and_keeps_its_length():
    """Once around with the normal, in 10 000 steps: the vector comes back. And spin about the normal turns it likewise."""
    stored, steps = np.array([1.0, 0.0, 2.0]), 10_000
    vector = stored
    for k in range(1, steps + 1):
        angle = 2 * math.pi * k / steps
        normal = (0.0, math.sin(angle), math.cos(angle))
        vector = np.array(contact.carry(*vector, *normal, 0.0))
        if k == 1:
            length = np.linalg.norm(vector)
    assert np.linalg.norm(vector) == pytest.approx(length, rel=1e-12)  # rounding of 10 000 steps
    vector = np.array([1.0, 0.0, 0.0])
    for _ in range(steps):
        vector = np.array(contact.carry(*vector, 0.0, 0.0, 1.0, 2 * math.pi / steps))
    assert np.linalg.norm(vector) == pytest.approx(1.0, rel=1e-12)  # rounding of 10 000 turns


def test_a_loaded_spring_that_turns_as_a_rigid_body_does_no_work():
    """Normal, stored displacement and both bodies turn together: the force turns along, its length and power stay."""
    law, dt, rate = Contact(HertzMindlin(shear_damping=0.0)), 1e-5, 50.0
    memory = NOTHING._replace(sx=1e-5, sy=0.5e-5, stiffness=8000.0)
    length = math.hypot(1e-5, 0.5e-5)
    for k in range(1, 2001):
        angle = rate * dt * k
        touch = touching()._replace(ny=math.sin(angle), nz=math.cos(angle), wx=0.0)
        answer, memory = respond(law, PAIR, touch, memory, dt)
        assert math.hypot(memory.sx, memory.sy, memory.sz) == pytest.approx(length, rel=1e-9)  # rounding
        assert abs(answer.slip_power) + abs(answer.stiffness_power) + abs(answer.damping_power) == 0.0
    force = np.array([answer.fx, answer.fy, answer.fz])
    turned = -8000.0 * np.array([1e-5, 0.5e-5 * math.cos(angle), -0.5e-5 * math.sin(angle)])
    np.testing.assert_allclose(
        force, turned, atol=2.5e-4 * np.linalg.norm(turned)
    )  # first order: half of 0.5 mrad


def test_rolling_spring_and_constant_torque_oppose_rolling():
    for law in (ConstantTorque(), ElasticPlasticRolling()):
        answer, _ = respond(Contact(rolling=law), PAIR, touching(turning=(0.0, 100.0, 0.0)), NOTHING, 1e-3)
        assert (answer.mx, answer.mz) == (0.0, 0.0)
        assert answer.my == pytest.approx(-4e-4, rel=1e-12)  # the limit mu_r F R
        assert answer.rolling_power > 0.0


def test_twisting_opposes_spin():
    answer, _ = respond(
        Contact(twisting=FrictionTwisting()), PAIR, touching(turning=(0.0, 0.0, 100.0)), NOTHING, 1e-2
    )
    assert answer.mz == pytest.approx(-4e-4 / 3, rel=1e-12)  # the limit 2/3 a mu F
    assert answer.rolling_power > 0.0
