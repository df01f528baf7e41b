"""What holds a solid and what it refuses; its points, loads and measures of stress; facet loads as load cases."""

from dataclasses import fields, replace

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.liner.block import Hexahedra, Tetrahedra, block
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import SolidMesh
from wearfem.liner.solid import Solid
from wearfem.liner.solve import Load, Structure, factorise, solve_elastic
from wearfem.liner.strength import principal_stress, von_mises
from wearfem.liner.support import EVERY, Bed, ElasticBolt, Fixed, X, Y, Z, free_motions
from wearfem.liner.traction import facet_force, load_cases, nodal_traction
from wearfem.loads import FacetLoads
from wearfem.material import Material

STEEL = Material("steel", 7850.0, 80e9, 0.3)
KINDS = pytest.mark.parametrize("kind", [Tetrahedra, Hexahedra], ids=["tetrahedra", "hexahedra"])


def plate(kind=Tetrahedra, cells=(3, 2, 1)):
    return Liner(block((0.0, 0.0, 0.0), (0.3, 0.2, 0.05), cells, kind, name="plate"), STEEL)


# ---------------------------------------------------------------------------------------------------- supports


def test_a_liner_without_supports_is_free_in_six_ways():
    with pytest.raises(UserError) as refused:
        factorise(plate(), Structure([]))
    for motion in (
        "translation along x",
        "translation along z",
        "rotation about x through (0.15, 0.1, 0.025) m",
    ):
        assert motion in str(refused.value)
    assert str(refused.value).count("rotation") == 3
    assert "It has the groups bottom, rim, wear, x_high" in str(refused.value)


@pytest.mark.parametrize(
    ("supports", "free"),
    [
        ([Fixed("bottom", (Z,))], ["translation along x", "translation along y", "rotation about z"]),
        ([Fixed("x_low", (X, Y)), Fixed("y_low", (Y,))], ["translation along z"]),
        ([Fixed("x_low", ((1.0, 1.0, 0.0), Z))], ["translation along (0.707, -0.707, 0)"]),
        ([ElasticBolt("x_low", 1e7, 0.0)], ["translation along y", "translation along z", "rotation about x"]),
        ([Bed("bottom", 1e9)], ["translation along x", "translation along y", "rotation about z"]),
    ],
)  # fmt: skip
def test_the_free_motion_is_named(supports, free):
    with pytest.raises(UserError) as refused:
        factorise(plate(), Structure(supports))
    text = str(refused.value)
    assert all(motion in text for motion in free)
    assert text.count("translation") + text.count("rotation") == len(free)


def test_hinges_are_named_with_their_place():
    body = Solid(plate().mesh, STEEL)
    corners = [
        np.flatnonzero(np.isclose(body.point, place).all(axis=1))[0]
        for place in ((0.3, 0, 0.05), (0.3, 0.2, 0.05))
    ]
    springs, held = np.zeros((len(body.point), 3, 3)), np.zeros((len(body.point), 3, 3))
    held[corners[0]] = np.eye(3)
    assert free_motions(body, held, springs) == [
        f"rotation about {axis} through {place} m"
        for axis, place in (("x", "(0.15, 0, 0.05)"), ("y", "(0.3, 0.1, 0.05)"), ("z", "(0.3, 0, 0.025)"))
    ]  # each axis by its point beside the centre
    springs[corners[1]] = 1e7 * np.eye(3)
    assert free_motions(body, held, springs) == ["rotation about y through (0.3, 0.1, 0.05) m"]


def test_each_part_of_a_liner_must_be_held():
    first, second = plate().mesh, plate().mesh
    apart = second.node + [1.0, 0.0, 0.0]
    group = {"near": first.group["x_low"], "wear": first.group["wear"]}
    both = SolidMesh(
        np.concatenate([first.node, apart]),
        np.concatenate([first.element, second.element + len(first.node)]),
        group,
        "pair",
    )
    with pytest.raises(UserError, match=r"of the part around \(1.15, 0.1, 0.025\) m"):
        factorise(Liner(both, STEEL), Structure([Fixed("near")]))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Fixed("rim", ((0.0, 0.0, 0.0),)), "not all zero"),
        (lambda: ElasticBolt("rim", -1.0, 1.0), "0 or more"),
        (lambda: Bed("rim", 0.0), "not all zero"),
        (lambda: Structure([], yield_stress=0.0), "above 0"),
        (lambda: factorise(plate(), Structure([Fixed("clamp")])), "no group 'clamp'; it has bottom, rim"),
        (lambda: factorise(plate(), Structure([Fixed("rim"), Fixed("rim", (X,))])), "each of them once"),
        (
            lambda: solve_elastic(plate(), Structure([Fixed("rim")]), Load({"wear": np.zeros((3, 3))})),
            r"\(12, 3\)",
        ),
        (
            lambda: solve_elastic(
                plate(), Structure([Fixed("rim")]), Load({"wear": np.full((12, 3), np.nan)})
            ),
            "finite",
        ),
        (lambda: Solid(plate().mesh, replace(STEEL, poisson_ratio=0.5)), "below 0.5"),
    ],
)
def test_bad_input_is_one_sentence(make, words):
    with pytest.raises(UserError, match=words):
        make()


