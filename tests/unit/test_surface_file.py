"""Surfaces read from files, and what is said where that fails."""

import meshio
import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.material import Material
from wearfem.surface_file import read_surface
from wearfem.units import mm

STEEL = Material("steel", 7932.0, 78e9, 0.3)
SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def write(path, point=SQUARE, cells=(("triangle", TRIANGLES),)):
    meshio.Mesh(point, list(cells)).write(path)
    return path


@pytest.mark.parametrize("ending", ["stl", "vtu", "ply"])
def test_a_square(tmp_path, ending):
    surface = read_surface(write(tmp_path / f"square.{ending}"), STEEL)
    assert len(surface.point) == 4  # the corners that STL repeats are one point each
    np.testing.assert_allclose(surface.area, [0.5, 0.5], rtol=1e-7)  # STL holds single precision
    np.testing.assert_array_equal(surface.normal, [[0, 0, 1], [0, 0, 1]])


def test_other_cells_and_their_points_are_left_out(tmp_path):
    point = np.vstack([SQUARE, [[0.0, 0.0, 9.0]]])
    cells = [("line", np.array([[0, 4]])), ("triangle", TRIANGLES)]
    assert len(read_surface(write(tmp_path / "square.vtu", point, cells), STEEL).point) == 4


def test_millimetres(tmp_path):
    path = write(tmp_path / "plate.vtu", 53.0 * SQUARE)
    with pytest.raises(UserError, match="53 m wide.*scale=mm"):
        read_surface(path, STEEL)
    # 53 mm squared, to rounding
    assert read_surface(path, STEEL, scale=mm).area.sum() == pytest.approx(53e-3**2, rel=1e-15)
    assert read_surface(path, STEEL, scale=1.0).area.sum() == pytest.approx(53.0**2, rel=1e-15)


def test_a_missing_file(tmp_path):
    with pytest.raises(UserError, match="no mesh file"):
        read_surface(tmp_path / "disk.vtu", STEEL)


def test_no_triangles(tmp_path):
    path = write(tmp_path / "line.vtu", cells=[("line", np.array([[0, 1]]))])
    with pytest.raises(UserError, match="no triangles"):
        read_surface(path, STEEL)


@pytest.mark.parametrize("ending", ["stl", "vtu", "what"])
def test_not_a_mesh(tmp_path, ending):
    path = tmp_path / f"bad.{ending}"
    path.write_text("this is no mesh")
    with pytest.raises(UserError, match="cannot be read as a mesh|no triangles"):
        read_surface(path, STEEL)
