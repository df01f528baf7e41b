"""The case checker: its formulas against hand values, and a warning exactly where one is due."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.case import Case, Stage, Window
from wearfem.check import (
    Facts,
    Mesh,
    bytes_per_particle,
    case_facts,
    findings,
    impact_duration,
    impact_overlap,
    rayleigh_time,
    static_overlap,
    summary,
)
from wearfem.dem.feed import Inlet, uniform_sizes
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.motion import rotation, vibration
from wearfem.dem.particles import spheres
from wearfem.material import Material
from wearfem.surface import Plane, Surface, rectangle

# The held pin of the pin-on-disc paper: R = 2 mm, rho = 4850 kg/m3, nu = 0.24, G = 65 GPa, E* = 96.77 GPa, 5 N.
PIN = Facts(
    stage="slide",
    time_step=0.3e-6,
    duration=1.0,
    start_count=1,
    count=1,
    smallest_radius=0.002,
    largest_radius=0.002,
    rayleigh_time=rayleigh_time(0.002, 4850.0, 65e9, 0.24),
    effective_modulus=96.77e9,
    density=4850.0,
    speed=0.15,
    force=5.0,
    bytes_per_particle=1000.0,
    meshes=(Mesh("disc", 0.8e-3, 1.6e-3),),
)


def test_the_rayleigh_time_of_the_pin_is_the_published_one():
    assert PIN.rayleigh_time == pytest.approx(1.874e-6, rel=3e-4)  # printed with four digits


def test_the_static_overlap_carries_its_force():
    overlap = static_overlap(5.0, 0.002, 96.77e9)
    assert 4.0 / 3.0 * 96.77e9 * 0.002**0.5 * overlap**1.5 == pytest.approx(5.0, rel=1e-12)


def test_the_impact_stores_its_kinetic_energy():
    mass, speed = 1.6e-4, 2.0
    overlap = impact_overlap(mass, speed, 0.002, 96.77e9)
    stored = 8.0 / 15.0 * 96.77e9 * 0.002**0.5 * overlap**2.5
    assert stored == pytest.approx(0.5 * mass * speed**2, rel=1e-12)
    assert impact_duration(overlap, speed) == pytest.approx(2.9432750 * overlap / 2.0, rel=1e-12)


def warned(facts):
    return {finding.name for finding in findings(facts) if finding.warning}


@pytest.mark.parametrize(
    ("change", "warning"),
    [
        ({}, set()),
        ({"time_step": 0.8e-6}, {"time step over Rayleigh time"}),
        ({"speed": 0.0}, set()),
        ({"meshes": (Mesh("disc", 0.8e-3, 2.1e-3),)}, {"longest edge of the disc"}),
        ({"meshes": (Mesh("disc", 1e-6, 1.6e-3),)}, {"longest edge of the disc"}),
        ({"meshes": (Mesh("disc", 1e-6, 1.0),), "wears": False}, set()),
        ({"meshes": ()}, set()),
        ({"effective_modulus": 1e6, "meshes": ()}, {"overlap over radius, steady load"}),
        (
            {"effective_modulus": 1e6, "speed": 5.0, "force": 0.0, "meshes": ()},
            {"overlap over radius, impact"},
        ),
        ({"time_step": 1.2e-6, "speed": 1.0, "rayleigh_time": 1.0}, {"time steps in an impact"}),
        ({"periodic_width": 0.016}, {"periodic width over largest diameter"}),
        ({"periodic_width": 0.017}, set()),
        ({"count": 10**14}, {"memory"}),
    ],
)
def test_a_warning_comes_where_it_is_due(change, warning):
    assert warned(replace(PIN, **change)) == warning


def test_the_summary_counts_the_warnings():
    assert summary(findings(PIN)) == "ready to run"
    assert summary(findings(replace(PIN, meshes=(Mesh("disc", 1e-3, 1.0),)))).startswith("1 warning;")


STEEL = Material("steel", 7932.0, 78e9, 0.3)
ORE = Material("ore", 4850.0, 65e9, 0.24)


def facts_of(flow, model, duration=0.5, wear_law=None):
    case = Case("box", flow, (Stage("fall", model, Window(duration)),), wear_law, measure=lambda outcome: ())
    return case_facts(case)


def box(**changes):
    given = {
        "materials": (STEEL, ORE),
        "time_step": 1e-6,
        "domain": Domain((-1, -1, -1), (1, 1, 1)),
        "gravity": (0.0, 0.0, -10.0),
    }
    return Model(**{**given, **changes})


def test_the_facts_are_those_of_the_flow_and_the_model():
    particles = spheres(
        np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.2]]),
        np.array([0.002, 0.004]),
        ORE.density,
        velocity=np.array([[0.0, 3.0, 0.0], [0.0, 0.0, 0.0]]),
        applied_force=np.array([[0.0, 0.0, -5.0], [0.0, 0.0, 0.0]]),
        material=1,
    )
    triangle = Surface(
        np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.4, 0.0]]), np.array([[0, 1, 2]]), STEEL
    )
    (facts,) = facts_of(Flow(particles), box(walls=(Wall(triangle),)))
    assert (facts.start_count, facts.count, facts.smallest_radius, facts.largest_radius) == (
        2,
        2,
        0.002,
        0.004,
    )
    assert facts.rayleigh_time == pytest.approx(
        rayleigh_time(0.002, 4850.0, 65e9, 0.24), rel=1e-14
    )  # rounding
    assert facts.speed == pytest.approx((3.0**2 + 2 * 10.0 * 0.2) ** 0.5, rel=1e-12)  # 0.2 m is the height
    assert facts.force == pytest.approx(5.0 + 10.0 * particles.mass[0], rel=1e-12)
    assert facts.meshes == (Mesh("surface", pytest.approx(0.3), pytest.approx(0.5)),)
    compliance = (1 - 0.24) / (2 * 65e9) * 2
    assert facts.effective_modulus == pytest.approx(1 / compliance, rel=1e-12)  # of ore on ore, the softest
    assert facts.density == pytest.approx(4850.0, rel=1e-14)
    assert not facts.wears


def test_inlets_count_where_nothing_is_there_at_the_start():
    """10 kg/s of 20 mm spheres for 0.4 s of two stages of 0.3 s, from 0.5 m above a plane at 2 m/s."""
    inlet = Inlet(
        (-0.1, -0.1, 0.4),
        (0.1, 0.1, 0.5),
        10.0,
        uniform_sizes(0.01, 0.01),
        (0.0, 0.0, -2.0),
        material=1,
        stop=0.4,
    )
    model = box(inlets=(inlet,), walls=(Wall(Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), STEEL)),))
    stages = tuple(Stage(name, model, Window(0.3)) for name in ("first", "second"))
    case = Case("fed", Flow(spheres(np.zeros((0, 3)), 0.0, 1.0)), stages, None, measure=lambda outcome: ())
    first, second = case_facts(case)
    each = 4850.0 * 4.0 / 3.0 * np.pi * 0.01**3
    assert (first.start_count, first.count) == (0, round(3.0 / each))
    assert (second.start_count, second.count) == (first.count, first.count + round(1.0 / each))
    assert first.speed == pytest.approx((2.0**2 + 2 * 10.0 * 0.5) ** 0.5, rel=1e-12)
    assert not any(np.isnan(finding.value) for facts in (first, second) for finding in findings(facts))


def test_a_stage_without_any_particles_says_nothing():
    assert facts_of(Flow(spheres(np.zeros((0, 3)), 0.0, 1.0)), box()) == ()


@pytest.mark.parametrize(
    ("motion", "speed"),
    [
        (rotation(7.0), 0.0),  # a disc in its own plane makes no impact
        (rotation(7.0, axis=(0.0, 1.0, 0.0)), 7.0 * 0.5),
        (vibration((0.3, 0.0, 0.004), 10.0), 0.004 * 2 * np.pi * 10.0),
    ],
)
def test_a_wall_is_as_fast_as_it_moves_across_itself(motion, speed):
    wall = Wall(rectangle((-0.5, -0.5), (0.5, 0.5), (2, 2), STEEL), motion)
    flow = Flow(spheres(np.zeros((1, 3)), 0.01, ORE.density, material=1))
    (facts,) = facts_of(flow, box(walls=(wall,), gravity=(0.0, 0.0, 0.0)))
    assert facts.speed == pytest.approx(speed, rel=1e-12)


def test_bytes_are_those_of_the_arrays():
    """State 173, packed copy and references 144, eight pairs of 12 + 32 bytes; all twice."""
    assert bytes_per_particle(box()) == 2 * (173 + 144 + 8 * (12 + 32))