# ------------------------------------------------------------------------------------------------- equilibrium


@KINDS
def test_reactions_balance_loads(kind):
    liner = plate(kind)
    supports = [
        Fixed("x_low", (X, Z)),
        Fixed("y_low", ((0.0, 1.0, 1.0),)),
        ElasticBolt("x_high", 3e7, 1e6),
        Bed("bottom", 1e9, 1e8),
    ]
    force = np.random.default_rng(3).normal(size=(len(liner.mesh.wear), 3))
    gravity = np.array([1.0, -2.0, -9.81])
    state = solve_elastic(liner, Structure(supports, gravity=tuple(gravity)), Load({"wear": force}))
    weight = STEEL.density * liner.mesh.volume * gravity
    centre = liner.mesh.node[liner.mesh.wear].mean(axis=1)
    load = force.sum(axis=0) + weight
    moment = np.cross(centre, force).sum(axis=0) + np.cross([0.15, 0.1, 0.025], weight)
    size = np.abs(weight).max()
    assert (
        np.abs(sum(r.force for r in state.reaction.values()) + load).max() < 1e-10 * size
    )  # rounding of K u
    assert np.abs(sum(r.moment for r in state.reaction.values()) + moment).max() < 1e-10 * size  # likewise


def test_many_load_cases_of_one_factorisation_superpose():
    liner = plate()
    ready = factorise(liner, Structure([Fixed("x_low")], yield_stress=250e6))
    rng = np.random.default_rng(5)
    one, other = (rng.normal(size=(len(liner.mesh.wear), 3)) for _ in range(2))
    sum_of = ready.solve(Load({"wear": one})).displacement + ready.solve(Load({"wear": other})).displacement
    both = ready.solve(Load({"wear": one + other}))
    np.testing.assert_allclose(both.displacement, sum_of, atol=1e-10 * np.abs(sum_of).max())  # rounding
    assert both.energy > 0
    np.testing.assert_allclose(both.reserve_factor * both.von_mises, 250e6, rtol=1e-12)  # by definition


def test_energy_is_that_of_a_bar():
    """Uniform tension s in a bar without Poisson's ratio: s^2 V / (2 E)."""
    soft = Material("soft", 1.0, 1e6, 0.0)
    liner = Liner(block((0.0, 0.0, 0.0), (0.3, 0.2, 0.5), (2, 1, 2)), soft)
    area = Solid(liner.mesh, soft).share("wear")[1]
    state = solve_elastic(
        liner, Structure([Fixed("bottom")]), Load({"wear": 1e3 * area[:, None] * np.array(Z)})
    )
    assert state.energy == pytest.approx(1e3**2 * 0.03 / (2.0 * soft.young_modulus), rel=1e-12)  # rounding
    np.testing.assert_allclose(state.stress, 1e3 * np.outer(Z, Z) + 0 * state.stress, atol=1e-8)  # rounding
    assert state.deflection.max() == pytest.approx(1e3 * 0.5 / soft.young_modulus, rel=1e-12)  # s L / E


def test_without_load_nothing_moves():
    state = solve_elastic(plate(), Structure([Fixed("x_low")]))
    assert not state.displacement.any()
    assert np.isinf(state.reserve_factor).all()


@KINDS
def test_interpolation_carries_linear_fields(kind):
    body = Solid(plate(kind).mesh, STEEL)
    linear = np.array([1.0, 2.0, -3.0])
    np.testing.assert_allclose(
        body.interpolation @ (body.mesh.node @ linear), body.point @ linear, atol=1e-14
    )  # rounding
    assert body.volume.sum() == pytest.approx(body.mesh.volume, rel=1e-12)  # rounding
    np.testing.assert_array_equal(body.point[: len(body.mesh.node)], body.mesh.node)


