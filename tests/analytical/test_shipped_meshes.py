"""The meshes in `meshes/`: each reads and is a sound liner, has its groups, and the volume of the body that was drawn."""

from functools import cache
from math import cos, pi, radians, sin, tan
from pathlib import Path

import numpy as np
import pytest

from wearfem.liner.mesh import ShellMesh, triangles
from wearfem.liner.mesh_file import read_mesh as read
from wearfem.liner.quality import worst

FOLDER = Path(__file__).parents[2] / "meshes"
EXACT = 1e-9  # relative: rounding, and gmsh's placing of nodes on planes and circles
CHORD = 1e-4  # relative: chords of 40 mm on a radius of 2 m are shorter by (0.02)^2 / 6 = 7e-5
LEAST = 0.3  # quality; a liner starts better than the worst that recession may leave

SECTORS = {f"sector_{k}" for k in range(1, 7)}
BOLTS = {f"bolt_{k}" for k in range(1, 7)}
GROUPS = {
    "flat_plate": {"wear", "support", "rim"} | BOLTS,
    "curved_chute": {"wear", "zone_arc", "support", "entry", "end", "rim"},
    "curved_chute_shell": {"wear", "zone_arc", "entry", "end", "rim"},
    "annular_sectors": {"wear", "support", "rim"} | SECTORS,
    "pin_on_disc": {"wear", "support", "rim"},
    "feeder_plates_75": {"wear", "plate_1", "plate_2", "support", "rim", "joint"},
    "feeder_plates_45": {"wear", "plate_1", "plate_2", "support", "rim", "joint"},
    "bucket_bottom": {"wear", "support", "rim"},
    "bucket_bottom_bars_90": {"wear", "bars", "support", "rim"},
    "bucket_bottom_bars_45": {"wear", "bars", "support", "rim"},
}


@cache
def shipped(name):
    return read(FOLDER / f"{name}.msh")


def area_vectors(mesh, facet):
    a, b, c = np.moveaxis(mesh.node[triangles(facet)[0]], 1, 0)
    return 0.5 * np.cross(b - a, c - a)


def area(mesh, facet):
    return np.linalg.norm(area_vectors(mesh, facet), axis=1).sum()


def circle(mesh, radius, centre=(0.0, 0.0)):
    """Area of the polygon that a circle of the top has become, by the number of its nodes."""
    top = mesh.node[np.unique(mesh.wear)][:, :2] - centre
    count = int((np.abs(np.linalg.norm(top, axis=1) - radius) < 1e-6).sum())
    return 0.5 * count * radius**2 * sin(2 * pi / count)


def test_every_shipped_mesh_is_tested():
    assert {path.stem for path in FOLDER.glob("*.msh")} == set(GROUPS)


@pytest.mark.parametrize("name", GROUPS)
def test_a_shipped_mesh_is_a_sound_liner(name):
    path = FOLDER / f"{name}.msh"
    assert path.stat().st_size < 1.5e6
    mesh = shipped(name)  # refuses what is open, turned, or overlaps
    assert set(mesh.group) == GROUPS[name]
    assert worst(mesh) > LEAST
    row = next(line for line in (FOLDER / "README.md").read_text().splitlines() if f"`{name}.msh` |" in line)
    assert f"| {len(mesh.node)} | {len(mesh.element)} |" in row and row.endswith(f"| {worst(mesh):.2f} |")
    if isinstance(mesh, ShellMesh):
        assert len(mesh.wear) == len(mesh.element)
        assert (mesh.offset == -0.5 * mesh.thickness).all()
    else:
        assert (
            np.abs(area_vectors(mesh, mesh.boundary).sum(axis=0)).max() < 1e-12
        )  # [m2] a closed surface has none
        parts = sum(
            len(mesh.group[group]) for group in ("wear", "support", "rim") + tuple(BOLTS & mesh.group.keys())
        )
        assert parts == len(mesh.boundary), "wear, support, rim and bolts are all of the boundary, once"


def test_flat_plate():
    mesh = shipped("flat_plate")
    holes = sum(circle(mesh, 0.013, (x, y)) for x in (0.1, 0.5, 0.9) for y in (0.1, 0.5))
    assert area(mesh, mesh.wear) == pytest.approx(0.6 - holes, rel=EXACT)
    # nodes between the ends of a hole, turned by half a chord, take away more than the prism of the polygon does
    assert 0.02 * (0.6 - 6 * pi * 0.013**2) < mesh.volume <= 0.02 * (0.6 - holes) * (1 + EXACT)
    assert holes == pytest.approx(6 * pi * 0.013**2, rel=0.05)  # 12 chords: 4.5 % less than the circle


