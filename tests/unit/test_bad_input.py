"""What cannot go well is refused before the first step, in one sentence that says what was given and what to do."""

import numpy as np
import pytest

from wearfem.dem.feed import Inlet, Sizes, uniform_sizes
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.motion import along_path, rotation
from wearfem.dem.particles import spheres
from wearfem.dem.sample import advance
from wearfem.errors import UserError
from wearfem.material import Interaction, Material, pair_table
from wearfem.surface import Plane, Surface, rectangle

ORE = Material("ore", 2500.0, 1e7 / 2.6, 0.3)
SPACE = Domain((-0.1,) * 3, (0.1,) * 3)
SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)


def start(particles, time_step=1e-5, **settings):
    advance(Flow(particles), Model((ORE,), time_step, SPACE, **settings), 1e-4)


def one(**settings):
    return spheres((0.0, 0.0, 0.0), 0.005, 2500.0, **settings)


def refused(match: str):
    return pytest.raises(UserError, match=match)


def test_time_step_over_the_limit():
    with refused(r"time step 0\.001 s is over the stable limit.*use \S+ s"):
        start(one(), time_step=1e-3)


@pytest.mark.parametrize("time_step", [0.0, -1e-5, float("nan")])
def test_time_step_that_is_none(time_step):
    with refused("must be above 0"):
        start(one(), time_step=time_step)


def test_overlapping_particles():
    position = [(0.0, 0.0, 0.0), (0.03, 0.0, 0.0), (0.037, 0.0, 0.0)]
    with refused(r"Particles [12] and [12] overlap by 60 % .* at most 5 %"):
        start(spheres(position, 0.005, 2500.0))


def test_overlap_across_a_periodic_border():
    flow = Flow(spheres([(-0.099, 0.0, 0.0), (0.099, 0.0, 0.0)], 0.005, 2500.0))
    with refused("overlap by 160 %"):
        advance(flow, Model((ORE,), 1e-5, Domain((-0.1,) * 3, (0.1,) * 3, (True, False, False))), 1e-4)


def test_particle_outside():
    with refused(r"Particle 0 starts outside the domain, at \[0\.2, 0\.0, 0\.0\] m"):
        start(spheres((0.2, 0.0, 0.0), 0.005, 2500.0))


def test_particle_leaving():
    with refused(r"Particle 0 left the domain at .*outlet=True"):
        model = Model((ORE,), 1e-5, SPACE)
        advance(Flow(spheres((0.0999, 0.0, 0.0), 0.005, 2500.0, velocity=(1.0, 0.0, 0.0))), model, 0.01)


@pytest.mark.parametrize(
    "name", ["position", "velocity", "angular_velocity", "applied_force", "radius", "mass"]
)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_not_a_number(name, value):
    particles = one()
    getattr(particles, name)[0] = value
    with refused("Particle 0: its .* must be a finite number"):
        start(particles)


def test_not_a_number_on_the_way():
    """Springs far stiffer than the step allows end in a sentence, not in numbers that are none."""
    hard = Material("hard", 2500.0, 1e7, 0.3)
    position = [(0.0, 0.0, 0.0), (0.00999, 0.0, 0.0)]
    particles = spheres(position, 0.005, 2500.0, velocity=[(1e200, 0.0, 0.0), (0.0, 0.0, 0.0)])
    with refused("not a number at .* near"):
        advance(Flow(particles), Model((hard,), 1e-5, SPACE), 1e-3)


@pytest.mark.parametrize("radius", [0.0, -0.005])
def test_radius_that_is_none(radius):
    particles = one()
    particles.radius[0] = radius
    with refused("it must be above 0"):
        start(particles)


def test_material_that_does_not_exist():
    with refused("material 3, but materials are numbered 0 to 0"):
        start(one(material=3))


@pytest.mark.parametrize(
    ("radius", "time_step", "match"),
    [
        (0.03, 1e-5, "periodic width is 0.2 m; it must be at least 0.225 m"),
        (0.005, 1e-3, "over the stable limit"),
        (1e-4, 1e-6, "ratio above 255"),
    ],
)
def test_particles_to_come_are_seen_before_they_come(radius, time_step, match):
    """An empty flow with an inlet: the largest particle may come late."""
    largest = 300.0 * radius if radius < 1e-3 else radius
    inlet = Inlet((-0.09,) * 3, (0.09,) * 3, 1.0, uniform_sizes(radius, largest))
    periodic = Domain((-0.1,) * 3, (0.1,) * 3, (True, False, False))
    nothing = spheres(np.zeros((0, 3)), 0.0, 2500.0)
    with refused(match):
        advance(Flow(nothing), Model((ORE,), time_step, periodic, inlets=(inlet,)), 1e-4)


