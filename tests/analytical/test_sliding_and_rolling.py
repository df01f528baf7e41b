"""Bodies on planes against their closed forms: sliding, rolling, spinning, on walls that move."""

import math
from dataclasses import replace

import numpy as np
import pytest

from wearfem.case import Window
from wearfem.dem.contact import (
    ConstantTorque,
    Contact,
    ElasticPlasticRolling,
    FrictionTwisting,
    HertzMindlin,
)
from wearfem.dem.energy import energy
from wearfem.dem.flow import Flow, Model, Wall
from wearfem.dem.motion import POSE, along_path, bodies, pose_at, rotation, vibration
from wearfem.dem.particles import HELD, spheres
from wearfem.dem.sample import Stepper, advance, sample
from wearfem.proofs import motion, seams
from wearfem.proofs.seams import ORE, RADIUS, SPACE, TIME_STEP
from wearfem.surface import Plane, rectangle

GRAVITY = 9.81
FLOOR = (Wall(Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), ORE)),)
ROUGH = replace(ORE, name="rough", friction=0.8, rolling_friction=0.1)
MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * ORE.density


def on_a_slope(degrees, material, contact, held=0, duration=0.3):
    """Speed along the slope [m/s] after `duration` of a sphere that rested on it at the start; gravity is tilted instead."""
    angle = math.radians(degrees)
    load = MASS * GRAVITY * math.cos(angle)
    overlap = seams.resting_overlap(load, material=material)
    gravity = (GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle))
    sphere = spheres((0.0, 0.0, RADIUS - overlap), RADIUS, ORE.density, held=held)
    floor = (Wall(Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), material)),)
    model = Model((material,), TIME_STEP, SPACE, floor, contact=contact, gravity=gravity)
    return advance(Flow(sphere), model, duration).particles.velocity[0, 0]


def test_a_block_slides_down_with_what_friction_leaves():
    early, late = (on_a_slope(40.0, ORE, Contact(), HELD["rotation"], time) for time in (0.1, 0.3))
    expected = 0.2 * GRAVITY * (math.sin(math.radians(40)) - 0.5 * math.cos(math.radians(40)))
    assert late - early == pytest.approx(expected, rel=1e-6)  # the load has ceased to swing
    assert abs(on_a_slope(26.0, ORE, Contact(), HELD["rotation"])) < 1e-5  # tan 26 < 0.5: it stays


def test_a_sphere_rolls_down_at_five_sevenths():
    speed = on_a_slope(20.0, ROUGH, Contact())
    assert speed == pytest.approx(
        0.3 * 5 / 7 * GRAVITY * math.sin(math.radians(20)), rel=2e-3
    )  # overlap, start


@pytest.mark.parametrize(
    "contact",
    [
        Contact(HertzMindlin(), ConstantTorque()),
        Contact(HertzMindlin(), ElasticPlasticRolling(), FrictionTwisting()),
    ],
)
def test_rolling_starts_above_the_angle_of_rolling_friction(contact):
    """At tan(alpha) = mu_r = 0.1, 5.71 degrees; beyond it with 5/7 g (sin - mu_r cos)."""
    assert abs(on_a_slope(5.4, ROUGH, contact)) < 2e-4
    steep = math.radians(12.0)
    expected = 0.3 * 5 / 7 * GRAVITY * (math.sin(steep) - 0.1 * math.cos(steep))
    assert on_a_slope(12.0, ROUGH, contact) == pytest.approx(
        expected, rel=0.02
    )  # the spring must first be wound


def test_spin_about_the_normal_stops_by_friction_of_the_patch():
    """w falls by 2/3 a mu F / I each second, a = sqrt(R d)."""
    load, spin = 0.02, 200.0
    overlap = seams.resting_overlap(load)
    sphere = spheres(
        (0.0, 0.0, RADIUS - overlap),
        RADIUS,
        ORE.density,
        angular_velocity=(0.0, 0.0, spin),
        applied_force=(0.0, 0.0, -load),
        held=HELD["z"],
    )
    law = Contact(HertzMindlin(), ElasticPlasticRolling(), FrictionTwisting())
    model = Model((ORE,), TIME_STEP, SPACE, FLOOR, contact=law, gravity=(0.0,) * 3)
    rate = 2 / 3 * math.sqrt(RADIUS * overlap) * 0.5 * load / (0.4 * MASS * RADIUS**2)
    duration = 0.5 * spin / rate
    left = advance(Flow(sphere), model, duration).particles.angular_velocity[0, 2]
    assert left == pytest.approx(spin - rate * duration, rel=1e-3)  # the twisting spring is wound first
    at_rest = advance(Flow(sphere), model, 1.2 * spin / rate).particles.angular_velocity[0, 2]
    assert abs(at_rest) < 0.01 * spin  # it swings a little on the spring


@pytest.mark.parametrize("surface", [seams.fan(24), seams.plate(9, seed=8)], ids=["fan", "squares"])
def test_a_sphere_on_a_turntable_circles_at_two_sevenths(surface):
    arm = 1.0 - seams.resting_overlap(seams.LOAD) / RADIUS
    expected = 10.0 / (1.0 + arm**2 / 0.4)  # 2/7 of 10 rad/s for a rigid sphere
    assert motion.turntable(surface) == pytest.approx(expected, rel=1e-4)  # swing at the start


