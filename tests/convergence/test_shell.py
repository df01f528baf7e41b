"""Orders of the shell: deflection and moments of plates, membranes, and the obstacle course under refinement."""

import numpy as np
import pytest

from wearfem.liner.block import Falling, Rising
from wearfem.liner.shell import at_nodes, resultants
from wearfem.proofs import shell as proof
from wearfem.proofs._shell_problems import OBSTACLES, W, elastic, square_plate
from wearfem.verification.plate_theory import Plate, clamped_plate, supported_plate


def orders(error):
    error = np.abs(error)
    return np.log2(error[:-1] / error[1:])


@pytest.mark.parametrize("cut", [Rising, Falling], ids=["rising", "falling"])
@pytest.mark.parametrize("h", [1e-3, 0.1])
def test_deflection_of_a_clamped_plate_is_second_order(h, cut):
    exact = clamped_plate(Plate(1.0, h, 1e9, 0.3, 1.0))
    moved = [
        -square_plate(n, h, proof.CLAMPED, elastic(1e9, 0.3), cut).displacement()[0, W] for n in (8, 16, 32)
    ]
    assert orders(np.array(moved) - exact) == pytest.approx(2.0, abs=0.2)  # nearly asymptotic


@pytest.mark.parametrize("h", [1e-3, 0.1])
def test_moments_of_a_supported_plate_are_second_order(h):
    """Means at the nodes; the moment at the centre."""
    exact = supported_plate(Plate(1.0, h, 1e9, 0.3, 1.0))[1]
    error = []
    for n in (8, 16, 32):
        problem = square_plate(n, h, proof.SUPPORTED, elastic(1e9, 0.3), Falling)
        section = resultants(problem.mesh, problem.material, problem.displacement())
        error.append(abs(at_nodes(problem.mesh, section.moment)[0, 0]) - exact)
    assert orders(np.array(error)).min() > 1.0  # better than the first order of a single triangle


@pytest.mark.slow
@pytest.mark.parametrize("one", OBSTACLES, ids=lambda one: one.name)
def test_the_obstacle_course_converges(one):
    value = np.array([one.computed(n, Rising) for n in (8, 16, 32, 64)]) / one.reference
    step = np.abs(np.diff(value))
    assert step[-1] < 0.02  # from 32 to 64 the value changes by less than the asked 2 %
    assert abs(value[-1] - 1.0) < 0.02  # and stays within 2 %: 32 is no lucky crossing
