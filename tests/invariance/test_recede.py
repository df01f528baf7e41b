"""Volume asked is volume lost, whatever the field, the mesh, its numbering, its place and its diagonals."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from wearfem.liner.block import Falling, Hexahedra, Rising, Tetrahedra, block, mapped, sheet
from wearfem.liner.corners import find_corners, unworn
from wearfem.liner.liner import Liner
from wearfem.liner.projection import to_corners
from wearfem.liner.quality import quality
from wearfem.liner.recede import recede, removed_volume, volume
from wearfem.proofs.recession import STEEL, ball, drum, uneven


def field(mesh, rng, roughness):
    """Random depths; rough fields are zero on most facets."""
    return 2e-3 * rng.random(len(mesh.wear)) * (rng.random(len(mesh.wear)) > roughness)


def solid(kind, shape, seed):
    if shape == "plate":
        return uneven(block((0.0, 0.0, 0.0), (0.3, 0.2, 0.04), (6, 5, 3), kind), seed=seed)
    if shape == "wavy":
        flat = uneven(block((0.0, 0.0, 0.0), (0.3, 0.2, 0.06), (6, 5, 3), kind), seed=seed)
        return mapped(
            flat, lambda x: x + np.outer(0.3 * x[:, 2] * np.sin(30.0 * x[:, 0] + 20.0 * x[:, 1]), [0, 0, 1])
        )
    if shape == "edges":
        cube = uneven(block((0.0, 0.0, 0.0), (0.1, 0.1, 0.1), (3, 3, 3), kind), seed=seed)
        worn = np.concatenate([cube.group[name] for name in ("wear", "x_high", "y_high")])
        return replace(cube, group={"wear": worn})
    scaled = drum(6, True, kind) if shape == "drum" else ball(4, False, kind)
    return mapped(scaled, lambda x: 0.2 * x)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    roughness=st.sampled_from([0.0, 0.5, 0.95]),
    kind=st.sampled_from([Tetrahedra, Hexahedra]),
    shape=st.sampled_from(["plate", "wavy", "edges", "drum", "ball"]),
)
# One deep facet whose neighbours cannot give
@example(seed=366, roughness=0.95, kind=Tetrahedra, shape="wavy")
@example(seed=14, roughness=0.95, kind=Tetrahedra, shape="wavy")
def test_volume_asked_is_volume_lost(seed, roughness, kind, shape):
    mesh = solid(kind, shape, seed)
    assume(quality(mesh).min() > 0.0)  # a draw whose elements are turned over already is no mesh
    depth = field(mesh, np.random.default_rng(seed), roughness)
    lost = volume(mesh) - volume(recede(Liner(mesh, STEEL), depth).mesh)
    rounding = 1e-15 * volume(mesh)  # of the two volumes, where next to nothing is asked
    assert lost == pytest.approx(removed_volume(mesh, depth), rel=1e-10, abs=rounding)  # as issued


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), roughness=st.sampled_from([0.0, 0.5, 0.95]), curved=st.booleans())
def test_volume_asked_of_a_shell_is_volume_lost(seed, roughness, curved):
    mesh = sheet((0.0, 0.0), (0.3, 0.2), (6, 5), 0.04)
    if curved:
        mesh = mapped(mesh, lambda x: np.c_[np.sin(3 * x[:, 0]) / 3, x[:, 1], np.cos(3 * x[:, 0]) / 3])
    depth = field(mesh, np.random.default_rng(seed), roughness)
    new = recede(Liner(mesh, STEEL), depth).mesh
    rounding = 1e-15 * volume(mesh)  # of the two volumes
    assert volume(mesh) - volume(new) == pytest.approx(removed_volume(mesh, depth), rel=1e-10, abs=rounding)
    assert (new.thickness <= mesh.thickness).all()


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), roughness=st.sampled_from([0.0, 0.5, 0.95]))
def test_depths_at_corners_stay_within_those_of_the_facets_around(seed, roughness):
    mesh = solid(Tetrahedra, "edges", seed)
    depth = field(mesh, np.random.default_rng(seed), roughness)
    corners = find_corners(mesh.node, mesh.wear, unworn(mesh))
    w = to_corners(corners, mesh.node, depth)
    at, owner = corners.corner.ravel(), np.repeat(corners.facet, 3)
    worn = corners.worn[owner]
    least, largest = np.full(len(w), np.inf), np.full(len(w), -np.inf)
    np.minimum.at(least, at[worn], depth[owner[worn]])
    np.maximum.at(largest, at[worn], depth[owner[worn]])
    used = corners.of_worn
    assert (w >= 0.0).all()
    slack = 1e-15  # [m] rounding of depths of 2 mm: a few units in the last place, and of sums
    assert (w[used] >= least[used] - slack).all()
    assert (w[used] <= largest[used] + slack).all()


def renumbered(mesh, rng):
    """The same mesh with nodes, elements and facets in another order; and the order of the nodes and facets."""
    node, element, facet = (rng.permutation(len(x)) for x in (mesh.node, mesh.element, mesh.wear))
    number = np.argsort(node)
    group = {name: number[nodes] for name, nodes in mesh.group.items()} | {"wear": number[mesh.wear[facet]]}
    return (
        replace(mesh, node=mesh.node[node], element=number[mesh.element[element]], group=group),
        node,
        facet,
    )


@pytest.mark.parametrize("kind", [Tetrahedra, Hexahedra], ids=["tetrahedra", "hexahedra"])
def test_numbering_does_not_matter(kind):
    rng = np.random.default_rng(5)
    mesh = solid(kind, "wavy", 3)
    depth = field(mesh, rng, 0.3)
    other, node, facet = renumbered(mesh, rng)
    one = recede(Liner(mesh, STEEL), depth).mesh
    two = recede(Liner(other, STEEL), depth[facet]).mesh
    worn = np.isin(node, mesh.wear)
    # the worn face to the accuracy of the elastic motion that slides it (1e-6 of the depth)
    assert np.abs(two.node - one.node[node])[worn].max() < 1e-5 * depth.max()
    assert np.abs(two.node - one.node[node]).max() < 1e-4 * depth.max()


def test_place_and_direction_do_not_matter():
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(5)
    mesh = solid(Tetrahedra, "wavy", 3)
    depth = field(mesh, rng, 0.3)
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7])
    moved = mapped(mesh, lambda x: turn.apply(x) + [1.0, 2.0, -1.0])
    one = recede(Liner(mesh, STEEL), depth).mesh.node
    two = recede(Liner(moved, STEEL), depth).mesh.node
    apart = np.abs(turn.inv().apply(two - [1.0, 2.0, -1.0]) - one).max()
    assert apart < 1e-4 * depth.max()  # the accuracy of the elastic motion


def test_the_diagonal_of_a_hexahedrons_facet_does_not_matter():
    """Facets that name their corners from another corner on, so that triangles(0-2) would cut them the other way."""
    mesh = solid(Hexahedra, "wavy", 3)
    depth = field(mesh, np.random.default_rng(2), 0.3)
    rolled = replace(mesh, group={**mesh.group, "wear": np.roll(mesh.wear, 1, axis=1)})
    one = recede(Liner(mesh, STEEL), depth).mesh.node
    two = recede(Liner(rolled, STEEL), depth).mesh.node
    assert np.abs(one - two).max() < 1e-4 * depth.max()  # the accuracy of the elastic motion


def test_the_diagonals_of_a_shell_do_not_matter_as_the_mesh_gets_finer():
    apart = []
    for cells in (8, 16):
        thickness = []
        for cut in (Rising, Falling):
            mesh = sheet((0.0, 0.0), (1.0, 1.0), (cells, cells), 0.04, cut)
            x, y, _ = mesh.node[mesh.wear].mean(axis=1).T
            thickness.append(
                recede(Liner(mesh, STEEL), 5e-3 * (1.0 + np.sin(3.0 * x) * np.cos(2.0 * y))).mesh.thickness
            )
        apart.append(np.abs(thickness[0] - thickness[1]).mean())
    assert np.log2(apart[0] / apart[1]) > 1.7  # second order, less what the border has
