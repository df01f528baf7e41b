"""The orders of the solid on finer meshes than its proof has time for."""

import numpy as np
import pytest

from wearfem.liner.block import Hexahedra, Tetrahedra
from wearfem.proofs.solid import errors


@pytest.mark.slow
@pytest.mark.parametrize("kind", [Tetrahedra, Hexahedra], ids=["tetrahedra", "hexahedra"])
def test_quadratic_elements_are_of_third_and_second_order(kind):
    coarse, fine = errors(kind, 5), errors(kind, 10)
    order = np.log2(np.array(coarse) / fine)
    assert order[0] == pytest.approx(3.0, abs=0.15)  # displacement; twice as near as from 3 to 6 cells
    assert order[1:] == pytest.approx(2.0, abs=0.2)  # stress in the mean and at the nodes
