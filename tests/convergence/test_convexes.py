"""The meshed convex against the ellipsoid: its volume with the mesh."""

import numpy as np
import pytest

from wearfem.liner.convexes import Convex, Fineness, Pattern, tile_with


@pytest.mark.parametrize(
    "convex", [Convex(3e-3, 2e-3, 2e-3), Convex(2e-3, 2e-3, 2e-3), Convex(5e-3, 4e-3, 1e-3)]
)
def test_volume_converges_with_second_order(convex):
    pattern = Pattern(convex, 40e-3, 30e-3)
    missing = np.array(
        [convex.volume - tile_with(pattern, Fineness(16 * k, 4 * k, 2)).volume for k in (1, 2, 4)]
    )
    assert (missing > 0.0).all()  # inscribed: chords lie inside
    order = np.log2(missing[:-1] / missing[1:])
    # Chords of a smooth arc err by the square of their angle. The next term of the sine, angle^2 / 20, changes the order by
    # 0.03 at 22.5 degrees and by a quarter of it at each step.
    np.testing.assert_allclose(order, 2.0, atol=0.04)


def test_the_default_mesh_misses_six_per_cent():
    convex = Convex(3e-3, 2e-3, 2e-3)
    tile = tile_with(Pattern(convex, 40e-3, 30e-3), Fineness())
    polygon = 8.0 * np.sin(np.pi / 8.0) / np.pi  # area of 16 sides inscribed in a circle over the circle's
    sine, cosine = np.sin(np.pi / 8 * np.arange(5)), np.cos(np.pi / 8 * np.arange(5))
    # Frusta between rings of similar polygons: h (A + sqrt(A B) + B) / 3, here as heights over plan; a triangulated side of a frustum
    # bulges from the frustum by less than one part in a thousand (its four corners are in one plane, so by nothing).
    frusta = (np.diff(sine) * (cosine[1:] ** 2 + cosine[1:] * cosine[:-1] + cosine[:-1] ** 2)).sum() / 3.0
    assert tile.volume / convex.volume == pytest.approx(polygon * frusta * 1.5, rel=1e-12)  # rounding
    assert tile.volume / convex.volume == pytest.approx(0.937, abs=0.001)  # as the case's README says
