"""How strongly the worn face bends under each facet, and how fine its facets are: what a jump must stay well below."""

import numpy as np

from wearfem.edges import neighbours
from wearfem.surface import Surface
from wearfem.units import degree


def largest_curvature(surface: Surface, sharp: float = 30.0 * degree) -> np.ndarray:
    """(f,) [1/m] largest principal curvature at the corners of each facet, absolute.

    At a node with a third A of the triangles around it, mean and Gaussian curvature are

        H = sum of l b / (4 A),    K = (2 pi - sum of angles) / A,

    over its edges of length l that turn by the angle b, and the angles of its triangles; the larger principal curvature is
    |H| + sqrt(H^2 - K). A corner at a border or a sharp edge tells nothing; a facet between such corners alone has 0.

    Parameters
    ----------
    surface
        The worn face.
    sharp
        [rad] Edges that turn by more are edges of the body, not curvature.

    Source
    ------
    Meyer, Desbrun, Schroeder and Barr 2003, in Visualization and Mathematics III, 35-57, eqs. 8 and 9; H by edges as in Cohen-Steiner
    and Morvan 2003, Proc. 19th Symp. Computational Geometry, 312-321.

    Valid for
    ---------
    facets smaller than the radius; on irregular meshes it scatters by some tens of per cent.
    """
    triangle, count = surface.triangle, len(surface.point)
    twin = neighbours(surface.point, triangle, sharp)
    begin, end = triangle.ravel(), np.roll(triangle, -1, axis=1).ravel()
    along = surface.point[end] - surface.point[begin]
    length = np.linalg.norm(along, axis=1)
    normal = np.repeat(surface.normal, 3, axis=0)
    here, there = normal, normal[twin]
    turn = np.arctan2(
        np.einsum("ei,ei->e", np.cross(here, there), along) / length, np.einsum("ei,ei->e", here, there)
    )
    area = np.bincount(begin, np.repeat(surface.area / 3.0, 3), count)
    each = np.where(twin >= 0, 0.5 * length * turn, 0.0)  # every inner edge is there twice
    mean = (np.bincount(begin, each, count) + np.bincount(end, each, count)) / (4.0 * area)
    unit = along / length[:, None]
    back = np.roll(unit.reshape(-1, 3, 3), 1, axis=1).reshape(-1, 3)
    angle = np.arccos(np.clip(-np.einsum("ei,ei->e", unit, back), -1.0, 1.0))
    gauss = (2.0 * np.pi - np.bincount(begin, angle, count)) / area
    largest = np.abs(mean) + np.sqrt(np.maximum(mean**2 - gauss, 0.0))
    largest[begin[twin < 0]] = largest[end[twin < 0]] = 0.0
    result = np.zeros(surface.facet_count)
    np.maximum.at(result, np.repeat(surface.facet, 3), largest[begin])
    return result


def shortest_edge(node: np.ndarray, facet: np.ndarray) -> np.ndarray:
    """(f,) [m] of facets (f, 3) or (f, 4) between nodes (n, 3)"""
    corner = node[facet]
    return np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).min(axis=1)
