"""A worn face with semi-ellipsoidal convexes, as a shell: whole tiles, structured and graded, repeated and bent into an arc.

A shell has one thickness at each node, so a convex is a place where it is thicker. Its worn face sinks straight down and its mesh
never degrades, even when the convexes are long gone. No mesh generator is needed.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from wearfem.errors import UserError
from wearfem.liner.mesh import WEAR, ShellMesh


@dataclass(frozen=True)
class Convex:
    """Half an ellipsoid on a face, its longest axis along the flow.

    Parameters
    ----------
    along, across, height
        Semi-axes [m]: along the flow, across it, and out of the face.
    """

    along: float
    across: float
    height: float

    def __post_init__(self) -> None:
        """Refuse a convex without volume."""
        if not min(self.along, self.across, self.height) > 0.0:
            raise UserError(
                f"a convex of {1e3 * self.along:g} x {1e3 * self.across:g} x {1e3 * self.height:g} mm was given: its semi-axes along, "
                "across and out of the face must be above 0 mm"
            )

    @property
    def volume(self) -> float:
        """[m3] 2/3 pi a b c"""
        return 2.0 / 3.0 * pi * self.along * self.across * self.height


@dataclass(frozen=True)
class Pattern:
    """Where the convexes stand on a face that is rolled out flat: at the corners of rhombi, or of rectangles.

    Parameters
    ----------
    convex
        Each of them.
    spacing_along, spacing_across
        Distances of centres along and across the flow [m]: the diagonals of the rhombi, or the sides of the rectangles.
    staggered
        Rhombi: every other row is shifted by half of both spacings, so there are twice as many convexes as with rectangles.
    """

    convex: Convex
    spacing_along: float
    spacing_across: float
    staggered: bool = True

    def __post_init__(self) -> None:
        """Refuse convexes that touch their neighbours."""
        room = 0.9 * np.array(self.tile) / 2.0
        for axis, radius, free in zip(
            ("along", "across"), (self.convex.along, self.convex.across), room, strict=True
        ):
            if radius > free:
                raise UserError(
                    f"convexes with a radius of {1e3 * radius:g} mm {axis} the flow were given, but their spacing leaves room for "
                    f"{1e3 * free:.4g} mm: make the spacing {axis} the flow larger"
                )

    @property
    def tile(self) -> tuple[float, float]:
        """[m] length and width of a tile, which has one convex in its middle or none"""
        part = 2.0 if self.staggered else 1.0
        return self.spacing_along / part, self.spacing_across / part

    def has_convex(self, row: np.ndarray, column: np.ndarray) -> np.ndarray:
        """Which tiles of these rows (along the flow) and columns (across) have a convex."""
        return (row + column) % 2 == 0 if self.staggered else np.ones(np.broadcast(row, column).shape, bool)


@dataclass(frozen=True)
class Fineness:
    """How finely a tile is meshed.

    Parameters
    ----------
    sectors
        Around a convex, a multiple of 8.
    rings
        From the rim of a convex to its top; at equal steps of latitude, so its steep foot is resolved as well as its flat top.
    rings_around
        From the rim to the border of the tile, growing outwards.
    """

    sectors: int = 16
    rings: int = 4
    rings_around: int = 3

    def __post_init__(self) -> None:
        """Refuse counts that make no tile."""
        if self.sectors < 8 or self.sectors % 8 or self.rings < 1 or self.rings_around < 1:
            raise UserError(
                f"{self.sectors} sectors, {self.rings} rings and {self.rings_around} rings around were given for the mesh of a convex: "
                "sectors must be a multiple of 8, and each needs one ring"
            )


@dataclass(frozen=True)
class Tile:
    """A piece of flat face around the origin."""

    node: np.ndarray  # (n, 2) [m] along and across
    height: np.ndarray  # (n,) [m] above the face
    triangle: np.ndarray  # (t, 3) normals up

    @property
    def volume(self) -> float:
        """[m3] above the face"""
        edge = self.node[self.triangle[:, 1:]] - self.node[self.triangle[:, :1]]
        area = 0.5 * np.linalg.det(edge)
        return float(area @ self.height[self.triangle].mean(axis=1))

    @cached_property
    def alike(self) -> np.ndarray:
        """(t,) numbers that a triangle shares with its mirror image across the line along the flow through the middle"""
        centre = self.node[self.triangle].mean(axis=1)
        size = np.abs(self.node).max()
        place = np.column_stack([centre[:, 0], np.abs(centre[:, 1])]) / size
        return np.unique(np.round(place, 9), axis=0, return_inverse=True)[1].ravel()


def tile_with(pattern: Pattern, fineness: Fineness) -> Tile:
    """A tile with its convex: rings at latitudes of the ellipsoid, then rings that turn from its rim into the border of the tile.

    Symmetric about both middle lines. The meshed convex is inscribed in the ellipsoid; its volume converges with the second order of
    the angle between nodes.
    """
    convex, count = pattern.convex, fineness.sectors
    angle = 2.0 * pi * np.arange(count) / count
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    rim = circle * (convex.along, convex.across)
    border = circle / np.abs(circle).max(axis=1)[:, None] * 0.5 * np.array(pattern.tile)
    latitude = 0.5 * pi * np.arange(fineness.rings, 0, -1) / fineness.rings
    inside = [np.cos(phi) * rim for phi in latitude[1:]]
    gap = np.linalg.norm(border - rim, axis=1).mean() / np.linalg.norm(rim, axis=1).mean()
    part = np.linspace(0.0, 1.0, fineness.rings_around + 1)
    part = (
        np.expm1(part * np.log1p(gap)) / gap
    )  # each ring wider than the last, the first as wide as the mean
    around = [rim + share * (border - rim) for share in part]
    node = np.concatenate([np.zeros((1, 2)), *inside, *around])
    height = np.zeros(len(node))
    height[0] = convex.height
    for ring, phi in enumerate(latitude[1:]):
        height[1 + ring * count : 1 + (ring + 1) * count] = convex.height * np.sin(phi)
    return Tile(node, height, _rings(len(inside) + len(around), count))


def _rings(rings: int, count: int) -> np.ndarray:
    """Triangles around node 0, then between rings of `count` nodes; diagonals turn from quadrant to quadrant."""
    here = np.arange(count)
    there = (here + 1) % count
    parts = [np.column_stack([np.zeros(count, int), 1 + here, 1 + there])]
    odd = (here // (count // 4)) % 2 == 1
    for ring in range(rings - 1):
        a, b = 1 + ring * count + here, 1 + ring * count + there
        c, d = a + count, b + count
        rising = np.stack([np.column_stack([a, c, d]), np.column_stack([a, d, b])], axis=1)
        falling = np.stack([np.column_stack([a, c, b]), np.column_stack([b, c, d])], axis=1)
        parts.append(np.where(odd[:, None, None], falling, rising).reshape(-1, 3))
    return np.concatenate(parts)


def tile_without(pattern: Pattern, fineness: Fineness) -> Tile:
    """A flat tile whose border has the same nodes."""
    side = np.tan(0.25 * pi * np.linspace(-1.0, 1.0, fineness.sectors // 4 + 1))
    count = len(side)
    x, y = np.meshgrid(side, side, indexing="ij")
    node = 0.5 * np.column_stack([x.ravel(), y.ravel()]) * pattern.tile
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    b, c, d = a + 1, a + count, a + count + 1
    middle = node[np.column_stack([a, b, c, d])].mean(axis=1)
    rising = np.stack([np.column_stack([a, c, d]), np.column_stack([a, d, b])], axis=1)
    falling = np.stack([np.column_stack([a, c, b]), np.column_stack([b, c, d])], axis=1)
    turned = (middle[:, 0] * middle[:, 1] < 0.0)[:, None, None]
    return Tile(node, np.zeros(len(node)), np.where(turned, falling, rising).reshape(-1, 3))


@dataclass(frozen=True)
class EmbossedStrip:
    """A flat strip of whole tiles, and where its triangles lie in them."""

    node: np.ndarray  # (n, 2) [m] along from 0, across from 0
    height: np.ndarray  # (n,) [m] above the face
    triangle: np.ndarray  # (f, 3) normals up
    row: np.ndarray  # (f,) of the tile, along the flow
    alike: (
        np.ndarray
    )  # (f,) the same for triangles at the same place of a tile, mirror images across the flow included
    on_convex: np.ndarray  # (f,) bool

    @property
    def convex_volume(self) -> float:
        """[m3] above the face"""
        return Tile(self.node, self.height, self.triangle).volume


def embossed_strip(
    pattern: Pattern, rows: int, columns: int, fineness: Fineness | None = None
) -> EmbossedStrip:
    """A strip of `rows` x `columns` tiles; an even number of columns of staggered convexes fits to itself across the flow.

    Raises
    ------
    UserError
        for fewer than one row or column, or an odd number of columns of staggered convexes.
    """
    if rows < 1 or columns < 1 or (pattern.staggered and columns % 2):
        raise UserError(
            f"a strip of {rows} x {columns} tiles was asked for: it needs at least one row and one column, and staggered convexes "
            "an even number of columns, which is whole spacings across the flow"
        )
    fineness = fineness or Fineness()
    kinds = (tile_without(pattern, fineness), tile_with(pattern, fineness))
    inside = fineness.sectors * (2 * fineness.rings - 1)  # triangles of the convex come first
    nodes, heights, triangles, place, alike, convex = [], [], [], [], [], []
    first = 0
    for row in range(rows):
        for column in range(columns):
            kind = int(pattern.has_convex(np.array(row), np.array(column)))
            tile = kinds[kind]
            nodes.append(tile.node + (np.array([row, column]) + 0.5) * pattern.tile)
            heights.append(tile.height)
            triangles.append(first + tile.triangle)
            first += len(tile.node)
            place.append(np.full(len(tile.triangle), row))
            alike.append(tile.alike + kind * (kinds[0].alike.max() + 1))
            convex.append((np.arange(len(tile.triangle)) < inside) & bool(kind))
    node = np.concatenate(nodes)
    grain = 1e-6 * min(pattern.tile)
    _, kept, number = np.unique(np.round(node / grain), axis=0, return_index=True, return_inverse=True)
    return EmbossedStrip(
        node[kept],
        np.concatenate(heights)[kept],
        number.ravel()[np.concatenate(triangles)],
        np.concatenate(place),
        np.concatenate(alike),
        np.concatenate(convex),
    )


def bent_shell(
    strip: EmbossedStrip, radius: float, start: float, thickness: float, *, name: str = "liner"
) -> ShellMesh:
    """The strip as a shell on the inside of an arc around the y axis.

    A point at the angle theta lies at (-r cos theta, y, -r sin theta): theta = 0 is a wall that ore falls along, 90 degrees a floor.

    Parameters
    ----------
    strip
        Flat; along it theta grows.
    radius
        Of the face without convexes [m].
    start
        Theta where the strip begins [rad].
    thickness
        Without convexes [m].
    """
    theta = start + strip.node[:, 0] / radius
    node = np.column_stack([-radius * np.cos(theta), strip.node[:, 1], -radius * np.sin(theta)])
    full = thickness + strip.height
    element = _towards_axis(node, strip.triangle)
    return ShellMesh(node, element, full, 0.5 * full - thickness, {WEAR: element}, name)


def _towards_axis(node: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(node[triangle], 1, 0)
    inward = -(a + b + c) * (1.0, 0.0, 1.0)
    turned = np.einsum("ti,ti->t", np.cross(b - a, c - a), inward) < 0.0
    return np.where(turned[:, None], triangle[:, ::-1], triangle)
