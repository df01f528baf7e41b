"""The engine, its slow twin and the engine without compilation are one simulation."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from naive import Twin, scene

from wearfem.dem.contact import Contact
from wearfem.dem.energy import touching_pairs
from wearfem.dem.flow import Domain, Flow, Model
from wearfem.dem.particles import spheres
from wearfem.dem.sample import Stepper, advance
from wearfem.material import Material

TESTS = Path(__file__).parents[1]

WITHOUT_JIT = """
import sys, numpy as np
from naive import scene
from wearfem.dem.sample import Stepper
stepper = Stepper(*scene())
stepper.advance(120)
p = stepper.particles
np.savez(sys.argv[1], **p._asdict(), ledger=stepper.ledger, sums=stepper.tally.sums)
"""


def test_compiled_is_the_naive_twin():
    flow, model = scene()
    twin, stepper = Twin(flow, model), Stepper(flow, model)
    most_pairs, most_walls = 0, 0
    for _ in range(30):
        for _ in range(10):
            twin.step()
        stepper.advance(10)
        p = stepper.particles
        apart = p.position - twin.x[p.ident]
        apart[:, 0] -= 0.05 * np.round(apart[:, 0] / 0.05)
        assert np.abs(apart).max() < 1e-10 * 0.05  # rounding, a little amplified by impacts
        assert np.abs(p.velocity - twin.v[p.ident]).max() < 1e-10  # of 0.5 m/s
        assert np.abs(p.angular_velocity - twin.w[p.ident]).max() < 1e-10 * 100.0  # of 100 rad/s
        np.testing.assert_allclose(
            p.force, twin.force[p.ident], atol=1e-9 * np.abs(twin.force).max()
        )  # as above
        most_pairs = max(most_pairs, len(twin.pairs))
        most_walls = max(most_walls, sum(map(len, twin.walls)))
    assert most_pairs >= 4 and most_walls >= 4  # something touched


def test_compiled_is_not_compiled(tmp_path):
    """The same code, run by the Python interpreter in another process."""
    file = tmp_path / "end.npz"
    path = os.pathsep.join([str(TESTS), str(TESTS.parent / "src")])
    subprocess.run(
        [sys.executable, "-W", "ignore", "-c", WITHOUT_JIT, str(file)],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": path},
        check=True,
    )
    stepper = Stepper(*scene())
    stepper.advance(120)
    interpreted = np.load(file)
    compiled = stepper.particles._asdict() | {"ledger": stepper.ledger, "sums": stepper.tally.sums}
    assert stepper.tally.sums.any()
    for name, value in compiled.items():
        scale = np.abs(value).max()
        np.testing.assert_allclose(
            interpreted[name], value, atol=1e-12 * scale, err_msg=name
        )  # fused products


@pytest.mark.parametrize("periodic", [(False, False, False), (True, True, True), (False, True, False)])
def test_all_touching_pairs_are_found_at_a_size_ratio_of_ten(periodic):
    """Against all pairs, in a gas of points so soft and slow that nothing moves."""
    random = np.random.default_rng(3)
    count, width = 600, 0.1
    radius = 10.0 ** random.uniform(-3.0, -2.0, count) * 0.99
    radius[:2] = 1e-3, 1e-2
    soft = Material("soft", 2500.0, 1.0, 0.3)
    position = random.uniform(0.0, width, (count, 3))
    model = Model(
        (soft,), 1e-6, Domain((0.0,) * 3, (width,) * 3, periodic), contact=Contact(), gravity=(0.0,) * 3
    )
    stepper = Stepper(Flow(spheres(position, radius, 2500.0)), model)
    stepper.advance(1)
    flow = stepper.result()
    ident = flow.particles.ident
    found = {tuple(sorted((int(ident[i]), int(ident[j])))) for i, j, _ in touching_pairs(flow)}
    assert len(found) == len(touching_pairs(flow))  # each once
    apart = position[:, None] - position[None]
    apart -= np.where(periodic, width, 0.0) * np.round(apart / width)
    gap = np.linalg.norm(apart, axis=2) - radius[:, None] - radius
    expected = {(i, j) for i, j in zip(*np.nonzero(gap < 0.0), strict=True) if i < j}
    assert len(expected) > 100
    assert found == expected


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_periodic_border_is_no_place(axis):
    """Two spheres that collide across the border do what they do in the middle."""
    ends = []
    for shift in (0.1, 0.0):
        position = np.full((2, 3), 0.1)
        position[:, axis] = shift - 0.0049, shift + 0.0055
        position[1, (axis + 1) % 3] += 0.002
        velocity = np.zeros((2, 3))
        velocity[:, axis] = 1.0, -0.5
        flow = Flow(spheres(position % 0.2, 0.005, 2500.0, velocity=velocity))
        periodic = tuple(k == axis for k in range(3))
        model = Model((Material("ore", 2500.0, 4e6, 0.3),), 1e-5, Domain((0.0,) * 3, (0.2,) * 3, periodic))
        end = advance(flow, model, 0.02).particles
        order = np.argsort(end.ident)
        move = end.position[order] - position
        move -= 0.2 * np.round(move / 0.2)
        ends.append(np.concatenate([move, end.velocity[order], 0.01 * end.angular_velocity[order]]))
    assert np.abs(ends[0][:2]).max() > 1e-3  # they met and parted
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)  # rounding of positions
