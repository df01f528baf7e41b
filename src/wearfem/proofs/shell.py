"""The shell: patch tests, plates thin and thick, the obstacle course, tapers, offsets, and a plate with a worn pocket."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.integrate import quad

from wearfem.liner.block import Falling, Hexahedra, Rising, block, mapped, sheet
from wearfem.liner.liner import Liner, worn_face
from wearfem.liner.mesh import ShellMesh
from wearfem.liner.shell import at_nodes, resultants, shell_stiffness
from wearfem.liner.shell_element import axes_of, local_stiffness
from wearfem.liner.solve import Load, Structure, solve_elastic
from wearfem.liner.support import Fixed, X, Y, Z
from wearfem.proof import Claim
from wearfem.proofs._shell_problems import (
    ALL,
    OBSTACLES,
    TURN_X,
    TURN_Y,
    Problem,
    U,
    V,
    W,
    cantilever,
    elastic,
    hold,
    node_at,
    pocket,
    square_plate,
    worn_plate,
)
from wearfem.verification.plate_theory import Plate, clamped_plate, supported_plate

ROUNDING = 1e-9  # of stiffness matrices whose terms differ by a factor of 1e6
SUPPORTED, CLAMPED = (W, TURN_X), (W, TURN_X, TURN_Y)
STEEL = elastic(210e9, 0.3, density=7850.0)
RIM = (Fixed("x_high"), Fixed("y_high"))
THICKNESS = (1e-4, 1e-3, 1e-2, 0.05, 0.1, 0.2)


def claims() -> Iterator[Claim]:
    """Rigid motions, patch tests, plates, obstacles, cantilevers, powers of the thickness, and a pocket."""
    yield from rigid_motions()
    yield from patch_tests()
    yield from plates()
    yield from obstacle_course()
    yield from cantilevers()
    yield from powers_of_thickness()
    yield from worn_pocket()
    yield from solid_and_shell()


def rigid_motions() -> Iterator[Claim]:
    """A triangle in space resists everything but its six rigid motions."""
    corner = np.array([[[0.0, 0.0, 0.0], [1.3, 0.2, 0.1], [0.4, 0.9, -0.3]]])
    _, xy = axes_of(corner)
    energy = np.linalg.eigvalsh(local_stiffness(xy, np.array([[0.10, 0.12, 0.09]]), 1.0, 0.3)[0])
    none = int((np.abs(energy) < 1e-12 * energy[-1]).sum())
    yield Claim(
        "motions of a triangle without energy", "three translations and three rotations", 6, none, "-", 0.0, False,
        f"the seventh has {energy[6] / energy[-1]:.1e} of the largest energy",
    )  # fmt: skip


def patch() -> ShellMesh:
    """A sheet 2 x 1 with distorted triangles, tilted in space."""
    mesh = sheet((0.0, 0.0), (2.0, 1.0), (5, 4), 0.05)
    inside = np.setdiff1d(np.arange(len(mesh.node)), mesh.group["rim"])
    node = mesh.node.copy()
    node[inside, :2] += np.random.default_rng(7).uniform(-0.07, 0.07, (len(inside), 2))
    return replace(mesh, node=node)


def tilted(mesh: ShellMesh) -> tuple[ShellMesh, np.ndarray]:
    """The mesh turned in space, and the matrix (3, 3) that turns."""
    turn, _ = np.linalg.qr(np.array([[1.0, 0.3, -0.2], [0.1, 1.0, 0.5], [0.4, -0.6, 1.0]]))
    turn *= np.sign(np.linalg.det(turn))
    return replace(mesh, node=mesh.node @ turn.T), turn


def patch_error(field: np.ndarray, mesh: ShellMesh) -> float:
    """Largest error inside a tilted patch whose rim moves as `field` (n, 6), over the largest of the field, by kind of component."""
    turned, turn = tilted(mesh)
    exact = np.hstack([field[:, :3] @ turn.T, field[:, 3:] @ turn.T])
    rim = hold(turned, ("rim", ALL))
    material = elastic(1.0, 0.3)
    stiffness = shell_stiffness(turned, material)
    pulled = np.where(rim, exact, 0.0)
    load = -(stiffness @ pulled.ravel()).reshape(-1, 6)
    moved = Problem(turned, material, rim, load).displacement() + pulled
    scale = [np.abs(exact[:, :3]).max(), np.abs(exact[:, 3:]).max()]
    return max(
        float(np.abs(moved - exact)[:, part].max() / max(size, max(scale)))
        for part, size in ((slice(0, 3), scale[0]), (slice(3, 6), scale[1]))
    )


def stretched(mesh: ShellMesh) -> np.ndarray:
    """(n, 6) uniform strains eps_x, eps_y, gamma_xy in the plane"""
    x, y, _ = mesh.node.T
    field = np.zeros((len(x), 6))
    field[:, U], field[:, V] = 1.0 * x + 0.7 * y, 0.2 * x - 0.5 * y
    field[:, 5] = 0.5 * (0.2 - 0.7)
    return field


def bent(mesh: ShellMesh) -> np.ndarray:
    """(n, 6) uniform curvatures and twist: w = -(x^2 + 0.6 x y - 0.4 y^2) / 2, normals stay normal"""
    x, y, _ = mesh.node.T
    field = np.zeros((len(x), 6))
    field[:, W] = -0.5 * (x**2 + 0.6 * x * y - 0.4 * y**2)
    field[:, TURN_X], field[:, TURN_Y] = -0.5 * (0.6 * x - 0.8 * y), 0.5 * (2.0 * x + 0.6 * y)
    return field


def sheared(mesh: ShellMesh) -> np.ndarray:
    """(n, 6) uniform transverse shear: w = x - 0.5 y, no normal turns"""
    field = np.zeros((len(mesh.node), 6))
    field[:, W] = mesh.node[:, 0] - 0.5 * mesh.node[:, 1]
    return field


def patch_tests() -> Iterator[Claim]:
    """Uniform strains are exact on distorted triangles."""
    mesh = patch()
    for name, field in (("stretch and shear in the plane", stretched), ("bending and twist", bent)):
        yield Claim(
            f"patch test, {name}: largest error", "a uniform strain is a solution", 0.0, patch_error(field(mesh), mesh),
            "-", ROUNDING, False, "20 distorted pairs of triangles, tilted in space",
        )  # fmt: skip
    for ratio, limit in ((1e2, 1e-3), (1e4, 1e-7)):
        thick = replace(mesh, thickness=ratio * np.ones(len(mesh.node)))
        yield Claim(
            f"patch test, transverse shear, thickness {ratio:g}: largest error", "a solution of pure shear, h / l -> infinity",
            0.0, patch_error(sheared(thick), thick), "-", limit, False,
            "shear without a moment that changes is no solution of plate theory; the element has it in the limit, error (l / h)^2",
        )  # fmt: skip


def supported_centre(plate: Plate) -> float:
    """Deflection [m] at the centre."""
    return supported_plate(plate)[0]


def plates() -> Iterator[Claim]:
    """Square plates from thin to thick; 32 x 32 cells cover a quarter."""
    material = elastic(1e9, 0.3)
    for name, edge, theory, source in (
        (
            "simply supported",
            SUPPORTED,
            supported_centre,
            "Navier's series with shear",
        ),
        ("clamped", CLAMPED, clamped_plate, "Ritz's method with 14 x 14 Legendre polynomials a field"),
    ):
        for h in THICKNESS:
            expected = theory(Plate(1.0, h, 1e9, 0.3, 1.0))
            moved = [
                -square_plate(32, h, edge, material, cut).displacement()[0, W] for cut in (Rising, Falling)
            ]
            worst = moved[int(np.argmax(np.abs(np.array(moved) - expected)))]
            yield Claim(
                f"centre of a {name} square plate, h / a = {h:g}, 32 x 32 a quarter", source, expected, float(worst),
                "m", 5e-3, True, "0.5 % is asked; the worse of both diagonals",
            )  # fmt: skip


def obstacle_course() -> Iterator[Claim]:
    """The published shells, 32 x 32 cells."""
    for one in OBSTACLES:
        for name, cut in (("rising", Rising), ("falling", Falling)):
            yield Claim(
                f"{one.name}, 32 x 32 on {one.covers}, {name} diagonals", one.source, one.reference, one.computed(32, cut),
                "length", 0.02, True, "2 % is asked",
            )  # fmt: skip


def cantilevers() -> Iterator[Claim]:
    """Beams of 1 m: tapered, with a flat back, and eccentric."""
    young, width = 1e9, 0.1

    def thickness(x: np.ndarray) -> np.ndarray:
        return 0.05 - 0.03 * x

    def compliance(x: float) -> float:
        h = float(thickness(np.array(x)))
        return (1.0 - x) ** 2 * 12.0 / (young * width * h**3) + 1.2 / (0.5 * young * width * h)

    expected = quad(compliance, 0.0, 1.0)[0]
    push = (0.0, 0.0, 1.0)
    straight = cantilever((32, 4), thickness, np.zeros_like, push)
    yield Claim(
        "tip of a cantilever that tapers from 50 to 20 mm, 32 x 4", "beam theory with shear, integrated", expected,
        tip(straight)[W], "m/N", 5e-3, True, "0.5 %",
    )  # fmt: skip
    flat_back = cantilever((32, 4), thickness, lambda x: 0.5 * (thickness(x) - 0.05), push)
    yield Claim(
        "the same, worn from one side: the back is flat", "beam theory with shear; slope of the axis 1.5 %", expected,
        tip(flat_back)[W], "m/N", 5e-3, True, "0.5 %; the inclined axis changes 0.01 %",
    )  # fmt: skip
    e, h, pull = 0.03, 0.02, (1.0, 0.0, 0.0)
    moved = tip(cantilever((16, 2), lambda x: h + 0.0 * x, lambda x: e + 0.0 * x, pull))
    section, second = width * h, width * h**3 / 12.0
    for name, component, exact in (
        ("pull", U, 1.0 / (young * section) + e**2 / (young * second)),
        ("deflection", W, e / (2.0 * young * second)),
    ):
        yield Claim(
            f"eccentric cantilever pulled at its nodes, {name} of the tip", "beam theory: F L / E A + F e^2 L / E I, F e L^2 / 2 E I",
            exact, moved[component], "m", 1e-6, True, "uniform force and moment: only rounding of a slender strip",
        )  # fmt: skip


def tip(problem: Problem) -> list[float]:
    """The six displacements at the middle of a cantilever's tip."""
    return [float(value) for value in problem.displacement()[node_at(problem.mesh, 1.0, 0.05)]]


