"""Effects: what makes a wear rate differ from the law's, by depth, time, load or place. [PLUG]

An effect is a frozen dataclass with one formula, `factor(...)`, of the features that `needs` names (see `features.py` for their units);
`effect.py` says how it is used. No factor is negative.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from wearfem.errors import UserError
from wearfem.loads import FacetLoads
from wearfem.wear.effect import FactorEffect, Log, logged, power, require, require_steps, step, unit
from wearfem.wear.features import WornLiner

# By depth: what the plate is made of.


@dataclass(frozen=True)
class HardnessGradient(FactorEffect):
    """Hardness that falls through the thickness: H(d)/H0 = max(1 - g d, core); rate as (H0/H)^m.

    **Source** m = 1 is Archard's k = K/H. **Valid for** quenched plates, whose core keeps 90 % of the surface's hardness and
    more, to surface-hardened ones; hardness alone does not set the wear of all steels, hence m.
    """

    needs: ClassVar[tuple[str, ...]] = ("depth",)
    loss: float  # [1/m] g, part of the surface's hardness lost with depth; below 0 for a gain
    core: float = 0.3  # [-] least hardness over that of the surface
    exponent: float = 1.0  # [-] m

    def __post_init__(self) -> None:
        require("loss", self.loss, -math.inf, math.inf)
        require("core", self.core, 1e-3, 1.0)
        require("exponent", self.exponent, 0.0, math.inf)

    def factor(self, *, depth: Any) -> Any:
        """[-] by depth [m]"""
        return np.maximum(1.0 - self.loss * depth, self.core) ** -self.exponent


@dataclass(frozen=True)
class Overlay(FactorEffect):
    """A hard layer on a softer plate: factor 1 in the layer, `ratio` below it, a straight line across the transition.

    **Source** the mixed zone between weld metal and base; thickness as ordered, ratio as tested (ASTM G65). **Valid for** one
    layer; several layers are several overlays, each with the ratio to the layer above.
    """

    needs: ClassVar[tuple[str, ...]] = ("depth",)
    thickness: float  # [m] of the layer
    ratio: float  # [-] rate below over rate in the layer
    transition: float = 0.0  # [m] width of the mixed zone about the border

    def __post_init__(self) -> None:
        require("thickness", self.thickness, 0.0, math.inf)
        require("ratio", self.ratio, 0.0, math.inf)
        require("transition", self.transition, 0.0, math.inf)

    def factor(self, *, depth: Any) -> Any:
        """[-] by depth [m]"""
        beyond = np.asarray(depth) - self.thickness
        if self.transition > 0.0:
            part = np.clip(0.5 + beyond / self.transition, 0.0, 1.0)
        else:
            part = np.where(beyond >= 0.0, 1.0, 0.0)
        return 1.0 + (self.ratio - 1.0) * part


@dataclass(frozen=True)
class RunningIn(FactorEffect):
    """A new surface wears faster until it is smooth: 1 + A exp(-d/d0).

    **Source** exponential running-in, Blau, Tribol. Int. 38 (2005) 1007-1012 on its forms. **Valid for** the first millimetre:
    scale, roughness, weld beads.
    """

    needs: ClassVar[tuple[str, ...]] = ("depth",)
    excess: float  # [-] A, rate when new over the later rate, less 1
    depth: float  # [m] d0

    def __post_init__(self) -> None:
        require("excess", self.excess, -1.0, math.inf)
        require("depth", self.depth, 0.0, math.inf, open_below=True)

    def factor(self, *, depth: Any) -> Any:
        """[-] by depth [m]"""
        return 1.0 + self.excess * np.exp(-np.asarray(depth) / self.depth)


@dataclass(frozen=True)
class RunningInByThroughput(FactorEffect):
    """Running-in with exposure: 1 + A exp(-M/M0), M the mass that has passed.

    **Source** as `RunningIn`. **Valid for** places that are all exposed alike; where exposure differs, depth is the better clock.
    """

    needs: ClassVar[tuple[str, ...]] = ("throughput",)
    excess: float  # [-] A
    throughput: float  # [kg] M0

    def __post_init__(self) -> None:
        require("excess", self.excess, -1.0, math.inf)
        require("throughput", self.throughput, 0.0, math.inf, open_below=True)

    def factor(self, *, throughput: Any) -> Any:
        """[-] by throughput [kg]"""
        return 1.0 + self.excess * np.exp(-np.asarray(throughput) / self.throughput)


@dataclass(frozen=True)
class WorkHardening(FactorEffect):
    """A surface that hardens under impacts: 1 - g (1 - exp(-w/w0)), w the energy of impacts received by area.

    **Source** saturating hardening, as of austenitic manganese steel (Hadfield), measured hardness 2 to 3 times the initial.
    **Valid for** steels that harden; w in a run is the present intensity times service time, so the flow should not have
    changed much before.
    """

    needs: ClassVar[tuple[str, ...]] = ("impact_work",)
    gain: float  # [-] g, part of the rate that hardening saves in the end
    work: float  # [J/m2] w0

    def __post_init__(self) -> None:
        require("gain", self.gain, 0.0, 1.0)
        require("work", self.work, 0.0, math.inf, open_below=True)

    def factor(self, *, impact_work: Any) -> Any:
        """[-] by impact work [J/m2]"""
        return 1.0 + self.gain * np.expm1(-np.asarray(impact_work) / self.work)


@dataclass(frozen=True)
class WorkHardeningByDepth(FactorEffect):
    """Work hardening that keeps step with wear: 1 - g (1 - exp(-d/d0)).

    **Source** as `WorkHardening`; hardened layers of 0.5 mm and more are reported. **Valid for** places whose impacts and wear
    go together. The same formula as `RunningIn` with A = g/(1 - g), another coefficient k: depth alone cannot tell the two
    apart.
    """

    needs: ClassVar[tuple[str, ...]] = ("depth",)
    gain: float  # [-] g
    depth: float  # [m] d0

    def __post_init__(self) -> None:
        require("gain", self.gain, 0.0, 1.0)
        require("depth", self.depth, 0.0, math.inf, open_below=True)

    def factor(self, *, depth: Any) -> Any:
        """[-] by depth [m]"""
        return 1.0 + self.gain * np.expm1(-np.asarray(depth) / self.depth)


# By time: what flows, and the weather.


@dataclass(frozen=True)
class OreChange(FactorEffect):
    """Another ore from a throughput on: factor 1, then `ratio[i]` from `throughput[i]` on.

    **Source** the tonnage book. **Valid for** ores that change at once, for the whole liner; an error of the tonnage book looks
    alike.
    """

    needs: ClassVar[tuple[str, ...]] = ("throughput",)
    throughput: tuple[float, ...]  # [kg] rising
    ratio: tuple[float, ...]  # [-] rate over that of the first ore

    def __post_init__(self) -> None:
        require_steps("OreChange", self.throughput, self.ratio, least=0.0)

    def factor(self, *, throughput: Any) -> Any:
        """[-] by throughput [kg]"""
        return step(throughput, self.throughput, self.ratio)


@dataclass(frozen=True)
class OreChangeByTime(FactorEffect):
    """Another ore from a time on: factor 1, then `ratio[i]` from `service_time[i]` on. **Source**, **Valid for** as `OreChange`."""

    needs: ClassVar[tuple[str, ...]] = ("service_time",)
    service_time: tuple[float, ...]  # [s] rising
    ratio: tuple[float, ...]  # [-]

    def __post_init__(self) -> None:
        require_steps("OreChangeByTime", self.service_time, self.ratio, least=0.0)

    def factor(self, *, service_time: Any) -> Any:
        """[-] by service time [s]"""
        return step(service_time, self.service_time, self.ratio)


@dataclass(frozen=True)
class OreHardness(FactorEffect):
    """Harder ore wears faster: (H/H0)^m, H as it was logged.

    **Source** a power law for want of a better one. **Valid for** a narrow range on one side of the transition at an ore 1.8 to
    2.1 times as hard as the steel (SSAB); across it the rate jumps.
    """

    needs: ClassVar[tuple[str, ...]] = ("ore_hardness",)
    exponent: float  # [-] m
    reference: float  # [Pa] H0
    log: Log | None = None  # of ore hardness [Pa], for a run

    def __post_init__(self) -> None:
        require("exponent", self.exponent, -math.inf, math.inf)
        require("reference", self.reference, 0.0, math.inf, open_below=True)

    def known(self, loads: FacetLoads, liner: WornLiner) -> dict[str, Any]:
        """From the log, at the liner's service time."""
        return logged("ore_hardness", self.log, loads, liner)

    def factor(self, *, ore_hardness: Any) -> Any:
        """[-] by hardness of the ore [Pa]"""
        return (np.asarray(ore_hardness) / self.reference) ** self.exponent


