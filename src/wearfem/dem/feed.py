"""Where particles come from: sizes, inlets, packings."""

from dataclasses import dataclass

import numpy as np

from wearfem.errors import UserError


@dataclass(frozen=True)
class Sizes:
    """A distribution of radii by mass: the share of mass in each class, uniform in radius within a class."""

    edge: tuple[float, ...]  # [m] class borders, rising
    share: tuple[float, ...]  # mass in each class, any scale

    def __post_init__(self) -> None:
        edge, share = np.asarray(self.edge, float), np.asarray(self.share, float)
        if len(edge) != len(share) + 1 or not (np.diff(edge) >= 0).all() or not edge[0] > 0:
            raise UserError(
                f"Class borders {self.edge} and shares {self.share} were given; there must be one border more than shares, "
                "all above 0 m and rising."
            )
        if not (share >= 0).all() or not share.sum() > 0 or not np.isfinite(share.sum()):
            raise UserError(
                f"The mass shares {self.share} sum to nothing; at least one must be above 0 and none below."
            )

    @property
    def largest(self) -> float:
        return float(max(e for e, s in zip(self.edge[1:], self.share, strict=True) if s > 0))

    @property
    def smallest(self) -> float:
        return float(min(e for e, s in zip(self.edge[:-1], self.share, strict=True) if s > 0))

    def draw(self, count: int, random: np.random.Generator) -> np.ndarray:
        """(count,) radii [m]; classes are drawn by number, so that mass follows the shares."""
        edge, share = np.asarray(self.edge, float), np.asarray(self.share, float)
        low, high = edge[:-1], edge[1:]
        mean_cube = np.where(
            high > low, (high**4 - low**4) / (4.0 * np.where(high > low, high - low, 1.0)), low**3
        )
        number = share / mean_cube
        kind = random.choice(len(share), size=count, p=number / number.sum())
        return low[kind] + (high[kind] - low[kind]) * random.random(count)


def uniform_sizes(smallest: float, largest: float) -> Sizes:
    """Radii uniform by number between two values [m]."""
    return Sizes((smallest, largest), (1.0,))


@dataclass(frozen=True)
class Inlet:
    """A box in which particles appear at a mass rate, where there is room, seeded."""

    low: tuple[float, float, float]  # [m]
    high: tuple[float, float, float]  # [m]
    mass_rate: float  # [kg/s]
    sizes: Sizes
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m/s]
    material: int = 0
    seed: int = 0
    start: float = 0.0  # [s]
    stop: float = np.inf  # [s]

    def __post_init__(self) -> None:
        if not self.mass_rate >= 0.0:
            raise UserError(f"The inlet's mass rate is {self.mass_rate!r} kg/s; it must be 0 or more.")
        room = np.asarray(self.high) - np.asarray(self.low)
        if (room < 2.0 * self.sizes.largest * (1.0 - 1e-12)).any():
            raise UserError(
                f"The inlet from {self.low} to {self.high} m is narrower than its largest particle "
                f"({2 * self.sizes.largest:g} m across); widen it."
            )

    def due(self, time: float) -> float:
        """Mass [kg] that shall have come by `time` [s]."""
        return self.mass_rate * max(0.0, min(time, self.stop) - self.start)

    def place(self, due, density, particles, period, random, tries=30):
        """Radii (k,) and positions (k, 3) of new particles of at most the mass `due` [kg] that touch no other."""
        if due <= 0.0:
            return np.zeros(0), np.zeros((0, 3))
        mean = (
            density * 4.0 / 3.0 * np.pi * float((self.sizes.draw(256, np.random.default_rng(0)) ** 3).mean())
        )
        drawn = self.sizes.draw(int(due / mean) + 1, random)
        mass = np.cumsum(density * 4.0 / 3.0 * np.pi * drawn**3)
        drawn = drawn[mass <= due + 0.5 * density * 4.0 / 3.0 * np.pi * drawn**3]
        low, high = np.asarray(self.low), np.asarray(self.high)
        reach = self.sizes.largest + (particles.radius.max() if particles.count else 0.0)
        inside = ((particles.position > low - reach) & (particles.position < high + reach)).all(axis=1)
        position, radius = list(particles.position[inside]), list(particles.radius[inside])
        first = len(radius)
        for r in drawn:
            for _ in range(tries):
                x = low + r + random.random(3) * np.maximum(high - low - 2.0 * r, 0.0)
                if len(radius):
                    apart = np.asarray(position) - x
                    apart -= period * np.round(apart / np.where(period > 0, period, np.inf))
                    if ((apart**2).sum(axis=1) < (np.asarray(radius) + r) ** 2).any():
                        continue
                position.append(x)
                radius.append(r)
                break
        return np.array(radius[first:]), np.array(position[first:]).reshape(-1, 3)
