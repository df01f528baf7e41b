"""A curved chute: an arc that turns what falls down it, and a straight end; a slice of it, or the whole with its sides."""

from dataclasses import dataclass
from math import cos, pi, sin, tan

import numpy as np

from wearfem.liner.block import Hexahedra, block, mapped
from wearfem.liner.mesh import SolidMesh
from wearfem.surface import Surface


@dataclass(frozen=True)
class CurvedChute:
    """The shape of a chute whose bottom is an arc of a circle and then straight on, all of one thickness.

    Frame: x along, y across, z up, the arc's centre at the origin. An angle on the chute is counted from the horizontal through the
    centre: 0 where the chute falls straight down, pi/2 at the bottom of the circle.
    """

    radius: float  # [m] of the arc's face
    begin: float  # [rad] where the chute begins
    end: float  # [rad] where the arc ends
    straight: float  # [m] of chute after the arc
    thickness: float  # [m]
    width: float  # [m] of the bottom
    side: float = 0.0  # [m] width of each of the two sides
    slope: float = 0.25 * pi  # [rad] of the sides

    @property
    def length(self) -> float:
        """[m] along the face"""
        return self.radius * (self.end - self.begin) + self.straight

    def slice(self, width: float, size: float, layers: int = 1) -> SolidMesh:
        """A slice of the bottom from y = 0 to `width` [m], one element of length `size` [m] across: what wears it is the same all over."""
        cells = (round(self.length / size), 1, layers)
        flat = block((0, 0, -self.thickness), (self.length, width, 0), cells, Hexahedra, name="chute")
        return mapped(flat, self.bent)

    def trough(self, size: float, layers: int = 1) -> SolidMesh:
        """The whole chute of elements of `size` [m]: a bottom between two sides that rise by `slope`, plates that meet in a mitre."""
        half = 0.5 * self.width
        bottom, side = round(self.width / size), round(self.side / size)
        across = np.concatenate(
            [
                np.linspace(-half - self.side, -half, side + 1)[:-1],
                np.linspace(-half, half, bottom + 1),
                np.linspace(half, half + self.side, side + 1)[1:],
            ]
        )
        cells = (round(self.length / size), len(across) - 1, layers)
        thick = self.thickness
        flat = block((0, 0, -thick), (self.length, cells[1], 0), cells, Hexahedra, name="chute")
        knot = (-half - self.side, -half, half, half + self.side)
        reach, rise = half + self.side * cos(self.slope), self.side * sin(self.slope)
        inner = np.array([(-reach, rise), (-half, 0.0), (half, 0.0), (reach, rise)])
        mitre = thick * tan(0.5 * self.slope)
        out, down = thick * sin(self.slope), thick * cos(self.slope)
        outer = inner + [(-out, -down), (-mitre, -thick), (mitre, -thick), (out, -down)]

        def folded(position: np.ndarray) -> np.ndarray:
            """The flat plate with its sides turned up."""
            s = across[position[:, 1].round().astype(int)]
            back = (-position[:, 2] / thick)[:, None]
            face, rear = (
                np.column_stack([np.interp(s, knot, line[:, k]) for k in range(2)]) for line in (inner, outer)
            )
            return self.bent(np.column_stack([position[:, 0], face + back * (rear - face)]))

        return mapped(flat, folded)

    def bent(self, flat: np.ndarray) -> np.ndarray:
        """Positions (n, 3) [m] along, across and above the flat chute's face, where they are in the bent one."""
        along, across, above = flat.T
        angle = np.minimum(self.begin + along / self.radius, self.end)
        rest = along - self.radius * (angle - self.begin)
        inward = self.radius - above
        return np.column_stack(
            [
                -inward * np.cos(angle) + rest * np.sin(angle),
                across,
                -inward * np.sin(angle) - rest * np.cos(angle),
            ]
        )

    def down(self, angle: np.ndarray) -> np.ndarray:
        """(n, 3) unit vectors down the chute at angles (n,) [rad] of places on it"""
        turned = np.minimum(angle, self.end)
        return np.column_stack([np.sin(turned), np.zeros_like(turned), -np.cos(turned)])


def angle_of(position: np.ndarray) -> np.ndarray:
    """(n,) [rad] on a curved chute of positions (n, 3) [m]; on the straight end it goes on, so zones are told by it."""
    return np.arctan2(-position[:, 2], -position[:, 0])


def facet_angle(surface: Surface) -> np.ndarray:
    """(f,) [rad] on a curved chute of the facets' centres"""
    return angle_of(surface.facet_centre)


def share_between(surface: Surface, low: float, high: float) -> np.ndarray:
    """(f,) [-] the part of each facet that lies between two angles [rad] on a curved chute: a border cuts facets"""
    corner = angle_of(surface.corner.reshape(-1, 3)).reshape(-1, 3)
    first, last = np.full(surface.facet_count, np.inf), np.full(surface.facet_count, -np.inf)
    np.minimum.at(first, surface.facet, corner.min(axis=1))
    np.maximum.at(last, surface.facet, corner.max(axis=1))
    return np.clip(np.minimum(last, high) - np.maximum(first, low), 0.0, None) / (last - first)
