"""Wear laws of impact: what each first touch removes, by its energy, angle and speed. [PLUG]

An impact is the first touch of a contact; its angle a is measured from the surface (0 grazing, pi/2 normal), v is the speed of the
point that touches, m v^2 / 2 the kinetic energy of the particle's centre as the surface sees it. A contact that endures is one impact,
however long it lasts and however small the time step; what it does afterwards is sliding (`Combined`, or `KineticEnergy.enduring`).
A law here is a formula `volume_per_energy(angle, speed)` [m3/J]; the sum over impacts is taken from the classes of `FacetLoads`.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from wearfem.loads import FacetLoads
from wearfem.wear.laws import per_area_and_time, require_number

ROUNDING = 1e-12  # [rad] angle x ln(speed), below which a spread is what rounding leaves of none


@dataclass(frozen=True)
class ImpactPoints:
    """The impacts of a sample, stood for by a few points: energy at an angle and a speed, on a facet during a block."""

    place: np.ndarray  # (n,) int, number of block times facets plus number of facet
    energy: np.ndarray  # (n,) [J]
    angle: np.ndarray  # (n,) [rad]
    speed: np.ndarray  # (n,) [m/s]
    shape: tuple[int, int]  # blocks, facets

    def total(self, amount: np.ndarray) -> np.ndarray:
        """(b, f) sum of an amount (n,) over the points of each block and facet"""
        return np.bincount(self.place, amount, self.shape[0] * self.shape[1]).reshape(self.shape)


def impact_points(loads: FacetLoads) -> ImpactPoints:
    """Four points for each class of impacts that has any, about its means of angle and of ln(speed).

    Weighted by energy, they keep the means, the variances and the covariance of angle and ln(speed) within the class; what is lost is
    the law's third derivative within one class. `wearfem verify wear_laws` shows the error. Loads that hold no moments are stood for by
    the middle of each class, geometric for speed: good for a first look only.
    """
    energy = loads.impact_energy
    block, facet, a, v = np.nonzero(energy)
    weight = energy[block, facet, a, v]
    place = block * loads.facet_count + facet
    shape = (loads.block_count, loads.facet_count)
    if loads.impact_moment is None:
        edge = np.radians(loads.angle_edge)
        speed = np.sqrt(loads.speed_edge[1:] * loads.speed_edge[:-1])
        return ImpactPoints(place, weight, 0.5 * (edge[1:] + edge[:-1])[a], speed[v], shape)
    moment = loads.impact_moment[block, facet, a, v] / weight[:, None]
    angle, log_speed = moment[:, 0], moment[:, 2]
    angle_spread = np.sqrt(np.maximum(moment[:, 1] - angle**2, 0.0))
    log_spread = np.sqrt(np.maximum(moment[:, 3] - log_speed**2, 0.0))
    both = angle_spread * log_spread
    tied = np.divide(moment[:, 4] - angle * log_speed, both, out=np.zeros_like(both), where=both > ROUNDING)
    tied = np.clip(tied, -1.0, 1.0)
    free = np.sqrt(1.0 - tied**2)
    sides = ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0))
    return ImpactPoints(
        np.tile(place, 4),
        np.tile(0.25 * weight, 4),
        np.clip(np.concatenate([angle + p * angle_spread for p, _ in sides]), 0.0, 0.5 * math.pi),
        np.exp(np.concatenate([log_speed + (p * tied + q * free) * log_spread for p, q in sides])),
        shape,
    )


class ImpactLaw:
    """What all laws of impact share: the sum over impacts of energy times `volume_per_energy`."""

    def volume_per_energy(self, angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """[m3/J] removed by an impact at `angle` [rad] and `speed` [m/s], over its kinetic energy; any one shape"""
        raise NotImplementedError

    def block_volume(self, loads: FacetLoads) -> np.ndarray:
        """(b, f) [m3] removed in each block"""
        points = impact_points(loads)
        return points.total(points.energy * self.volume_per_energy(points.angle, points.speed))

    def depth_rate(self, loads: FacetLoads, liner: Any = None) -> np.ndarray:
        """(b, f) [m/s] volume over area and time"""
        return per_area_and_time(self.block_volume(loads), loads)

    def volume(self, loads: FacetLoads) -> np.ndarray:
        """(f,) [m3]"""
        return self.block_volume(loads).sum(axis=0)


@dataclass(frozen=True)
class Finnie(ImpactLaw):
    """Cutting of a ductile metal by the tip of a hard angular grain.

    V = c m v^2 / (p psi K) x [ sin 2a - (6/K) sin^2 a  where tan a <= K/6 (the grain leaves while still cutting),
    (K/6) cos^2 a  above (it comes to rest in the surface) ].

    With K = 2, psi = 2 and c = 0.5 this is m v^2 / (8 p) (sin 2a - 3 sin^2 a) up to 18.4 degrees and m v^2 / (24 p) cos^2 a above.

    **Source** Finnie, Wear 3 (1960) 87-103, who puts c = 0.5 since not every grain cuts; as eqs. (3) and (4) in Svanberg, Larsson,
    Maki and Jonsen, Minerals 11 (2021) 623, whose second branch of (3) prints 6/K for K/6 ((4) has it right).
    **Valid for** ductile metals under angular grains at shallow angles; above about 45 degrees it wears far too little, at 90 degrees and
    in pure sliding nothing.
    """

    flow_stress: float  # [Pa] p, plastic flow stress; of the order of the hardness
    cutting_share: float  # [-] c, share of the grains that cut: 0.5 by Finnie, 1 for the bare formula
    force_ratio: float = 2.0  # [-] K, normal over shear force on the grain
    depth_ratio: float = 2.0  # [-] psi, length of contact over depth of cut

    def __post_init__(self) -> None:
        require_number("cutting_share", self.cutting_share, "")
        for name, unit in (("flow_stress", "Pa"), ("force_ratio", ""), ("depth_ratio", "")):
            require_number(name, getattr(self, name), unit, above_zero=True)

    def volume_per_energy(self, angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """[m3/J] 2 c f(a) / (p psi K)"""
        ratio = self.force_ratio / 6.0
        leaves = np.sin(2.0 * angle) - np.sin(angle) ** 2 / ratio
        stays = ratio * np.cos(angle) ** 2
        shape = np.where(np.tan(angle) <= ratio, leaves, stays)
        return 2.0 * self.cutting_share * shape / (self.flow_stress * self.depth_ratio * self.force_ratio)


@dataclass(frozen=True)
class KineticEnergy(ImpactLaw):
    """The m v^2 law of rope shovel and feeder: V = K m v^2 for each impact, whatever its angle.

    **Source** Svanberg et al., Minerals 11 (2021) 623, eq. (5): Finnie's law without its angle, so that shallow, steep and sliding contact
    all wear. The paper does not print how often a contact that endures is counted; once for every time step would make wear grow
    without bound as the step is refined. Here every contact is counted once, by the particle's speed against the surface at first touch.
    Sliding after that is counted, if `enduring` is 1, by the kinetic energy that friction takes out: d(m v^2) = 2 dW_friction. A free
    impact with friction is then counted with its own friction on top, at most m v_t^2 more.
    **Valid for** one pair of materials in flows like those of the calibration; K is fitted, with the same `enduring`, per plant.
    """

    volume_per_mass_speed_squared: float  # [m3/J] K
    enduring: float = 0.0  # [-] 0: first touches alone; 1: the work of friction too

    def __post_init__(self) -> None:
        require_number("volume_per_mass_speed_squared", self.volume_per_mass_speed_squared, "m3/J")
        require_number("enduring", self.enduring, "")

    def volume_per_energy(self, angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """[m3/J] 2 K"""
        return np.full(np.shape(angle), 2.0 * self.volume_per_mass_speed_squared)

    def block_volume(self, loads: FacetLoads) -> np.ndarray:
        """(b, f) [m3] K (sum of m v^2 + 2 enduring W_friction); exact, classes play no part"""
        energy = loads.impact_energy.sum(axis=(2, 3)) + self.enduring * loads.friction_work
        return 2.0 * self.volume_per_mass_speed_squared * energy


@dataclass(frozen=True)
class Oka(ImpactLaw):
    """Erosion from one measured value at normal impact, with the angle by hardness.

    V = m E90 (v/v')^k2 (D/D')^k3 g(a),  g = (sin a)^n1 (1 + H (1 - sin a))^n2,  H Vickers hardness in GPa.

    **Source** Oka, Okamura and Yoshida, Wear 259 (2005) 95-101, and Oka and Yoshida, ibid. 102-109; v' = 104 m/s and D' = 326 um. The
    exponents of silica sand are in `sand_on_metal`. Constants as the manuals of
    EDEM and Fluent print them; not checked against the papers themselves.
    **Valid for** erosion of metals by hard grains of the order of 0.3 mm and 100 m/s; for chutes both powers are extrapolations, so fit
    E90 to the plant. Particles of all sizes are counted with the one `diameter`.
    """

    volume_per_mass: float  # [m3/kg] E90 at the reference speed and diameter (papers give mm3/kg, 1e-9 of it)
    hardness: float  # [Pa] Vickers hardness of the surface, as a pressure (HV 180 is 1.77e9 Pa)
    diameter: float  # [m] of the particles
    sine_exponent: float  # [-] n1
    hardness_exponent: float  # [-] n2
    speed_exponent: float  # [-] k2
    diameter_exponent: float = 0.19  # [-] k3
    reference_speed: float = 104.0  # [m/s] v'
    reference_diameter: float = 326e-6  # [m] D'

    def __post_init__(self) -> None:
        for name, unit in (
            ("volume_per_mass", "m3/kg"),
            ("hardness", "Pa"),
            ("sine_exponent", ""),
            ("hardness_exponent", ""),
            ("speed_exponent", ""),
            ("diameter_exponent", ""),
        ):
            require_number(name, getattr(self, name), unit)
        for name, unit in (("diameter", "m"), ("reference_speed", "m/s"), ("reference_diameter", "m")):
            require_number(name, getattr(self, name), unit, above_zero=True)

    @classmethod
    def sand_on_metal(cls, volume_per_mass: float, hardness: float, diameter: float) -> "Oka":
        """Angular silica sand: n1 = 0.71 H^0.14, n2 = 2.4 H^-0.94, k2 = 2.3 H^0.038, k3 = 0.19, H in GPa."""
        require_number("hardness", hardness, "Pa", above_zero=True)
        h = hardness / 1e9
        return cls(volume_per_mass, hardness, diameter, 0.71 * h**0.14, 2.4 * h**-0.94, 2.3 * h**0.038)

    def angle_factor(self, angle: np.ndarray) -> np.ndarray:
        """g(a) [-], 1 at normal impact"""
        sine = np.sin(angle)
        return sine**self.sine_exponent * (1.0 + self.hardness / 1e9 * (1.0 - sine)) ** self.hardness_exponent

    def volume_per_energy(self, angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """[m3/J] 2 E(a, v, D) / v^2"""
        size = (self.diameter / self.reference_diameter) ** self.diameter_exponent
        speed_power = (speed / self.reference_speed) ** self.speed_exponent
        return 2.0 * self.volume_per_mass * size * speed_power * self.angle_factor(angle) / speed**2


@dataclass(frozen=True)
class DNV(ImpactLaw):
    """Sand erosion of pipework: V = m K F(a) v^n / rho, F = 0.6 [sin a + 7.2 (sin a - sin^2 a)]^0.6 [1 - exp(-20 a)].

    The unit of K belongs to its n: it is the eroded mass over the mass that hits, at 1 m/s.

    **Source** DNVGL-RP-O501 (2015), ductile materials; steel K = 2e-9 (m/s)^-n, n = 2.6, rho = 7850 kg/m3. Constants as in
    the open code pysand; not checked against the text of the practice.
    **Valid for** ductile metals under silica sand, up to 200 m/s; at the speeds of chutes v^n extrapolates from tests at tens of m/s.
    """

    coefficient: float = 2e-9  # [(m/s)^-n] K
    speed_exponent: float = 2.6  # [-] n
    density: float = 7850.0  # [kg/m3] of the surface

    def __post_init__(self) -> None:
        require_number("coefficient", self.coefficient, "(m/s)^-n")
        require_number("speed_exponent", self.speed_exponent, "")
        require_number("density", self.density, "kg/m3", above_zero=True)

    @staticmethod
    def angle_factor(angle: np.ndarray) -> np.ndarray:
        """F(a) [-], largest 1 at some 36 degrees, 0.6 at normal impact"""
        sine = np.sin(angle)
        return 0.6 * (sine + 7.2 * (sine - sine**2)) ** 0.6 * -np.expm1(-20.0 * angle)

    def volume_per_energy(self, angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """[m3/J] 2 K F(a) v^(n - 2) / rho"""
        scale = 2.0 * self.coefficient / self.density
        return scale * self.angle_factor(angle) * speed ** (self.speed_exponent - 2.0)


@dataclass(frozen=True)
class NeilsonGilchrist(ImpactLaw):
    """Cutting by the velocity along the surface, and deformation by that into it beyond a threshold.

    V = (m/2) [ v^2 cos^2 a sin(n a) / phi  for a <= pi/(2n), v^2 cos^2 a / phi above ] + (m/2) (v sin a - v0)^2 / eps where v sin a > v0.

    **Source** Neilson and Gilchrist, Wear 11 (1968) 111-122, a simpler form of Bitter, Wear 6 (1963) 5-21 and 169-190; equations as the
    manuals and codes repeat them, numbers not checked against the paper.
    **Valid for** ductile (phi small) to brittle (eps small) surfaces, any angle above 0; phi, eps, n and v0 come from
    tests at three angles or more.
    """

    cutting_energy: float  # [J/m3] phi, kinetic energy along the surface spent on a volume cut
    deformation_energy: float  # [J/m3] eps, energy into the surface spent on a volume loosened
    angle_constant: float  # [-] n; from pi/(2n) on a grain stops cutting within the surface
    threshold_speed: float = 0.0  # [m/s] v0, normal speed below which nothing is loosened

    def __post_init__(self) -> None:
        for name, unit in (
            ("cutting_energy", "J/m3"),
            ("deformation_energy", "J/m3"),
            ("angle_constant", ""),
        ):
            require_number(name, getattr(self, name), unit, above_zero=True)
        require_number("threshold_speed", self.threshold_speed, "m/s")

    def volume_per_energy(self, angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """[m3/J] cos^2 a sin(min(n a, pi/2)) / phi + (sin a - v0/v)^2 / eps"""
        cut = np.cos(angle) ** 2 * np.sin(np.minimum(self.angle_constant * angle, 0.5 * math.pi))
        loosened = np.maximum(np.sin(angle) - self.threshold_speed / speed, 0.0) ** 2
        return cut / self.cutting_energy + loosened / self.deformation_energy


@dataclass(frozen=True)
class ShearImpactEnergy:
    """SIEM: a share of the energy that impacts lose to shear goes into cutting: V = c E_shear / p, c = 1/4.

    E_shear is the work of the tangential force during contact; here the part of it that slip dissipates, `friction_work`, summed during
    the run and therefore free of classes. A contact that endures counts by its work too.

    **Source** the share of 1/4 by Zhao, Ma, Xu and Zheng, Particuology 34 (2017) 81-88, as told in Svanberg et al., Minerals 11 (2021) 623,
    section 1; the equation itself was not at hand. **Valid for** ductile surfaces under grains that slip; impacts that grip and roll off
    (tan a > 2/(7 mu (1 + e)) for a solid sphere) lose less.
    """

    flow_stress: float  # [Pa] p, plastic flow pressure; of the order of the hardness
    cutting_share: float = 0.25  # [-] c

    def __post_init__(self) -> None:
        require_number("flow_stress", self.flow_stress, "Pa", above_zero=True)
        require_number("cutting_share", self.cutting_share, "")

    def depth_rate(self, loads: FacetLoads, liner: Any = None) -> np.ndarray:
        """(b, f) [m/s] c W / (p A T)"""
        return self.cutting_share / self.flow_stress * per_area_and_time(loads.friction_work, loads)

    def volume(self, loads: FacetLoads) -> np.ndarray:
        """(f,) [m3] c W / p"""
        return self.cutting_share / self.flow_stress * loads.friction_work.sum(axis=0)
