"""The particles: spheres, as arrays."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

HELD = {"x": 1, "y": 2, "z": 4, "rotation": 8}  # bits of Particles.held


class Particles(NamedTuple):
    """Spheres in the world frame. `wrench` holds force and torque side by side, because contacts add to both at once."""

    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    angular_velocity: np.ndarray  # (n, 3) [rad/s]
    wrench: np.ndarray  # (n, 6) [N, N m] contact force and torque
    applied_force: np.ndarray  # (n, 3) [N] given from outside, gravity apart
    radius: np.ndarray  # (n,) [m]
    mass: np.ndarray  # (n,) [kg]
    material: np.ndarray  # (n,) int32, number of the material
    held: np.ndarray  # (n,) uint8, bits of HELD: directions in which the particle does not move
    ident: np.ndarray  # (n,) int64, survives sorting

    @property
    def count(self) -> int:  # type: ignore[override]  # hides tuple.count, which nobody asks of particles
        """Number of particles."""
        return len(self.radius)

    @property
    def force(self) -> np.ndarray:
        """(n, 3) [N] sum of contact forces"""
        return self.wrench[:, :3]

    @property
    def torque(self) -> np.ndarray:
        """(n, 3) [N m] sum of contact torques about the centre"""
        return self.wrench[:, 3:]

    @property
    def inertia(self) -> np.ndarray:
        """(n,) [kg m2] of a solid sphere, 2/5 m R^2"""
        return 0.4 * self.mass * self.radius**2


def spheres(
    position: ArrayLike,
    radius: np.ndarray | float,
    density: np.ndarray | float,
    *,
    velocity: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0),
    angular_velocity: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0),
    applied_force: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0),
    material: np.ndarray | int = 0,
    held: np.ndarray | int = 0,
    first_ident: int = 0,
) -> Particles:
    """Solid spheres at `position` (n, 3) [m] of `radius` [m] and `density` [kg/m3]; single values serve for all."""
    places = np.array(position, float, ndmin=2)
    count = len(places)

    def vectors(given: np.ndarray | tuple[float, float, float]) -> np.ndarray:
        return np.array(np.broadcast_to(np.asarray(given, float), (count, 3)), order="C")

    def numbers(given: np.ndarray | float, kind: type = float) -> np.ndarray:
        return np.array(np.broadcast_to(np.asarray(given, kind), (count,)))

    radii = numbers(radius)
    return Particles(
        position=places,
        velocity=vectors(velocity),
        angular_velocity=vectors(angular_velocity),
        wrench=np.zeros((count, 6)),
        applied_force=vectors(applied_force),
        radius=radii,
        mass=numbers(density) * (4.0 / 3.0 * np.pi) * radii**3,
        material=numbers(material, np.int32),
        held=numbers(held, np.uint8),
        ident=np.arange(first_ident, first_ident + count, dtype=np.int64),
    )


def joined(one: Particles, other: Particles) -> Particles:
    """All particles of both, `one` first."""
    return Particles(*(np.concatenate(pair) for pair in zip(one, other, strict=True)))


def chosen(particles: Particles, choice: np.ndarray) -> Particles:
    """The particles that an index array or mask picks."""
    return Particles(*(np.ascontiguousarray(array[choice]) for array in particles))
