"""The solid against theory: every claim of its proof, and what the theories are compared with."""

import numpy as np
import pytest

from wearfem.proofs import solid as proof
from wearfem.verification.plate_elasticity import supported_block
from wearfem.verification.plate_theory import Plate, supported_plate


@pytest.fixture(scope="module")
def settled():
    return list(proof.claims())


def test_claims_hold(settled):
    failed = [
        f"{claim.claim}: {claim.computed} instead of {claim.expected}" for claim in settled if not claim.holds
    ]
    assert not failed


def test_thin_blocks_are_plates():
    exact, _ = supported_block(1.0, 0.01, 80e9, 0.3, 1e4, terms=11)
    mindlin, _ = supported_plate(Plate(1.0, 0.01, 208e9, 0.3, 1e4))
    assert exact == pytest.approx(mindlin, rel=1e-3)  # they part as (h / a)^2


def test_the_series_of_blocks_has_converged():
    few, many = (supported_block(1.0, 0.2, 80e9, 0.3, 1e4, terms) for terms in (13, 19))
    assert few[0] == pytest.approx(many[0], rel=1e-4)  # terms fall with the fifth power
    assert few[1] == pytest.approx(many[1], rel=1e-3)  # and the third


def test_without_poisson_ratio_a_block_is_a_mindlin_plate():
    """Without Poisson's ratio the exact block is Reissner's plate to (h / a)^4: the shear term of Mindlin."""
    exact, _ = supported_block(1.0, 0.1, 1e9, 0.0, 1.0, terms=11)
    mindlin, _ = supported_plate(Plate(1.0, 0.1, 2e9, 0.0, 1.0))
    assert exact == pytest.approx(
        mindlin, rel=1e-3
    )  # (h / a)^4 times k^4 / a^4 = 4 pi^4, over a factor of some 40


def test_manufactured_forces_balance_the_stress():
    """div sigma + f = 0, by central differences."""
    place, step = np.array([0.3, 0.4, 0.7]), 1e-4
    divergence = sum(
        (
            proof.hooke(proof.manufactured(place + step * axis)[1])
            - proof.hooke(proof.manufactured(place - step * axis)[1])
        )
        @ axis
        for axis in np.eye(3)
    ) / (2.0 * step)
    np.testing.assert_allclose(
        -divergence, proof.manufactured(place)[2], rtol=1e-6
    )  # differences of 2nd order
