"""Remeshing: the same body with better elements, its groups, sides and edges in place, and fields that lose nothing."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wearfem.liner.block import block, mapped, sheet
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import LinerMesh, ShellMesh, SolidMesh
from wearfem.liner.quality import worst
from wearfem.liner.recede import advance
from wearfem.liner.remesh import Change, carry, change, refill, remesh, volume_of, worn_facets
from wearfem.material import Material
from wearfem.proof import Claim

STEEL = Material("steel", 7850.0, 80e9, 0.3)
SIDE, HEIGHT = 0.4, 0.04  # [m] of the plate
SIZES = (0.05, 0.025, 0.0125)  # [m] of the new meshes of the dome
STEPS, DEEP, EVERY = (
    16,
    0.016,
    5,
)  # the pocket: 40 % of the plate in 16 steps, remeshed after each fifth whether needed or not


def claims() -> Iterator[Claim]:
    """Skin kept, skin renewed, fields, shell, and a pocket that goes on growing on new meshes."""
    yield from _refilled()
    yield from _renewed()
    yield from _shell()
    yield from _pocket()


def _refilled() -> Iterator[Claim]:
    before = random_depth(Liner(tangled(), STEEL))
    after = refill(before, 0.02)
    told = change(before, after)
    same = np.array_equal(before.mesh.node[before.mesh.wear], after.mesh.node[after.mesh.wear])
    yield Claim(
        "worn facets and their depth the same to the last bit, inside refilled", "nothing touches them", 1.0,
        float(same and np.array_equal(before.depth, after.depth)), "-", 0.0, False,
    )  # fmt: skip
    yield Claim(
        "change of the volume, inside refilled",
        "the skin encloses it",
        0.0,
        told.volume,
        "-",
        1e-12,
        False,
        "rounding",
    )
    yield Claim(
        "worst quality after that", f"above the limit of 0.1; it was {told.quality_before:.2g}", 1.0, float(told.quality_after > 0.1), "-",
        0.0, False, f"{told.quality_after:.2g}",
    )  # fmt: skip


def _renewed() -> Iterator[Claim]:
    before = random_depth(Liner(dome(64), STEEL))
    after = [remesh(before, size) for size in SIZES]
    told = [change(before, one) for one in after]
    volume = np.abs([one.volume for one in told])
    yield Claim(
        "order of the change of volume in the edge length, plate with a dome", "chords of a curved face: 2", 2.0,
        float(np.polyfit(np.log(SIZES), np.log(volume), 1)[0]), "-", 0.3, False,
        f"{', '.join(f'{one.volume:.2g}' for one in told)} for edges of {', '.join(f'{1e3 * size:g}' for size in SIZES)} mm; "
        "edges are of that length in the mean only",
    )  # fmt: skip
    new = after[1]
    total = [float(worn_facets(one).facet_area @ one.depth) for one in (before, new)]
    yield Claim(
        "integral of a random depth",
        "carried conservatively",
        total[0],
        total[1],
        "m3",
        1e-10,
        True,
        "rounding",
    )
    yield Claim(
        "part of the depth beyond its old range", "bounds", 0.0,
        max(float(new.depth.max() - before.depth.max()), float(before.depth.min() - new.depth.min()), 0.0), "m", 0.0, False,
    )  # fmt: skip
    constant = carry(np.full(len(before.depth), 3.0), before, new)
    yield Claim(
        "change of a constant field",
        "exact",
        0.0,
        float(np.abs(constant - 3.0).max()),
        "-",
        1e-14,
        False,
        "rounding",
    )
    area, off = _flat_groups(before.mesh, new.mesh)
    yield Claim(
        "change of the area of the plane groups",
        "groups and edges stay",
        0.0,
        area,
        "-",
        1e-12,
        False,
        "rounding",
    )
    yield Claim(
        "largest distance of their nodes from their planes",
        "planes stay plane",
        0.0,
        off,
        "m",
        1e-15,
        False,
        "rounding",
    )
    yield Claim(
        "worst quality of the new mesh", "above the limit of 0.1", 1.0, float(told[1].quality_after > 0.1), "-", 0.0, False,
        f"{told[1].quality_after:.2g}; it was {told[1].quality_before:.2g}",
    )  # fmt: skip


def _flat_groups(before: LinerMesh, after: LinerMesh) -> tuple[float, float]:
    """Largest relative change of area, and largest distance [m] from the plane, of the groups on the box's sides."""
    planes = {
        "bottom": (2, 0.0),
        "x_low": (0, 0.0),
        "x_high": (0, SIDE),
        "y_low": (1, 0.0),
        "y_high": (1, SIDE),
    }
    change_of_area, off = 0.0, 0.0
    for name, (axis, place) in planes.items():
        old, new = (_area(mesh, name) for mesh in (before, after))
        change_of_area = max(change_of_area, abs(new / old - 1.0) if name == "bottom" else 0.0)
        off = max(off, float(np.abs(after.node[after.group[name]][..., axis] - place).max()))
    return change_of_area, off


