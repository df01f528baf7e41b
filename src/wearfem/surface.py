"""The triangles that particles touch: the first noun that particles, liner and wear share."""

import hashlib
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from wearfem.errors import UserError
from wearfem.material import Material


def _mark(name: str, *arrays: np.ndarray) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(array.tobytes())
    return f"{name} {digest.hexdigest()[:16]}"


@dataclass(frozen=True)
class Surface:
    """A triangulated surface in its own frame, checked when made.

    Triangles are oriented so that `normal` points into the flow. Several triangles may belong to one `facet` of a finite-element mesh;
    loads are summed by facet.

    Raises
    ------
    UserError
        for points that are not finite, triangles that name points that do not exist, that have no area, that are there
        twice, or that are turned against their neighbours.
    """

    point: np.ndarray  # (p, 3) [m]
    triangle: np.ndarray  # (t, 3) int
    material: Material
    facet: np.ndarray = field(
        default_factory=lambda: np.zeros(0, int)
    )  # (t,) owning facet; by default its own
    name: str = "surface"

    def __post_init__(self) -> None:
        point = np.ascontiguousarray(self.point, float)
        triangle = np.ascontiguousarray(self.triangle, np.int64)
        facet = np.ascontiguousarray(self.facet, np.int64) if len(self.facet) else np.arange(len(triangle))
        for what, value in (("point", point), ("triangle", triangle), ("facet", facet)):
            object.__setattr__(self, what, value)
        self._check()

    @property
    def corner(self) -> np.ndarray:
        """(t, 3, 3) [m] corners of each triangle"""
        return self.point[self.triangle]

    @property
    def _twice_area_vector(self) -> np.ndarray:
        a, b, c = np.moveaxis(self.corner, 1, 0)
        return np.cross(b - a, c - a)

    @property
    def normal(self) -> np.ndarray:
        """(t, 3) unit normals, into the flow"""
        vector = self._twice_area_vector
        return vector / np.linalg.norm(vector, axis=1, keepdims=True)

    @property
    def area(self) -> np.ndarray:
        """(t,) [m2]"""
        return 0.5 * np.linalg.norm(self._twice_area_vector, axis=1)

    @property
    def facet_count(self) -> int:
        """Number of facets, by the highest in use."""
        return int(self.facet.max()) + 1

    @property
    def facet_area(self) -> np.ndarray:
        """(f,) [m2]"""
        return np.bincount(self.facet, self.area, self.facet_count)

    def mean_over_facet(self, value: np.ndarray) -> np.ndarray:
        """(f, ...) mean over each facet, by area, of a value (t, ...) of its triangles, in its unit"""
        part = (value.reshape(len(value), -1) * self.area[:, None]).T
        total = np.column_stack([np.bincount(self.facet, one, self.facet_count) for one in part])
        return (total / self.facet_area[:, None]).reshape(self.facet_count, *value.shape[1:])

    @property
    def facet_centre(self) -> np.ndarray:
        """(f, 3) [m] centre of each facet's area"""
        return self.mean_over_facet(self.corner.mean(axis=1))

    @cached_property
    def mark(self) -> str:
        """Name and a hash of the shape: equal marks are equal surfaces."""
        return _mark(self.name, self.point, self.triangle, self.facet)

    def _check(self) -> None:
        point, triangle, facet = self.point, self.triangle, self.facet
        if (
            point.ndim != 2
            or point.shape[1] != 3
            or triangle.ndim != 2
            or triangle.shape[1] != 3
            or not len(triangle)
        ):
            raise UserError(
                f"{self.name}: points of shape {point.shape} and triangles of shape {triangle.shape} were given; "
                "a surface needs (p, 3) points and at least one triangle, (t, 3)."
            )
        if facet.shape != (len(triangle),) or facet.min() < 0:
            raise UserError(
                f"{self.name}: one facet number, 0 or more, is needed for each of {len(triangle)} triangles."
            )
        if not np.isfinite(point).all():
            bad = int(np.argmin(np.isfinite(point).all(axis=1)))
            raise UserError(
                f"{self.name}: point {bad} is {point[bad].tolist()}; coordinates must be finite numbers in m."
            )
        if triangle.min() < 0 or triangle.max() >= len(point):
            bad = int(np.argmax(((triangle < 0) | (triangle >= len(point))).any(axis=1)))
            raise UserError(
                f"{self.name}: triangle {bad} names the points {triangle[bad].tolist()}; "
                f"points are numbered 0 to {len(point) - 1}."
            )
        longest = np.linalg.norm(self.corner - np.roll(self.corner, 1, axis=1), axis=2).max(axis=1)
        flat = self.area <= 1e-12 * longest**2
        if flat.any():
            raise UserError(
                f"{self.name}: {flat.sum()} of {len(triangle)} triangles have no area, the first is number "
                f"{int(np.argmax(flat))}; remove degenerate triangles or merge their points."
            )
        _, first, count = np.unique(np.sort(triangle, axis=1), axis=0, return_index=True, return_counts=True)
        if (count > 1).any():
            raise UserError(
                f"{self.name}: {int((count - 1).sum())} triangles are there twice, the first is number "
                f"{int(first[count > 1].min())}; remove duplicates."
            )
        edge = np.concatenate([triangle[:, [0, 1]], triangle[:, [1, 2]], triangle[:, [2, 0]]])
        _, where, count = np.unique(edge, axis=0, return_index=True, return_counts=True)
        if (count > 1).any():
            bad = int(where[count > 1].min()) % len(triangle)
            raise UserError(
                f"{self.name}: {int((count > 1).sum())} edges are run through twice in the same direction, first at triangle "
                f"{bad}; neighbouring triangles must be oriented alike, with normals into the flow (flip the inverted ones)."
            )


@dataclass(frozen=True)
class Plane:
    """An endless plane; `normal` points to the side where particles are."""

    point: tuple[float, float, float]  # [m]
    normal: tuple[float, float, float]
    material: Material
    name: str = "plane"

    @property
    def mark(self) -> str:
        """Name and numbers of the plane: equal marks are equal planes."""
        return _mark(self.name, np.asarray(self.point, float), np.asarray(self.normal, float))

    def __post_init__(self) -> None:
        if not np.isfinite(self.normal).all() or not np.any(self.normal):
            raise UserError(f"{self.name}: the normal {self.normal} was given; it must have a direction.")


def rectangle(
    lower: tuple[float, float],
    upper: tuple[float, float],
    cells: tuple[int, int],
    material: Material,
    *,
    height: float = 0.0,
    name: str = "plate",
) -> Surface:
    """A horizontal rectangle of `cells` squares cut along one diagonal, normal up; x and y from `lower` to `upper` [m]."""
    nx, ny = cells
    x, y = np.linspace(lower[0], upper[0], nx + 1), np.linspace(lower[1], upper[1], ny + 1)
    point = np.stack([*np.meshgrid(x, y, indexing="ij"), np.full((nx + 1, ny + 1), height)], axis=-1).reshape(
        -1, 3
    )
    a = (np.arange(nx)[:, None] * (ny + 1) + np.arange(ny)).ravel()
    b = a + ny + 1
    triangle = np.stack([a, b, b + 1, a, b + 1, a + 1], axis=1).reshape(-1, 3)
    return Surface(point, triangle, material, name=name)
