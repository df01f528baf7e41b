"""Recession: the worn face moves by a depth field and the liner loses exactly that volume."""

from dataclasses import dataclass, replace

import numpy as np

from wearfem.errors import UserError
from wearfem.liner.breakthrough import Breakthrough, breakthrough
from wearfem.liner.corners import SHARP, facet_area, find_corners, unworn
from wearfem.liner.liner import Liner, node_normal, worn_face
from wearfem.liner.mesh import LinerMesh, ShellMesh, SolidMesh
from wearfem.liner.motion import follow
from wearfem.liner.offset import Offset, offset, swept_by_corner
from wearfem.liner.quality import POOR, determinant, quality

STEPS_OF_BISECTION = 12  # the share offered is right to 1 / 4096


@dataclass(frozen=True)
class Recession:
    """How far a liner could recede by the depth asked for, and what stopped it."""

    liner: Liner
    share: float  # [-] of the depth asked for that was taken; 1 if nothing stopped it
    breakthrough: Breakthrough | None  # where the liner wore through, if that stopped it
    quality: float  # [-] of the worst element
    remesh_needed: bool  # quality below the limit, or elements that would have turned over


class StepTooLong(UserError):
    """A depth that the mesh cannot take in one step; `share` of it is the most that it can."""

    def __init__(self, sentence: str, share: float) -> None:
        super().__init__(sentence)
        self.share = share


def recede(
    liner: Liner,
    depth: np.ndarray,
    *,
    service_time: float = 0.0,
    throughput: float = 0.0,
    sharp: float = SHARP,
) -> Liner:
    """The liner after its worn face has lost `depth`.

    The volume removed is the sum of depth x facet area on the old geometry, to 1e-10 and better: that is what a wear law
    gives, volume by facet. A body of radius r that is worn by w from outside so shrinks to sqrt(r^2 - 2 r w) (cylinder) or
    (r^3 - 3 r^2 w)^(1/3) (sphere), which is r - w but for w^2 / 2r and w^2 / r.

    Parameters
    ----------
    liner
        As it is; it is not changed.
    depth
        (f,) [m] to wear off each facet of `liner.mesh.wear`, along its normal, 0 or more.
    service_time, throughput
        [s] and [kg] that this took, added to the liner's.
    sharp
        [rad] an edge that turns by more stays sharp: both its sides recede by their own depth. pi: all edges are worn round.

    Raises
    ------
    UserError
        for a depth of the wrong length, negative or not finite.
    StepTooLong
        for a depth that would turn elements over or wear through the liner; its `share` is what the mesh can take.

    Source
    ------
    `to_corners`, `offset`, `follow` name theirs.

    Valid for
    ---------
    steps shorter than the facets; a shell, whose thickness has one value a node, has no sharp edges.
    """
    _require(liner, depth)
    reached = _try(liner, depth, 1.0, sharp)
    event = breakthrough(liner.mesh, depth)
    if reached is None or event is not None:
        share = advance(liner, depth, sharp=sharp).share
        cause = f"wears through facet {event.facet}" if event else "would turn elements over"
        raise StepTooLong(
            f"{liner.mesh.name}: a depth of up to {1e3 * depth.max():.4g} mm in one step {cause}; take {share:.4g} of it, then remesh, "
            "open the surface, or go on with the rest.",
            share,
        )
    return _worn(liner, reached, depth, 1.0, service_time, throughput)


def advance(
    liner: Liner,
    depth: np.ndarray,
    *,
    service_time: float = 0.0,
    throughput: float = 0.0,
    sharp: float = SHARP,
    poor: float = POOR,
) -> Recession:
    """Recede by as much of `depth` as the mesh can take, up to the first place where the liner wears through.

    Parameters are those of `recede`; `poor` is the quality [-] of the worst element below which `remesh_needed` is told. Depth,
    service time and throughput are taken by the `share` that the result names.
    """
    _require(liner, depth)
    event = breakthrough(liner.mesh, depth)
    share = event.share if event else 1.0
    reached = _try(liner, depth, share, sharp)
    turned = reached is None
    if reached is None:
        low, high, reached, event = 0.0, share, liner.mesh, None
        for _ in range(STEPS_OF_BISECTION):
            middle = 0.5 * (low + high)
            mesh = _try(liner, depth, middle, sharp)
            if mesh is None:
                high = middle
            else:
                low, reached = middle, mesh
        share = low
    worst = float(quality(reached).min())
    new = _worn(liner, reached, depth, share, service_time, throughput)
    return Recession(new, share, event, worst, turned or worst < poor)


