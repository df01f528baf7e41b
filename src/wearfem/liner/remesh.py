"""A liner with worn-out elements gets a new mesh of the same body by gmsh, with its groups and fields carried over.

Solids become tetrahedra, whatever they were; shells become triangles. Two grades: `refill` keeps the skin, triangle by triangle, and
meshes the inside again; `remesh` meshes the skin too, each smooth patch of it laid flat, so that new nodes lie on the old triangles.
"""

from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from wearfem.edges import neighbours, parts
from wearfem.errors import UserError
from wearfem.liner.corners import SHARP
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import LinerMesh, ShellMesh, SolidMesh, find_facets, triangles
from wearfem.liner.mesher import gmsh_model
from wearfem.liner.patches import TURNED, Skin, skin
from wearfem.liner.quality import POOR, worst
from wearfem.liner.transfer import transfer, transfer_nodes
from wearfem.surface import Surface

POINT, LINE, TRIANGLE, TETRAHEDRON = 15, 1, 2, 4  # gmsh's numbers of element types


@dataclass(frozen=True)
class Change:
    """What a new mesh changed: of a perfect one, nothing but the quality."""

    volume: float  # [-] new over old volume of the solid, of a shell of its thickness over its area, less 1
    area: float  # [-] new over old area of the worn facets, less 1
    quality_before: float  # [-] of the worst element
    quality_after: float


def renew(liner: Liner, size: float, limit: float = POOR) -> Liner:
    """The liner itself while its worst element is no worse than `limit`; else refilled if that will do, else remeshed.

    Parameters
    ----------
    liner
        As it is now.
    size
        [m] edge length wanted.
    limit
        [-] least `quality` of an element.
    """
    if worst(liner.mesh) >= limit:
        return liner
    if isinstance(liner.mesh, SolidMesh):
        filled = refill(liner, size)
        if worst(filled.mesh) >= limit:
            return filled
    return remesh(liner, size)


def refill(liner: Liner, size: float) -> Liner:
    """The same skin, facet by facet, around new tetrahedra with edges up to `size` [m].

    Volume, depth and groups are kept as they are. A facet with four corners becomes two triangles with its depth.

    Raises
    ------
    UserError
        for a shell, which has no inside; for a size that is not positive; where gmsh is missing or fails.
    """
    mesh = liner.mesh
    if isinstance(mesh, ShellMesh):
        raise UserError(f"{mesh.name} is a shell, which has no inside to fill; use remesh.")
    boundary = skin(mesh)
    with _session(mesh.name, size) as gmsh:
        _send(gmsh, boundary, with_curves=False)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)
        _fill(gmsh, boundary, mesh.name)
        tag, node = _nodes(gmsh)
        element = _elements(gmsh, TETRAHEDRON)
    used = np.unique(boundary.triangle)
    order = np.concatenate(
        [used + 1, np.setdiff1d(element, used + 1)]
    )  # nodes of the skin first, in their old order
    number = np.full(int(max(tag.max(), len(mesh.node))) + 1, -1)
    number[order] = np.arange(len(order))
    place = np.full(len(number), -1)
    place[tag] = np.arange(len(tag))
    position = node[place[order]]
    position[: len(used)] = mesh.node[used]
    group = {name: number[triangles(rows)[0] + 1] for name, rows in mesh.group.items()}
    new = SolidMesh(position, _positive(position, number[element]), group, mesh.name)
    _check_skin(new, number[boundary.triangle + 1])
    return replace(liner, mesh=new, depth=liner.depth[triangles(mesh.wear)[1]])


def remesh(liner: Liner, size: float, sharp: float = SHARP) -> Liner:
    """The same body with a new skin and a new inside, with edges of about `size` [m].

    Sharp edges, corners, and the borders of groups stay; plane sides stay plane. New nodes lie on the old triangles, so that only where the
    skin is curved the volume changes, by the square of `size`: see `change`. Depth goes over by `transfer`, the thickness and
    offset of a shell by `transfer_nodes`; other facet fields by `carry`. Facets get new numbers.

    Parameters
    ----------
    liner
        As it is now.
    size
        [m] edge length wanted.
    sharp
        [rad] Edges and corners that turn by more are kept.

    Raises
    ------
    UserError
        for a size that is not positive; for groups inside the body; where gmsh is missing or fails.

    Notes
    -----
    Source: Remacle, Geuzaine, Compere and Marchandise, Int. J. Numer. Meth. Eng. 83 (2010) 403 (surface meshes laid flat patch by patch).
    Valid for: a skin that is closed and touches itself nowhere. An edge that is sharp along a part of its way only, and so parts no patch
    from another, is not kept.
    """
    mesh = liner.mesh
    old = skin(mesh, sharp)
    with _session(mesh.name, size) as gmsh:
        _send(gmsh, old, with_curves=True)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size)
        if isinstance(mesh, SolidMesh):
            _fill(gmsh, old, mesh.name)
        else:
            _generate(gmsh, mesh.name, 2)
        tag, node = _nodes(gmsh)
        area = [_elements(gmsh, TRIANGLE, 1 + p) for p in range(old.patch.max() + 1)]
        line = [_elements(gmsh, LINE, 1 + c) for c in range(len(old.curve))]
        element = _elements(gmsh, TETRAHEDRON) if isinstance(mesh, SolidMesh) else np.concatenate(area)
    used = np.unique(element)
    number = np.full(int(tag.max()) + 1, -1)
    number[used] = np.arange(len(used))
    place = np.full(len(number), -1)
    place[tag] = np.arange(len(tag))
    node = node[place[used]]
    if isinstance(mesh, SolidMesh):
        new: LinerMesh = _solid(mesh, old, node, number[element], [number[rows] for rows in area])
    else:
        new = _shell(mesh, old, node, [number[rows] for rows in area], [number[rows] for rows in line])
    after = replace(liner, mesh=new, depth=np.zeros(0))
    return replace(after, depth=carry(liner.depth, liner, after))


