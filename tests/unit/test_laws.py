"""Wear laws against values worked out by hand."""

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.loads import FacetLoads
from wearfem.wear.laws import Archard, ShearWork, worn_depth

EXACT = 1e-15  # relative: a product of three numbers is right to a few roundings


def loads(**given):
    """Two blocks of 2 s and 4 s on three facets; everything that is not given is zero."""
    zeros = {name: np.zeros((2, 3)) for name in FacetLoads.__dataclass_fields__}
    zeros |= {"duration": np.array([2.0, 4.0]), "area": np.array([1e-2, 2e-2, 0.0])}
    return FacetLoads(**(zeros | given))


def test_archard():
    law = Archard(1e-12)
    pressed = loads(load_distance=np.array([[6.0, 0.0, 0.0], [8.0, 40.0, 0.0]]))
    # 1e-12 m2/N x 6 N m / (0.01 m2 x 2 s), and so on
    expected = [[3e-10, 0.0, 0.0], [2e-10, 5e-10, 0.0]]
    np.testing.assert_allclose(law.depth_rate(pressed), expected, rtol=EXACT)
    np.testing.assert_allclose(law.volume(pressed), [14e-12, 40e-12, 0.0], rtol=EXACT)
    np.testing.assert_allclose(worn_depth(law, pressed), [14e-10, 20e-10, 0.0], rtol=EXACT)


def test_shear_work():
    law = ShearWork(2e-11)
    rubbed = loads(friction_work=np.array([[3.0, 1.0, 0.0], [0.0, 0.0, 0.0]]))
    # 2e-11 m3/J x 3 J / (0.01 m2 x 2 s), and so on
    np.testing.assert_allclose(law.depth_rate(rubbed)[0], [3e-9, 5e-10, 0.0], rtol=EXACT)
    np.testing.assert_allclose(law.volume(rubbed), [6e-11, 2e-11, 0.0], rtol=EXACT)
    np.testing.assert_allclose(worn_depth(law, rubbed), [6e-9, 1e-9, 0.0], rtol=EXACT)


def test_a_facet_that_nothing_touches_does_not_wear():
    for law in (Archard(1e-12), ShearWork(1e-12)):
        assert (law.depth_rate(loads()) == 0.0).all()  # exactly, also where the area is 0


@pytest.mark.parametrize("make", [Archard, ShearWork])
@pytest.mark.parametrize("value", [-1e-12, np.inf, np.nan])
def test_a_surface_does_not_grow(make, value):
    with pytest.raises(UserError, match="0 or more"):
        make(value)