def test_von_mises_and_principal_stress():
    shear, pressure = np.zeros((3, 3)), -7.0 * np.eye(3)
    shear[0, 1] = shear[1, 0] = 5.0
    assert von_mises(shear) == pytest.approx(np.sqrt(3.0) * 5.0, rel=1e-15)  # von Mises (1913)
    assert von_mises(pressure + shear) == pytest.approx(np.sqrt(3.0) * 5.0, rel=1e-14)  # no part in it
    np.testing.assert_allclose(principal_stress(shear), [5.0, 0.0, -5.0], atol=1e-14)
    assert von_mises(np.diag([40.0, 0.0, 0.0])) == pytest.approx(40.0, rel=1e-15)


# ----------------------------------------------------------------------------------------------------- traction


def loads_of(normal, tangential, duration):
    """Loads of which only the impulses matter."""
    blocks, facets = normal.shape
    value = {field.name: np.zeros((blocks, facets)) for field in fields(FacetLoads)}
    return FacetLoads(
        **value
        | {
            "duration": duration,
            "area": np.ones(facets),
            "normal_impulse": normal,
            "tangential_impulse": tangential,
        }
    )


@KINDS
def test_force_and_moment_go_to_the_nodes_whole(kind):
    liner = plate(kind)
    turned = replace(
        liner, mesh=replace(liner.mesh, node=liner.mesh.node + 0.02 * np.sin(7.0 * liner.mesh.node))
    )
    force = np.random.default_rng(1).normal(size=(len(liner.mesh.wear), 3))
    point, load = nodal_traction(turned, force)
    share, area = Solid(turned.mesh, STEEL).share("wear")
    np.testing.assert_allclose(load.sum(axis=0), force.sum(axis=0), atol=1e-13)  # rounding
    centre = share.T @ point  # of triangles their centroid; of warped squares that of the quadrature
    if kind is Tetrahedra:
        np.testing.assert_allclose(
            centre, turned.mesh.node[turned.mesh.wear].mean(axis=1), atol=1e-15
        )  # rounding
    for about in ([0.0, 0.0, 0.0], [3.0, -1.0, 2.0]):
        moment = np.cross(point - about, load).sum(axis=0)
        np.testing.assert_allclose(
            moment, np.cross(centre - about, force).sum(axis=0), atol=1e-12
        )  # rounding


def test_particles_press_into_the_solid_and_drag_along_it():
    liner = plate()
    facets = len(liner.mesh.wear)
    tangential = np.zeros((2, facets, 3))
    tangential[:, :, 0] = 0.5
    force = facet_force(loads_of(np.full((2, facets), 3.0), tangential, np.array([1.0, 2.0])), liner)
    np.testing.assert_allclose(force[0], np.tile([0.5, 0.0, -3.0], (facets, 1)), atol=1e-15)  # up is outward
    np.testing.assert_allclose(force[1], force[0] / 2.0, atol=1e-15)  # rounding


def test_mean_and_peak_load_case():
    liner = plate()
    facets, blocks = len(liner.mesh.wear), 21
    order = np.random.default_rng(4).permutation(blocks)
    normal = np.repeat(order[:, None] + 1.0, facets, axis=1)
    loads = loads_of(normal, np.zeros((blocks, facets, 3)), np.full(blocks, 0.1))
    cases = load_cases(loads, liner)
    assert order[cases.peak_block] == 19  # the 20th of 21 blocks: 95 % of the way from first to last
    np.testing.assert_allclose(cases.peak.force["wear"][:, 2], -20.0 / 0.1, rtol=1e-12)  # rounding
    np.testing.assert_allclose(cases.mean.force["wear"][:, 2], -11.0 / 0.1, rtol=1e-12)  # rounding
    assert order[load_cases(loads, liner, 100.0).peak_block] == 20
    with pytest.raises(UserError, match="between 0 and 100"):
        load_cases(loads, liner, 101.0)
    with pytest.raises(UserError, match="wears on 12"):
        load_cases(loads_of(normal[:, :5], np.zeros((blocks, 5, 3)), np.full(blocks, 0.1)), liner)


def test_every_direction_is_the_default():
    assert Fixed("rim").directions == EVERY