def powers_of_thickness() -> Iterator[Claim]:
    """A thin clamped plate: deflection and stress against thickness, by the ratio of two thicknesses."""
    material, thin = elastic(1e9, 0.3), (0.002, 0.001)
    deflection, stress = [], []
    for h in thin:
        plate = square_plate(16, h, CLAMPED, material)
        moved = plate.displacement()
        face = at_nodes(plate.mesh, resultants(plate.mesh, material, moved).stress(-0.5))
        deflection.append(-moved[0, W])
        stress.append(face[node_at(plate.mesh, 0.5, 0.0), 0, 0])
    for name, value, power in (("deflection", deflection, -3.0), ("stress at the edge", stress, -2.0)):
        order = float(np.log(value[0] / value[1]) / np.log(thin[0] / thin[1]))
        yield Claim(
            f"power of the thickness in the {name} of a thin plate", "Kirchhoff's plate theory", power, order, "-", 2e-3, False,
            "shear adds (h / a)^2, 1e-5 here",
        )  # fmt: skip


def worn_pocket() -> Iterator[Claim]:
    """A clamped plate with a pocket to half its thickness, against meshes twice and four times as fine."""
    coarse, middle, fine = (pocket_answers(cells) for cells in (24, 48, 96))
    for name, unit in (("deflection", "m"), ("stress on the back", "Pa")):
        order = np.log2((middle[name] - coarse[name]) / (fine[name] - middle[name]))
        limit = fine[name] + (fine[name] - middle[name]) / 3.0
        yield Claim(
            f"worn plate, {name} under the pocket, 72 x 48", "144 x 96 cells, extrapolated at second order", limit, middle[name],
            unit, 0.02, True, "2 % is asked of solid and shell",
        )  # fmt: skip
        yield Claim(
            f"worn plate, {name} under the pocket: observed order", "quadratic convergence", 2.0, float(order), "-", 0.5, False,
            "not yet asymptotic: the pocket is 6 cells of the coarse mesh wide",
        )  # fmt: skip


