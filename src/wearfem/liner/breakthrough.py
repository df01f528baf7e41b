"""What is left of the liner under each facet, where it wears through first, and the hole that opens there."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from wearfem.liner.corners import facet_area, facet_vector
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import _SIDES, LinerMesh, ShellMesh, SolidMesh

NEAR = 0.9  # of the way from a facet's centre to its corners, where it is measured too
SIDE = np.cos(
    np.radians(75.0)
)  # of the angle between a line and the normal of the face that it leaves by: a side, not the back
THIN = 0.05  # of the mean length of the worn facets: what is left when the liner counts as worn through


@dataclass(frozen=True)
class Breakthrough:
    """The first place where a step wears through the liner."""

    place: np.ndarray  # (3,) [m] centre of the facet, before the step
    facet: int  # of `mesh.wear`
    share: float  # [-] of the step at which it happens


def thickness(mesh: LinerMesh) -> np.ndarray:
    """(f,) [m] what is left under each worn facet.

    Of a solid, the least distance from the facet's centre, and from points close to its corners, along its inward normal to where
    that line leaves the solid: from element to element, so time and memory go with the number of elements in a row. Lines that leave by a
    face next to the facet do not count, nor those that leave by a side, whose normal is more than 75 degrees off the line;
    infinity if all do. Of a shell, the least at the facet's nodes.
    """
    if isinstance(mesh, ShellMesh):
        return mesh.thickness[mesh.wear].min(axis=1)
    return _walk(mesh)[0]


def least_thickness(mesh: LinerMesh) -> float:
    """[m] at which the liner counts as worn through.

    Of a solid, `THIN` x the mean edge of its worn facets; of a shell, 1e-3 x its largest thickness.
    """
    if isinstance(mesh, ShellMesh):
        return 1e-3 * float(mesh.thickness.max())
    return THIN * float(np.sqrt(facet_area(mesh.node, mesh.wear)).mean())


def breakthrough(mesh: LinerMesh, depth: np.ndarray, least: float | None = None) -> Breakthrough | None:
    """Where a step of `depth` (f,) [m] first leaves `least` [m] or less (`least_thickness`), if it does."""
    least = least_thickness(mesh) if least is None else least
    spare = np.maximum(thickness(mesh) - least, 0.0)
    wears = depth > 0.0
    share = np.divide(spare, depth, out=np.full(len(depth), np.inf), where=wears)
    facet = int(np.argmin(share))
    if not share[facet] < 1.0:
        return None
    return Breakthrough(mesh.node[mesh.wear[facet]].mean(axis=0), facet, float(share[facet]))


@dataclass(frozen=True)
class Opening:
    """A liner with a hole, and which facets are left."""

    liner: Liner
    facet: np.ndarray  # (f,) number in the old `mesh.wear` of each facet that is left
    node: np.ndarray  # (n,) number in the old mesh of each node that is left
    lost: float  # [m3] taken away with the hole


def open_surface(liner: Liner, least: float | None = None, *, margin: float = 2.0) -> Opening:
    """Take away what is worn through: the facets with `margin` x `least` [m] or less under them, and the elements below.

    `least` is where a step is cut; with twice as much a facet cannot take another such step.

    Pieces that no longer hang on the rest (by a facet; of a shell, an edge) go too: the piece with the most elements stays, and any that
    has facets of `support` or of a bolt. The other groups lose the facets that have gone; the walls of the hole belong
    to no group but `opening`.
    """
    mesh = liner.mesh
    least = least_thickness(mesh) if least is None else least
    thin = thickness(mesh) <= margin * least
    keep = np.ones(len(mesh.element), bool)
    if isinstance(mesh, ShellMesh):
        keep[_numbers(mesh.element, mesh.wear[thin])] = False
    else:
        _, facet, element = _walk(mesh)
        keep[element[thin[facet]]] = False
    keep &= _hangs_on(mesh, keep)
    return _without(liner, keep)


def _hangs_on(mesh: LinerMesh, keep: np.ndarray) -> np.ndarray:
    """(e,) bool: elements that hang on the rest, or on what holds the liner."""
    count = len(mesh.element)
    if isinstance(mesh, ShellMesh):
        first, second, _ = _joints(mesh.element, np.array([[0, 1], [1, 2], [2, 0]]))
    else:
        first, second, _ = _joints(mesh.element, _SIDES[mesh.element.shape[1]])
    both = keep[first] & keep[second]
    joined = coo_array((np.ones(both.sum()), (first[both], second[both])), shape=(count, count))
    piece = connected_components(joined, directed=False)[1]
    held = [nodes for name, nodes in mesh.group.items() if name == "support" or name.startswith("bolt")]
    is_held = (
        np.isin(mesh.element, np.concatenate([n.ravel() for n in held]) if held else []).sum(axis=1) >= 2
    )
    stays = np.bincount(piece[keep & is_held], minlength=piece.max() + 1) > 0
    if keep.any():
        stays[np.bincount(piece[keep]).argmax()] = True
    return stays[piece]


def _without(liner: Liner, keep: np.ndarray) -> Opening:
    """The liner with only the elements that are kept."""
    mesh = liner.mesh
    node = np.unique(mesh.element[keep])
    number = np.full(len(mesh.node), -1)
    number[node] = np.arange(len(node))
    element = mesh.element[keep]
    lost = 0.0
    if isinstance(mesh, ShellMesh):
        edges = np.concatenate([element[:, side] for side in ([0, 1], [1, 2], [2, 0])])
        group = {}
        for name, facet in mesh.group.items():
            there = _among(facet, element if facet.shape[1] == 3 else edges)
            group[name] = number[facet[there]]
        wear_left = _among(mesh.wear, element)
        new: LinerMesh = replace(
            mesh,
            node=mesh.node[node],
            element=number[element],
            thickness=mesh.thickness[node],
            offset=mesh.offset[node],
            group=group,
        )
    else:
        boundary = SolidMesh(mesh.node, element).boundary
        group = {name: number[facet[_among(facet, boundary)]] for name, facet in mesh.group.items()}
        wear_left = _among(mesh.wear, boundary)
        fresh = boundary[~_among(boundary, mesh.boundary)]
        group["opening"] = np.concatenate(
            [group.get("opening", np.zeros((0, fresh.shape[1]), int)), number[fresh]]
        )
        new = replace(mesh, node=mesh.node[node], element=number[element], group=group)
        lost = SolidMesh(mesh.node, mesh.element[~keep]).volume if (~keep).any() else 0.0
    return Opening(
        replace(liner, mesh=new, depth=liner.depth[wear_left]), np.flatnonzero(wear_left), node, lost
    )


def _among(facet: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(k,) bool: which facets, by their nodes in any order, are among the others."""
    every = np.sort(np.concatenate([facet, others]), axis=1)
    number = np.unique(every, axis=0, return_inverse=True)[1].ravel()
    return np.isin(number[: len(facet)], number[len(facet) :])


