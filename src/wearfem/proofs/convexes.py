"""A worn face with convexes: the mesh of a convex beside the ellipsoid, and a face that wears until its convexes are gone."""

from collections.abc import Iterator

import numpy as np

from wearfem.liner.convexes import Convex, Fineness, Pattern, bent_shell, embossed_strip, tile_with
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.mesh import ShellMesh
from wearfem.liner.recede import recede, volume
from wearfem.material import Material
from wearfem.proof import Claim
from wearfem.units import GPa, degree, mm

CONVEXES = (Convex(3 * mm, 2 * mm, 2 * mm), Convex(2 * mm, 2 * mm, 2 * mm), Convex(5 * mm, 2 * mm, 2 * mm))
STEPS, DEEP, SHALLOW = 25, 0.1 * mm, 0.01 * mm  # in which convexes and the face between lose this each


def claims() -> Iterator[Claim]:
    """Order and size of the error of the mesh; exact volume while convexes wear away."""
    for convex in CONVEXES:
        yield order(convex)
    yield inscribed()
    yield from worn_away()


def _pattern(convex: Convex) -> Pattern:
    return Pattern(convex, 40 * mm, 30 * mm)


def order(convex: Convex) -> Claim:
    """Volume that the mesh misses, from 32 to 64 sectors"""
    missing = [convex.volume - tile_with(_pattern(convex), Fineness(16 * k, 4 * k, 2)).volume for k in (2, 4)]
    return Claim(
        f"order of the volume of a meshed convex, {1e3 * convex.along:g} x {1e3 * convex.across:g} x {1e3 * convex.height:g} mm",
        "2/3 pi a b c; chords err by the square of their angle", 2.0, float(np.log2(missing[0] / missing[1])), "-", 0.01, False,
        "the next term of the sine, angle^2 / 20, changes the order by 0.008 at 11.25 degrees",
    )  # fmt: skip


def inscribed() -> Claim:
    """Volume of the default mesh: 16 sectors, 4 rings"""
    convex = CONVEXES[0]
    angle = np.pi / 8.0 * np.arange(5)
    rise, radius = np.diff(np.sin(angle)), np.cos(angle)
    frusta = rise @ (radius[1:] ** 2 + radius[1:] * radius[:-1] + radius[:-1] ** 2) / 3.0
    expected = 8.0 * np.sin(np.pi / 8.0) * convex.along * convex.across * convex.height * frusta
    computed = tile_with(_pattern(convex), Fineness()).volume
    return Claim(
        f"volume of the default convex, {1.0 - computed / convex.volume:.1%} less than the ellipsoid's",
        "frusta between similar polygons: h (A + sqrt(A B) + B) / 3", expected, computed, "m3", 1e-12, True, "rounding",
    )  # fmt: skip


def worn_away() -> Iterator[Claim]:
    """Convexes lose 2.5 mm of their 2 mm, step by step: on a face as good as plane, where the walls between the rim's normals are too"""
    strip = embossed_strip(_pattern(CONVEXES[0]), 4, 2, Fineness(8, 2, 1))
    steel = Material("steel", 7932.0, 78 * GPa, 0.3)
    worn = Liner(bent_shell(strip, 1000.0, 30 * degree, 20 * mm), steel)
    before, asked = volume(worn.mesh), 0.0
    depth = np.where(strip.on_convex, DEEP, SHALLOW)
    for _ in range(STEPS):
        asked += float(depth @ wear_surface(worn).facet_area)
        worn = recede(worn, depth)
    yield Claim(
        f"volume lost while convexes wear away, {STEPS} steps", "sum of depth x area", asked, before - volume(worn.mesh), "m3", 1e-9, True,
        "each step is exact to 1e-10; on the chute's radius of 2 m, where these walls twist, 1.5e-8 are left",
    )  # fmt: skip
    assert isinstance(worn.mesh, ShellMesh)
    height = worn.mesh.thickness - worn.mesh.thickness[strip.height == 0.0].max()
    yield Claim(
        "largest height left of convexes", "they were 2 mm high and lost 2.5 mm, the face between 0.25 mm", 0.0,
        max(0.0, float(height.max())), "m", 0.0, False, "exact: none stands above the face",
    )  # fmt: skip