def test_held_directions_stay_and_the_others_go():
    for name, bit in HELD.items():
        sphere = spheres(
            (0.0, 0.0, RADIUS),
            RADIUS,
            ORE.density,
            velocity=(0.1, 0.2, -0.3),
            angular_velocity=(1.0, 2.0, 3.0),
            held=bit,
        )
        p = advance(Flow(sphere), Model((ORE,), TIME_STEP, SPACE, FLOOR), 0.003).particles
        if name == "rotation":
            assert p.angular_velocity[0].tolist() == [1.0, 2.0, 3.0]
        else:
            axis = "xyz".index(name)
            assert p.velocity[0, axis] == (0.1, 0.2, -0.3)[axis]
        moved = p.velocity[0] != (0.1, 0.2, -0.3)
        assert moved.sum() == (3 if name == "rotation" else 2)


def pose(one, time):
    filled = np.zeros(POSE)
    pose_at(bodies([one]), 0, time, filled)
    return filled


def test_bodies_are_where_their_motions_say():
    shaken = vibration((0.0, 1e-3, 2e-3), 50.0, 0.3)
    for time in (0.0, 0.0123, 1.7):
        at = pose(shaken, time)
        phase = 2 * math.pi * 50.0 * time + 0.3
        np.testing.assert_allclose(
            at[0:3], np.array([0, 1e-3, 2e-3]) * math.sin(phase), atol=1e-15
        )  # rounding
        speed = 2 * math.pi * 50.0 * math.cos(phase)
        np.testing.assert_allclose(at[12:15], np.array([0, 1e-3, 2e-3]) * speed, atol=1e-12)  # rounding
    path = along_path(np.array([(1.0, 0, 0, 0), (2.0, 0.1, 0, 0), (4.0, 0.1, -0.4, 0)]))
    for time, place, speed in (
        (0.5, (0, 0, 0), (0, 0, 0)),
        (1.25, (0.025, 0, 0), (0.1, 0, 0)),
        (3.0, (0.1, -0.2, 0), (0, -0.2, 0)),
        (9.0, (0.1, -0.4, 0), (0, 0, 0)),
    ):
        at = pose(path, time)
        np.testing.assert_allclose(at[0:3], place, atol=1e-15)  # rounding
        np.testing.assert_allclose(at[12:15], speed, atol=1e-15)  # rounding
    at = pose(rotation(2.0, axis=(0, 0, 3), centre=(1.0, 0, 0)), 0.4)
    turn = at[3:12].reshape(3, 3)
    expected = [1 + math.cos(0.8), math.sin(0.8), 0.5]
    np.testing.assert_allclose(turn @ (2.0, 0.0, 0.5) + at[0:3], expected, atol=1e-15)  # rounding


def test_a_path_carries_what_rests_on_it():
    """Friction takes a sphere with held rotation along with a plate that moves at 0.1 m/s."""
    plate = rectangle((-0.1, -0.1), (0.1, 0.1), (5, 5), ORE)
    wall = Wall(plate, along_path(np.array([(0.0, 0, 0, 0), (1.0, 0.1, 0, 0)])))
    sphere = spheres((0.0, 0.0, RADIUS), RADIUS, ORE.density, held=HELD["rotation"])
    end = advance(Flow(sphere), Model((ORE,), TIME_STEP, SPACE, (wall,)), 0.3).particles
    assert end.velocity[0, 0] == pytest.approx(0.1, rel=1e-6)  # sticks after 20 ms


def test_work_of_a_vibrating_plate_is_what_the_sphere_and_the_ledger_got():
    """A sphere hops on a plate that shakes at 1.8 g."""
    plate = rectangle((-0.05, -0.05), (0.05, 0.05), (4, 4), ORE)
    frequency = 30.0
    amplitude = 1.8 * GRAVITY / (2 * math.pi * frequency) ** 2
    model = Model((ORE,), TIME_STEP, SPACE, (Wall(plate, vibration((0, 0, amplitude), frequency)),))
    flow = Flow(spheres((0.0011, 0.0007, RADIUS + 1e-4), RADIUS, ORE.density))
    start = energy(flow, model)
    end = energy(advance(flow, model, 1.0), model)
    assert end.wall_work > 1e-4 * MASS * GRAVITY
    assert abs(end.gap_since(start)) < 1e-3 * end.dissipated  # second order in the step


def test_power_of_a_plate_that_drags_is_force_times_speed():
    plate = rectangle((-0.1, -0.1), (0.1, 0.1), (4, 4), ORE)
    load, speed = 0.02, 0.3
    wall = Wall(plate, along_path(np.array([(0.0, 0, 0, 0), (1.0, speed, 0, 0)])))
    place = (0.0, 0.0, RADIUS - seams.resting_overlap(load))
    sphere = spheres(place, RADIUS, ORE.density, applied_force=(0.0, 0.0, -load), held=seams.DRAGGED)
    model = Model((ORE,), TIME_STEP, SPACE, (wall,), gravity=(0.0,) * 3)
    settled = advance(Flow(sphere), model, 0.1)
    end, loads, _ = sample(settled, model, Window(0.05))
    work = energy(end, model).wall_work - energy(settled, model).wall_work
    assert work == pytest.approx(0.5 * load * speed * 0.05, rel=1e-9)  # settled
    assert loads.friction_work.sum() == pytest.approx(work, rel=1e-9)  # settled
    assert loads.tangential_impulse[0, :, 0].sum() == pytest.approx(-0.5 * load * 0.05, rel=1e-9)  # settled


def test_a_stepper_tells_the_time():
    stepper = Stepper(Flow(spheres((0.0, 0.0, 0.05), RADIUS, 2500.0)), Model((ORE,), TIME_STEP, SPACE))
    stepper.advance(250)
    fallen = 0.05 - stepper.particles.position[0, 2]
    assert fallen == pytest.approx(
        0.5 * GRAVITY * 0.0025**2, rel=1e-9
    )  # Verlet is exact for a constant force
