"""The same bits: for any number of threads, twice, in one window or several, and after a pickle."""

import pickle

import numpy as np
import pytest

from wearfem.case import Window
from wearfem.dem.contact import Contact, ElasticPlasticRolling, FrictionTwisting, HertzMindlin
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.motion import vibration
from wearfem.dem.neighbours import chunk_bounds
from wearfem.dem.particles import spheres
from wearfem.dem.sample import sample
from wearfem.jit import set_thread_count, thread_count
from wearfem.material import Material
from wearfem.surface import rectangle

ORE = Material("ore", 2500.0, 1e7 / 2.6, 0.3, 0.5, 0.5, 0.1)


def bed(count: int) -> tuple[Flow, Model]:
    """Spheres of several sizes, slightly overlapping, thrown on a shaking plate of 200 triangles; periodic in x and y."""
    random = np.random.default_rng(5)
    across = 22
    place = np.stack(np.unravel_index(np.arange(count), (count // across**2 + 1, across, across)), axis=1)
    width = across * 4e-3
    position = 4e-3 * (place[:, ::-1] + 0.5) + random.uniform(-2e-5, 2e-5, (count, 3))
    radius = random.uniform(1.0e-3, 2.02e-3, count)
    particles = spheres(position, radius, ORE.density, velocity=random.normal(0.0, 0.2, (count, 3)))
    domain = Domain((0.0, 0.0, -0.05), (width, width, 0.2), (True, True, False))
    plate = rectangle((0.0, 0.0), (width, width), (10, 10), ORE)
    law = Contact(HertzMindlin(), ElasticPlasticRolling(), FrictionTwisting())
    walls = (Wall(plate, vibration((0.0, 0.0, 2e-4), 50.0)),)
    return Flow(particles), Model((ORE,), 1e-5, domain, walls, contact=law)


def bits(flow: Flow) -> bytes:
    """All that a flow is."""
    arrays = [*flow.particles, *flow.pairs, *flow.walls, flow.packed, flow.ledger, flow.travel, flow.drift]
    return b"".join(np.ascontiguousarray(array).tobytes() for array in arrays) + repr(flow.step).encode()


def load_bits(loads) -> bytes:
    """All that it left."""
    return b"".join(np.ascontiguousarray(array).tobytes() for array in vars(loads).values())


@pytest.fixture
def threads():
    before = thread_count()
    yield
    set_thread_count(before)


def test_the_same_bits_for_one_thread_and_two_and_twice(threads):
    flow, model = bed(6000)
    assert len(chunk_bounds(6000)) - 1 > 1  # several tasks
    results = []
    for count in (1, 2, 2):
        set_thread_count(count)
        end, loads, _ = sample(flow, model, Window(0.003, 2))
        results.append((bits(end), load_bits(loads)))
    assert loads.contact_count.sum() > 100  # something happened
    assert results[0] == results[1] == results[2]


def test_three_windows_are_one():
    flow, model = bed(500)
    whole, loads, _ = sample(flow, model, Window(0.006, 3))
    part, blocks = flow, []
    for _ in range(3):
        part, left, _ = sample(part, model, Window(0.002))
        blocks.append(left)
    assert bits(part) == bits(whole)
    for name in ("normal_impulse", "load_distance", "friction_work", "impact_energy", "contact_count"):
        together = np.concatenate([getattr(block, name) for block in blocks])
        assert together.tobytes() == getattr(loads, name).tobytes()


def test_blocks_and_snapshots_change_nothing():
    flow, model = bed(500)
    one, _, _ = sample(flow, model, Window(0.006, 1))
    many, _, kept = sample(flow, model, Window(0.006, 3, 6))
    for name in one.particles._fields:
        assert getattr(one.particles, name).tobytes() == getattr(many.particles, name).tobytes()
    assert [round(snapshot.step) for snapshot in kept] == [100, 200, 300, 400, 500, 600]
    third, _, _ = sample(flow, model, Window(0.003))
    assert kept[2].particles.position.tobytes() == third.particles.position.tobytes()
    assert kept[5].particles.position.tobytes() == many.particles.position.tobytes()


def test_a_flow_kept_in_a_file_goes_on_to_the_bit():
    flow, model = bed(500)
    half, _, _ = sample(flow, model, Window(0.003))
    before = bits(half)
    unbroken, _, _ = sample(half, model, Window(0.003))
    assert bits(half) == before  # sampling does not change what it was given
    resumed, _, _ = sample(pickle.loads(pickle.dumps(half)), model, Window(0.003))
    assert bits(resumed) == bits(unbroken)
