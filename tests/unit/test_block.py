"""Lattice meshes: volume, closed boundary, groups and normals against what a box has."""

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.liner.block import (
    Falling,
    Hexahedra,
    Rising,
    Tetrahedra,
    block,
    mapped,
    sheet,
    with_group,
)
from wearfem.liner.liner import worn_face
from wearfem.liner.mesh import triangles

EXACT = 1e-12  # relative; sums of a few hundred rounded terms

LOWER, UPPER = (0.1, -0.2, 0.3), (1.1, 0.5, 0.7)


def area_vector(mesh, facet):
    a, b, c = np.moveaxis(mesh.node[triangles(facet)[0]], 1, 0)
    return 0.5 * np.cross(b - a, c - a).sum(axis=0)


@pytest.mark.parametrize("kind", [Tetrahedra, Hexahedra])
def test_a_block_is_a_box(kind):
    mesh = block(LOWER, UPPER, (3, 4, 2), kind)
    assert mesh.volume == pytest.approx(1.0 * 0.7 * 0.4, rel=EXACT)
    assert area_vector(mesh, mesh.boundary) == pytest.approx(np.zeros(3), abs=EXACT)
    size = {"wear": (0, 0, 0.7), "bottom": (0, 0, -0.7), "x_low": (-0.28, 0, 0), "x_high": (0.28, 0, 0),
            "y_low": (0, -0.4, 0), "y_high": (0, 0.4, 0), "rim": (0, 0, 0)}  # fmt: skip
    assert set(mesh.group) == set(size)
    for name, vector in size.items():
        assert area_vector(mesh, mesh.group[name]) == pytest.approx(vector, abs=EXACT)
    assert len(mesh.group["rim"]) + len(mesh.wear) + len(mesh.group["bottom"]) == len(mesh.boundary)
    assert mesh.node[(1 * 5 + 2) * 3 + 1] == pytest.approx([0.1 + 1 / 3, 0.15, 0.5])


@pytest.mark.parametrize("kind", [Rising, Falling])
def test_a_sheet_is_a_rectangle(kind):
    mesh = sheet((0, 0), (2, 1), (4, 3), 0.01, kind, offset=0.02)
    assert area_vector(mesh, mesh.wear) == pytest.approx([0, 0, 2.0], rel=EXACT)
    assert len(mesh.group["rim"]) == 2 * (4 + 3)
    along = mesh.node[mesh.group["x_high"]]
    assert (along[:, 1, 1] > along[:, 0, 1]).all() and (along[..., 0] == 2.0).all()  # shell on the left
    assert worn_face(mesh)[:, 2] == pytest.approx(0.025)


def test_a_map_bends():
    mesh = block((0, 0, 1), (np.pi / 2, 1, 2), (40, 1, 3), Hexahedra)
    bent = mapped(
        mesh, lambda x: np.column_stack([x[:, 2] * np.sin(x[:, 0]), x[:, 1], x[:, 2] * np.cos(x[:, 0])])
    )
    chord = np.sin(np.pi / 80) / (np.pi / 80)  # area of a polygon to that of its circle, sectors of pi / 80
    assert bent.volume == pytest.approx(np.pi / 4 * 3.0 * chord, rel=1e-12)  # exact for the polygon
    assert (bent.wear == mesh.wear).all()


def test_a_group_by_place():
    mesh = with_group(
        block((0, 0, 0), (1, 1, 1), (4, 4, 1)), "patch", lambda x: (x[:, 2] == 0) & (x[:, 0] < 0.5)
    )
    assert area_vector(mesh, mesh.group["patch"]) == pytest.approx([0, 0, -0.5])


@pytest.mark.parametrize("bad", [{"cells": (0, 1, 1)}, {"upper": (1.1, -0.2, 0.7)}])
def test_a_box_without_volume(bad):
    with pytest.raises(UserError, match="each direction needs a cell and a length above 0 m"):
        block(**{"lower": LOWER, "upper": UPPER, "cells": (1, 1, 1)} | bad)


def test_volume_of_warped_hexahedra_is_the_integral_of_their_determinant():
    rng = np.random.default_rng(5)
    flat = block((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (3, 3, 3), Hexahedra)
    mesh = mapped(flat, lambda x: x + 0.08 * rng.standard_normal(x.shape))
    sign = np.array(
        [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
    )
    total = 0.0
    # Gauss: exact for the determinant, which is of second degree in each direction
    for point in sign / np.sqrt(3.0):
        factor = 0.5 * (1.0 + sign * point)
        slope = np.stack(
            [0.5 * sign[:, k] * np.delete(factor, k, axis=1).prod(axis=1) for k in range(3)], axis=1
        )
        total += np.linalg.det(np.einsum("eci,ck->eik", mesh.node[mesh.element], slope)).sum()
    assert mesh.volume == pytest.approx(total, rel=1e-12)  # rounding
