"""What is wrong with a mesh, in a sentence."""

import numpy as np

from wearfem.errors import UserError
from wearfem.liner.mesh import WEAR, LinerMesh, ShellMesh, SolidMesh, find_facets, group_of
from wearfem.liner.quality import determinant, quality

FLAT = 1e-6  # quality below which an element counts as one without volume


def check_mesh(mesh: LinerMesh) -> None:
    """Refuse a mesh that cannot be a liner.

    Raises
    ------
    UserError
        for nodes that belong to no element; elements that are flat, inverted or there twice; a solid whose boundary is not one
        closed surface with two facets at each edge; a shell with three triangles at an edge, with neighbours turned against each
        other, without thickness, or thicker than it is wide; a group with facets that do not lie on the boundary, look inwards,
        or are there twice; no group `wear`.
    """
    _check_nodes(mesh)
    _check_elements(mesh)
    if isinstance(mesh, SolidMesh):
        _check_solid(mesh)
    else:
        _check_shell(mesh)
    for name, facet in mesh.group.items():
        _check_group(mesh, name, facet)
    if not len(group_of(mesh, WEAR)):
        raise UserError(
            f"{mesh.name}: the group '{WEAR}' is empty; it must hold the facets that particles touch."
        )


def _check_nodes(mesh: LinerMesh) -> None:
    used = np.zeros(len(mesh.node), bool)
    used[mesh.element] = True
    if not used.all():
        raise UserError(
            f"{mesh.name}: {(~used).sum()} of {len(used)} nodes belong to no element, the first is {int(np.argmin(used))}; "
            "remove them."
        )


def _check_elements(mesh: LinerMesh) -> None:
    flat = quality(mesh) < FLAT
    if isinstance(mesh, SolidMesh) and flat.any():
        inverted = flat & (determinant(mesh).min(axis=1) < 0.0)
        if inverted.any():
            raise UserError(
                f"{mesh.name}: {inverted.sum()} of {len(flat)} elements are inverted, the first is {_place(mesh, inverted)}; "
                "corners must be in the order of VTK, with a positive volume."
            )
    if flat.any():
        raise UserError(
            f"{mesh.name}: {flat.sum()} of {len(flat)} elements have no {'volume' if isinstance(mesh, SolidMesh) else 'area'} "
            f"(quality below {FLAT:g}), the first is {_place(mesh, flat)}; mesh that place again."
        )
    _, first, count = np.unique(np.sort(mesh.element, axis=1), axis=0, return_index=True, return_counts=True)
    if (count > 1).any():
        raise UserError(
            f"{mesh.name}: {(count > 1).sum()} elements are there twice, the first is number {first[count > 1].min()}; "
            "remove the copies."
        )


def _place(mesh: LinerMesh, bad: np.ndarray) -> str:
    number = int(np.argmax(bad))
    x, y, z = mesh.node[mesh.element[number]].mean(axis=0)
    return f"number {number} at ({x:.4g}, {y:.4g}, {z:.4g}) m"


def _check_solid(mesh: SolidMesh) -> None:
    most = int(mesh.facet_use.max())
    if most > 2:
        raise UserError(
            f"{mesh.name}: up to {most} elements share one facet; elements overlap, so make the mesh without copies."
        )
    edge = _edges(mesh.boundary)
    _check_directed(mesh, edge, "facets of the boundary")
    _, count = np.unique(np.sort(edge, axis=1), axis=0, return_counts=True)
    if (count % 2).any():
        raise UserError(
            f"{mesh.name}: the boundary is open at {(count % 2).sum()} edges; elements must meet in whole facets."
        )