@pytest.mark.parametrize(
    "name, inner, outer, thickness",
    [("annular_sectors", 0.09, 0.13, 0.01), ("pin_on_disc", 0.0, 0.0265, 0.006)],
)
def test_discs(name, inner, outer, thickness):
    mesh = shipped(name)
    ring = circle(mesh, outer) - (circle(mesh, inner) if inner else 0.0)
    whole = pi * (outer**2 - inner**2)
    assert area(mesh, mesh.wear) == pytest.approx(ring, rel=EXACT)
    assert ring == pytest.approx(
        whole, rel=2e-3
    )  # chords of an angle a lose a^2 / 6, here up to (2 pi / 60)^2 / 6
    assert mesh.volume == pytest.approx(whole * thickness, rel=2e-3)
    for sector in SECTORS & mesh.group.keys():
        assert area(mesh, mesh.group[sector]) == pytest.approx(ring / 6, rel=EXACT)


def test_curved_chute():
    """The volume by Pappus: the profile's area times the path of its centroid."""
    radius, turn, straight, t, half, slope = 2.0, radians(65), 0.3 + 0.5, 0.02, 0.1, radians(45)
    side = 0.2
    wing = np.array([[half, 0.0], [half + side * cos(slope), side * sin(slope)],
                     [half + side * cos(slope) + t * sin(slope), side * sin(slope) - t * cos(slope)],
                     [half + t * tan(slope / 2), -t]])  # fmt: skip
    bottom = np.array(
        [[half, 0.0], [half + t * tan(slope / 2), -t], [-half - t * tan(slope / 2), -t], [-half, 0.0]]
    )
    whole, moment = 0.0, 0.0
    for polygon, times in ((wing, 2), (bottom, 1)):
        (y, z), (y1, z1) = polygon.T, np.roll(polygon, -1, axis=0).T
        cross = y * z1 - y1 * z
        sign = np.sign(cross.sum())
        whole += times * sign * cross.sum() / 2
        moment += times * sign * ((z + z1) * cross).sum() / 6
    mesh = shipped("curved_chute")
    assert mesh.volume == pytest.approx(whole * (straight + radius * turn) - moment * turn, rel=CHORD)
    worn = 2 * half * (straight + radius * turn) + 2 * side * (
        straight + (radius - side * sin(slope) / 2) * turn
    )
    assert area(mesh, mesh.wear) == pytest.approx(worn, rel=CHORD)
    shell = shipped("curved_chute_shell")
    assert area(shell, shell.wear) == pytest.approx(worn, rel=CHORD)
    for one in (mesh, shell):
        assert area(one, one.group["zone_arc"]) == pytest.approx(2 * half * radius * turn, rel=CHORD)
        normal = area_vectors(one, one.group["zone_arc"])
        centre = one.node[one.group["zone_arc"]].mean(axis=1)
        assert (np.einsum("ti,ti->t", normal, centre * [1, 0, 1]) < 0).all(), (
            "towards the axis, where the flow is"
        )
        assert np.linalg.norm(one.node[np.unique(one.group["zone_arc"])][:, [0, 2]], axis=1) == pytest.approx(
            radius, rel=1e-6
        )


def test_feeder_plates():
    for size in (45, 75):
        mesh = shipped(f"feeder_plates_{size}")
        assert area_vectors(mesh, mesh.wear).sum(axis=0) == pytest.approx([0, 0, 5.3 * 1.8], rel=EXACT)
        for plate in ("plate_1", "plate_2"):
            assert area(mesh, mesh.group[plate]) == pytest.approx(5.3 * 0.9, rel=EXACT)
        joint = mesh.node[mesh.group["joint"]]
        assert joint[..., 1] == pytest.approx(0.0, abs=1e-12)
        assert np.linalg.norm(joint[:, 1] - joint[:, 0], axis=1).sum() == pytest.approx(5.3, rel=EXACT)


def oblique_bars(width, angle):
    """[m2] under four bars at 45 degrees, clipped to the plate's margin: a piecewise linear width, integrated exactly."""
    total, half = 0.0, 0.5 * width / sin(angle)
    for centre in 0.2 + 2.6 * (np.arange(4) + 0.5) / 4:
        y = np.clip([-1.5, 1.5, *(end - centre + s * half for end in (0.2, 2.8) for s in (-1, 1))], -1.5, 1.5)
        y.sort()
        covered = np.clip(centre + y + half, 0.2, 2.8) - np.clip(centre + y - half, 0.2, 2.8)
        total += float(np.sum(np.diff(y) * 0.5 * (covered[1:] + covered[:-1])))
    return total


def test_bucket_bottom():
    plain = 3.0 * 3.4 * 0.06
    expected = {
        "": plain,
        "_bars_90": plain + 4 * 3.0 * 0.12 * 0.06,
        "_bars_45": plain + 0.06 * oblique_bars(0.12, radians(45)),
    }
    for ending, volume in expected.items():
        mesh = shipped(f"bucket_bottom{ending}")
        assert mesh.volume == pytest.approx(volume, rel=EXACT)
        assert area_vectors(mesh, mesh.wear).sum(axis=0) == pytest.approx(
            [0, 0, 3.0 * 3.4], rel=EXACT, abs=1e-9
        )
