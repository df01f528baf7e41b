"""Smoothing of a facet field over a surface with a length in metres, so that maps converge when the mesh is refined.

The filter solves  w - l^2 Lap w = depth  on the triangulated surface, with natural borders (no flux). Linear triangles on the
unknowns at the corners, lumped mass, and a stiffness whose couplings are never attractive, so that what goes in positive comes
out positive on any triangulation: see `couplings`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import SuperLU, splu

from wearfem.edges import neighbours, parts
from wearfem.errors import UserError
from wearfem.surface import Surface
from wearfem.units import degree

ROUNDING = 1e-10  # [rad] by which two angles may pass pi together before their edge is flipped


@dataclass(frozen=True)
class HelmholtzFilter:
    """Smooth facet fields of one surface; factorised at the first call, then one solve a field.

    A wave of wave number k is damped to 1 / (1 + l^2 k^2), a point becomes K0(r / l) / (2 pi l^2). Along each axis that has the
    variance 2 l^2: as a blur it is as wide as a Gaussian of standard deviation sqrt(2) l, with a sharper tip and a longer tail.

    What is kept: the volume (sum of field x area) of each smooth part, to rounding; constants, to rounding; the sign, exactly:
    values never leave the range of those that came in by more than rounding. Nothing crosses a border of the surface or a
    sharp edge. The filter is symmetric: weighted by area, what facet f hands to g is what g hands to f.

    Parameters
    ----------
    surface
        Where the fields live; several triangles may belong to a facet, and share its value.
    length
        l [m]. Below an edge length the corners still share out a facet's value among its neighbours: the filter then is a mean
        over the facets around, not nothing.
    sharp
        [rad] Edges whose two triangles have normals further apart than this are borders.

    Raises
    ------
    UserError
        for a length that is not a positive number.

    Notes
    -----
    Source: Lazarov and Sigmund, Int. J. Numer. Meth. Eng. 86 (2011) 765, eq. 5 for the filter (their r is 2 sqrt(3) l).
    Valid for: surfaces whose sharp edges are edges of the mesh; the error falls with the square of the edge length for smooth
    fields. A finite number of *points* still has a peak at each of them that grows with ln(l / edge): the mean over any fixed area
    converges, the value at the very place of an impact does not.
    """

    surface: Surface
    length: float
    sharp: float = 30.0 * degree

    def __post_init__(self) -> None:
        if not 0.0 < self.length < np.inf:
            raise UserError(
                f"The smoothing length is {self.length!r} m; give a length above 0 m, about two edges of the mesh or more."
            )

    def __call__(self, field: np.ndarray) -> np.ndarray:
        """The field smoothed.

        Parameters
        ----------
        field
            (f,) or (b, f), one value a facet, in any unit: depth [m] or depth rate [m/s].

        Returns
        -------
        numpy.ndarray
            Same shape and unit. Facets without a triangle keep their value.

        Raises
        ------
        UserError
            for a field of another length than the facets, or with values that are not finite.
        """
        field = np.asarray(field, float)
        area = self.surface.facet_area
        if field.ndim not in (1, 2) or field.shape[-1] != len(area):
            raise UserError(
                f"A field of shape {field.shape} was given to smooth; {self.surface.name} has {len(area)} facets: (f,) or (b, f)."
            )
        if not np.isfinite(field).all():
            raise UserError(
                f"{int((~np.isfinite(field)).sum())} of {field.size} values to smooth on {self.surface.name} are not finite numbers."
            )
        load = self._share @ field.T
        node = self._factor.solve(load)
        lack = self._by_part @ (load - (self._mass * node.T).T)
        held = self._by_part @ (self._mass * np.abs(node).T).T
        part = np.divide(lack, held, out=np.zeros_like(lack), where=held > 0.0)  # of rounding
        node += np.abs(node) * (self._by_part.T @ part)
        smooth = (self._share.T @ node).T / np.where(area > 0.0, area, 1.0)
        return np.where(area > 0.0, smooth, field)

    @cached_property
    def node(self) -> np.ndarray:
        """(t, 3) unknown at each corner; corners of triangles that meet in a smooth edge share theirs"""
        twin = neighbours(self.surface.point, self.surface.triangle, self.sharp)
        inner = np.flatnonzero(twin >= 0)
        graph = coo_array(
            (np.ones(len(inner), bool), (inner, _next(twin[inner]))), shape=(len(twin), len(twin))
        )
        return connected_components(graph, directed=False)[1].reshape(-1, 3)

    @cached_property
    def part(self) -> np.ndarray:
        """(t,) smooth part that each triangle belongs to: the field's volume in each is kept"""
        return parts(neighbours(self.surface.point, self.surface.triangle, self.sharp))

    @cached_property
    def _share(self) -> csr_array:
        """(n, f) [m2] area that unknown n has of facet f: a third of each triangle that they share"""
        corner = self.node.ravel()
        area = np.repeat(self.surface.area / 3.0, 3)
        shape = (int(corner.max()) + 1, self.surface.facet_count)
        return coo_array((area, (corner, np.repeat(self.surface.facet, 3))), shape=shape).tocsr()

    @cached_property
    def _mass(self) -> np.ndarray:
        """(n,) [m2] area of each unknown"""
        return np.asarray(self._share.sum(axis=1)).ravel()

    @cached_property
    def _by_part(self) -> csr_array:
        """(parts, n) 1 where an unknown belongs to a smooth part. Where a length is 10 000 edges and more, the solver's rounding is felt in
        the volume (1e-16 l^2 / h^2): it is taken out, part by part."""
        node, part = self.node.ravel(), np.repeat(self.part, 3)
        first = np.unique(node, return_index=True)[1]
        shape = (int(part.max()) + 1, len(first))
        return coo_array((np.ones(len(first)), (part[first], np.arange(len(first)))), shape=shape).tocsr()

    @cached_property
    def _factor(self) -> SuperLU:
        """Of  M + l^2 K.  Pivots stay on the diagonal: then the factors of such a matrix have no sign but the right one
        (M-matrix; Berman and Plemmons 1994, ch. 6), and substitution only ever adds: not even rounding makes a negative value."""
        coupling = couplings(self.surface, self.node, self.sharp)
        stiffness = diags_array(np.asarray(coupling.sum(axis=1)).ravel()) - coupling
        matrix = diags_array(self._mass) + self.length**2 * stiffness
        return splu(matrix.tocsc(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def filter_over(surface: Surface, length: float) -> Callable[[np.ndarray], np.ndarray]:
    """The filter over a length [m]; for a length of 0 each facet stands for itself"""
    return HelmholtzFilter(surface, length) if length > 0.0 else np.asarray


def couplings(surface: Surface, node: np.ndarray, sharp: float) -> csr_array:
    """(n, n) [-] coupling of two unknowns, never negative: minus the off-diagonal of the stiffness of linear triangles.

    On an edge it is (cot a + cot b) / 2 with the angles a and b opposite to it, negative where a + b > pi. Therefore the triangles
    are those of the *intrinsic Delaunay triangulation*: edges with a + b > pi are exchanged for the other diagonal of their two
    triangles, unfolded into a plane, until there is none. The surface stays as it is, only straight lines on it are chosen anew,
    so that this is still linear finite elements on the same surface. A natural border is a mirror: the surface is glued to its image,
    where an obtuse angle opposite to a border edge is exchanged like all others.

    Parameters
    ----------
    surface, sharp
        As in `HelmholtzFilter`.
    node
        (t, 3) unknown at each corner.

    Notes
    -----
    Source: Bobenko and Springborn, Discrete Comput. Geom. 38 (2007) 740 (theorem on existence and end of the flips, and the sign of the
    couplings); Fisher, Springborn, Bobenko and Schroeder, Computing 81 (2007) 199 (data structure and lengths).
    """
    length = np.linalg.norm(np.roll(surface.corner, -1, axis=1) - surface.corner, axis=2).ravel()
    twin = neighbours(surface.point, surface.triangle, sharp)
    edge = np.arange(len(twin))
    image = edge + len(twin) + 2 - 2 * (edge % 3)  # the mirrored triangle runs backwards
    here = np.where(twin >= 0, twin, image)
    there = np.where(twin >= 0, image[np.abs(twin)], edge)
    twin = np.concatenate([here, np.empty_like(here)])
    twin[image] = there
    start = np.concatenate([node.ravel(), np.empty_like(node.ravel())])
    start[image] = np.roll(node, -1, axis=1).ravel()
    length = np.concatenate([length, np.empty_like(length)])
    length[image] = length[: len(image)]
    twin, start, length = delaunay(twin, start, length)
    cotangent = 1.0 / np.tan(_angle(length))
    weight = np.maximum(cotangent + cotangent[twin], 0.0)  # rounding may leave -1e-10
    count = int(node.max()) + 1
    # (cot a + cot b) / 2 for the edge, half of it for each of the two mirrored surfaces
    return coo_array(
        (0.25 * weight, (start, start[_next(np.arange(len(start)))])), shape=(count, count)
    ).tocsr()


def delaunay(
    twin: np.ndarray, start: np.ndarray, length: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Flip edges of a closed surface, known by its edge lengths only, until opposite angles sum to pi at most.

    Parameters
    ----------
    twin
        (3 t,) Each triangle has three directed edges 3 t, 3 t + 1, 3 t + 2; `twin` is the same edge in the neighbour.
    start
        (3 t,) node where the directed edge begins.
    length
        (3 t,) [m]
    """
    while True:
        edge = np.arange(len(twin))
        angle = _angle(length)
        bad = np.flatnonzero(
            (angle + angle[twin] > np.pi + ROUNDING) & (edge < twin) & (edge // 3 != twin // 3)
        )
        if not len(bad):
            return twin, start, length
        worst = np.argsort(-(angle + angle[twin])[bad], kind="stable")
        bad, first = bad[worst], np.full(len(twin) // 3, len(bad))
        rank = np.arange(len(bad))
        np.minimum.at(first, bad // 3, rank)
        np.minimum.at(first, twin[bad] // 3, rank)
        alone = (first[bad // 3] == rank) & (
            first[twin[bad] // 3] == rank
        )  # two flips never share a triangle
        twin, start, length = _flip(bad[alone], twin, start, length)


def _flip(
    edge: np.ndarray, twin: np.ndarray, start: np.ndarray, length: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Exchange edges a-b of triangles abc and bad for c-d; the triangles become cdb and dca."""
    other = twin[edge]
    bc, ca, ad, db = _next(edge), _next(_next(edge)), _next(other), _next(_next(other))
    ab = length[edge]
    along_c = (ab**2 + length[ca] ** 2 - length[bc] ** 2) / (2.0 * ab)
    along_d = (ab**2 + length[ad] ** 2 - length[db] ** 2) / (2.0 * ab)
    area = _twice_area(length)
    across = (area[edge // 3] + area[other // 3]) / ab
    c, d = start[ca], start[db]
    first, second = 3 * (edge // 3), 3 * (other // 3)
    place = np.arange(len(twin))
    for old, new in (
        (edge, first), (db, first + 1), (bc, first + 2), (other, second), (ca, second + 1), (ad, second + 2)
    ):  # fmt: skip
        place[old] = new
    new_twin, new_start, new_length = np.empty_like(twin), np.empty_like(start), np.empty_like(length)
    new_twin[place], new_start[place], new_length[place] = place[twin], start, length
    new_start[first], new_start[second] = c, d
    new_length[first] = new_length[second] = np.hypot(along_c - along_d, across)
    return new_twin, new_start, new_length


def _next(edge: np.ndarray) -> np.ndarray:
    """The directed edge that follows in the same triangle."""
    return np.where(edge % 3 == 2, edge - 2, edge + 1)


def _twice_area(length: np.ndarray) -> np.ndarray:
    """(t,) [m2] by Heron's formula in the order of Kahan, which keeps its digits for needles"""
    c, b, a = np.sort(length.reshape(-1, 3), axis=1).T
    return 0.5 * np.sqrt(np.maximum((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c)), 0.0))


def _angle(length: np.ndarray) -> np.ndarray:
    """(3 t,) [rad] opposite to each edge"""
    a = length.reshape(-1, 3)
    b, c = np.roll(a, -1, axis=1), np.roll(a, -2, axis=1)
    return np.arctan2(2.0 * _twice_area(length)[:, None], b**2 + c**2 - a**2).ravel()