@dataclass(frozen=True)
class Temperature(FactorEffect):
    """A surface that softens when warm: exp(b (T - T0)).

    **Source** hardness H = A exp(-b T) of Ito and Shishokin, with Archard's k = K/H. **Valid for** metals below half their
    melting temperature without change of phase; tempering and oxides break it (NM600 steel does not follow it above 100 degrees
    Celsius).
    """

    needs: ClassVar[tuple[str, ...]] = ("temperature",)
    softening: float  # [1/K] b
    reference: float  # [K or degrees Celsius, like the log] T0
    log: Log | None = None  # of temperature, for a run

    def __post_init__(self) -> None:
        require("softening", self.softening, -math.inf, math.inf)
        require("reference", self.reference, -math.inf, math.inf)

    def known(self, loads: FacetLoads, liner: WornLiner) -> dict[str, Any]:
        """From the log, at the liner's service time."""
        return logged("temperature", self.log, loads, liner)

    def factor(self, *, temperature: Any) -> Any:
        """[-] by temperature"""
        return np.exp(self.softening * (np.asarray(temperature) - self.reference))


@dataclass(frozen=True)
class Corrosion:
    """Depth lost to corrosion by calendar time, beside wear: rate + c x (calendar time per service time).

    **Source** general corrosion is reported as depth a year (ISO 9223: carbon steel outdoors 1.3 to 200 um a year). **Valid
    for** attack that does not depend on wear; that bare metal corrodes faster (synergy) is not in it. It adds where nothing
    rubs too.
    """

    needs: ClassVar[tuple[str, ...]] = ()
    depth_rate: float  # [m/s of calendar time] c
    calendar_per_service: float = 1.0  # [-] calendar time over service time; above 1 where the plant idles

    def __post_init__(self) -> None:
        require("depth_rate", self.depth_rate, 0.0, math.inf)
        require("calendar_per_service", self.calendar_per_service, 1.0, math.inf)

    def addition(self) -> float:
        """[m/s] depth for each second of service"""
        return self.depth_rate * self.calendar_per_service

    def modify(self, rate: np.ndarray, loads: FacetLoads, liner: WornLiner) -> np.ndarray:
        """The rate (b, f) [m/s] plus corrosion."""
        return rate + self.addition()


