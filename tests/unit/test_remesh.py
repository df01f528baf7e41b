"""Remeshing: bodies of other kinds and shapes, groups, repeatability, and what is refused."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.liner.block import Hexahedra, Tetrahedra, block, mapped, sheet, with_group
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import SolidMesh, find_facets
from wearfem.liner.mesh_check import check_mesh
from wearfem.liner.patches import skin
from wearfem.liner.quality import worst
from wearfem.liner.remesh import carry, change, refill, remesh, renew
from wearfem.material import Material

STEEL = Material("steel", 7850.0, 80e9, 0.3)


def plate(kind=Tetrahedra):
    return Liner(block((0.0, 0.0, 0.0), (0.2, 0.1, 0.04), (8, 4, 2), kind), STEEL)


def welded(mesh):
    """Nodes at one place become one."""
    _, first, number = np.unique(np.round(mesh.node, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    return SolidMesh(mesh.node[first], number.ravel()[mesh.element])


def worn_all_over(mesh):
    return Liner(replace(mesh, group={"wear": mesh.boundary}), STEEL)


def outward(mesh):
    """Whether every facet of every group is one of the boundary with its normal outwards."""
    boundary = mesh.boundary
    for rows in mesh.group.values():
        same = boundary[find_facets(rows, boundary)]
        turns = [(same == np.roll(rows, shift, axis=1)).all(axis=1) for shift in range(3)]
        if not np.any(turns, axis=0).all():
            return False
    return True


@pytest.mark.parametrize("renewed", [refill, remesh])
@pytest.mark.parametrize("kind", [Tetrahedra, Hexahedra])
def test_a_plate_keeps_its_volume_groups_and_depth(kind, renewed):
    before = plate(kind)
    before = replace(
        before, depth=np.linspace(0.0, 1e-3, len(before.depth)), service_time=5.0, throughput=6.0
    )
    after = renewed(before, 0.02)
    assert after.mesh.element.shape[1] == 4
    assert set(after.mesh.group) == set(before.mesh.group)
    check_mesh(after.mesh)
    assert outward(after.mesh)
    told = change(before, after)
    assert abs(told.volume) < 1e-13 and abs(told.area) < 1e-13  # rounding: a box is plane
    assert (after.service_time, after.throughput) == (5.0, 6.0)
    assert len(after.depth) == len(after.mesh.wear)
    count = sum(len(after.mesh.group[name]) for name in ("wear", "bottom", "rim"))
    assert count == len(after.mesh.boundary)


def test_a_field_on_a_skin_that_was_kept_stays_as_it_is():
    before = plate(Hexahedra)
    field = np.random.default_rng(0).random((2, len(before.depth)))
    assert np.array_equal(carry(field, before, refill(before, 0.02)), np.repeat(field, 2, axis=1))


def test_meshes_repeat_to_the_last_bit():
    one, two = remesh(plate(), 0.02), remesh(plate(), 0.02)
    assert np.array_equal(one.mesh.node, two.mesh.node) and np.array_equal(one.mesh.element, two.mesh.element)


def test_a_bolt_in_the_bottom_keeps_its_place():
    def inside(x):
        return (x[:, 2] < 1e-9) & (np.abs(x[:, 0] - 0.1) < 0.026) & (np.abs(x[:, 1] - 0.05) < 0.026)

    before = plate()
    before = replace(before, mesh=with_group(before.mesh, "bolt_1", inside))
    after = remesh(before, 0.015).mesh
    corner = after.node[after.group["bolt_1"]]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    assert abs(area.sum() - 0.05**2) < 1e-12  # rounding: its corners stay
    assert np.allclose([corner[..., 0].min(), corner[..., 0].max()], [0.075, 0.125])


def test_a_ring_a_ball_and_a_long_pipe_can_be_laid_flat():
    def bent(x):
        return np.column_stack([x[:, 0] * np.cos(x[:, 1]), x[:, 0] * np.sin(x[:, 1]), x[:, 2]])

    def rounded(x):
        most, length = np.abs(x).max(axis=1), np.linalg.norm(x, axis=1)
        return 0.1 * x * (most / np.where(length > 0.0, length, 1.0))[:, None]

    def pipe(height, rows):
        return welded(mapped(block((0.1, 0.0, 0.0), (0.14, 2.0 * np.pi, height), (1, 32, rows)), bent))

    ball = mapped(block((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0), (6, 6, 6)), rounded)
    for mesh, size in (
        (pipe(0.1, 4), 0.03),
        (pipe(0.6, 24), 0.04),
        (SolidMesh(ball.node, ball.element), 0.05),
    ):
        before = worn_all_over(mesh)
        after = remesh(before, size)
        told = change(before, after)
        assert told.quality_after > 0.3  # as good as gmsh gives on bodies without thin places
        assert abs(told.volume) < (size / 0.1) ** 2  # chords: (h / R)^2 / 8 on each of a few radii
        check_mesh(after.mesh)
        assert outward(after.mesh)


def test_two_bodies_and_a_cavity():
    one = block((0.0, 0.0, 0.0), (0.1, 0.1, 0.1), (3, 3, 3))
    two = mapped(one, lambda x: x + [0.3, 0.0, 0.0])
    pair = SolidMesh(
        np.concatenate([one.node, two.node]), np.concatenate([one.element, two.element + len(one.node)])
    )
    hollow = SolidMesh(one.node, np.delete(one.element, np.s_[13 * 6 : 14 * 6], axis=0))
    for mesh, faces in ((pair, 12), (hollow, 12)):
        for renewed in (refill, remesh):
            after = renewed(worn_all_over(mesh), 0.03)
            assert abs(after.mesh.volume / mesh.volume - 1.0) < 1e-12  # rounding
            assert skin(after.mesh).patch.max() + 1 == faces


def test_a_shell_keeps_its_edges_and_its_side():
    mesh = sheet((0.0, 0.0), (0.2, 0.1), (8, 4), 0.02, offset=0.003)
    after = remesh(Liner(mesh, STEEL), 0.02).mesh
    check_mesh(after)
    a, b, c = np.moveaxis(after.node[after.element], 1, 0)
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
    assert set(after.group) == set(mesh.group)
    for name, rows in after.group.items():
        if name in ("wear", "rim"):
            continue
        begin, end = after.node[rows[:, 0]], after.node[rows[:, 1]]
        assert (
            abs(np.linalg.norm(end - begin, axis=1).sum() - (0.1 if name[0] == "x" else 0.2)) < 1e-12
        )  # rounding
        middle = np.array([0.1, 0.05, 0.0])
        assert (np.cross(end - begin, middle - begin)[:, 2] > 0.0).all(), f"{name}: shell on its left"
    assert np.allclose(after.thickness, 0.02, rtol=1e-14) and np.allclose(after.offset, 0.003, rtol=1e-14)


def test_a_mesh_that_is_good_enough_is_left_alone():
    liner = plate()
    assert renew(liner, 0.02) is liner
    filled = renew(liner, 0.02, limit=worst(liner.mesh) + 1e-6)
    assert filled is not liner


def test_what_is_refused():
    liner = plate()
    with pytest.raises(UserError, match="edge length wanted"):
        remesh(liner, 0.0)
    with pytest.raises(UserError, match="no inside"):
        refill(Liner(sheet((0.0, 0.0), (1.0, 1.0), (2, 2), 0.02), STEEL), 0.1)
    side = liner.mesh.element[:, [0, 2, 1]]
    hidden = side[find_facets(side, liner.mesh.boundary) < 0]
    inside = replace(liner.mesh, group={**liner.mesh.group, "layer": hidden[:3]})
    with pytest.raises(UserError, match="'layer' are not on the boundary"):
        remesh(replace(liner, mesh=inside), 0.02)


def test_without_gmsh_the_sentence_names_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(UserError, match="libglu1-mesa libgl1 .* libxft2"):
        remesh(plate(), 0.02)


def test_a_session_that_is_open_is_left_open():
    import gmsh

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.model.add("mine")
    remesh(plate(), 0.03)
    assert gmsh.isInitialized() and gmsh.model.getCurrent() == "mine"
    gmsh.finalize()
