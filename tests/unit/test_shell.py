"""What a shell carries and weighs, what holds it, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.liner.block import sheet, with_group
from wearfem.liner.liner import Liner, worn_face
from wearfem.liner.shell import (
    Shell,
    edge_load,
    face_load,
    gravity_load,
    middle_surface,
    pressure_load,
    resultants,
    shell_stiffness,
)
from wearfem.liner.shell_element import axes_of, local_stiffness, thickness_moments
from wearfem.liner.solve import Load, Structure, solve_elastic
from wearfem.liner.support import EVERY, ElasticBolt, Fixed, X, Y, Z
from wearfem.proofs import shell as proof
from wearfem.proofs._shell_problems import elastic, pocket

STEEL = elastic(210e9, 0.3, density=7850.0)
ROUNDING = 1e-12  # relative, of sums of some hundred terms


def curved(offset: float = 0.01):
    """A worn, offset panel of a cylinder."""
    flat = sheet((0.0, 0.0), (0.6, 0.4), (6, 4), 0.04, offset=offset)
    worn = pocket(flat, 0.04, 0.02, (0.25, 0.2), 0.1)
    x, y, _ = flat.node.T
    return replace(worn, node=np.stack([0.5 * np.sin(2.0 * x), y, 0.5 * np.cos(2.0 * x)], axis=1))


def resultant(place, force):
    """Force and moment about the origin of forces at places."""
    return np.concatenate([force.sum(axis=0), np.cross(place, force).sum(axis=0)])


def resultant_of(mesh, load):
    total = resultant(mesh.node, load[:, :3])
    total[3:] += load[:, 3:].sum(axis=0)
    return total


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.49])
@pytest.mark.parametrize("thickness", [1e-3, 1.0, 1e2])
def test_a_triangle_has_six_motions_without_energy(ratio, thickness):
    _, xy = axes_of(np.array([[[0.0, 0.0, 0.0], [3.0, 0.2, 0.1], [0.4, 0.9, -0.3]]]))
    h = thickness * np.array([[1.0, 1.3, 0.7]])
    stiffness = local_stiffness(xy, h, 1.0, ratio)[0]
    size = 1.0 / np.sqrt(np.diag(stiffness))
    energy = np.linalg.eigvalsh(stiffness * np.outer(size, size))
    assert (
        np.abs(energy[:6]).max() < 1e-9 * energy[-1]
    )  # rounding: plate over membrane is 1e-6 for the thin one
    assert energy[6] > 1e-6 * energy[-1]  # the first true one, far from rounding


def test_rigid_motions_of_a_worn_offset_panel_cost_nothing():
    mesh = curved()
    body = Shell(mesh, STEEL)
    stiffness = body.stiffness
    force = stiffness @ body.rigid_motions.reshape(-1, 6)
    assert np.abs(force).max() < 1e-12 * np.abs(stiffness.data).max()  # rounding
    assert abs(stiffness - stiffness.T).max() < 1e-12 * np.abs(stiffness.data).max()  # symmetric


def test_thickness_moments_are_exact():
    """Against Gauss's rule on a square that is drawn together into the triangle."""
    moments = thickness_moments(np.array([0.5]), np.array([[1.0, 2.0, 3.0]]), 3)[0]
    point, weight = np.polynomial.legendre.leggauss(8)
    first, second = np.meshgrid(0.5 * point + 0.5, 0.5 * point + 0.5, indexing="ij")
    zeta = np.stack([(1.0 - first) * (1.0 - second), first, second * (1.0 - first)])
    size = 0.25 * np.outer(weight, weight) * (1.0 - first)
    exact = np.einsum("ixy,jxy,xy->ij", zeta, zeta, size * (zeta[0] + 2.0 * zeta[1] + 3.0 * zeta[2]) ** 3)
    assert moments == pytest.approx(exact, rel=1e-13)  # rounding: both rules are exact


