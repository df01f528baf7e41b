"""The case checker: its formulas against hand values, and a warning exactly where one is due."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from wearfem.case import Stage, Window
from wearfem.check import (
    Facts,
    facts_of,
    findings,
    impact_duration,
    impact_overlap,
    rayleigh_time,
    static_overlap,
    summary,
)

# The held pin of the pin-on-disc paper: R = 2 mm, rho = 4850 kg/m3, nu = 0.24, G = 65 GPa, E* = 96.77 GPa, 5 N.
PIN = Facts(
    stage="slide",
    time_step=0.3e-6,
    duration=1.0,
    count=1,
    smallest_radius=0.002,
    largest_radius=0.002,
    rayleigh_time=rayleigh_time(0.002, 4850.0, 65e9, 0.24),
    effective_modulus=96.77e9,
    density=4850.0,
    speed=0.15,
    force=5.0,
    shortest_edge=0.8e-3,
    longest_edge=1.6e-3,
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
        ({"longest_edge": 2.1e-3}, {"longest edge"}),
        ({"shortest_edge": 1e-6}, {"longest edge"}),
        ({"shortest_edge": None, "longest_edge": None}, set()),
        ({"effective_modulus": 1e6, "shortest_edge": None}, {"overlap over radius"}),
        ({"time_step": 1.2e-6, "speed": 1.0, "rayleigh_time": 1.0}, {"time steps in an impact"}),
    ],
)
def test_a_warning_comes_where_it_is_due(change, warning):
    assert warned(replace(PIN, **change)) == warning


def test_the_summary_counts_the_warnings():
    assert summary(findings(PIN)) == "ready to run"
    assert summary(findings(replace(PIN, longest_edge=1.0))).startswith("1 warning;")


def test_the_facts_are_those_of_the_flow_and_the_model():
    material = pytest.importorskip("wearfem.material")
    steel = material.Material("steel", 7932.0, 78e9, 0.3)
    ore = material.Material("ore", 4850.0, 65e9, 0.24)
    particles = SimpleNamespace(
        position=np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.2]]),
        velocity=np.array([[0.0, 3.0, 0.0], [0.0, 0.0, 0.0]]),
        radius=np.array([0.002, 0.004]),
        mass=np.array([1.0, 2.0]),
        applied_force=np.array([[0.0, 0.0, -5.0], [0.0, 0.0, 0.0]]),
        material=np.array([1, 1]),
    )
    triangle = np.array([[[0.0, 0.0, 0.0], [0.003, 0.0, 0.0], [0.0, 0.004, 0.0]]])
    model = SimpleNamespace(
        materials=(steel, ore),
        surfaces=(SimpleNamespace(corner=triangle),),
        gravity=(0.0, 0.0, -10.0),
        time_step=1e-6,
    )
    facts = facts_of(SimpleNamespace(particles=particles), Stage("fall", model, Window(0.5)))
    assert (facts.count, facts.smallest_radius, facts.largest_radius) == (2, 0.002, 0.004)
    assert facts.rayleigh_time == rayleigh_time(0.002, 4850.0, 65e9, 0.24)
    assert facts.speed == pytest.approx(
        (3.0**2 + 2 * 10.0 * 0.2) ** 0.5, rel=1e-12
    )  # 0.2 m is the largest extent
    assert facts.force == 20.0
    assert (facts.shortest_edge, facts.longest_edge) == pytest.approx((0.003, 0.005), rel=1e-12)
    compliance_of_steel = (1 - 0.3) / (2 * 78e9)
    assert facts.effective_modulus == pytest.approx(0.5 / compliance_of_steel, rel=1e-12)
    assert facts.density == 4850.0