def _check_shell(mesh: ShellMesh) -> None:
    for what, value in (("thickness", mesh.thickness), ("offset", mesh.offset)):
        if value.shape != (len(mesh.node),) or not np.isfinite(value).all():
            raise UserError(
                f"{mesh.name}: the {what} has shape {value.shape}; one finite number in m is needed for each of "
                f"{len(mesh.node)} nodes."
            )
    thin = mesh.thickness <= 0.0
    if thin.any():
        node = int(np.argmax(thin))
        raise UserError(
            f"{mesh.name}: the thickness is {mesh.thickness[node]:g} m at node {node}, and not above 0 at {thin.sum()} of "
            f"{len(thin)} nodes; give the plate's thickness in m."
        )
    thick, wide = float(mesh.thickness.max()), float(np.linalg.norm(np.ptp(mesh.node, axis=0)))
    if thick > wide:
        raise UserError(
            f"{mesh.name}: the thickness is {thick:g} m, but the whole shell is {wide:.4g} m wide, so it is probably given in mm; give it "
            f"in m, as {thick:g} * mm."
        )
    _check_directed(mesh, _edges(mesh.element), "triangles")


def _check_directed(mesh: LinerMesh, edge: np.ndarray, what: str) -> None:
    """Each edge belongs to two facets at most, which run through it in opposite directions."""
    pair, count = np.unique(np.sort(edge, axis=1), axis=0, return_counts=True)
    if (count > 2).any():
        x, y, z = mesh.node[pair[count > 2][0]].mean(axis=0)
        raise UserError(
            f"{mesh.name}: {(count > 2).sum()} edges belong to more than two {what}, the first at ({x:.4g}, {y:.4g}, {z:.4g}) m; "
            "such a surface has no inside: join the parts along a face, or give them as liners of their own."
        )
    pair, count = np.unique(edge, axis=0, return_counts=True)
    if (count > 1).any():
        x, y, z = mesh.node[pair[count > 1][0]].mean(axis=0)
        raise UserError(
            f"{mesh.name}: {(count > 1).sum()} edges are run through twice in the same direction, first at "
            f"({x:.4g}, {y:.4g}, {z:.4g}) m; neighbours must be oriented alike, with normals into the flow (flip the turned ones)."
        )


def _edges(facet: np.ndarray) -> np.ndarray:
    """(k, 2) directed edges of facets (f, c)"""
    return np.stack([facet, np.roll(facet, -1, axis=1)], axis=2).reshape(-1, 2)


def _check_group(mesh: LinerMesh, name: str, facet: np.ndarray) -> None:
    solid = isinstance(mesh, SolidMesh)
    if isinstance(mesh, SolidMesh):
        among = mesh.boundary
    else:
        among = mesh.element if facet.shape[1] == 3 else _edges(mesh.element)
    what = "facets" if solid else "triangles" if facet.shape[1] == 3 else "edges"
    where = "the boundary of the solid" if solid else "the shell"
    found = find_facets(facet, among) if facet.shape[1] == among.shape[1] else np.full(len(facet), -1)
    if (found < 0).any():
        raise UserError(
            f"{mesh.name}: {(found < 0).sum()} of {len(facet)} {what} of the group '{name}' are no {what} of {where}, the first has "
            f"the nodes {facet[np.argmax(found < 0)].tolist()}; a group names parts of {where}."
        )
    if len(np.unique(found)) < len(found):
        raise UserError(
            f"{mesh.name}: {len(found) - len(np.unique(found))} {what} of the group '{name}' are there twice; name each once."
        )
    if facet.shape[1] > 2:
        turned = (_rolled(facet) != _rolled(among[found])).any(axis=1)
        if turned.any():
            raise UserError(
                f"{mesh.name}: {turned.sum()} of {len(facet)} {what} of the group '{name}' are turned against {where}, the first has "
                f"the nodes {facet[np.argmax(turned)].tolist()}; normals must point {'out of it' if solid else 'as its own'}."
            )


def _rolled(facet: np.ndarray) -> np.ndarray:
    """The same corners in the same sense, the lowest number first"""
    start = facet.argmin(axis=1)[:, None]
    return np.take_along_axis(facet, (start + np.arange(facet.shape[1])) % facet.shape[1], axis=1)
