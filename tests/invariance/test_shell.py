"""What must not matter to a shell: its place in space, numbering, the start of a triangle, and where its nodes lie in its thickness."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.liner.liner import node_normal
from wearfem.liner.shell import pressure_load, resultants
from wearfem.liner.strength import von_mises
from wearfem.proofs import shell as proof
from wearfem.proofs._shell_problems import ALL, Problem, elastic, hold, pocket, sheet

MATERIAL = elastic(210e9, 0.3)
ROUNDING = 1e-8  # relative: condition of a shell 40 mm thick in the stiffness times 1e-16


def panel(offset=0.0):
    """A worn panel of a cylinder, and how it deforms when clamped at one side."""
    flat = pocket(sheet((0.0, 0.0), (0.6, 0.4), (9, 6), 0.04), 0.04, 0.02, (0.25, 0.2), 0.1)
    x, y, _ = flat.node.T
    radius = 0.5
    mesh = replace(flat, node=np.stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)], axis=1))
    return replace(mesh, node=mesh.node - offset * node_normal(mesh), offset=mesh.offset + offset)


def solved(mesh):
    return Problem(mesh, MATERIAL, hold(mesh, ("x_low", ALL)), pressure_load(mesh, 1e5)).displacement()


def mises(mesh, moved):
    return von_mises(resultants(mesh, MATERIAL, moved).stress(-0.5))


def test_a_shell_turned_in_space_moves_as_before():
    mesh = panel()
    turned, turn = proof.tilted(mesh)
    moved, same = solved(mesh), solved(turned)
    assert same[:, :3] == pytest.approx(moved[:, :3] @ turn.T, abs=ROUNDING * np.abs(moved[:, :3]).max())
    assert same[:, 3:] == pytest.approx(moved[:, 3:] @ turn.T, abs=ROUNDING * np.abs(moved[:, 3:]).max())
    assert mises(turned, same) == pytest.approx(
        mises(mesh, moved), rel=1e-6
    )  # rounding, divided by small strains


def test_numbering_does_not_matter():
    mesh = panel()
    random = np.random.default_rng(5)
    new = random.permutation(len(mesh.node))  # old node i becomes new[i]
    old = np.argsort(new)
    element = np.stack([np.roll(new[row], random.integers(3)) for row in mesh.element])[
        random.permutation(len(mesh.element))
    ]
    group = {name: new[corner] for name, corner in mesh.group.items()}
    other = replace(
        mesh,
        node=mesh.node[old],
        element=element,
        thickness=mesh.thickness[old],
        offset=mesh.offset[old],
        group=group,
    )
    moved, same = solved(mesh), solved(other)
    assert same[new] == pytest.approx(moved, abs=ROUNDING * np.abs(moved).max())


def test_where_the_nodes_lie_in_the_thickness_does_not_matter():
    """Nodes moved along their normals and levers grown by as much: the same body; nodes move as the levers carry them."""
    mesh, lowered = panel(), panel(offset=0.05)
    flat = pocket(sheet((0.0, 0.0), (0.6, 0.4), (9, 6), 0.04), 0.04, 0.02, (0.25, 0.2), 0.1)
    below = replace(flat, node=flat.node - [0.0, 0.0, 0.05], offset=flat.offset + 0.05)
    moved, under = solved(flat), solved(below)
    carried = under[:, :3] + np.cross(under[:, 3:], [0.0, 0.0, 0.05])
    assert under[:, 3:] == pytest.approx(moved[:, 3:], abs=ROUNDING * np.abs(moved[:, 3:]).max())
    assert carried == pytest.approx(moved[:, :3], abs=ROUNDING * np.abs(moved[:, :3]).max())
    moved, under = solved(mesh), solved(lowered)
    carried = under[:, :3] + np.cross(under[:, 3:], 0.05 * node_normal(lowered))
    # normals at nodes are those of facets: they differ at second order, 0.1 % of the displacement here
    assert carried == pytest.approx(moved[:, :3], abs=5e-3 * np.abs(moved[:, :3]).max())
