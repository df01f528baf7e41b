"""What must not matter to a solid: where it lies, how it is numbered, and how its equations are solved."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wearfem.liner.block import Hexahedra, Tetrahedra, block
from wearfem.liner.liner import Liner
from wearfem.liner.solid import Solid
from wearfem.liner.solve import Load, Structure, solve_elastic
from wearfem.liner.support import Bed, ElasticBolt, Fixed
from wearfem.material import Material

STEEL = Material("steel", 7850.0, 80e9, 0.3)
KINDS = pytest.mark.parametrize("kind", [Tetrahedra, Hexahedra], ids=["tetrahedra", "hexahedra"])


def answer(liner, turn=None):
    """Under loads and supports that turn with the liner."""
    turn = turn or Rotation.identity()
    axes = tuple(tuple(axis) for axis in turn.apply(np.eye(3)))
    supports = [Fixed("x_low", axes[:2]), Bed("bottom", 1e9, 1e8), ElasticBolt("x_high", 1e7, 1e6)]
    force = turn.apply(np.random.default_rng(7).normal(size=(len(liner.mesh.wear), 3)))
    gravity = tuple(turn.apply((0.0, 1.0, -9.81)))
    return solve_elastic(liner, Structure(supports, gravity=gravity), Load({"wear": force}))


def plate(kind):
    return Liner(block((0.0, 0.0, 0.0), (0.3, 0.2, 0.05), (4, 3, 2), kind), STEEL)


@KINDS
def test_turned_and_moved(kind):
    liner = plate(kind)
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7])
    moved = replace(liner, mesh=replace(liner.mesh, node=turn.apply(liner.mesh.node) + [5.0, -3.0, 1.0]))
    here, there = answer(liner), answer(moved, turn)
    size = np.abs(here.displacement).max()
    np.testing.assert_allclose(
        there.displacement, turn.apply(here.displacement), atol=1e-9 * size
    )  # rounding x condition
    np.testing.assert_allclose(
        there.von_mises, here.von_mises, atol=1e-8 * here.von_mises.max()
    )  # of strains
    np.testing.assert_allclose(
        there.principal_stress, here.principal_stress, atol=1e-8 * here.von_mises.max()
    )  # likewise
    assert there.energy == pytest.approx(here.energy, rel=1e-9)  # likewise


@KINDS
def test_numbered_otherwise(kind):
    liner = plate(kind)
    mesh, rng = liner.mesh, np.random.default_rng(11)
    new = rng.permutation(len(mesh.node))  # of each old node
    old = np.argsort(new)
    other = replace(
        mesh,
        node=mesh.node[old],
        element=new[mesh.element][rng.permutation(len(mesh.element))],
        group={name: new[facet] for name, facet in mesh.group.items()},
    )
    here, there = answer(liner), answer(replace(liner, mesh=other))
    np.testing.assert_allclose(
        there.displacement, here.displacement[old], atol=1e-9 * np.abs(here.displacement).max()
    )  # rounding x condition
    np.testing.assert_allclose(
        there.stress, here.stress[old], atol=1e-8 * np.abs(here.stress).max()
    )  # likewise


@KINDS
def test_multigrid_gives_what_factors_give(kind, monkeypatch):
    liner = Liner(block((0.0, 0.0, 0.0), (1.0, 1.0, 0.1), (10, 10, 2), kind), STEEL)
    direct = answer(liner)
    monkeypatch.setattr(Solid, "direct_limit", 0)
    iterated = answer(liner)
    size = np.abs(direct.displacement).max()
    np.testing.assert_allclose(
        iterated.displacement, direct.displacement, atol=1e-7 * size
    )  # residual of 1e-8
    for name, one in direct.reaction.items():
        np.testing.assert_allclose(iterated.reaction[name].force, one.force, atol=1e-5 * 1000.0)  # of 7700 N
    assert iterated.energy == pytest.approx(direct.energy, rel=1e-7)  # likewise