def carry(field: np.ndarray, before: Liner, after: Liner) -> np.ndarray:
    """A facet field (f,) or (b, f) of the liner before `remesh`, `refill` or `renew` as one on the facets after it.

    On a skin that was kept it stays as it is; on a new one see `transfer` for what is kept. Of a shell, areas are those of its
    reference surface.
    """
    field = np.asarray(field, float)
    facet, owner = triangles(before.mesh.wear)
    there = after.mesh.wear
    if there.shape == facet.shape and np.array_equal(before.mesh.node[facet], after.mesh.node[there]):
        return field[..., owner]
    return transfer(field, worn_facets(before), worn_facets(after))


def worn_facets(liner: Liner) -> Surface:
    """The worn facets between the nodes of the mesh; of a shell, those of its reference surface."""
    corner, facet = triangles(liner.mesh.wear)
    used, triangle = np.unique(corner, return_inverse=True)
    return Surface(
        liner.mesh.node[used],
        triangle.reshape(-1, 3),
        liner.material,
        facet,
        f"{liner.mesh.name}, worn facets",
    )


def change(before: Liner, after: Liner) -> Change:
    """What a new mesh changed."""
    return Change(
        volume_of(after.mesh) / volume_of(before.mesh) - 1.0,
        float(worn_facets(after).area.sum() / worn_facets(before).area.sum()) - 1.0,
        worst(before.mesh),
        worst(after.mesh),
    )


