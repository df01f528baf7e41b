"""How strongly the worn face bends under each facet, and how fine its facets are: what a jump must stay well below."""

import numpy as np

from wearfem.edges import neighbours
from wearfem.surface import Surface
from wearfem.units import degree


def largest_curvature(surface: Surface, sharp: float = 30.0 * degree) -> np.ndarray:
    """(f,) [1/m] largest curvature across the edges of each facet, absolute.

    Across an edge whose triangles turn by the angle a, and whose centres are h away from it in all, the curvature is
    2 sin(a / 2) / h: on a cylinder and a sphere that is 1 / r to second order in h / r.

    Parameters
    ----------
    surface
        The worn face.
    sharp
        [rad] Edges that turn by more are edges of the body, not curvature.
    """
    point, triangle = surface.point, surface.triangle
    twin = neighbours(point, triangle, sharp)
    edge = np.flatnonzero(twin >= 0)
    here, there = edge // 3, twin[edge] // 3
    begin = point[triangle.ravel()[edge]]
    along = point[np.roll(triangle, -1, axis=1).ravel()[edge]] - begin
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    centre = surface.corner.mean(axis=1)
    apart = sum(_across(centre[side] - begin, along) for side in (here, there))
    turned = np.linalg.norm(surface.normal[here] - surface.normal[there], axis=1)  # 2 sin(a / 2)
    result = np.zeros(surface.facet_count)
    np.maximum.at(result, surface.facet[here], turned / apart)
    return result


def shortest_edge(node: np.ndarray, facet: np.ndarray) -> np.ndarray:
    """(f,) [m] of facets (f, 3) or (f, 4) between nodes (n, 3)"""
    corner = node[facet]
    return np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).min(axis=1)


def _across(way: np.ndarray, along: np.ndarray) -> np.ndarray:
    """(k,) [m] length of ways (k, 3) across directions (k, 3)"""
    return np.linalg.norm(way - np.einsum("ki,ki->k", way, along)[:, None] * along, axis=1)
