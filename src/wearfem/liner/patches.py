"""The skin of a liner in patches, curves and corners: what must stay where it is when the skin is meshed again."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from wearfem.edges import neighbours, parts
from wearfem.errors import UserError
from wearfem.liner.corners import SHARP
from wearfem.liner.mesh import LinerMesh, SolidMesh, find_facets, triangles

TURNED = np.pi  # no two triangles turn by more: asks for neighbours by number only


@dataclass(frozen=True)
class Curve:
    """A border of patches between two corners; or closed, with one corner at any node of it."""

    edge: np.ndarray  # (k, 2) nodes
    corner: np.ndarray  # (1,) or (2,) nodes
    patch: np.ndarray  # (1,) or (2,) the patches that meet here


@dataclass(frozen=True)
class Skin:
    """All triangles of a shell, or of the boundary of a solid, cut into patches.

    A patch is smooth, lies in the same groups throughout, and can be laid flat: it is a disk, with holes or without.
    """

    node: np.ndarray  # (n, 3) [m] of the mesh
    triangle: np.ndarray  # (t, 3) nodes; of a solid, normals outward
    patch: np.ndarray  # (t,)
    curve: tuple[Curve, ...]
    patch_group: dict[str, np.ndarray]  # (patches,) whether the patch lies in the group
    curve_group: dict[str, np.ndarray]  # (curves,) of a shell: whether the curve does


def skin(mesh: LinerMesh, sharp: float = SHARP) -> Skin:
    """Cut the skin of a mesh at sharp edges [rad] and at the borders of all groups.

    Raises
    ------
    UserError
        for a group with facets that are not on the boundary of the solid, or not triangles or edges of the shell.
    """
    facet = mesh.boundary if isinstance(mesh, SolidMesh) else mesh.element
    triangle, owner = triangles(facet)
    begin, end = triangle.ravel(), np.roll(triangle, -1, axis=1).ravel()
    every = np.stack([begin, end], axis=1)
    areas = {name: rows for name, rows in mesh.group.items() if rows.shape[1] > 2}
    lines = {name: rows for name, rows in mesh.group.items() if rows.shape[1] == 2}
    inside = np.stack(
        [np.zeros(len(facet), bool), *(_mask(mesh, n, r, facet) for n, r in areas.items())], axis=1
    )[owner]
    marked = np.stack(
        [np.zeros(len(every), bool), *(_mask(mesh, n, r, every) for n, r in lines.items())], axis=1
    )
    twin = neighbours(mesh.node, triangle, sharp)
    kept = marked.any(axis=1) | (np.repeat(inside, 3, axis=0) != inside[twin // 3]).any(axis=1)
    patch = _flat(mesh.node, triangle, parts(np.where(kept, -1, twin)))
    first = np.unique(patch, return_index=True)[1]
    curve, mark = _curves(mesh.node, triangle, patch, marked, sharp)
    return Skin(
        mesh.node,
        triangle,
        patch,
        curve,
        {name: inside[first, 1 + i] for i, name in enumerate(areas)},
        {name: mark[:, 1 + i] for i, name in enumerate(lines)},
    )


def _mask(mesh: LinerMesh, name: str, rows: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Which of `among` are in the group; edges are found in both directions."""
    place = find_facets(rows, among)
    if (place < 0).any():
        raise UserError(
            f"{mesh.name}: {(place < 0).sum()} of {len(place)} facets of the group '{name}' are not on the boundary of the mesh; "
            "groups of a mesh that is to be meshed again must be parts of its boundary."
        )
    if rows.shape[1] > 2:
        return np.isin(np.arange(len(among)), place)
    return find_facets(among, rows) >= 0