# By load: where the law's exponents are not those of the pair of materials.


@dataclass(frozen=True)
class PressureExponent(FactorEffect):
    """A rate not in proportion to pressure: (p/p0)^(n - 1), so k p v becomes k p0 v (p/p0)^n.

    **Source** generalised Archard law, p^n v (COMSOL, Abaqus). **Valid for** the range of pressure that n was fitted in; p is
    the mean over the facet, which is below that in the contacts. Where nothing presses the factor is 1 (n < 1) or 0.
    """

    needs: ClassVar[tuple[str, ...]] = ("pressure",)
    exponent: float  # [-] n
    reference: float  # [Pa] p0

    def __post_init__(self) -> None:
        require("exponent", self.exponent, 0.0, math.inf)
        require("reference", self.reference, 0.0, math.inf, open_below=True)

    def factor(self, *, pressure: Any) -> Any:
        """[-] by pressure [Pa]"""
        return power(np.asarray(pressure) / self.reference, self.exponent - 1.0)


@dataclass(frozen=True)
class SpeedExponent(FactorEffect):
    """A rate not in proportion to speed: (v/v0)^m on top of the law's own power of speed.

    **Source** erosion goes as v^2 to v^2.6 (Finnie 2, Oka 2.3, DNV 2.6), sliding as v; m is the difference. **Valid for** the
    range of speed that m was fitted in. Where nothing slips the factor is 1 (m < 0) or 0.
    """

    needs: ClassVar[tuple[str, ...]] = ("slip_speed",)
    exponent: float  # [-] m
    reference: float  # [m/s] v0

    def __post_init__(self) -> None:
        require("exponent", self.exponent, -math.inf, math.inf)
        require("reference", self.reference, 0.0, math.inf, open_below=True)

    def factor(self, *, slip_speed: Any) -> Any:
        """[-] by slip speed [m/s]"""
        return power(np.asarray(slip_speed) / self.reference, self.exponent)


