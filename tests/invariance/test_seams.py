"""How a surface is cut into triangles must not matter: not to the force on a sphere, not to the wear that it leaves."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wearfem.case import Window
from wearfem.dem.flow import Flow, Model, Wall
from wearfem.dem.motion import rotation, translation
from wearfem.dem.particles import spheres
from wearfem.dem.sample import advance, sample
from wearfem.proofs import seams
from wearfem.proofs.seams import LOAD, ORE, PLATES, RADIUS, SPACE, TIME_STEP, WAYS
from wearfem.surface import Plane, Surface, rectangle

FLOOR = (Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), ORE),)


@pytest.fixture(scope="module")
def on_a_plane():
    return {
        (kind, way): getattr(seams, kind)(FLOOR, *WAYS[way]) for kind in ("dragged", "rolled") for way in WAYS
    }


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("plate", PLATES)
@pytest.mark.parametrize("kind", ["dragged", "rolled"])
def test_a_plate_is_a_plane(on_a_plane, kind, plate, way):
    trace, plane = getattr(seams, kind)(PLATES[plate], *WAYS[way]), on_a_plane[kind, way]
    assert (trace.contacts == 1).all()
    np.testing.assert_allclose(trace.force[:, 2], LOAD, rtol=1e-9)  # settled; heights of 1e-17 m in 1e-5 m
    np.testing.assert_allclose(trace.force, plane.force, atol=1e-9 * LOAD)  # the same rounding
    np.testing.assert_allclose(trace.velocity, plane.velocity, atol=1e-9)  # of 1 m/s


def test_friction_carries_on_from_triangle_to_triangle_and_from_surface_to_surface():
    """Creeping at 0.1 mm/s the spring is still loading at the joint; a lost history would halve the friction."""
    for plates in (PLATES["two triangles"], PLATES["two surfaces with T-joints"]):
        flow, model = seams.on_the_plate(plates, (-3e-8, 1e-4), (1.0, 0.0), speed=1e-4, rolling=False)
        trace = seams.watch(flow, model, 200)
        assert trace.position[0, 0] < 0.0 < trace.position[-1, 0]
        steps = np.diff(np.linalg.norm(trace.force[:, :2], axis=1))
        assert (steps > 0).all()  # a loading spring, without a fall at the joint


def test_triangles_far_smaller_than_the_contact():
    """The contact circle is 0.34 mm across; 600 triangles lie under it, more than a sphere has candidates."""
    small = rectangle((-4.5e-4, -4.5e-4), (4.5e-4, 4.5e-4), (36, 36), ORE)
    flow, model = seams.on_the_plate((small,), (-1e-4, 1.3e-5), (1.0, 0.21), speed=1.0, rolling=False)
    trace = seams.watch(flow, model, 20)
    assert (trace.contacts == 1).all()
    np.testing.assert_allclose(trace.force[:, 2], LOAD, rtol=1e-9)  # as on any plate


def test_wear_of_a_block_is_load_times_distance():
    k = 1e-12  # [1/Pa]
    for surface in (seams.plate(1), seams.plate(7, 3, seed=5), seams.scattered_plate(400, seed=2)):
        worn, expected = seams.block_wear(surface, 0.08, 0.5, 0.02)
        assert k * worn == pytest.approx(k * expected, rel=1e-12)  # sums of 2000 numbers


def test_loads_do_not_know_triangles_numbers_or_frames():
    reference = seams.thrown_loads(seams.plate(8))
    for parts, seed in ((2, None), (5, None), (1, 6), (3, 7)):
        loads = seams.thrown_loads(seams.plate(8, parts, seed=seed))
        assert seams.apart(loads, reference) < 1e-9  # two ways to round; nothing amplifies over five hops
    for seed in (1, 2):
        turn = Rotation.random(random_state=np.random.default_rng(seed))
        assert seams.apart(seams.thrown_loads(seams.plate(8), turn), reference) < 1e-9  # as above


@pytest.mark.parametrize("tilt", [0.1, 0.5, 1.0, 2.5, 5.0, 10.0, 45.0, -1.0])
def test_force_over_a_joint_is_continuous_and_does_not_know_the_triangles(tilt):
    assert seams.largest_jump_ratio(tilt) == pytest.approx(0.5, abs=0.02)  # first order in the step
    whole = seams.across_joint(tilt, 500)
    np.testing.assert_allclose(
        seams.across_joint(tilt, 500, 7), whole, atol=1e-9 * LOAD
    )  # rounding of points
    if abs(tilt) <= 5.0:
        small = seams.across_joint(tilt, 500, 7, size=5e-3)  # squares of 0.36 mm, as wide as the contact
        np.testing.assert_allclose(small, whole, atol=1e-9 * LOAD)  # rounding of points


def test_force_over_an_edge_is_that_of_the_nearest_point():
    """A ridge pushes with one contact, 4/3 E* sqrt(R) d^(3/2) along the line from the nearest point, also beyond the edge."""
    ridge = seams.valley(-30.0, material=seams.ELASTIC)
    centre = np.array([0.3e-3, 1e-4, RADIUS - 2e-5])
    sphere = spheres(centre, RADIUS, ORE.density, held=seams.HELD_FAST)
    model = Model((seams.ELASTIC,), TIME_STEP, SPACE, (Wall(ridge),))
    force = seams.watch(Flow(sphere), model, 1).force[0]
    away = np.array([centre[0], 0.0, centre[2]])
    distance = np.linalg.norm(away)
    expected = seams.hertz_force(RADIUS - distance) * away / distance
    np.testing.assert_allclose(force, expected, rtol=1e-10, atol=1e-10 * expected[2])  # rounding of d / R


def test_force_on_a_corner_point_is_that_of_the_point():
    """The peak of a pyramid of three triangles."""
    angle = 2.0 * np.pi * np.arange(3) / 3
    rim = 0.02 * np.stack([np.cos(angle), np.sin(angle), np.full(3, -0.5)], axis=1)
    peak = Surface(
        np.concatenate([np.zeros((1, 3)), rim]), np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1)]), seams.ELASTIC
    )
    centre = np.array([0.2e-3, 1e-4, RADIUS - 2e-5])
    sphere = spheres(centre, RADIUS, ORE.density, held=seams.HELD_FAST)
    trace = seams.watch(Flow(sphere), Model((seams.ELASTIC,), TIME_STEP, SPACE, (Wall(peak),)), 1)
    distance = np.linalg.norm(centre)
    expected = seams.hertz_force(RADIUS - distance) * centre / distance
    assert trace.contacts[0] == 1
    np.testing.assert_allclose(trace.force[0], expected, rtol=1e-10)  # rounding of d / R


def test_two_contacts_in_a_corner_of_floor_and_wall():
    floor = rectangle((0.0, -0.05), (0.05, 0.05), (3, 4), seams.SLIPPERY)
    wall = Surface(
        np.array([(0, -0.05, 0), (0, 0.05, 0), (0, 0.05, 0.05), (0, -0.05, 0.05)], float),
        np.array([(0, 1, 2), (0, 2, 3)]),
        seams.SLIPPERY,
    )
    push = np.array([-0.013, 0.0, -0.02])
    sphere = spheres((RADIUS - 1e-5, 1e-3, RADIUS - 1e-5), RADIUS, ORE.density, applied_force=tuple(push))
    walls = (Wall(floor), Wall(wall))
    model = Model((seams.SLIPPERY,), TIME_STEP, SPACE, walls, gravity=(0.0, 0.0, 0.0))
    settled = advance(Flow(sphere), model, 0.3)
    _, loads, _ = sample(settled, model, Window(0.001))
    force = loads.normal_impulse[0] / 0.001
    assert force[: floor.facet_count].sum() == pytest.approx(0.02, rel=1e-9)  # at rest
    assert force[floor.facet_count :].sum() == pytest.approx(0.013, rel=1e-9)  # at rest


@pytest.mark.parametrize("tilt", [10.0, 20.0, 37.0, 45.0, 60.0, 75.0])
def test_forces_in_a_groove(tilt):
    side = LOAD / (2.0 * math.cos(math.radians(tilt)))
    np.testing.assert_allclose(
        seams.forces_in_groove(tilt), side, rtol=1e-6
    )  # nearly at rest; steep sides swing longest


def test_leaving_an_edge():
    angle, theory = seams.leaves_edge_at()
    assert angle == pytest.approx(theory, rel=0.01)  # stiff but elastic: the contact lags half a degree


def test_a_moving_plate_under_a_sphere_is_a_sphere_moving_over_a_plate():
    """Galileo: the same hops, slides and loads if plate and sphere get the same velocity."""
    drift = np.array([0.7, -0.4, 0.2])
    results = []
    for velocity in (np.zeros(3), drift):
        sphere = spheres(
            (-0.0413, -0.0291, RADIUS + 2e-4),
            RADIUS,
            ORE.density,
            velocity=tuple(velocity + (0.9, 0.5, -0.2)),
        )
        model = Model((ORE,), TIME_STEP, SPACE, (Wall(seams.plate(8, 2), translation(tuple(velocity))),))
        flow, loads, _ = sample(Flow(sphere), model, Window(0.1))
        p = flow.particles
        results.append((p.position[0] - velocity * flow.time, p.angular_velocity[0], loads))
    (x, spin, loads), (moved_x, moved_spin, moved_loads) = results
    np.testing.assert_allclose(moved_x, x, atol=1e-11)  # of 0.1 m
    np.testing.assert_allclose(moved_spin, spin, rtol=1e-9)  # amplified rounding of hops
    for name in ("normal_impulse", "load_distance", "friction_work", "contact_count"):
        one, other = getattr(loads, name), getattr(moved_loads, name)
        np.testing.assert_allclose(other, one, atol=1e-9 * one.sum())  # amplified rounding of hops


def test_loads_on_a_turning_plate():
    """A held sphere pressed on a turntable at distance a leaves F w a t, however the table is cut."""
    rate, arm, duration = 20.0, 0.03, 0.05
    start = RADIUS - seams.resting_overlap(LOAD)
    for surface in (seams.fan(40), seams.plate(9, seed=8)):
        sphere = spheres(
            (arm, 0.0, start), RADIUS, ORE.density, applied_force=(0.0, 0.0, -LOAD), held=seams.DRAGGED
        )
        walls = (Wall(surface, rotation(rate)),)
        model = Model((ORE,), TIME_STEP, SPACE, walls, gravity=(0.0, 0.0, 0.0))
        flow = advance(Flow(sphere), model, seams.SETTLING)
        flow, loads, _ = sample(flow, model, Window(duration))
        left = loads.load_distance.sum()
        assert left == pytest.approx(LOAD * rate * arm * duration, rel=1e-10)  # settled, rounding
        worn = np.flatnonzero(loads.load_distance[0])
        assert (
            1 < len(worn) < surface.facet_count / 2
        )  # only what passed under the sphere in a sixth of a turn


def test_a_tilted_surface_is_a_tilted_plane():
    """Sliding down at 30 degrees over random triangles, against the endless plane of the same slope."""
    turn = Rotation.from_euler("y", 30, degrees=True)
    shapes = (
        replace(seams.scattered_plate(300, 9), point=turn.apply(seams.scattered_plate(300, 9).point)),
        Plane((0.0, 0.0, 0.0), tuple(turn.apply((0.0, 0.0, 1.0))), ORE),
    )
    ends = []
    for shape in shapes:
        sphere = spheres(turn.apply((-0.05, 0.0123, RADIUS + 1e-4)), RADIUS, ORE.density)
        ends.append(advance(Flow(sphere), Model((ORE,), TIME_STEP, SPACE, (Wall(shape),)), 0.15).particles)
    np.testing.assert_allclose(ends[0].position, ends[1].position, atol=1e-11)  # of 0.1 m
    np.testing.assert_allclose(ends[0].angular_velocity, ends[1].angular_velocity, atol=1e-7)  # of 50 rad/s
