"""The finite-element mesh of a liner: nodes, elements, and named groups of its boundary.

Geometry is straight: corner nodes only. Elements of higher order add their own degrees of freedom on top of it (`solid.py`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import fsum

import numpy as np

from wearfem.errors import UserError, in_words

WEAR = "wear"  # the group of facets that particles touch


@dataclass(frozen=True)
class SolidMesh:
    """Tetrahedra or hexahedra that fill the liner.

    A group is a named part of the boundary: facets by their corner nodes, in the order that makes the normal point out of the solid.
    `wear` names the facets that wear; its order is the order of all fields (f,) by facet.
    """

    node: np.ndarray  # (n, 3) [m]
    element: np.ndarray  # (e, 4) tetrahedra or (e, 8) hexahedra, corner nodes in the order of VTK
    group: Mapping[str, np.ndarray] = field(default_factory=dict)  # name -> (k, 3) or (k, 4) corner nodes
    name: str = "liner"

    def __post_init__(self) -> None:
        _make_arrays(self, (4, 8), "(e, 4) tetrahedra or (e, 8) hexahedra")

    @cached_property
    def _sides(self) -> tuple[np.ndarray, np.ndarray]:
        """Facets (k, 3) or (k, 4) of the elements, each once, and the number (k,) of elements that they belong to"""
        side = _SIDES[self.element.shape[1]]
        facet = self.element[:, side].reshape(-1, side.shape[1])
        _, first, count = np.unique(np.sort(facet, axis=1), axis=0, return_index=True, return_counts=True)
        order = np.argsort(first)
        return facet[first[order]], count[order]

    @property
    def boundary(self) -> np.ndarray:
        """(k, 3) or (k, 4) corner nodes of all facets of one element only, normals outward"""
        facet, count = self._sides
        return facet[count == 1]

    @property
    def facet_use(self) -> np.ndarray:
        """(k,) number of elements at each facet: 1 on the boundary, 2 inside, more in a mesh that overlaps itself"""
        return self._sides[1]

    @property
    def wear(self) -> np.ndarray:
        """(f, 3) or (f, 4) corner nodes of the facets that wear"""
        return group_of(self, WEAR)

    @property
    def volume(self) -> float:
        """[m3] enclosed by the boundary; a facet with four corners is bilinear, which is the mean of both its cuts into triangles"""
        corner = self.node[self.boundary]
        corner = corner - corner.mean(axis=(0, 1))
        whole, halves = [(0, 1, 2)], [(0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3)]
        cuts, weight = (whole, 1.0) if corner.shape[1] == 3 else (halves, 0.5)
        parts = [weight * np.linalg.det(corner[:, cut]) for cut in cuts]
        return fsum(np.concatenate(parts)) / 6.0


@dataclass(frozen=True)
class ShellMesh:
    """Triangles of a reference surface, with the thickness of the shell at each node.

    The middle surface lies at node + offset x normal, the worn face at node + (offset + thickness / 2) x normal; the normal of a
    triangle follows from the order of its corners and points into the flow. Groups are triangles (k, 3) or edges (k, 2).
    """

    node: np.ndarray  # (n, 3) [m]
    element: np.ndarray  # (e, 3) corner nodes
    thickness: np.ndarray  # (n,) [m]
    offset: np.ndarray  # (n,) [m] of the middle surface from the nodes, along the normal
    group: Mapping[str, np.ndarray] = field(default_factory=dict)
    name: str = "liner"

    def __post_init__(self) -> None:
        _make_arrays(self, (3,), "(e, 3) triangles")
        for what in ("thickness", "offset"):
            object.__setattr__(self, what, np.ascontiguousarray(getattr(self, what), float))

    @property
    def wear(self) -> np.ndarray:
        """(f, 3) corner nodes of the triangles that wear"""
        return group_of(self, WEAR)

    @property
    def turned(self) -> "ShellMesh":
        """The same shell with its normals, and so its worn face, on the other side."""
        group = {name: facet[:, ::-1] for name, facet in self.group.items()}
        return replace(self, element=self.element[:, ::-1], offset=-self.offset, group=group)


LinerMesh = SolidMesh | ShellMesh

_SIDES = {  # corners of the facets of an element, outward normals: tetrahedron, hexahedron
    4: np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
    8: np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]),
}


def group_of(mesh: LinerMesh, name: str) -> np.ndarray:
    """Corner nodes of a group's facets or edges.

    Raises
    ------
    UserError
        for a name that the mesh does not have; the sentence names those that it has.
    """
    if name not in mesh.group:
        raise UserError(
            f"{mesh.name} has no group '{name}'; it has {in_words(sorted(mesh.group))}. Name the group so in the mesh file, or rename one."
        )
    return mesh.group[name]


def triangles(facet: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Facets (f, 3) or (f, 4) as triangles (t, 3), and the facet (t,) that each belongs to; four corners are cut from 0 to 2."""
    if facet.shape[1] == 3:
        return facet, np.arange(len(facet))
    return facet[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3), np.repeat(np.arange(len(facet)), 2)


def find_facets(facet: np.ndarray, among: np.ndarray) -> np.ndarray:
    """(k,) the row of `among` (m, c) that has the same corners as each `facet` (k, c), in whatever order; -1 where there is none."""
    _, number = np.unique(np.sort(np.concatenate([among, facet]), axis=1), axis=0, return_inverse=True)
    number = number.ravel()
    place = np.full(len(number), -1)
    place[number[: len(among)]] = np.arange(len(among))
    return place[number[len(among) :]]


def _make_arrays(mesh: LinerMesh, corners: tuple[int, ...], expected: str) -> None:
    """Store what was given as contiguous arrays; refuse numbers that name nothing."""
    node, element = np.ascontiguousarray(mesh.node, float), np.ascontiguousarray(mesh.element, np.int64)
    group = {name: np.ascontiguousarray(facet, np.int64) for name, facet in mesh.group.items()}
    for what, value in (("node", node), ("element", element), ("group", group)):
        object.__setattr__(mesh, what, value)
    if (
        node.ndim != 2
        or node.shape[1] != 3
        or element.ndim != 2
        or element.shape[1] not in corners
        or not len(element)
    ):
        raise UserError(
            f"{mesh.name}: nodes of shape {node.shape} and elements of shape {element.shape} were given; a mesh needs (n, 3) nodes "
            f"and {expected}."
        )
    if not np.isfinite(node).all():
        bad = int(np.argmin(np.isfinite(node).all(axis=1)))
        raise UserError(
            f"{mesh.name}: node {bad} is {node[bad].tolist()}; coordinates must be finite numbers in m."
        )
    for what, number in [
        ("elements", element),
        *((f"group '{name}'", facet) for name, facet in group.items()),
    ]:
        if number.size and (number.min() < 0 or number.max() >= len(node)):
            raise UserError(
                f"{mesh.name}: {what} name the nodes {number.min()} to {number.max()}; nodes are numbered 0 to {len(node) - 1}."
            )