@dataclass(frozen=True)
class ImpactAngleCurve(FactorEffect):
    """A measured curve over the angle of impact: straight lines between points.

    **Source** a test of the material at some angles, over what the law says there. **Valid for** facets that are hit from about
    one side: the mean angle of a facet stands for all impacts on it; a law of impact that knows the angle does better.
    """

    needs: ClassVar[tuple[str, ...]] = ("impact_angle",)
    angle: tuple[float, ...]  # [rad] rising, 0 grazing
    ratio: tuple[float, ...]  # [-]

    def __post_init__(self) -> None:
        require_steps("ImpactAngleCurve", self.angle, self.ratio, least=0.0)

    def factor(self, *, impact_angle: Any) -> Any:
        """[-] by angle [rad]"""
        return np.interp(impact_angle, self.angle, self.ratio)


@dataclass(frozen=True)
class SlipShare(FactorEffect):
    """Three-body wear: grains that roll wear `rolling_ratio` times what grains that slide do; a straight line between.

    The share that slides is the mobilised friction over the coefficient of friction: rolling grains pull little.

    **Source** two- against three-body abrasion, Rabinowicz, Dunn and Russell, Wear 4 (1961) 345-355: about a tenth. **Valid
    for** flow in one direction; in flow to and fro the impulses cancel and grains seem to roll.
    """

    needs: ClassVar[tuple[str, ...]] = ("mobilised_friction",)
    rolling_ratio: float  # [-]
    friction: float  # [-] coefficient of grain on liner

    def __post_init__(self) -> None:
        require("rolling_ratio", self.rolling_ratio, 0.0, math.inf)
        require("friction", self.friction, 0.0, math.inf, open_below=True)

    def factor(self, *, mobilised_friction: Any) -> Any:
        """[-] by tangential over normal impulse [-]"""
        sliding = np.clip(np.asarray(mobilised_friction) / self.friction, 0.0, 1.0)
        return self.rolling_ratio + (1.0 - self.rolling_ratio) * sliding


# By place.


@dataclass(frozen=True)
class BuildUp(FactorEffect):
    """Material that sticks covers a round patch: the rate inside is multiplied by `ratio` once `since` has passed.

    **Source** rock boxes and dead corners, ratio near 0. **Valid for** a patch that stays; seen in surveys as a border without
    transition.
    """

    needs: ClassVar[tuple[str, ...]] = ("position", "throughput")
    centre: tuple[float, float, float]  # [m]
    radius: float  # [m]
    ratio: float = 0.0  # [-]
    since: float = 0.0  # [kg] throughput from which on it is there

    def __post_init__(self) -> None:
        require("radius", self.radius, 0.0, math.inf)
        require("ratio", self.ratio, 0.0, math.inf)

    def factor(self, *, position: Any, throughput: Any) -> Any:
        """[-] by position (..., 3) [m] and throughput [kg]"""
        near = np.linalg.norm(np.asarray(position) - self.centre, axis=-1) <= self.radius
        return np.where(near & (np.asarray(throughput) >= self.since), self.ratio, 1.0)


