"""What the exchange and its indicator refuse, and that neither blocks nor elements matter to them."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.liner.block import Hexahedra, Tetrahedra, block, sheet
from wearfem.liner.flexure import Ore, exchange, flexure
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.solve import Structure, factorise
from wearfem.liner.support import Fixed
from wearfem.liner.vibration import lowest_frequencies, mass_matrix
from wearfem.proofs.flexure import IRON_ORE, STEEL, pressing

MESHES = {
    "tetrahedra": block((0, 0, 0), (0.3, 0.2, 0.02), (4, 3, 1), Tetrahedra),
    "hexahedra": block((0, 0, 0), (0.3, 0.2, 0.02), (4, 3, 1), Hexahedra),
    "shell": sheet((0, 0), (0.3, 0.2), (4, 3), 0.02),
}
EACH = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)


def held(mesh, gravity=(0.0, 0.0, 0.0)):
    return factorise(Liner(mesh, STEEL), Structure([Fixed("x_low")], gravity=gravity))


@EACH
def test_halves_of_blocks_do_what_the_whole_does(mesh):
    ready = held(mesh, (0.0, 0.0, -9.81))
    liner = Liner(mesh, STEEL)
    force = np.random.default_rng(3).random((6, len(mesh.wear)))
    once = exchange(ready, liner, pressing(liner, force, 0.1), time_constant=0.3)
    finer = exchange(ready, liner, pressing(liner, np.repeat(force, 2, axis=0), 0.05), time_constant=0.3)
    assert finer == pytest.approx(once, rel=1e-9, abs=1e-9 * np.abs(once).max())  # rounding of two solutions
    first = exchange(
        ready, liner, pressing(liner, force[:4], 0.1), np.zeros_like(mesh.node), time_constant=0.3
    )
    then = exchange(ready, liner, pressing(liner, force[4:], 0.1), first, time_constant=0.3)
    whole = exchange(ready, liner, pressing(liner, force, 0.1), np.zeros_like(mesh.node), time_constant=0.3)
    assert then == pytest.approx(whole, rel=1e-9, abs=1e-9 * np.abs(whole).max())  # as above


@EACH
def test_a_steady_load_is_answered_at_once_and_by_statics(mesh):
    ready, liner = held(mesh, (0.0, 0.0, -9.81)), Liner(mesh, STEEL)
    loads = pressing(liner, np.ones((3, len(mesh.wear))), 0.1)
    from wearfem.liner.traction import load_cases

    static = ready.solve(load_cases(loads, liner).mean).displacement
    found = exchange(ready, liner, loads, time_constant=5.0)
    assert found == pytest.approx(static, rel=1e-9, abs=1e-9 * np.abs(static).max())  # rounding
    after = exchange(ready, liner, loads, found, time_constant=5.0)
    assert after == pytest.approx(static, rel=1e-9, abs=1e-9 * np.abs(static).max())  # it stays there
    moved = wear_surface(liner, found).point - wear_surface(liner).point
    assert moved[:, 2].min() == pytest.approx(
        found[np.unique(mesh.wear), 2].min(), rel=1e-6
    )  # the surface has gone along


@EACH
def test_mass_is_that_of_the_body(mesh):
    body = held(mesh).body
    motion = body.rigid_motions.reshape(-1, 6)
    inertia = motion.T @ (mass_matrix(body) @ motion)
    mass = 7850.0 * 0.3 * 0.2 * 0.02
    assert np.diag(inertia)[:3] == pytest.approx(mass, rel=1e-12)  # rounding
    middle = 0.01 if mesh.element.shape[1] > 3 else 0.0
    about_z = mass * (0.3**2 + 0.2**2) / 3.0
    about_x = mass * (0.2**2 / 3.0 + 0.02**2 / 12.0 + middle**2)
    # about the normal a shell's triangles count as their middle surface: exact; both are polynomials that the elements hold
    assert inertia[5, 5] == pytest.approx(about_z, rel=1e-12)
    assert inertia[3, 3] == pytest.approx(about_x, rel=1e-12)


def test_frequencies_come_in_order_and_repeat_to_the_last_bit():
    ready = held(MESHES["shell"])
    found = lowest_frequencies(ready, 4)
    assert (np.diff(found) > 0).all() and (found == lowest_frequencies(ready, 4)).all()
    cantilever = 1.8751**2 / (2 * np.pi) * np.sqrt(STEEL.young_modulus * 0.02**2 / 12 / 7850.0) / 0.3**2
    assert (
        1.0 < found[0] / cantilever < 1.06
    )  # a wide strip is stiffer than a beam, by 1 / sqrt(1 - nu^2) at most (5 %); mesh 1 %


ORE = Ore(IRON_ORE, 2.5e-3, 3.0, 0.5, 0.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda r, li, lo, u: exchange(r, replace(li, mesh=replace(li.mesh)), lo, time_constant=1.0), "changed since it was factorised"),
        (lambda r, li, lo, u: exchange(r, li, lo, time_constant=0.0), "time constant is 0.0 s"),
        (lambda r, li, lo, u: exchange(r, li, lo, time_constant=np.inf), "time constant is inf s"),
        (lambda r, li, lo, u: exchange(r, li, lo, u[1:], time_constant=1.0), r"displacement of shape \(19, 3\)"),
        (lambda r, li, lo, u: exchange(r, li, lo, u * np.nan, time_constant=1.0), "finite numbers in m"),
        (lambda r, li, lo, u: exchange(r, li, pressing(li, np.ones((2, 5)), 1.0), time_constant=1.0), "loads of 5 facets"),
        (lambda r, li, lo, u: flexure(li, u, ORE, 0.0), "lowest frequency is 0.0 Hz"),
        (lambda r, li, lo, u: flexure(li, u[:, :2], ORE, 1.0), r"displacement of shape \(20, 2\)"),
        (lambda r, li, lo, u: replace(ORE, radius=0.0), "ore's radius is 0.0"),
        (lambda r, li, lo, u: replace(ORE, loading_frequency=-1.0), "loading frequency is -1.0"),
        (lambda r, li, lo, u: lowest_frequencies(r, 0), "0 natural frequencies"),
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence(make, words):
    mesh = MESHES["shell"]
    liner = Liner(mesh, STEEL)
    with pytest.raises(UserError, match=words):
        make(held(mesh), liner, pressing(liner, np.ones((2, len(mesh.wear))), 1.0), np.zeros_like(mesh.node))


def test_a_bend_is_told_in_units_of_the_flow():
    mesh = MESHES["shell"]
    tilt = np.zeros_like(mesh.node)
    tilt[:, 2] = 0.01 * mesh.node[:, 0]
    found = flexure(Liner(mesh, STEEL), tilt, ORE, 100.0)
    assert found.deflection == pytest.approx(0.003, rel=1e-12)  # 0.01 x 0.3 m
    assert found.slope == pytest.approx(np.arctan(0.01), rel=1e-9)  # a plane turned
    assert found.of_radius == pytest.approx(1.2, rel=1e-12) and found.shape_matters
    assert found.amplification == 1.0 and found.quasi_static