def _flat(node: np.ndarray, triangle: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """Patches halved across their longest extent until each can be laid flat."""
    whole = neighbours(node, triangle, TURNED)
    done, pending, count = (
        np.full(len(patch), -1),
        [np.flatnonzero(patch == p) for p in range(patch.max() + 1)],
        0,
    )
    while pending:
        member = pending.pop()
        if _is_flat(triangle, member, whole):
            done[member] = count
            count += 1
            continue
        centre = node[triangle[member]].mean(axis=1)
        along = np.linalg.svd(centre - centre.mean(axis=0), full_matrices=False)[2][0]
        place = centre @ along
        half = np.full(len(patch), -1)
        half[member] = place > np.median(place)
        if half[member].max() == half[member].min():
            half[member[0]] = 1 - half[member[0]]
        twin = np.where((whole >= 0) & (np.repeat(half, 3) == half[whole // 3]), whole, -1)
        label = parts(twin)[member]
        pending += [member[label == one] for one in np.unique(label)]
    return done


def _is_flat(triangle: np.ndarray, member: np.ndarray, twin: np.ndarray) -> bool:
    """Whether triangles make a disk, with holes or without: by its border and by Euler's formula."""
    edge = (3 * member[:, None] + np.arange(3)).ravel()
    beyond = twin[edge]
    border = edge[(beyond < 0) | ~np.isin(beyond // 3, member)]
    begin, end = triangle.ravel(), np.roll(triangle, -1, axis=1).ravel()
    nodes, start = np.unique(begin[border], return_inverse=True)
    if not len(border) or len(nodes) < len(border):  # closed, or touching itself in a node
        return False
    stop = np.searchsorted(nodes, end[border])
    loops = connected_components(coo_array((np.ones(len(start)), (start, stop)), shape=(len(nodes),) * 2))[0]
    corners = len(np.unique(triangle[member]))
    edges = (len(edge) + len(border)) // 2
    return corners - edges + len(member) == 2 - loops


def _curves(
    node: np.ndarray, triangle: np.ndarray, patch: np.ndarray, marked: np.ndarray, sharp: float
) -> tuple[tuple[Curve, ...], np.ndarray]:
    """The borders of patches as curves, and the marks (curves, g) of their edges. A curve ends where others meet it, where its
    patches or marks change, and where it turns by more than `sharp`."""
    twin = neighbours(node, triangle, TURNED)
    number = np.arange(len(twin))
    own, other = patch[number // 3], np.where(twin >= 0, patch[twin // 3], -1)
    edge = np.flatnonzero((own != other) & ((twin < 0) | (number < twin)))
    pair = np.stack([triangle.ravel(), np.roll(triangle, -1, axis=1).ravel()], axis=1)[edge]
    side = np.sort(np.stack([own, other], axis=1)[edge], axis=1)
    kind = np.unique(np.concatenate([side, marked[edge]], axis=1), axis=0, return_inverse=True)[1].ravel()

    order = np.argsort(pair.ravel(), kind="stable")
    corner, first, count = np.unique(pair.ravel()[order], return_index=True, return_counts=True)
    place = first[count == 2]
    p, q = order[place], order[place + 1]  # the two ends of edges that meet here
    here = corner[count == 2]
    before = node[here] - node[pair[p // 2, 1 - p % 2]]
    after = node[pair[q // 2, 1 - q % 2]] - node[here]
    turn = np.arctan2(np.linalg.norm(np.cross(before, after), axis=1), np.einsum("ei,ei->e", before, after))
    on = (kind[p // 2] == kind[q // 2]) & (turn < sharp)
    joined = coo_array((np.ones(on.sum()), (p[on] // 2, q[on] // 2)), shape=(len(edge),) * 2)
    label = connected_components(joined, directed=False)[1]
    is_corner = np.ones(len(node), bool)
    is_corner[here[on]] = False
    curve, mark = [], []
    for one in np.unique(label):
        rows = np.flatnonzero(label == one)
        nodes = np.unique(pair[rows])
        ends = nodes[is_corner[nodes]]
        patches = side[rows[0]]
        curve.append(Curve(pair[rows], ends if len(ends) else nodes[:1], patches[patches >= 0]))
        mark.append(marked[edge[rows[0]]])
    return tuple(curve), np.array(mark, bool).reshape(len(mark), marked.shape[1])