def test_face_loads_keep_force_and_moment():
    mesh = curved()
    force = np.random.default_rng(3).normal(size=(len(mesh.wear), 3))
    load = face_load(mesh, mesh.wear, force)
    centroid = worn_face(mesh)[mesh.wear].mean(axis=1)
    assert resultant_of(mesh, load) == pytest.approx(resultant(centroid, force), rel=ROUNDING, abs=1e-13)


def test_edge_loads_keep_force_and_moment():
    mesh = curved(offset=0.0)
    edge = mesh.group["rim"]
    force = np.random.default_rng(3).normal(size=(len(edge), 3))
    load = edge_load(mesh, edge, force)
    middle = mesh.node[edge].mean(axis=1)
    assert resultant_of(mesh, load) == pytest.approx(resultant(middle, force), rel=ROUNDING, abs=1e-13)


def test_pressure_is_normal_to_the_worn_face_where_it_is_now():
    mesh = curved()
    a, b, c = np.moveaxis(worn_face(mesh)[mesh.wear], 1, 0)
    vector = -0.5e5 * np.cross(b - a, c - a)
    expected = resultant((a + b + c) / 3.0, vector)
    assert resultant_of(mesh, pressure_load(mesh, 1e5)) == pytest.approx(expected, rel=1e-11)


def test_weight_is_density_times_volume_at_the_middle_surface():
    mesh = sheet((0.0, 0.0), (0.6, 0.4), (6, 4), 0.04, offset=0.05)
    load = gravity_load(mesh, STEEL, np.array([3.0, 0.0, -9.81]))
    mass = 7850.0 * 0.6 * 0.4 * 0.04
    expected = resultant(np.array([[0.3, 0.2, 0.05]]), mass * np.array([[3.0, 0.0, -9.81]]))
    assert resultant_of(mesh, load) == pytest.approx(expected, rel=ROUNDING)


def test_the_solver_takes_a_shell_as_it_takes_a_solid():
    mesh = curved()
    force = -np.tile([10.0, 20.0, 1000.0], (len(mesh.wear), 1))
    structure = Structure((Fixed("x_low"), Fixed("x_high", (Y, Z), ())), gravity=(0.0, 0.0, -9.81))
    strength = solve_elastic(Liner(mesh, STEEL), structure, Load({"wear": force}))
    weight = gravity_load(mesh, STEEL, np.array([0.0, 0.0, -9.81]))
    applied = resultant_of(mesh, face_load(mesh, mesh.wear, force) + weight)
    reaction = sum(np.concatenate([one.force, one.moment]) for one in strength.reaction.values())
    scale = np.abs(applied).max()
    assert reaction == pytest.approx(-applied, abs=1e-8 * scale)  # rounding of a direct solution
    assert strength.energy > 0.0
    assert strength.stress.shape == (len(mesh.node), 3, 3)


def test_a_stiff_plate_on_two_bolts_sinks_by_force_over_stiffness():
    mesh = sheet((0.0, 0.0), (0.6, 0.4), (6, 4), 0.04)
    mesh = with_group(mesh, "bolt_1", lambda p: p[:, 0] < 0.1)
    mesh = with_group(mesh, "bolt_2", lambda p: p[:, 0] > 0.5)
    stiff = elastic(210e12, 0.3)
    supports = (ElasticBolt("bolt_1", 1e6, 2e5), ElasticBolt("bolt_2", 1e6, 2e5))
    force = np.tile(np.array([0.5, 0.0, -1.0]) * 1000.0 / len(mesh.wear), (len(mesh.wear), 1))
    moved = solve_elastic(Liner(mesh, stiff), Structure(supports), Load({"wear": force})).displacement
    middle = moved[np.argmin(np.hypot(mesh.node[:, 0] - 0.3, mesh.node[:, 1] - 0.2))]
    assert middle[2] == pytest.approx(-1000.0 / 2e6, rel=1e-4)  # the plate is some 1e5 times as stiff
    assert middle[0] == pytest.approx(500.0 / 4e5, rel=1e-4)  # likewise


