"""The order at which a receding surface follows closed forms, and its proofs."""

import numpy as np
import pytest

from wearfem.proofs import moving_front, recession


def test_a_drum_worn_inside_keeps_its_radius_at_second_order():
    coarse, fine = (
        recession.wear_round(recession.drum(cells, True), 2, True, total=0.02) for cells in (6, 12)
    )
    assert recession.order(coarse.error, fine.error) == pytest.approx(2.0, abs=0.1)  # flat facets
    assert fine.spread < 1e-8  # all nodes are alike; the elastic motion is right to 1e-6 of the depth
    assert fine.volume < 1e-10  # as asked


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["hill", "valley"])
def test_a_front_follows_its_characteristics_at_second_order(sign):
    coarse, fine = (moving_front.erode(cells, moving_front.SMOOTH, sign) for cells in (12, 24))
    assert np.log2(coarse.mean_error / fine.mean_error) > 1.8  # second, on coarse meshes


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["hill", "valley"])
def test_the_entropy_solution_agrees_with_godunovs_scheme(sign):
    """Another route to the expected values: an upwind scheme on a fine grid, first order."""
    cells = 4000
    x = np.linspace(-0.25, 1.25, cells + 1)
    z, step = moving_front.wave(x, sign), x[1] - x[0]
    steps = int(np.ceil(moving_front.BEYOND / (0.9 * step)))
    dt = moving_front.BEYOND / steps
    for _ in range(steps):
        left = np.concatenate([[0.0], np.diff(z) / step])
        right = np.concatenate([np.diff(z) / step, [0.0]])
        z = z - dt * np.maximum(  # Godunov for a convex F with its least at 0
            moving_front.erosion(np.maximum(left, 0.0)), moving_front.erosion(np.minimum(right, 0.0))
        )
    apart = np.abs(z - moving_front.entropy_solution(x, moving_front.BEYOND, sign))
    assert apart.mean() < step  # first order: the error is of the size of a cell, 0.4 mm, times its slope


@pytest.mark.slow
@pytest.mark.parametrize("proof", [recession, moving_front], ids=["recession", "moving front"])
def test_every_claim_holds(proof):
    for claim in proof.claims():
        assert claim.holds, claim
