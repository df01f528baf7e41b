"""Meshes made without a mesh generator: a box, a sheet, and what a smooth map bends them into."""

from collections.abc import Callable
from dataclasses import replace
from itertools import permutations
from typing import TypeVar

import numpy as np

from wearfem.errors import UserError
from wearfem.liner.mesh import WEAR, ShellMesh, SolidMesh

Mesh = TypeVar("Mesh", SolidMesh, ShellMesh)
Cut = tuple[tuple[int, ...], ...]  # the elements that fill one cell of a lattice, by the cell's corners

CUBE = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))  # as VTK
SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))


def _kuhn() -> Cut:
    """Six tetrahedra around the diagonal of a cube; their copies in the next cube meet them (Kuhn 1960)."""
    unit = np.eye(3, dtype=int)
    path = [np.cumsum([(0, 0, 0), *unit[list(order)]], axis=0) for order in permutations(range(3))]
    path = [p if np.linalg.det(np.diff(p, axis=0)) > 0 else p[[0, 2, 1, 3]] for p in path]
    return tuple(tuple(CUBE.index(tuple(int(x) for x in corner)) for corner in p) for p in path)


Hexahedra: Cut = (tuple(range(8)),)
"""One hexahedron a cell."""
Tetrahedra: Cut = _kuhn()
"""Six tetrahedra a cell."""
Rising: Cut = ((0, 1, 2), (0, 2, 3))
"""Two triangles a cell, cut along x = y."""
Falling: Cut = ((0, 1, 3), (1, 2, 3))
"""Two triangles a cell, cut along x = -y."""


def block(
    lower: tuple[float, float, float],
    upper: tuple[float, float, float],
    cells: tuple[int, int, int],
    kind: Cut = Tetrahedra,
    *,
    name: str = "block",
) -> SolidMesh:
    """A box from `lower` to `upper` [m] of `cells` along x, y and z, each filled by `kind`: `Tetrahedra` or `Hexahedra`.

    Node (i, j, k) of the lattice has the number (i (ny + 1) + j) (nz + 1) + k. Groups: `wear` (top), `bottom`, `rim` (the four sides),
    and the sides one by one: `x_low`, `x_high`, `y_low`, `y_high`.

    Raises
    ------
    UserError
        for a box without volume or without cells.
    """
    node, index, element = _lattice(lower, upper, cells, CUBE, kind, name)
    mesh = SolidMesh(node, element, name=name)
    side = _sides(index, cells, mesh.boundary)
    group = {WEAR: side.pop("z_high"), "bottom": side.pop("z_low"), "rim": np.concatenate([*side.values()])}
    return replace(mesh, group=group | side)


def sheet(
    lower: tuple[float, float],
    upper: tuple[float, float],
    cells: tuple[int, int],
    thickness: float,
    kind: Cut = Rising,
    *,
    offset: float = 0.0,
    name: str = "sheet",
) -> ShellMesh:
    """A flat shell in the plane z = 0, normal up, of `cells` along x and y, each two triangles: `Rising` or `Falling`.

    Node (i, j) of the lattice has the number i (ny + 1) + j. Groups: `wear` (all triangles), `rim` (all edges of the border), and the
    sides one by one: `x_low`, `x_high`, `y_low`, `y_high`, edges (k, 2) with the shell on their left.

    Raises
    ------
    UserError
        for a sheet without area or without cells.
    """
    flat, index, element = _lattice(lower, upper, cells, SQUARE, kind, name)
    node = np.column_stack([flat, np.zeros(len(flat))])
    every = np.concatenate([element[:, [0, 1]], element[:, [1, 2]], element[:, [2, 0]]])
    side = _sides(index, cells, every)
    group = {WEAR: element, "rim": np.concatenate([*side.values()])}
    full = np.ones(len(node))
    return ShellMesh(node, element, thickness * full, offset * full, group | side, name)


def mapped(mesh: Mesh, function: Callable[[np.ndarray], np.ndarray]) -> Mesh:
    """The mesh with its nodes moved by `function`, positions (n, 3) to positions (n, 3) [m]; elements and groups stay.

    A map that turns space inside out, such as a mirror, is refused with the inverted elements that it makes.
    """
    return replace(mesh, node=np.asarray(function(mesh.node), float))


def with_group(mesh: Mesh, name: str, inside: Callable[[np.ndarray], np.ndarray]) -> Mesh:
    """The mesh with one more group: facets of the boundary (of a shell: triangles) whose centres (k, 3) are `inside`, a mask (k,)."""
    facet = mesh.boundary if isinstance(mesh, SolidMesh) else mesh.element
    return replace(mesh, group={**mesh.group, name: facet[inside(mesh.node[facet].mean(axis=1))]})


def _lattice(
    lower: tuple[float, ...],
    upper: tuple[float, ...],
    cells: tuple[int, ...],
    corners: tuple[tuple[int, ...], ...],
    kind: Cut,
    name: str,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes (n, d), their place (n, d) in the lattice, and elements (e, k)."""
    if min(cells) < 1 or not all(low < high for low, high in zip(lower, upper, strict=True)):
        raise UserError(
            f"{name}: {cells} cells from {lower} to {upper} were given; each direction needs a cell and a length above 0 m."
        )
    shape = tuple(count + 1 for count in cells)
    index = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, len(cells))
    low, high, part = np.array(lower, float), np.array(upper, float), index / np.array(cells)
    cell = index[(index < cells).all(axis=1)]
    corner = cell[:, None, :] + np.array(corners)
    number = np.ravel_multi_index(tuple(np.moveaxis(corner, -1, 0)), shape)
    element = number[:, np.array(kind)].reshape(-1, len(kind[0]))
    return low + part * (high - low), index, element


def _sides(index: np.ndarray, cells: tuple[int, ...], facet: np.ndarray) -> dict[str, np.ndarray]:
    """The facets on each side of the lattice."""
    return {
        f"{axis}_{end}": facet[(index[facet][..., i] == place).all(axis=1)]
        for i, axis in enumerate("xyz"[: len(cells)])
        for end, place in (("low", 0), ("high", cells[i]))
    }