def test_too_narrow_to_be_periodic():
    flow = Flow(spheres((0.0, 0.0, 0.0), 0.03, 2500.0))
    with refused("at least"):
        advance(flow, Model((ORE,), 1e-5, Domain((-0.1,) * 3, (0.1,) * 3, (True, False, False))), 1e-4)


@pytest.mark.parametrize(
    ("point", "triangle", "match"),
    [
        (SQUARE, [(0, 1, 2), (0, 3, 2)], "same direction.*flip the inverted"),
        (SQUARE, [(0, 1, 2), (0, 1, 1)], "1 of 2 triangles have no area.*number 1"),
        (SQUARE * (1, 0, 0), [(0, 1, 2)], "have no area"),
        (SQUARE, [(0, 1, 2), (1, 2, 0)], "1 triangles are there twice"),
        (SQUARE, [(0, 1, 2), (0, 2, 7)], "points are numbered 0 to 3"),
        (SQUARE, [(0, 1, -1)], "points are numbered 0 to 3"),
        (SQUARE * np.nan, [(0, 1, 2)], "must be finite"),
        (SQUARE, np.zeros((0, 3), int), "at least one triangle"),
        (SQUARE[:, :2], [(0, 1, 2)], r"\(p, 3\) points"),
    ],
)
def test_surfaces_that_are_none(point, triangle, match):
    with refused(match):
        Surface(point, np.array(triangle), ORE)


def test_a_facet_number_for_each_triangle():
    with refused("one facet number"):
        Surface(SQUARE, np.array([(0, 1, 2), (0, 2, 3)]), ORE, facet=np.array([0]))


def test_a_plane_needs_a_direction():
    with refused("must have a direction"):
        Plane((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), ORE)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("shear_modulus", -1e7),
        ("shear_modulus", float("nan")),
        ("density", 0.0),
        ("poisson_ratio", 0.6),
        ("restitution", 0.0),
        ("restitution", 1.1),
        ("friction", -0.1),
        ("rolling_friction", float("inf")),
    ],
)
def test_materials_that_are_none(name, value):
    good = {"density": 2500.0, "shear_modulus": 1e7, "poisson_ratio": 0.3}
    with refused(f"bad: {name} is .*; it must be"):
        Material("bad", **good | {name: value})


def test_interactions_that_are_none():
    other = Material("other", 2500.0, 1e7, 0.3)
    with refused("ore/other: friction"):
        Interaction(ORE, other, restitution=0.5, friction=-1.0)
    with refused("names other, which no particle or surface is made of"):
        pair_table((ORE,), (Interaction(ORE, other, restitution=0.5, friction=0.5),))


def test_walls_of_unknown_material_and_planes_that_turn():
    other = Material("other", 2500.0, 1e7, 0.3)
    with refused("plate is made of other, which is not among"):
        Model((ORE,), 1e-5, SPACE, (Wall(rectangle((0, 0), (1, 1), (1, 1), other)),))
    with refused("cannot turn; use a surface"):
        Model((ORE,), 1e-5, SPACE, (Wall(Plane((0, 0, 0), (0, 0, 1), ORE), rotation(1.0)),))
    with refused("axis must have a direction"):
        plate = Wall(rectangle((0, 0), (1, 1), (1, 1), ORE), rotation(1.0, axis=(0.0, 0.0, 0.0)))
        start(one(), walls=(plate,))


@pytest.mark.parametrize(
    ("edge", "share", "match"),
    [
        ((0.001, 0.002), (0.0,), "sum to nothing"),
        ((0.001, 0.002, 0.003), (1.0, -0.5), "none below"),
        ((0.001, 0.002), (float("nan"),), "sum to nothing"),
        ((0.002, 0.001), (1.0,), "rising"),
        ((0.0, 0.001), (1.0,), "above 0 m"),
        ((0.001, 0.002), (0.5, 0.5), "one border more"),
    ],
)
def test_sizes_that_are_none(edge, share, match):
    with refused(match):
        Sizes(edge, share)


def test_inlets_that_are_none():
    with refused("mass rate is -1"):
        Inlet((0,) * 3, (1,) * 3, -1.0, uniform_sizes(0.01, 0.02))
    with refused("narrower than its largest particle"):
        Inlet((0,) * 3, (0.03, 1.0, 1.0), 1.0, uniform_sizes(0.01, 0.02))


@pytest.mark.parametrize(
    "path",
    [[(0, 0, 0, 0)], [(0, 0, 0), (1, 0, 0)], [(0, 0, 0, 0), (0, 0, 0, 1)], [(1, 0, 0, 0), (0, 0, 0, 1)]],
)
def test_paths_that_are_none(path):
    with refused("four columns .* times that increase"):
        along_path(path)


def test_domain_upside_down():
    with refused("each end must lie above its beginning"):
        Domain((0.0, 0.0, 0.1), (0.1, 0.1, 0.0))
