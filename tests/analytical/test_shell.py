"""The shell against theory and published shells: every claim of its proof, and moments beside deflections."""

import numpy as np
import pytest

from wearfem.liner.shell import at_nodes, resultants
from wearfem.proofs import shell as proof
from wearfem.proofs._shell_problems import W, elastic, node_at, square_plate
from wearfem.verification.plate_theory import Plate, clamped_plate, supported_plate


@pytest.mark.parametrize(
    "part",
    [
        proof.rigid_motions,
        proof.patch_tests,
        proof.plates,
        proof.obstacle_course,
        proof.cantilevers,
        proof.powers_of_thickness,
        pytest.param(proof.worn_pocket, marks=pytest.mark.slow),
        proof.solid_and_shell,
    ],
    ids=lambda part: part.__name__,
)
def test_claims_hold(part):
    for claim in part():
        assert claim.holds, f"{claim.claim}: {claim.computed} instead of {claim.expected}"


@pytest.mark.parametrize("h", [1e-3, 0.1, 0.2])
def test_moments_of_a_supported_plate(h):
    material = elastic(1e9, 0.3)
    problem = square_plate(32, h, proof.SUPPORTED, material)
    section = resultants(problem.mesh, material, problem.displacement())
    moment = at_nodes(problem.mesh, section.moment)[node_at(problem.mesh, 0.0, 0.0), 0]
    expected = supported_plate(Plate(1.0, h, 1e9, 0.3, 1.0))[1]
    assert -moment == pytest.approx(
        expected, rel=5e-3
    )  # as deflections; pressed from above, the worn face is short


def test_ritz_meets_the_published_clamped_plate():
    """0.00126532 q a^4 / D: Taylor and Govindjee (2004)."""
    plate = Plate(1.0, 1e-4, 1e9, 0.3, 1.0)
    assert clamped_plate(plate) * plate.bending_stiffness == pytest.approx(0.00126532, abs=5e-9)  # last digit


def test_ritz_has_converged():
    for h in proof.THICKNESS:
        plate = Plate(1.0, h, 1e9, 0.3, 1.0)
        assert clamped_plate(plate, 14) == pytest.approx(
            clamped_plate(plate, 20), rel=1e-6
        )  # 0.5 % is judged


def test_navier_meets_the_published_thin_plate():
    """0.004062 q a^4 / D and 0.0479 q a^2: Timoshenko and Woinowsky-Krieger (1959), table 8."""
    plate = Plate(1.0, 1e-4, 1e9, 0.3, 1.0)
    deflection, moment = supported_plate(plate)
    assert deflection * plate.bending_stiffness == pytest.approx(0.00406, abs=5e-6)  # last digit
    assert moment == pytest.approx(0.0479, abs=5e-5)  # last digit


def test_a_thin_plate_does_not_lock():
    """Deflection times stiffness is the same from h / a = 1e-3 down to 1e-6, on a coarse mesh too."""
    value = []
    for h in (1e-3, 1e-4, 1e-5, 1e-6):
        moved = square_plate(8, h, proof.CLAMPED, elastic(1e9, 0.3)).displacement()
        value.append(moved[0, W] * h**3)
    assert np.ptp(value) < 1e-4 * np.abs(value[0])  # shear adds (h / a)^2 times some 30