def pocket_answers(cells: int) -> dict[str, float]:
    """Deflection [m] and stress [Pa] of the worn plate."""
    problem = worn_plate(cells)
    moved = problem.displacement()
    back = at_nodes(problem.mesh, resultants(problem.mesh, problem.material, moved).stress(-0.5))
    under = node_at(problem.mesh, 0.25, 0.2)
    return {"deflection": float(-moved[under, W]), "stress on the back": float(back[under, 1, 1])}


def solid_and_shell() -> Iterator[Claim]:
    """A plate with a pocket in its middle, a quarter of it, as a shell and as hexahedra of quadratic displacement."""
    shell, solid = central_pocket_shell(32), central_pocket_solid((12, 8, 2))
    for name, unit in (("deflection", "m"), ("von Mises stress on the back", "Pa")):
        yield Claim(
            f"worn plate, {name} under the pocket, shell 48 x 32", "solid of 12 x 8 x 2 hexahedra", solid[name], shell[name],
            unit, 0.02, True, "2 % is asked",
        )  # fmt: skip


def central_pocket_shell(cells: int) -> dict[str, float]:
    """A quarter of a plate 0.6 x 0.4 x 0.04 m, clamped, worn to half in its middle, 0.1 MPa: what happens at the middle of the back."""
    mesh = pocket(sheet((0.0, 0.0), (0.3, 0.2), (3 * cells // 2, cells), 0.04), 0.04, 0.02, (0.0, 0.0), 0.1)
    corner = worn_face(mesh)[mesh.wear]
    force = -0.5e5 * np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    supports = (*RIM, Fixed("x_low", (X,), (Y, Z)), Fixed("y_low", (Y,), (X, Z)))
    return at_the_back(
        Liner(mesh, STEEL), Structure(supports), Load({"wear": force}), node_at(mesh, 0.0, 0.0)
    )


def central_pocket_solid(cells: tuple[int, int, int]) -> dict[str, float]:
    """The same as a solid."""
    mesh = block((0.0, 0.0, -0.02), (0.3, 0.2, 0.02), cells, Hexahedra)

    def worn(point: np.ndarray) -> np.ndarray:
        lost = 0.02 * np.exp(-(point[:, 0] ** 2 + point[:, 1] ** 2) / 0.1**2)
        return point - (point[:, 2] / 0.04 + 0.5)[:, None] * lost[:, None] * np.array([0.0, 0.0, 1.0])

    mesh = mapped(mesh, worn)
    corner = mesh.node[mesh.wear]
    force = -0.5e5 * np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    supports = (*RIM, Fixed("x_low", (X,)), Fixed("y_low", (Y,)))
    back = int(np.argmin(np.abs(mesh.node - [0.0, 0.0, -0.02]).sum(axis=1)))
    return at_the_back(Liner(mesh, STEEL), Structure(supports), Load({"wear": force}), back)


def at_the_back(liner: Liner, structure: Structure, load: Load, node: int) -> dict[str, float]:
    """Deflection [m] and von Mises stress [Pa] at a node."""
    strength = solve_elastic(liner, structure, load)
    return {
        "deflection": float(-strength.displacement[node, 2]),
        "von Mises stress on the back": float(strength.von_mises[node]),
    }