@dataclass(frozen=True)
class DeadZone(FactorEffect):
    """Material that stands where it is slow covers the liner: the rate is multiplied by `ratio` below a slip speed.

    **Source**, **Valid for** as `BuildUp`; here the flow says where. Facets that nothing touches count as slow.
    """

    needs: ClassVar[tuple[str, ...]] = ("slip_speed",)
    slip_speed: float  # [m/s]
    ratio: float = 0.0  # [-]

    def __post_init__(self) -> None:
        require("slip_speed", self.slip_speed, 0.0, math.inf)
        require("ratio", self.ratio, 0.0, math.inf)

    def factor(self, *, slip_speed: Any) -> Any:
        """[-] by slip speed [m/s]"""
        return np.where(np.asarray(slip_speed) < self.slip_speed, self.ratio, 1.0)


@dataclass(frozen=True)
class LateralBias(FactorEffect):
    """Feed that comes in on one side: 1 + s ((x - x0) . side), never below 0.

    **Source** the first moment of an off-centre load. **Valid for** a bias that is there all the time; a tilted scan looks
    alike but does not grow.
    """

    needs: ClassVar[tuple[str, ...]] = ("position",)
    slope: float  # [1/m] s
    side: tuple[float, float, float]  # direction across the flow
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m] x0, on the middle line

    def __post_init__(self) -> None:
        require("slope", self.slope, -math.inf, math.inf)
        unit(self.side)

    def factor(self, *, position: Any) -> Any:
        """[-] by position (..., 3) [m]"""
        return np.maximum(1.0 + self.slope * (np.asarray(position) - self.centre) @ unit(self.side), 0.0)


@dataclass(frozen=True)
class AngularityLoss(FactorEffect):
    """Grains lose their edges on the way: exp(-s/s0), s the way along the flow from its start; before it 1.

    **Source** exponential rounding with distance (Sternberg's law, of river gravel). **Valid for** one pass over a liner whose
    flow keeps its direction; s is measured along a straight line, shorter than the way around a bend.
    """

    needs: ClassVar[tuple[str, ...]] = ("position",)
    length: float  # [m] s0
    along: tuple[float, float, float]  # direction of the flow
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m]

    def __post_init__(self) -> None:
        require("length", self.length, 0.0, math.inf, open_below=True)
        unit(self.along)

    def factor(self, *, position: Any) -> Any:
        """[-] by position (..., 3) [m]"""
        way = (np.asarray(position) - self.start) @ unit(self.along)
        return np.exp(-np.maximum(way, 0.0) / self.length)


# By whatever carries the residual, where no formula of the library does.


@dataclass(frozen=True)
class FactorCurve(FactorEffect):
    """A tabulated effect, which has no formula: straight lines between points over one feature, constant beyond.

    **Source** a diagnosis, or a test. **Valid for** the range of the feature that it was found in; it says what carries the difference,
    not why.
    """

    feature: str  # of `wearfem.wear.features`, or a column of the survey
    at: tuple[float, ...]  # in SI, rising
    ratio: tuple[float, ...]  # [-]
    axis: int = -1  # of a position: 0, 1 or 2
    log: Log | None = None  # of a feature that particles do not tell, for a run

    def __post_init__(self) -> None:
        if not self.feature:
            raise UserError(
                "a FactorCurve was given no feature; name the quantity that the factor depends on."
            )
        require_steps("FactorCurve", self.at, self.ratio, least=0.0)

    @property
    def needs(self) -> tuple[str, ...]:  # type: ignore[override]
        """The one feature"""
        return (self.feature,)

    def known(self, loads: FacetLoads, liner: WornLiner) -> dict[str, Any]:
        """From the log if there is one, at the liner's service time."""
        return logged(self.feature, self.log, loads, liner)

    def factor(self, **known: Any) -> Any:
        """[-] by the feature"""
        value = np.asarray(known[self.feature])
        return np.interp(value if self.axis < 0 else value[..., self.axis], self.at, self.ratio)
