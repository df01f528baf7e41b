"""Two-way stiffness: every claim of its proof, and the impact behind the indicator by brute force."""

import numpy as np
import pytest
from scipy.sparse import identity
from scipy.sparse.linalg import splu

from wearfem.liner.vibration import mass_matrix
from wearfem.proofs import flexure as proof


@pytest.mark.parametrize(
    "part",
    [proof.frequencies, proof.impacts, proof.indicator, proof.moving_load, proof.memory],
    ids=lambda part: part.__name__,
)
def test_claims_hold(part):
    for claim in part():
        assert claim.holds, f"{claim.claim}: {claim.computed} instead of {claim.expected}"


def test_the_advice_fits_the_finding():
    fines, lumps = proof.judged(0.04, proof.FINES), proof.judged(1e-3, proof.LUMPS)
    assert fines.verdict.startswith("Deflection does not matter")
    assert "exchange" in lumps.verdict and "restitution" in lumps.verdict and "vibration" in lumps.verdict
    assert lumps.shape_matters and lumps.impact_matters and not lumps.quasi_static
    steepest = 16.0 / np.sqrt(
        27.0
    )  # of (1 - x^2)^2, -1 < x < 1: the shape of a clamped strip, near that of the plate; its side is 1 m
    assert fines.slope / fines.deflection == pytest.approx(steepest, rel=0.05)
    assert fines.amplification == pytest.approx(
        1.0 / (1.0 - (16.0 / fines.frequency) ** 2), rel=1e-12
    )  # the same formula


def test_an_endless_plate_answers_a_push_as_a_dashpot():
    """The middle of a large free-standing plate, stepped in time from its own matrices, against v = F / 8 sqrt(D rho h)."""
    h, force, cells = 0.01, 1.0, 40
    ready = proof.supported_sheet(h, cells)
    body, free = ready.body, ready.free
    middle = 6 * ((cells // 2) * (cells + 1) + cells // 2) + 2
    stiffness, mass = free @ ready.stiffness @ free, free @ mass_matrix(body) @ free
    step, load = 1e-5, np.zeros(stiffness.shape[0])
    load[middle] = force
    drilling = 1e-9 * mass.diagonal().max()  # turning about the normal has no mass
    held = identity(stiffness.shape[0]) - free
    system = (
        mass + drilling * identity(len(load)) + 0.25 * step**2 * stiffness + mass.diagonal().max() * held
    ).tocsc()
    factors = splu(system)
    u, v, a = np.zeros_like(load), np.zeros_like(load), np.zeros_like(load)
    track = []
    for _ in range(150):  # Newmark's average acceleration; 1.5 ms, in which the edges are not heard of
        guess = u + step * v + 0.25 * step**2 * a
        new = factors.solve(free @ (load - stiffness @ guess))
        u, v, a = guess + 0.25 * step**2 * new, v + 0.5 * step * (a + new), new
        track.append(u[middle])
    bending = proof.STEEL.young_modulus * h**3 / 12.0 / (1.0 - 0.3**2)
    speed = force / (8.0 * np.sqrt(bending * proof.STEEL.density * h))
    found = (track[-1] - track[49]) / (100 * step)
    assert found == pytest.approx(speed, rel=0.05)  # waves shorter than four cells are not the plate's
