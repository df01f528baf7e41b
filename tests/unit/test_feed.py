"""Inlets give the mass and the sizes that they promise, seeded; outlets take particles out and count them."""

import numpy as np
import pytest

from wearfem.dem.feed import Inlet, Sizes, uniform_sizes
from wearfem.dem.flow import Domain, Flow, Model
from wearfem.dem.particles import spheres
from wearfem.dem.sample import advance
from wearfem.material import Material

ORE = Material("ore", 2500.0, 4e6, 0.3)
NONE = spheres(np.zeros((0, 3)), 1e-3, 2500.0)


def fed(seed=0, duration=0.4):
    """A vertical stream of 50 g/s that falls out of the domain after 0.2 m."""
    inlet = Inlet(
        (-0.03, -0.03, 0.15), (0.03, 0.03, 0.19), 0.05, uniform_sizes(1e-3, 2e-3), (0, 0, -1.0), seed=seed
    )
    domain = Domain((-0.1, -0.1, 0.0), (0.1, 0.1, 0.2), outlet=True)
    return advance(Flow(NONE), Model((ORE,), 1e-5, domain, inlets=(inlet,)), duration)


def test_mass_comes_in_at_the_rate_and_goes_out_by_the_outlet():
    flow = fed()
    largest = 2500.0 * 4 / 3 * np.pi * 2e-3**3
    assert flow.fed[0] == pytest.approx(0.05 * 0.4, abs=50 * largest)  # what was due but not yet placed
    assert flow.left_mass > 0.0
    assert flow.particles.mass.sum() + flow.left_mass == pytest.approx(
        flow.fed[0], rel=1e-12
    )  # nothing is lost
    assert len(set(flow.particles.ident)) == flow.particles.count


def test_the_seed_decides():
    one, same, other = fed(1, 0.1), fed(1, 0.1), fed(2, 0.1)
    assert one.particles.position.tobytes() == same.particles.position.tobytes()
    assert one.particles.radius.tobytes() != other.particles.radius.tobytes()


def test_sizes_follow_the_mass_shares():
    sizes = Sizes((1e-3, 2e-3, 4e-3, 4e-3), (0.2, 0.5, 0.3))
    radius = sizes.draw(200_000, np.random.default_rng(0))
    mass = radius**3 / (radius**3).sum()
    shares = [
        mass[radius < 2e-3].sum(),
        mass[(radius >= 2e-3) & (radius < 4e-3)].sum(),
        mass[radius == 4e-3].sum(),
    ]
    np.testing.assert_allclose(shares, (0.2, 0.5, 0.3), atol=0.01)  # three standard errors of 200 000 draws
    assert (sizes.smallest, sizes.largest) == (1e-3, 4e-3)
