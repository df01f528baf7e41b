"""Element quality: the regular shape has 1, a box what the formula says, and any shape what VTK's Verdict says."""

import numpy as np
import pytest

from wearfem.liner.block import Hexahedra, Tetrahedra, block, mapped, sheet
from wearfem.liner.mesh import ShellMesh, SolidMesh
from wearfem.liner.quality import quality, worst

REGULAR = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)


def one(node):
    """A mesh of one tetrahedron."""
    return SolidMesh(node, [[0, 2, 1, 3]])


def test_regular_shapes_have_quality_one_at_any_size_and_place():
    rng = np.random.default_rng(1)
    for _ in range(10):
        turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
        turn *= np.linalg.det(turn)
        node = 10 ** rng.uniform(-3, 3) * REGULAR @ turn + rng.standard_normal(3)
        tetrahedron = node if np.linalg.det(node[[2, 1, 3]] - node[0]) > 0 else node[[0, 2, 1, 3]]
        assert worst(one(tetrahedron)) == pytest.approx(1.0, rel=1e-9)  # cancellation of far points
        triangle = ShellMesh(node[:3], [[0, 1, 2]], np.ones(3), np.zeros(3))
        assert worst(triangle) == pytest.approx(1.0, rel=1e-9)
    assert worst(block((0, 0, 0), (3, 3, 3), (3, 3, 3), Hexahedra)) == pytest.approx(1.0, rel=1e-12)


def test_a_box_and_a_right_triangle_have_what_the_formula_says():
    a, b, c = 1.0, 2.0, 5.0
    box = block((0, 0, 0), (a, b, c), (1, 1, 1), Hexahedra)
    assert worst(box) == pytest.approx(3 * (a * b * c) ** (2 / 3) / (a**2 + b**2 + c**2), rel=1e-12)
    assert quality(sheet((0, 0), (a, a), (1, 1), 0.1)) == pytest.approx(np.sqrt(3) / 2, rel=1e-12)


def test_flat_and_inverted_elements_have_none():
    flat = mapped(block((0, 0, 0), (1, 1, 1), (1, 1, 1), Hexahedra), lambda x: x * [1, 1, 0])
    assert worst(flat) == 0.0
    for kind in (Tetrahedra, Hexahedra):
        assert quality(mapped(block((0, 0, 0), (1, 1, 1), (1, 1, 1), kind), lambda x: -x)).max() == 0.0


@pytest.mark.parametrize("kind", ["Tet", "Hex", "Triangle"])
def test_quality_is_verdicts_shape(kind):
    verdict = pytest.importorskip("vtkmodules.vtkFiltersVerdict").vtkMeshQuality
    data = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    rng = np.random.default_rng(2)
    if kind == "Triangle":
        mesh = sheet((0, 0), (4, 4), (4, 4), 0.1)
    else:
        mesh = block((0, 0, 0), (4, 4, 4), (4, 4, 4), Tetrahedra if kind == "Tet" else Hexahedra)
    mesh = mapped(
        mesh, lambda x: x + rng.uniform(-0.2, 0.2, x.shape)
    )  # none inverted, all of different shape
    found = quality(mesh)
    cell = {"Tet": data.vtkTetra, "Hex": data.vtkHexahedron, "Triangle": data.vtkTriangle}[kind]()
    for element, value in zip(mesh.element, found, strict=True):
        for place, node in enumerate(element):
            cell.GetPoints().SetPoint(place, mesh.node[node])
        assert value == pytest.approx(getattr(verdict, f"{kind}Shape")(cell), rel=1e-9)  # rounding
    assert 0.05 < found.min() < 0.9 < 1.0  # the shapes do differ
