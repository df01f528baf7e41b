"""Recession: drums and spheres stay round, plates flat and boxes sharp, a pocket turns no element over, and no volume is lost."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from wearfem.liner.block import Cut, Hexahedra, Tetrahedra, block, mapped
from wearfem.liner.corners import facet_vector
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import SolidMesh
from wearfem.liner.recede import advance, recede, removed_volume, volume
from wearfem.material import Material
from wearfem.proof import Claim

STEEL = Material("steel", density=7850.0, shear_modulus=80e9, poisson_ratio=0.3)
STEPS = 100


def claims() -> Iterator[Claim]:
    """Round bodies, a plate, a box, and a pocket."""
    yield from _round()
    yield from _plate()
    yield from _box()
    yield from _pocket()


def order(coarse: float, fine: float) -> float:
    """Observed order of an error between two meshes, one twice as fine as the other"""
    return float(np.log2(coarse / fine))


# Round bodies: one radius everywhere, known in closed form


def drum(cells: int, inside: bool, kind: Cut = Hexahedra) -> SolidMesh:
    """A quarter of a thick drum of radius 1 m and 0.4 m thick, worn outside, or inside"""
    flat = block((0.0, 0.0, 0.0), (0.5 * pi, 0.4, 0.4), (cells, 1, 2), kind, name="drum")

    def bend(x: np.ndarray) -> np.ndarray:
        r = 1.4 - x[:, 2] if inside else 0.6 + x[:, 2]
        angle = x[:, 0] if inside else 0.5 * pi - x[:, 0]
        return np.column_stack([r * np.cos(angle), x[:, 1], r * np.sin(angle)])

    return mapped(flat, bend)


def ball(cells: int, inside: bool, kind: Cut = Tetrahedra) -> SolidMesh:
    """A sixth of a thick sphere of radius 1 m and 0.4 m thick between planes through its centre, worn outside, or inside"""
    flat = block(
        (-0.25 * pi, -0.25 * pi, 0.0), (0.25 * pi, 0.25 * pi, 0.4), (cells, cells, 2), kind, name="ball"
    )

    def bend(x: np.ndarray) -> np.ndarray:
        r = 1.4 - x[:, 2] if inside else 0.6 + x[:, 2]
        way = np.column_stack([np.tan(-x[:, 0] if inside else x[:, 0]), np.tan(x[:, 1]), np.ones(len(x))])
        return r[:, None] * way / np.linalg.norm(way, axis=1, keepdims=True)

    return mapped(flat, bend)


@dataclass(frozen=True)
class Roundness:
    """What is left of a round body."""

    error: float  # [m] mean radius of the worn nodes against the closed form
    spread: float  # [m] largest less least radius
    volume: float  # [-] largest relative error of the volume in a step


def wear_round(mesh: SolidMesh, dimension: int, inside: bool, total: float = 0.1) -> Roundness:
    """Wear a body of radius 1 m by the same depth everywhere, in `STEPS` steps to `total` [m].

    With the volume of a step depth x area, the radius of a cylinder (dimension 2) goes by r'^2 = r^2 -+ 2 r w, that of a sphere (3) by
    r'^3 = r^3 -+ 3 r^2 w.
    """
    liner, step, sign = Liner(mesh, STEEL), total / STEPS, 1.0 if inside else -1.0
    radius, worst = 1.0, 0.0
    depth = np.full(len(mesh.wear), step)
    for _ in range(STEPS):
        after = recede(liner, depth)
        lost, asked = volume(liner.mesh) - volume(after.mesh), removed_volume(liner.mesh, depth)
        worst, liner = max(worst, abs(lost / asked - 1.0)), after
        radius = (radius**dimension + sign * dimension * radius ** (dimension - 1) * step) ** (
            1.0 / dimension
        )
    node = liner.mesh.node[np.unique(mesh.wear)]
    away = np.linalg.norm(node[:, [0, 2]] if dimension == 2 else node, axis=1)
    return Roundness(abs(float(away.mean()) - radius), float(np.ptp(away)), worst)


def _round() -> Iterator[Claim]:
    for name, make, dimension, cells, inside in (("drum", drum, 2, 8, True), ("ball", ball, 3, 4, False)):
        coarse, fine = (
            wear_round(make(count, inside, Tetrahedra), dimension, inside) for count in (cells, 2 * cells)
        )
        side = "inside" if inside else "outside"
        yield Claim(
            f"order of the radius of a {name} worn {side}, {STEPS} steps to 10 %", "volume by volume in closed form", 2.0,
            order(coarse.error, fine.error), "-", 0.1, False, "flat facets are second order; the rest is the coarse mesh",
        )  # fmt: skip
        yield Claim(
            f"spread of the radii of a {name}, over 1 m", "a round body stays round", 0.0, fine.spread, "m", float("inf"), False,
            f"{coarse.spread:.2g} m on the mesh twice as coarse",
        )  # fmt: skip
        yield Claim(
            f"volume lost by a {name} in a step, worst of {STEPS}", "depth x area", 0.0, fine.volume, "-", 1e-10, False,
            "asked; rounding is 1e-13",
        )  # fmt: skip


# A plate and a box: planes that move


def uneven(mesh: SolidMesh, part: float = 0.2, seed: int = 1) -> SolidMesh:
    """The mesh of a box with its inner nodes and those within its sides moved at random by up to `part` of a cell"""
    low, high = mesh.node.min(axis=0), mesh.node.max(axis=0)
    count = np.array([len(np.unique(mesh.node[:, k].round(12))) - 1 for k in range(3)])
    shift = np.random.default_rng(seed).uniform(-part, part, mesh.node.shape) * (high - low) / count
    return replace(mesh, node=mesh.node + np.where((mesh.node > low) & (mesh.node < high), shift, 0.0))


def _plate() -> Iterator[Claim]:
    for kind, name in ((Tetrahedra, "tetrahedra"), (Hexahedra, "hexahedra")):
        plate = uneven(block((0.0, 0.0, 0.0), (0.3, 0.2, 0.04), (9, 6, 4), kind, name="plate"))
        liner = Liner(plate, STEEL)
        for _ in range(10):
            liner = recede(liner, np.full(len(plate.wear), 1e-3))
        height = liner.mesh.node[np.unique(plate.wear), 2]
        yield Claim(
            f"10 mm off a plate of uneven {name}: farthest node", "a plane stays a plane", 0.03,
            float(height[np.abs(height - 0.03).argmax()]), "m", 1e-15, False, "rounding of ten steps",
        )  # fmt: skip


def box(cells: int) -> SolidMesh:
    """A cube of 1 m that wears on its upper three sides"""
    cube = block((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (cells, cells, cells), Hexahedra, name="box")
    worn = np.concatenate([cube.group[name] for name in ("wear", "x_high", "y_high")])
    return replace(cube, group={"wear": worn, "bottom": cube.group["bottom"]})


def wear_box(cells: int, steps: int, total: float = 0.2) -> tuple[float, float]:
    """Turn of the sharp edges, least of all [degree], and depth of the corner beyond that of the faces' middles [m]"""
    liner = Liner(box(cells), STEEL)
    for _ in range(steps):
        liner = recede(liner, np.full(len(liner.mesh.wear), total / steps))
    node, wear = liner.mesh.node, liner.mesh.wear
    vector = facet_vector(node, wear)
    normal = vector / np.linalg.norm(vector, axis=1, keepdims=True)
    edge = np.sort(np.stack([wear, np.roll(wear, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    _, number, count = np.unique(edge, axis=0, return_inverse=True, return_counts=True)
    face = np.repeat(np.arange(len(wear)) // cells**2, 4)
    pairs = [np.flatnonzero(number.ravel() == k) for k in np.flatnonzero(count == 2)]
    turn = [
        np.degrees(np.arccos(normal[p[0] // 4] @ normal[p[1] // 4]))
        for p in pairs
        if face[p[0]] != face[p[1]]
    ]
    top = node[np.unique(wear[: cells**2])]
    return float(np.min(turn)), float(np.ptp(top[:, 2]))


def _box() -> Iterator[Claim]:
    (turn, beyond), (_, finer) = wear_box(4, 10), wear_box(4, 20)
    yield Claim(
        "turn of the sharp edges of a box after 20 % off three sides", "they stay sharp", 90.0, turn, "degree", 4.6, False,
        "the overlap of a step's depths at an edge, 0.02 m, over its facets, 0.25 m",
    )  # fmt: skip
    yield Claim(
        "what a face of the box is off its plane, 10 steps", "a plane stays a plane", 0.0, beyond, "m", float("inf"), False,
        f"volume by facet counts the overlap at an edge twice, and it is made good beside the edge; {finer:.2g} m in 20 steps",
    )  # fmt: skip


# A deep pocket: the mesh holds


@dataclass(frozen=True)
class Pocket:
    """A plate with a pocket worn into it."""

    liner: Liner
    quality: float  # [-] least in all steps
    remeshes: int  # times that a remesh was called for
    volume: float  # [-] relative error over all steps


def wear_pocket(cells: int = 16, share: float = 0.4, steps: int = 20, kind: Cut = Hexahedra) -> Pocket:
    """Wear `share` of a 40 mm plate in a pocket of radius 30 mm, by exp(-r^2 / (2 x (15 mm)^2)), downwards, until it is that deep"""
    plate = block((-0.1, -0.1, 0.0), (0.1, 0.1, 0.04), (cells, cells, max(4, cells // 4)), kind, name="plate")
    liner, worst, calls, asked = Liner(plate, STEEL), 1.0, 0, 0.0
    while liner.mesh.node[plate.wear, 2].min() > (1.0 - share) * 0.04:
        vector = facet_vector(liner.mesh.node, plate.wear)
        centre = liner.mesh.node[plate.wear].mean(axis=1)
        down = vector[:, 2] / np.linalg.norm(vector, axis=1)
        depth = share * 0.04 / steps * np.exp(-(centre[:, :2] ** 2).sum(axis=1) / (2.0 * 0.015**2)) * down
        result = advance(liner, depth)
        asked += result.share * removed_volume(liner.mesh, depth)
        calls += result.remesh_needed
        worst, liner = min(worst, result.quality), result.liner
    return Pocket(liner, worst, calls, abs((volume(plate) - volume(liner.mesh)) / asked - 1.0))


def _pocket() -> Iterator[Claim]:
    pocket = wear_pocket()
    left = float(pocket.liner.mesh.node[np.unique(pocket.liner.mesh.wear), 2].min())
    yield Claim(
        "deepest point of a pocket of 40 % in a 40 mm plate", "worn until there, in steps of 0.8 mm", 0.016, 0.04 - left, "m", 0.8e-3,
        False, "a step",
    )  # fmt: skip
    yield Claim(
        "worst quality of an element on the way",
        "never below the limit",
        1.0,
        pocket.quality,
        "-",
        0.9,
        False,
        "limit 0.1",
    )
    yield Claim("remeshes called for", "none", 0.0, pocket.remeshes, "-", 0.0, False)
    yield Claim("volume of the pocket", "depth x area", 0.0, pocket.volume, "-", 1e-10, False, "asked")