def test_a_plate_on_four_points():
    mesh = sheet((0.0, 0.0), (0.6, 0.4), (6, 4), 0.04)
    x, y, _ = mesh.node.T
    corner = np.flatnonzero(np.isin(x, [0.0, x.max()]) & np.isin(y, [0.0, y.max()]))
    group = {f"foot_{i}": np.array([[node]]) for i, node in enumerate(corner)}
    mesh = replace(mesh, group={**mesh.group, **group, "middle": np.array([[17]])})
    feet = [Fixed(name, EVERY if name == "foot_0" else (Z,), ()) for name in group]
    feet[1] = Fixed("foot_1", (X, Z), ())  # no turning about z
    structure = Structure(tuple(feet), gravity=(0.0, 0.0, -10.0))
    strength = solve_elastic(Liner(mesh, STEEL), structure, Load({"middle": np.array([[0.0, 0.0, -4.0]])}))
    assert mesh.node[17] == pytest.approx([0.3, 0.2, 0.0])
    foot = np.array([strength.reaction[f"foot_{i}"].force[2] for i in range(4)])
    whole = 7850.0 * 0.6 * 0.4 * 0.04 * 10.0 + 4.0
    # statics: along each side half the weight, so feet across a diagonal carry alike; rounding of a direct solution
    assert foot[[0, 0, 1, 2]] + foot[[1, 2, 3, 3]] == pytest.approx(0.5 * whole, rel=1e-9)
    assert foot == pytest.approx(0.25 * whole, rel=0.03)  # what statics leave open: the mesh's own diagonals


def test_resultants_turn_into_stress_on_both_faces():
    """A strip bent by M and pulled by N: N / h +- 6 M / h^2."""
    mesh = sheet((0.0, 0.0), (1.0, 0.1), (4, 2), 0.02)
    material = elastic(1e9, 0.0)
    x = mesh.node[:, 0]
    moved = np.zeros((len(x), 6))
    moved[:, 0], moved[:, 2], moved[:, 4] = 1e-3 * x, -0.5 * 0.2 * x**2, 0.2 * x
    section = resultants(mesh, material, moved)
    assert section.force[..., 0] == pytest.approx(1e9 * 0.02 * 1e-3, rel=1e-9)  # rounding
    assert section.moment[..., 0] == pytest.approx(1e9 * 0.02**3 / 12.0 * 0.2, rel=1e-9)  # rounding
    for height, strain in ((0.5, 1e-3 + 0.2 * 0.01), (-0.5, 1e-3 - 0.2 * 0.01), (0.0, 1e-3)):
        stress = section.stress(height)
        assert stress[..., 0, 0] == pytest.approx(1e9 * strain, rel=1e-9)  # rounding
        assert np.abs(stress[..., 2, :]).max() < 1e-3  # Pa: the shear of a pure bending is rounding


def test_the_middle_surface_hangs_on_the_nodes():
    mesh = sheet((0.0, 0.0), (1.0, 1.0), (2, 2), 0.1, offset=-0.03)
    assert middle_surface(mesh)[:, 2] == pytest.approx(-0.03)


def test_a_shell_worn_through_is_refused():
    mesh = sheet((0.0, 0.0), (1.0, 1.0), (2, 2), 0.1)
    mesh.thickness[4] = 0.0
    with pytest.raises(UserError, match="thickness is 0 m at node 4"):
        shell_stiffness(mesh, STEEL)


def test_a_missing_group_is_named():
    mesh = sheet((0.0, 0.0), (1.0, 1.0), (2, 2), 0.1)
    with pytest.raises(UserError, match="no group 'edge'"):
        solve_elastic(Liner(mesh, STEEL), Structure((Fixed("edge"),)))


def test_a_free_rigid_motion_is_named():
    mesh = sheet((0.0, 0.0), (1.0, 1.0), (2, 2), 0.1)
    with pytest.raises(UserError, match="translation"):
        solve_elastic(Liner(mesh, STEEL), Structure((Fixed("x_low", (X, Z)),)))


def test_the_patch_is_distorted():
    assert np.ptp(np.linalg.norm(np.diff(proof.patch().node, axis=0), axis=1)) > 0.05
