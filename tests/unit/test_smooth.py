"""The Helmholtz filter: shapes, facets of several triangles, flips of edges, and what it refuses."""

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.material import Material
from wearfem.proofs.smoothing import uneven
from wearfem.surface import Surface, rectangle
from wearfem.wear.smooth import HelmholtzFilter, couplings

STEEL = Material("steel", 7850.0, 80e9, 0.3)


def test_blocks_are_smoothed_one_by_one():
    surface = uneven(6)
    field = np.random.default_rng(0).random((3, len(surface.triangle)))
    smoother = HelmholtzFilter(surface, 0.2)
    together = smoother(field)
    assert together.shape == field.shape
    for row, one in zip(together, field, strict=True):
        assert np.abs(row - smoother(one)).max() < 1e-14  # rounding: solved as columns of one matrix


def test_triangles_of_one_facet_share_its_value_and_facets_without_triangles_keep_theirs():
    cut = rectangle((0.0, 0.0), (1.0, 1.0), (4, 4), STEEL)
    facet = np.repeat(np.arange(16), 2) + 1  # no triangle belongs to facet 0
    surface = Surface(cut.point, cut.triangle, STEEL, facet)
    field = np.random.default_rng(0).random(17)
    smooth = HelmholtzFilter(surface, 0.2)(field)
    by_triangle = HelmholtzFilter(cut, 0.2)(field[facet]).reshape(-1, 2).mean(axis=1)
    assert smooth[0] == field[0]
    assert (
        np.abs(smooth[1:] - by_triangle).max() < 1e-14
    )  # rounding: the triangles of a square are of one size


def test_couplings_of_a_lattice_are_those_of_finite_differences():
    surface = rectangle((0.0, 0.0), (3.0, 3.0), (3, 3), STEEL)
    node = HelmholtzFilter(surface, 1.0).node
    matrix = couplings(surface, node, 0.5).toarray()
    np.fill_diagonal(matrix, 0.0)
    degree = np.sort(np.round(matrix.sum(axis=1), 12))
    assert np.allclose(
        degree, [2.0 * 0.5] * 4 + [2.0] * 8 + [4.0] * 4
    )  # corners 1/2 + 1/2, borders 1/2 + 1/2 + 1, inside 4


def test_an_obtuse_pair_and_an_obtuse_border_repel_nothing():
    point = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.05, 0.0], [0.5, -0.05, 0.0]])
    for triangle in ([[0, 1, 2], [1, 0, 3]], [[0, 1, 2]]):
        surface = Surface(point[: max(map(max, triangle)) + 1], np.array(triangle), STEEL)
        matrix = couplings(surface, HelmholtzFilter(surface, 1.0).node, 0.5)
        assert matrix.min() >= 0.0
        smooth = HelmholtzFilter(surface, 10.0)(np.arange(1.0, 1.0 + len(triangle)))
        assert smooth.min() >= 1.0 - 1e-12  # rounding


@pytest.mark.parametrize("length", [0.0, -1.0, np.nan, np.inf])
def test_a_length_that_is_none_is_refused(length):
    with pytest.raises(UserError, match="smoothing length"):
        HelmholtzFilter(uneven(3), length)


def test_a_field_that_does_not_fit_is_refused():
    smoother = HelmholtzFilter(uneven(3), 0.1)
    with pytest.raises(UserError, match="18 facets"):
        smoother(np.zeros(17))
    with pytest.raises(UserError, match="1 of 18 values"):
        smoother(np.where(np.arange(18) == 3, np.nan, 1.0))
