"""The finite-element mesh of a liner: nodes, elements, and named groups of its boundary.

Geometry is straight: corner nodes only. Elements of higher order add their own degrees of freedom on top of it (`solid.py`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

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

    @cached_property
    def boundary(self) -> np.ndarray:
        """(k, 3) or (k, 4) corner nodes of all facets of one element only, normals outward"""
        sides = self.element[:, _SIDES[self.element.shape[1]]].reshape(
            -1, _SIDES[self.element.shape[1]].shape[1]
        )
        _, first, count = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
        return sides[np.sort(first[count == 1])]

    @property
    def wear(self) -> np.ndarray:
        """(f, 3) or (f, 4) corner nodes of the facets that wear"""
        return group_of(self, WEAR)

    @property
    def volume(self) -> float:
        """[m3] enclosed by the boundary, cut into triangles"""
        a, b, c = np.moveaxis(self.node[triangles(self.boundary)[0]], 1, 0)
        return float(np.einsum("ti,ti->", a, np.cross(b, c)) / 6.0)


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

    @property
    def wear(self) -> np.ndarray:
        """(f, 3) corner nodes of the triangles that wear"""
        return group_of(self, WEAR)


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
            f"{mesh.name} has no group '{name}'; it has {in_words(sorted(mesh.group))}. Name the group so in the mesh file."
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
