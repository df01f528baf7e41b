"""Problems of shells that others have solved: the obstacle course, plates, beams, and a small plate with a pocket worn into it."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse.linalg import splu

from wearfem.liner.block import Cut, Rising, mapped, sheet
from wearfem.liner.mesh import ShellMesh
from wearfem.liner.shell import edge_load, gravity_load, pressure_load, shell_stiffness
from wearfem.material import Material

U, V, W, TURN_X, TURN_Y, TURN_Z = range(6)
ALL = (U, V, W, TURN_X, TURN_Y, TURN_Z)
MIRROR_X, MIRROR_Y, MIRROR_Z = (U, TURN_Y, TURN_Z), (V, TURN_X, TURN_Z), (W, TURN_X, TURN_Y)


def elastic(young_modulus: float, poisson_ratio: float, density: float = 1.0) -> Material:
    """A material by its modulus [Pa or the unit of the problem]."""
    return Material("elastic", density, 0.5 * young_modulus / (1.0 + poisson_ratio), poisson_ratio)


@dataclass(frozen=True)
class Problem:
    """A shell, what holds it, and what loads it."""

    mesh: ShellMesh
    material: Material
    held: np.ndarray  # (n, 6) bool
    load: np.ndarray  # (n, 6) [N, N m]

    def displacement(self) -> np.ndarray:
        """(n, 6) [m, rad], by a direct solution"""
        free = ~self.held.ravel()
        stiffness = shell_stiffness(self.mesh, self.material)[free][:, free].tocsc()
        factor = splu(
            stiffness,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        answer, load = np.zeros(free.size), self.load.ravel()[free]
        first = factor.solve(load)
        answer[free] = first + factor.solve(
            load - stiffness @ first
        )  # thin shells lose digits: one refinement
        return answer.reshape(-1, 6)


def hold(mesh: ShellMesh, *edges: tuple[str, tuple[int, ...]]) -> np.ndarray:
    """(n, 6) the components that are held, by groups of edges"""
    held = np.zeros((len(mesh.node), 6), bool)
    for name, components in edges:
        held[np.unique(mesh.group[name])[:, None], np.array(components)] = True
    return held


def node_at(flat: ShellMesh, x: float, y: float) -> int:
    """The node of a lattice nearest to a point of it."""
    return int(np.argmin(np.hypot(flat.node[:, 0] - x, flat.node[:, 1] - y)))


@dataclass(frozen=True)
class Obstacle:
    """A problem of the obstacle course: what is measured, and what others found."""

    name: str
    reference: float
    source: str
    covers: str  # what an n x n mesh covers
    computed: Callable[[int, Cut], float]


def scordelis_lo(cells: int, cut: Cut = Rising) -> float:
    """Sinking of the middle of the free edge of a roof R 25, L 50, t 0.25, 80 degrees, under 90 a unit of area; a quarter."""
    flat = sheet((0.0, 0.0), (math.radians(40.0), 25.0), (cells, cells), 0.25, cut)
    mesh = mapped(flat, lambda p: np.stack([25.0 * np.sin(p[:, 0]), p[:, 1], 25.0 * np.cos(p[:, 0])], axis=1))
    held = hold(mesh, ("x_low", MIRROR_X), ("y_high", MIRROR_Y), ("y_low", (U, W)))
    material = elastic(4.32e8, 0.0, density=360.0)  # 360 * 0.25 = 90 a unit of area
    load = gravity_load(mesh, material, np.array([0.0, 0.0, -1.0]))
    moved = Problem(mesh, material, held, load).displacement()
    return float(-moved[node_at(flat, math.radians(40.0), 25.0), W])


def pinched_cylinder(cells: int, cut: Cut = Rising) -> float:
    """Sinking under a pinching force 1 of a cylinder R 300, L 600, t 3 with rigid diaphragms at its ends; an octant."""
    flat = sheet((0.0, 0.0), (0.5 * math.pi, 300.0), (cells, cells), 3.0, cut)
    mesh = mapped(
        flat, lambda p: np.stack([300.0 * np.sin(p[:, 0]), p[:, 1], 300.0 * np.cos(p[:, 0])], axis=1)
    )
    held = hold(mesh, ("x_low", MIRROR_X), ("x_high", MIRROR_Z), ("y_high", MIRROR_Y), ("y_low", (U, W)))
    load = np.zeros((len(mesh.node), 6))
    under = node_at(flat, 0.0, 300.0)
    load[under, W] = -0.25
    return float(-Problem(mesh, elastic(3e6, 0.3), held, load).displacement()[under, W])


def pinched_hemisphere(cells: int, cut: Cut = Rising) -> float:
    """Displacement along the forces 2 that pull and press a hemisphere R 10, t 0.04 with a hole of 18 degrees; a quarter."""
    flat = sheet((0.0, 0.0), (0.5 * math.pi, math.radians(72.0)), (cells, cells), 0.04, cut)
    mesh = mapped(flat, _sphere)
    held = hold(mesh, ("x_low", MIRROR_Y), ("x_high", MIRROR_X))
    pulled, pressed = node_at(flat, 0.0, 0.0), node_at(flat, 0.5 * math.pi, 0.0)
    held[pulled, W] = True  # the only free rigid motion
    load = np.zeros((len(mesh.node), 6))
    load[pulled, U], load[pressed, V] = 1.0, -1.0
    return float(Problem(mesh, elastic(6.825e7, 0.3), held, load).displacement()[pulled, U])


def _sphere(p: np.ndarray) -> np.ndarray:
    east, north = p[:, 0], p[:, 1]
    return 10.0 * np.stack(
        [np.cos(east) * np.cos(north), np.sin(east) * np.cos(north), np.sin(north)], axis=1
    )


def twisted_beam(cells: int, cut: Cut = Rising, *, thickness: float, force: float, along: int) -> float:
    """Displacement of the tip along its force of a beam L 12, b 1.1, twisted by 90 degrees; the whole beam.

    The force is spread over the edge of the tip. The width lies along y at the clamped end and along z at the tip, so that `along` W
    bends the tip in its plane and V out of it.
    """
    flat = sheet((0.0, -0.55), (12.0, 0.55), (cells, cells), thickness, cut)
    mesh = mapped(flat, _twist)
    edge = mesh.group["x_high"]
    load = edge_load(mesh, edge, np.tile(force / len(edge) * np.eye(3)[along], (len(edge), 1)))
    moved = Problem(mesh, elastic(29e6, 0.22), hold(mesh, ("x_low", ALL)), load).displacement()
    return float(moved[node_at(flat, 12.0, 0.0), along])


def _twist(p: np.ndarray) -> np.ndarray:
    angle = 0.5 * math.pi * p[:, 0] / 12.0
    return np.stack([p[:, 0], p[:, 1] * np.cos(angle), p[:, 1] * np.sin(angle)], axis=1)


def _beam(thickness: float, force: float, along: int) -> Callable[[int, Cut], float]:
    return lambda cells, cut: twisted_beam(cells, cut, thickness=thickness, force=force, along=along)


_MACNEAL = "R. H. MacNeal and R. L. Harder, Finite Elem. Anal. Des. 1 (1985) 3-20"
_COURSE = "T. Belytschko et al. (the obstacle course), Comput. Methods Appl. Mech. Engrg. 51 (1985) 221-258"
_SIMO = "J. C. Simo, D. D. Fox, M. S. Rifai, Comput. Methods Appl. Mech. Engrg. 73 (1989) 53-92"

OBSTACLES = (
    Obstacle("Scordelis-Lo roof", 0.3024, _MACNEAL, "a quarter", scordelis_lo),
    Obstacle("pinched cylinder with diaphragms", 1.8248e-5, _COURSE, "an octant", pinched_cylinder),
    Obstacle(
        "pinched hemisphere with an 18 degree hole",
        0.0924,
        f"{_COURSE}; MacNeal and Harder (1985) have 0.094",
        "a quarter",
        pinched_hemisphere,
    ),
    Obstacle("twisted beam, in plane", 5.424e-3, _MACNEAL, "all of it", _beam(0.32, 1.0, W)),
    Obstacle("twisted beam, out of plane", 1.754e-3, _MACNEAL, "all of it", _beam(0.32, 1.0, V)),
    Obstacle("thin twisted beam, in plane", 5.256e-3, _SIMO, "all of it", _beam(0.0032, 1e-6, W)),
    Obstacle("thin twisted beam, out of plane", 1.294e-3, _SIMO, "all of it", _beam(0.0032, 1e-6, V)),
)


def square_plate(
    cells: int, thickness: float, edge: tuple[int, ...], material: Material, cut: Cut = Rising
) -> Problem:
    """A square plate of 1 m, a quarter of it, its edges held in the components of `edge` (as x and y edges), pressed by 1 Pa from above.

    For simple support `edge` is (W, TURN_X): the turn about x is held where the edge lies along y, and about y where along x.
    """
    mesh = sheet((0.0, 0.0), (0.5, 0.5), (cells, cells), thickness, cut)
    swapped = tuple({TURN_X: TURN_Y, TURN_Y: TURN_X}.get(c, c) for c in edge)
    held = hold(mesh, ("x_high", edge), ("y_high", swapped), ("x_low", MIRROR_X), ("y_low", MIRROR_Y))
    held[:, [U, V, TURN_Z]] = True  # bending alone
    return Problem(mesh, material, held, pressure_load(mesh, 1.0))


def pocket(
    mesh: ShellMesh, full: float, deepest: float, centre: tuple[float, float], radius: float
) -> ShellMesh:
    """The flat shell worn from above by a bell-shaped pocket; its back stays where it is.

    Thickness = full - deepest exp(-(r / radius)^2) [m]; the middle surface sinks by half of what is lost.
    """
    square = ((mesh.node[:, :2] - centre) ** 2).sum(axis=1)
    lost = deepest * np.exp(-square / radius**2)
    return replace(mesh, thickness=full - lost, offset=mesh.offset - 0.5 * lost)


def worn_plate(cells: int, cut: Cut = Rising) -> Problem:
    """A plate 0.6 x 0.4 m, 40 mm thick, clamped all around, with a pocket 20 mm deep, pressed by 0.1 MPa on its worn face."""
    mesh = sheet((0.0, 0.0), (0.6, 0.4), (3 * cells // 2, cells), 0.04, cut)
    mesh = pocket(mesh, 0.04, 0.02, (0.25, 0.2), 0.1)
    steel = elastic(210e9, 0.3, density=7850.0)
    return Problem(mesh, steel, hold(mesh, ("rim", ALL)), pressure_load(mesh, 1e5))


def cantilever(
    cells: tuple[int, int],
    thickness: Callable[[np.ndarray], np.ndarray],
    offset: Callable[[np.ndarray], np.ndarray],
    force: tuple[float, float, float],
) -> Problem:
    """A cantilever 1 m long and 0.1 m wide, E 1e9 and nu 0, its tip edge loaded by `force` [N] at the nodes."""
    mesh = sheet((0.0, 0.0), (1.0, 0.1), cells, 1.0)
    mesh = replace(mesh, thickness=thickness(mesh.node[:, 0]), offset=offset(mesh.node[:, 0]))
    edge = mesh.group["x_high"]
    load = edge_load(mesh, edge, np.tile(np.array(force) / len(edge), (len(edge), 1)))
    return Problem(mesh, elastic(1e9, 0.0), hold(mesh, ("x_low", ALL)), load)
