"""The filter on a sphere against the spherical harmonic of degree 1, on meshes whose triangles are needles at the poles."""

import numpy as np

from wearfem.material import Material
from wearfem.surface import Surface
from wearfem.wear.smooth import HelmholtzFilter

STEEL = Material("steel", 7850.0, 80e9, 0.3)


def globe(rows: int) -> Surface:
    """A unit sphere by 4 `rows` meridians and `rows` parallels: edges at the poles are `rows` times shorter east than south."""
    east = np.linspace(0.0, 2.0 * np.pi, 4 * rows, endpoint=False)
    south = np.linspace(0.0, np.pi, rows + 1)[1:-1]
    s, e = np.meshgrid(south, east, indexing="ij")
    ring = np.stack([np.sin(s) * np.cos(e), np.sin(s) * np.sin(e), np.cos(s)], axis=-1).reshape(-1, 3)
    point = np.concatenate([ring, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    count = len(east)
    j = np.arange(count)
    k = (j + 1) % count
    band = [
        triangle
        for row in range(rows - 2)
        for triangle in (
            np.stack([row * count + j, (row + 1) * count + j, (row + 1) * count + k], axis=1),
            np.stack([row * count + j, (row + 1) * count + k, row * count + k], axis=1),
        )
    ]
    last = (rows - 2) * count
    north = np.stack([np.full(count, len(ring)), j, k], axis=1)
    pole = np.stack([last + k, last + j, np.full(count, len(ring) + 1)], axis=1)
    return Surface(point, np.concatenate([north, *band, pole]), STEEL)


def error(rows: int, length: float) -> float:
    surface = globe(rows)
    centre = surface.corner.mean(axis=1)
    height = centre[:, 2] / np.linalg.norm(centre, axis=1)
    exact = height / (1.0 + 2.0 * length**2)  # Lap z = -2 z on the unit sphere
    smooth = HelmholtzFilter(surface, length)(height)
    return float(np.sqrt(surface.area @ (smooth - exact) ** 2))


def test_a_spherical_harmonic_is_damped_as_theory_says():
    errors = [error(rows, 0.5) for rows in (16, 32, 64)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(orders - 2.0) < 0.1).all(), (
        orders
    )  # linear elements on chords of a smooth surface: order 2
