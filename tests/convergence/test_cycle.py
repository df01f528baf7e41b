"""The order in time of the jump scheme, through loads, law, mesh and recession."""

import pytest

from wearfem.proofs import cycle as proof


@pytest.mark.slow
@pytest.mark.parametrize("law", ["hardness_gradient", "running_in"])
def test_second_order(law):
    judged, shown = proof.order(law, (40, 80))
    assert judged.holds, judged
    assert shown.computed > judged.computed  # what is taken off is the bias