def _numbers(element: np.ndarray, facet: np.ndarray) -> np.ndarray:
    """(k,) the element that has exactly the nodes of each facet."""
    every = np.sort(np.concatenate([element, facet]), axis=1)
    number = np.unique(every, axis=0, return_inverse=True)[1].ravel()
    place = np.zeros(number.max() + 1, int)
    place[number[: len(element)]] = np.arange(len(element))
    return place[number[len(element) :]]


def _joints(element: np.ndarray, side: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Elements on both sides of each inner side, and for each element's side (e, s) the element beyond, -1 outside."""
    count, sides = len(element), len(side)
    key = np.sort(element[:, side].reshape(count * sides, -1), axis=1)
    order = np.lexsort(key.T)
    same = (key[order[1:]] == key[order[:-1]]).all(axis=1)
    p, q = order[:-1][same], order[1:][same]
    beyond = np.full(count * sides, -1)
    beyond[p], beyond[q] = q // sides, p // sides
    return p // sides, q // sides, beyond.reshape(count, sides)


def _walk(mesh: SolidMesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lines from the worn facets through the solid: their lengths (f,) [m], and pairs of facet and element passed."""
    side = _SIDES[mesh.element.shape[1]]
    _, _, beyond = _joints(mesh.element, side)
    worn = mesh.wear
    vector = facet_vector(mesh.node, worn)
    way = -vector / np.linalg.norm(vector, axis=1, keepdims=True)
    corner = mesh.node[worn]
    centre = corner.mean(axis=1)
    near = centre[:, None] + NEAR * (corner - centre[:, None])
    start = np.concatenate([centre[:, None], near], axis=1).reshape(-1, 3)
    lines = worn.shape[1] + 1  # of each facet
    way = np.repeat(way, lines, axis=0)
    outer = np.argwhere(beyond < 0)
    place = _numbers(mesh.element[outer[:, :1], side[outer[:, 1]]], worn)
    element, ray = np.repeat(outer[place, 0], lines), np.arange(len(start))
    length = np.zeros(len(start))
    facets, elements = [ray], [element]
    for _ in range(len(mesh.element)):
        corner = mesh.element[element][:, side].reshape(-1, side.shape[1])
        normal = facet_vector(mesh.node, corner).reshape(len(element), len(side), 3)
        centre = mesh.node[corner].mean(axis=1).reshape(len(element), len(side), 3)
        towards = (normal * way[ray, None]).sum(axis=2)
        ahead = ((centre - start[ray, None]) * normal).sum(axis=2)
        out = towards > 1e-9 * np.linalg.norm(normal, axis=2)
        distance = np.divide(ahead, towards, out=np.full(towards.shape, np.inf), where=out)
        leaves = distance.argmin(axis=1)
        length[ray] = np.maximum(length[ray], distance[np.arange(len(ray)), leaves])
        outside = beyond[element, leaves] < 0
        last = mesh.element[element[outside][:, None], side[leaves[outside]]]
        own = worn[ray[outside] // lines]
        beside = (last[:, :, None] == own[:, None, :]).any(axis=(1, 2))
        steep = np.divide(towards, np.linalg.norm(normal, axis=2))[np.arange(len(ray)), leaves][outside]
        length[ray[outside][beside | (steep < SIDE)]] = np.inf  # out by a side: not through
        element = beyond[element, leaves]
        ray, element = ray[element >= 0], element[element >= 0]
        if not len(ray):
            break
        facets.append(ray)
        elements.append(element)
    return length.reshape(-1, lines).min(axis=1), np.concatenate(facets) // lines, np.concatenate(elements)