def _area(mesh: LinerMesh, name: str) -> float:
    a, b, c = np.moveaxis(mesh.node[mesh.group[name]], 1, 0)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _shell() -> Iterator[Claim]:
    flat = sheet((0.0, 0.0), (SIDE, 0.75 * SIDE), (32, 24), 0.02)
    bent = mapped(flat, lambda x: np.column_stack([x[:, :2], 0.1 * np.sin(5.0 * x[:, 0])]))
    thickness = 0.02 * np.random.default_rng(4).uniform(0.2, 1.0, len(bent.node))
    before = random_depth(Liner(replace(bent, thickness=thickness), STEEL))
    after = remesh(before, 0.02)
    assert isinstance(after.mesh, ShellMesh)
    told, new = change(before, after), after.mesh.thickness
    yield Claim(
        "change of a shell's volume, thickness random",
        "carried conservatively",
        0.0,
        told.volume,
        "-",
        1e-10,
        False,
        "rounding",
    )
    beyond = max(float(new.max() - thickness.max()), float(thickness.min() - new.min()), 0.0)
    yield Claim("part of the thickness beyond its old range", "bounds", 0.0, beyond, "m", 0.0, False)


def _pocket() -> Iterator[Claim]:
    liner, lost, told, least = pocket()
    start = SIDE * SIDE * HEIGHT
    by_remeshing = sum(one[0] for one in told)
    yield Claim(
        "volume of a 40 mm plate with a pocket of 40 %, after remeshing", "what was there, less what was asked for", start - lost,
        volume_of(liner.mesh) - by_remeshing, "m3", 1e-10, True,
        f"{len(told)} new meshes changed it by {by_remeshing / lost:.2g} of the volume worn off, taken out here",
    )  # fmt: skip
    yield Claim(
        "volume that remeshing changed, in what was worn off", "small against the wear", 0.0, by_remeshing / lost, "-", 1e-2, False,
        "1 % of the wear is below what a survey sees",
    )  # fmt: skip
    yield Claim(
        "worst quality on the way", "above the limit of 0.1", 1.0, float(least > 0.1), "-", 0.0, False,
        f"least {least:.2g}; after each new mesh {', '.join(f'{one[1].quality_after:.2g}' for one in told)}",
    )  # fmt: skip
    yield Claim(
        "integral of the depth over the worn facets, in the volume worn off", "area of the worn face grows with its slope", lost,
        float(worn_facets(liner).facet_area @ liner.depth), "m3", np.inf, True,
    )  # fmt: skip


def pocket() -> tuple[Liner, float, list[tuple[float, Change]], float]:
    """A round pocket worn into a plate in equal steps, with a new mesh after every few.

    Returns
    -------
    Liner
        At the end.
    float
        [m3] asked for.
    list
        For each new mesh, the volume [m3] that it added, and its `Change`.
    float
        Least quality after any step.
    """
    liner, lost, told, least = (
        Liner(block((0.0, 0.0, 0.0), (SIDE, SIDE, HEIGHT), (20, 20, 4)), STEEL),
        0.0,
        [],
        1.0,
    )
    for step in range(STEPS):
        worn = worn_facets(liner)
        centre = worn.corner.mean(axis=1)
        distance = np.hypot(centre[:, 0] - 0.5 * SIDE, centre[:, 1] - 0.5 * SIDE)
        depth = DEEP / STEPS * np.exp(-((distance / 0.06) ** 2))
        moved = advance(liner, depth)
        if moved.share < 1.0:
            raise RuntimeError(f"step {step} of the pocket was cut to {moved.share:g}")
        lost += float(depth @ worn.area)
        liner, least = moved.liner, min(least, moved.quality)
        if step % EVERY == EVERY - 1:
            new = remesh(liner, 0.02)
            told.append((volume_of(new.mesh) - volume_of(liner.mesh), change(liner, new)))
            liner = new
    return liner, lost, told, min(least, worst(liner.mesh))


def random_depth(liner: Liner) -> Liner:
    """The liner with a random depth of 0 to 10 mm on each facet."""
    return replace(liner, depth=0.01 * np.random.default_rng(7).random(len(liner.depth)))


def dome(cells: int) -> SolidMesh:
    """A plate whose worn face is a paraboloid, 30 mm higher in the middle than in the corners."""
    plate = block((0.0, 0.0, 0.0), (SIDE, SIDE, HEIGHT), (cells, cells, 1))
    half = 0.5 * SIDE

    def raised(x: np.ndarray) -> np.ndarray:
        rise = 0.03 * (1.0 - ((x[:, 0] - half) ** 2 + (x[:, 1] - half) ** 2) / (2.0 * half**2))
        return np.column_stack([x[:, :2], x[:, 2] * (1.0 + rise / HEIGHT)])

    return mapped(plate, raised)


def tangled() -> SolidMesh:
    """A plate with good facets and bad elements: its inner nodes pushed to the worn face."""
    plate = block((0.0, 0.0, 0.0), (SIDE, SIDE, HEIGHT), (16, 16, 3))

    def pushed(x: np.ndarray) -> np.ndarray:
        inner = (
            ((x[:, :2] > 1e-9) & (x[:, :2] < SIDE - 1e-9)).all(axis=1)
            & (x[:, 2] > 0.5 * HEIGHT)
            & (x[:, 2] < HEIGHT - 1e-9)
        )
        return np.column_stack([x[:, :2], np.where(inner, 0.999 * HEIGHT, x[:, 2])])

    return mapped(plate, pushed)