def volume_of(mesh: LinerMesh) -> float:
    """[m3] of a solid; of a shell, its thickness over its reference surface"""
    if isinstance(mesh, SolidMesh):
        return mesh.volume
    a, b, c = np.moveaxis(mesh.node[mesh.element], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return float(area @ mesh.thickness[mesh.element].mean(axis=1))


def _solid(
    mesh: SolidMesh, old: Skin, node: np.ndarray, element: np.ndarray, area: list[np.ndarray]
) -> SolidMesh:
    """Groups are the outward facets of the patches that were in them."""
    new = SolidMesh(node, _positive(node, element), {}, mesh.name)
    boundary, rows = new.boundary, np.concatenate(area)
    patch = np.repeat(np.arange(len(area)), [len(one) for one in area])
    place = find_facets(rows, boundary)
    if len(rows) != len(boundary) or (place < 0).any():
        raise UserError(_failed(mesh.name, "its tetrahedra do not end at the skin"))
    owner = np.empty(len(boundary), int)
    owner[place] = patch
    group = {name: boundary[inside[owner]] for name, inside in old.patch_group.items()}
    return replace(new, group=group)


def _shell(
    mesh: ShellMesh, old: Skin, node: np.ndarray, area: list[np.ndarray], line: list[np.ndarray]
) -> ShellMesh:
    """Triangles turned as the old ones nearby; edges of the border with the shell on their left."""
    turned = [_turned_as(old, patch, node, rows) for patch, rows in enumerate(area)]
    element = np.concatenate(turned)
    every = np.concatenate([element[:, [0, 1]], element[:, [1, 2]], element[:, [2, 0]]])
    group = {
        name: np.concatenate([turned[p] for p in np.flatnonzero(inside)])
        for name, inside in old.patch_group.items()
    }
    for name, inside in old.curve_group.items():
        group[name] = every[find_facets(np.concatenate([line[c] for c in np.flatnonzero(inside)]), every)]
    thickness, offset = (
        transfer_nodes(field, mesh.node, mesh.element, node, element)
        for field in (mesh.thickness, mesh.offset)
    )
    return ShellMesh(node, element, thickness, offset, {name: group[name] for name in mesh.group}, mesh.name)


def _turned_as(old: Skin, patch: int, node: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """Triangles of one patch with their normals on the side of the old ones."""
    before = old.node[old.triangle[old.patch == patch]]
    after = node[triangle]
    nearest = cKDTree(before.mean(axis=1)).query(after.mean(axis=1))[1]
    was, is_now = (np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) for x in (before[nearest], after))
    return triangle[:, ::-1] if np.einsum("ti,ti->", was, is_now) < 0.0 else triangle


def _positive(node: np.ndarray, element: np.ndarray) -> np.ndarray:
    corner = node[element]
    inverted = np.linalg.det(corner[:, 1:] - corner[:, :1]) < 0.0
    return np.where(inverted[:, None], element[:, [0, 2, 1, 3]], element)


def _check_skin(mesh: SolidMesh, triangle: np.ndarray) -> None:
    boundary = mesh.boundary
    if len(boundary) != len(triangle) or (find_facets(triangle, boundary) < 0).any():
        raise UserError(_failed(mesh.name, "its tetrahedra do not end at the skin"))


def _failed(name: str, reason: str) -> str:
    return f"gmsh cannot mesh {name} again: {reason.strip().rstrip('.')}; try another size, or carry on with the mesh as it is."


# gmsh


def _session(name: str, size: float) -> AbstractContextManager[Any]:
    """gmsh for edges up to `size` [m]"""
    if not 0.0 < size < np.inf:
        raise UserError(
            f"The size {size!r} m was given to mesh {name} again; give the edge length wanted, above 0 m."
        )
    options = {
        "Mesh.MeshSizeFromPoints": 0,
        "Mesh.MeshSizeMin": 0,
        "Mesh.MeshSizeMax": size,
        "Mesh.Algorithm": 6,  # frontal Delaunay
        "Mesh.Algorithm3D": 10,  # HXT, which keeps the triangles of the skin and takes a seventh of the time of Delaunay with Netgen
        "Mesh.Renumber": 0,  # nodes of the skin keep their numbers
        "Mesh.Optimize": 1,
    }
    return gmsh_model(name, options)


def _send(gmsh: Any, old: Skin, with_curves: bool) -> None:
    """Patches, and with them curves and corners, as discrete entities numbered from 1; node n of the mesh has the tag n + 1."""
    model, patches = gmsh.model, range(old.patch.max() + 1)
    corners = np.unique(np.concatenate([[], *(curve.corner for curve in old.curve)])).astype(int)
    border: list[list[int]] = [[] for _ in patches]
    if with_curves:
        for number in range(len(corners)):
            model.addDiscreteEntity(0, 1 + number)
        for number, curve in enumerate(old.curve):
            ends = 1 + np.searchsorted(corners, curve.corner[[0, -1]])
            model.addDiscreteEntity(1, 1 + number, ends.tolist())
            for patch in curve.patch:
                border[patch].append(1 + number)
    for patch in patches:
        model.addDiscreteEntity(2, 1 + patch, border[patch])
    used = np.unique(old.triangle)
    model.mesh.addNodes(2, 1, used + 1, old.node[used].ravel())
    if with_curves:
        for number, corner in enumerate(corners):
            model.mesh.addElementsByType(1 + number, POINT, [], [corner + 1])
        for number, curve in enumerate(old.curve):
            model.mesh.addElementsByType(1 + number, LINE, [], curve.edge.ravel() + 1)
    for patch in patches:
        model.mesh.addElementsByType(1 + patch, TRIANGLE, [], old.triangle[old.patch == patch].ravel() + 1)
    model.mesh.reclassifyNodes()
    if with_curves:
        try:
            model.mesh.createGeometry()
        except Exception as error:  # what gmsh raises is a bare Exception
            raise UserError(_failed("the skin", str(error))) from error


def _fill(gmsh: Any, old: Skin, name: str) -> None:
    """Mesh the inside: of each body, or of one body with cavities."""
    body = parts(neighbours(old.node, old.triangle, TURNED))
    a, b, c = np.moveaxis(old.node[old.triangle], 1, 0)
    volume = np.bincount(body, np.einsum("ti,ti->t", a, np.cross(b, c)))
    outer, cavity = np.flatnonzero(volume > 0.0), np.flatnonzero(volume <= 0.0)
    if len(outer) != 1 and len(cavity):
        raise UserError(
            _failed(
                name,
                f"it has {len(outer)} bodies and {len(cavity)} cavities, and only one body may have cavities",
            )
        )
    geometry = gmsh.model.geo
    loop = [
        geometry.addSurfaceLoop((1 + np.unique(old.patch[body == one])).tolist()) for one in (*outer, *cavity)
    ]
    for volume_loops in [loop] if len(outer) == 1 else [[one] for one in loop]:
        geometry.addVolume(volume_loops)
    geometry.synchronize()
    _generate(gmsh, name, 3)


def _generate(gmsh: Any, name: str, dimension: int) -> None:
    try:
        gmsh.model.mesh.generate(dimension)
    except Exception as error:  # what gmsh raises is a bare Exception
        raise UserError(_failed(name, str(error))) from error


def _nodes(gmsh: Any) -> tuple[np.ndarray, np.ndarray]:
    """Tags (n,) and positions (n, 3) [m]"""
    tag, position, _ = gmsh.model.mesh.getNodes()
    return tag.astype(int), position.reshape(-1, 3)


def _elements(gmsh: Any, kind: int, entity: int = -1) -> np.ndarray:
    """(e, k) tags of the corners of all elements of a kind"""
    corners = {LINE: 2, TRIANGLE: 3, TETRAHEDRON: 4}[kind]
    return gmsh.model.mesh.getElementsByType(kind, entity)[1].astype(int).reshape(-1, corners)