def _require(liner: Liner, depth: np.ndarray) -> None:
    """Refuse a depth that is none."""
    count, name = len(liner.mesh.wear), liner.mesh.name
    depth = np.asarray(depth)
    if depth.shape != (count,):
        raise UserError(
            f"{name}: a depth of shape {depth.shape} was given, but the group 'wear' has {count} facets; "
            "give one depth for each, in its order."
        )
    bad = np.flatnonzero(~np.isfinite(depth) | (depth < 0.0))
    if len(bad):
        raise UserError(
            f"{name}: the depth of facet {bad[0]} is {depth[bad[0]]:g} m ({len(bad)} of {count} are like that); a depth must be a finite "
            "number, 0 or more."
        )


def _try(liner: Liner, depth: np.ndarray, share: float, sharp: float) -> LinerMesh | None:
    """The mesh after `share` of the depth; None where elements would turn over."""
    mesh = liner.mesh
    if isinstance(mesh, ShellMesh):
        return _thin(mesh, share * depth)
    try:
        corners = find_corners(mesh.node, mesh.wear, unworn(mesh), sharp)
        straight = offset(corners, mesh.node, share * depth)
        motion = follow(mesh, straight.displacement, straight.moved, _held(straight))
        slide = _limited(motion - straight.displacement, straight)
        final = offset(corners, mesh.node, share * depth, slide=slide)
        motion = np.where(final.moved[:, None], final.displacement, motion)
    except UserError:
        if share < 1.0 / 2**STEPS_OF_BISECTION:
            raise
        return None
    node = mesh.node + motion
    new = with_nodes(mesh, node)
    return new if float(determinant(new).min()) > 0.0 else None


def _held(straight: Offset) -> np.ndarray:
    """What holds the worn nodes: the faces that they offset; a node that does not recede does not slide either."""
    hold = straight.hold.copy()
    recedes = np.linalg.norm(straight.displacement, axis=1)
    hold[recedes <= 1e-9 * recedes.max()] = np.eye(3)
    return hold


def _limited(slide: np.ndarray, straight: Offset) -> np.ndarray:
    """A node of the worn face slides no further than it recedes."""
    most = np.linalg.norm(straight.displacement, axis=1)
    size = np.linalg.norm(slide, axis=1)
    part = np.minimum(1.0, np.divide(most, size, out=np.ones(len(size)), where=size > 0.0))
    return np.where(straight.moved[:, None], part[:, None] * slide, slide)


def _thin(mesh: ShellMesh, depth: np.ndarray) -> ShellMesh | None:
    """A shell after its worn face has lost `depth`: the thickness loses w, and the middle surface sinks by w / 2."""
    key = np.sort(np.concatenate([mesh.wear, mesh.element]), axis=1)
    number = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    other = mesh.element[~np.isin(number[len(mesh.wear) :], number[: len(mesh.wear)])]
    face = worn_face(mesh)
    corners = find_corners(face, mesh.wear, other, whole=True)
    w = offset(corners, face, depth, direction=node_normal(mesh)).depth
    thickness = mesh.thickness - w
    return (
        replace(mesh, thickness=thickness, offset=mesh.offset - 0.5 * w) if (thickness >= 0.0).all() else None
    )


def _worn(
    liner: Liner, mesh: LinerMesh, depth: np.ndarray, share: float, service_time: float, throughput: float
) -> Liner:
    return replace(
        liner,
        mesh=mesh,
        depth=liner.depth + share * depth,
        service_time=liner.service_time + share * service_time,
        throughput=liner.throughput + share * throughput,
    )


def with_nodes(mesh: SolidMesh, node: np.ndarray) -> SolidMesh:
    """The same mesh with its nodes elsewhere; what follows from the elements alone is kept."""
    new = replace(mesh, node=node)
    new.__dict__["boundary"] = mesh.boundary
    return new


def volume(mesh: LinerMesh) -> float:
    """[m3] of the liner: of a solid with bilinear facets, of a shell between its back and its worn face.

    By the volume that a closed surface sweeps when it shrinks to a point, so to rounding: all that `recede` takes away is missing here.
    """
    if isinstance(mesh, SolidMesh):
        return mesh.volume
    back = mesh.node + (mesh.offset - 0.5 * mesh.thickness)[:, None] * node_normal(mesh)
    face = worn_face(mesh)
    corners = find_corners(back, mesh.element, mesh.element[:0], whole=True)
    return float(-swept_by_corner(corners, back, face - back).sum())


def removed_volume(old: LinerMesh, depth: np.ndarray) -> float:
    """[m3] that `recede` removes by definition: the sum of depth x facet area of the worn face as it is"""
    node = worn_face(old) if isinstance(old, ShellMesh) else old.node
    return float(depth @ facet_area(node, old.wear))
