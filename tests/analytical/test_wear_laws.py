"""The wear laws hold what `wearfem verify wear_laws` claims."""

import numpy as np
import pytest

from wearfem.proofs import wear_laws
from wearfem.wear.impact_laws import KineticEnergy


def test_formulas_by_another_route():
    failed = [claim for claim in wear_laws.formulas() if not claim.holds]
    assert not failed, failed


def test_classes_with_moments_lose_less_than_a_hundredth():
    """The bound, 1 %, is what is asked; without moments a narrow beam is off by tens of per cent, so the beams do ask something."""
    claims = list(wear_laws.classes())
    failed = [claim for claim in claims if not claim.holds]
    assert not failed, failed
    bare = [claim.computed for claim in claims if "without moments" in claim.claim]
    assert max(bare) > 0.3


def test_the_m_v2_law_needs_no_classes():
    beam = next(wear_laws.beams())
    kept = beam.loads(angles=3, per_decade=1)
    # a sum of 20 000 terms in another order
    assert KineticEnergy(1e-11).volume(kept)[0] == pytest.approx(2e-11 * beam.energy.sum(), rel=1e-12)


def test_tied_angles_and_speeds_are_among_the_beams():
    tied = [np.corrcoef(beam.angle, np.log(beam.speed))[0, 1] for beam in wear_laws.beams()]
    assert max(tied) > 0.75


@pytest.mark.slow
def test_stored_statistics_and_sums_on_the_fly():
    failed = [claim for claim in wear_laws.rain() if not claim.holds]
    assert not failed, failed
