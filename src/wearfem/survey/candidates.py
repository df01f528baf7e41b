"""Suspects: each effect of the library with its free parameters, how large they may reasonably be, and where a search begins.

A free parameter is searched in a coordinate without bounds that is normal (0, 1) before the data are seen; `Free.value` turns it into the
parameter. So the same lines serve as bounds, as start and as prior, and a suspect pays for each parameter that the data must fix.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import ndtr, ndtri

from wearfem.survey.history import History
from wearfem.wear import effects as library
from wearfem.wear.effect import FactorEffect
from wearfem.wear.effects import Corrosion, FactorCurve

Suspect = FactorEffect | Corrosion
KNOTS = 5  # of a free curve
GRID = 8  # places from point to point, along each side of a plan, where the middle of a patch may lie
CURVE_STEP = 0.4  # [-] standard deviation of the logarithm of a free curve from knot to knot
CURVE_PENALTY = 2.0  # nats: a curve that nobody can name must be 7 times more probable than an effect


@dataclass(frozen=True)
class Free:
    """A free parameter: its name, its unit in SI, and its value for a normal coordinate."""

    name: str
    unit: str
    value: Callable[[float], float]


@dataclass(frozen=True)
class Candidate:
    """A suspect.

    Parameters
    ----------
    name
        Of the effect; of a free curve the quantity too.
    free
        Its free parameters.
    build
        The effect for their values.
    starts
        (s, d) coordinates from which a search begins.
    penalty
        Nats taken off its log odds.
    twin
        Name of an effect of the library that is the same curve up to the coefficient.
    quantity
        What it depends on.
    share
        (k,) prior probability of each entry of a list (which points a patch covers) that the last coordinate numbers; none without a
        list. That coordinate stays where a start has put it, and the evidence is summed over the list.
    covers
        (k, l) plates that each entry acts on, where it does nothing to others and the same to all; entry k acts on every plate and
        entry k + 1 on none. So the readings of any entry follow from those two. Empty where entries are of another kind.
    """

    name: str
    free: tuple[Free, ...]
    build: Callable[[Sequence[float]], Suspect]
    starts: np.ndarray
    quantity: str
    penalty: float = 0.0
    twin: str = ""
    share: np.ndarray = field(default_factory=lambda: np.zeros(0))
    covers: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), bool))

    @property
    def frozen(self) -> int:
        """How many of the last coordinates stay where a start has put them"""
        return min(1, len(self.share))

    def effect(self, coordinate: np.ndarray) -> Suspect:
        """The effect at a coordinate (d,)."""
        return self.build([f.value(float(u)) for f, u in zip(self.free, coordinate, strict=True)])


def around(middle: float, width: float) -> Callable[[float], float]:
    """A parameter of either sign: normal."""
    return lambda u: middle + width * u


def above_zero(middle: float, width: float) -> Callable[[float], float]:
    """A parameter above zero: log-normal, `width` in natural logarithms."""
    return lambda u: middle * float(np.exp(np.clip(width * u, -12.0, 12.0)))


def between(low: float, high: float) -> Callable[[float], float]:
    """A parameter with two bounds: uniform."""
    return lambda u: low + (high - low) * float(np.clip(ndtr(u), 1e-6, 1.0 - 1e-6))


def product(*axes: Sequence[float]) -> np.ndarray:
    """All combinations of coordinates (s, d)."""
    return np.array(np.meshgrid(*axes, indexing="ij")).reshape(len(axes), -1).T


def candidates(past: History, deepest: float, knots: int = KNOTS) -> list[Candidate]:
    """All suspects that the columns of a survey allow; `deepest` [unit of depth] is the largest wear read."""
    return [
        *by_depth(deepest),
        *by_progress(past),
        *by_time(past, deepest),
        *by_log(past),
        *by_load(past, knots),
        *by_place(past),
    ]


def by_depth(deepest: float) -> list[Candidate]:
    """What the plate is made of."""
    excess = Free("excess", "-", above_zero(0.7, 0.8))
    loss = Free("loss", "1/m", above_zero(0.4 / deepest, 0.8))
    core = Free("core", "-", between(0.15, 0.98))
    layer = Free("thickness", "m", between(0.03 * deepest, 0.97 * deepest))
    ratio = Free("ratio", "-", lambda u: 1.0 + above_zero(0.7, 0.8)(u))
    in_depth = Free("depth", "m", above_zero(0.12 * deepest, 0.8))
    return [
        Candidate(
            "HardnessGradient", (loss, core), lambda v: library.HardnessGradient(v[0], v[1]),
            product([-1.0, 0.5], [-0.8, 0.6]), "depth",
        ),
        Candidate(
            "Overlay", (layer, ratio), lambda v: library.Overlay(v[0], v[1]),
            product([-1.3, -0.8, -0.4, 0.0, 0.4, 0.8], [0.0]), "depth",
        ),
        Candidate(
            "RunningIn", (excess, in_depth), lambda v: library.RunningIn(v[0], v[1]),
            product([0.0], [-1.0, 0.0, 1.0]), "depth", twin="WorkHardeningByDepth",
        ),
    ]  # fmt: skip


def by_progress(past: History) -> list[Candidate]:
    """What changes while service goes on, at all places alike."""
    first, last = float(past.begin.min()), float(past.end.max())
    ends = np.unique(past.end[past.end > past.begin])
    if len(ends) < 3:
        return []
    date = Free("throughput", "progress", between(first, last))
    ratio = Free("ratio", "-", above_zero(1.0, 0.4))
    excess = Free("excess", "-", above_zero(0.7, 0.8))
    scale = Free("throughput", "progress", above_zero(0.15 * (last - first), 0.8))
    middles = 0.5 * (
        np.append(first, ends[:-1]) + ends
    )  # readings bend where a date passes an occasion, so each interval has its best date
    return [
        Candidate(
            "OreChange", (date, ratio), lambda v: library.OreChange((v[0],), (v[1],)),
            product(ndtri((middles - first) / (last - first)).tolist(), [0.5]), "date",
        ),
        Candidate(
            "RunningInByThroughput", (excess, scale), lambda v: library.RunningInByThroughput(v[0], v[1]),
            product([0.0], [-0.7, 0.7]), "date",
        ),
    ]  # fmt: skip


def by_time(past: History, deepest: float) -> list[Candidate]:
    """What goes on while nothing rubs; without a calendar, service is taken to have been steady in time."""
    passed = past.calendar if past.calendar is not None else past.end - past.begin
    rate = deepest / float(passed.sum(axis=1).max())
    unit = "m/s" if past.calendar is not None else "m/progress"
    free = Free("depth_rate", unit, above_zero(0.1 * rate, 0.9))
    return [Candidate("Corrosion", (free,), lambda v: Corrosion(v[0]), np.zeros((1, 1)), "calendar time")]


def by_log(past: History) -> list[Candidate]:
    """What was written down in the course of service."""
    found = []
    ore = past.feature.get("ore_hardness")
    if ore is not None and _varies(ore) and ore.min() > 0.0:
        middle = float(np.median(ore))
        found.append(
            Candidate(
                "OreHardness", (Free("exponent", "-", around(0.0, 2.0)),),
                lambda v: library.OreHardness(v[0], middle), np.zeros((1, 1)), "ore_hardness",
            )
        )  # fmt: skip
    warm = past.feature.get("temperature")
    if warm is not None and _varies(warm):
        mean, width = float(np.mean(warm)), float(np.std(warm))
        found.append(
            Candidate(
                "Temperature", (Free("softening", "1/K", around(0.0, 0.35 / width)),),
                lambda v: library.Temperature(v[0], mean), np.zeros((1, 1)), "temperature",
            )
        )  # fmt: skip
    work = past.feature.get("impact_work")
    if work is not None and _varies(work) and work.min() >= 0.0:
        scale = float(np.median(work[work > 0.0]))
        found.append(
            Candidate(
                "WorkHardening",
                (Free("gain", "-", between(0.0, 1.0)), Free("work", "J/m2", above_zero(0.5 * scale, 1.0))),
                lambda v: library.WorkHardening(v[0], v[1]), product([0.0], [-1.0, 0.0, 1.0]), "impact_work",
            )
        )  # fmt: skip
    return found


def by_load(past: History, knots: int) -> list[Candidate]:
    """Where the law's exponents are not those of the pair of materials."""
    found = []
    pressure, speed = past.feature.get("pressure"), past.feature.get("slip_speed")
    if pressure is not None and _varies(pressure) and pressure.min() >= 0.0:
        p0 = float(np.median(pressure))
        found.append(
            Candidate(
                "PressureExponent", (Free("exponent", "-", lambda u: max(1.0 + 0.6 * u, 0.0)),),
                lambda v: library.PressureExponent(v[0], p0), np.zeros((1, 1)), "pressure",
            )
        )  # fmt: skip
    if speed is not None and _varies(speed) and speed.min() >= 0.0:
        v0 = float(np.median(speed))
        found.append(
            Candidate(
                "SpeedExponent", (Free("exponent", "-", around(0.0, 0.8)),),
                lambda v: library.SpeedExponent(v[0], v0), np.zeros((1, 1)), "slip_speed",
            )
        )  # fmt: skip
        slow = [float(np.quantile(speed, share)) for share in (0.08, 0.15, 0.25, 0.35)]
        found.append(
            Candidate(
                "DeadZone", (Free("ratio", "-", between(0.0, 1.0)), Free("slip_speed", "m/s", lambda u: slow[round(u)])),
                lambda v: library.DeadZone(v[1], v[0]), product([-0.5], [0.0, 1.0, 2.0, 3.0]), "slip_speed", share=np.full(4, 0.25),
            )
        )  # fmt: skip
    angle = past.feature.get("impact_angle")
    if angle is not None and _varies(angle):
        at = tuple(float(a) for a in _knots(angle, knots))
        found.append(
            Candidate(
                "ImpactAngleCurve", tuple(_ratio_at(f"{np.degrees(a):.0f}_deg") for a in at[1:]),
                lambda v: library.ImpactAngleCurve(at, _walk(v)), np.zeros((1, len(at) - 1)), "impact_angle",
            )
        )  # fmt: skip
    mobilised = past.feature.get("mobilised_friction")
    if mobilised is not None and _varies(mobilised) and mobilised.max() > 0.0:
        friction = float(mobilised.max())
        found.append(
            Candidate(
                "SlipShare", (Free("rolling_ratio", "-", above_zero(0.7, 0.9)),),
                lambda v: library.SlipShare(v[0], friction), np.zeros((1, 1)), "mobilised_friction",
            )
        )  # fmt: skip
    return found


def by_place(past: History) -> list[Candidate]:
    """Where something is: x along the flow, y across it."""
    position = past.feature.get("position")
    if position is None:
        return []
    place = np.unique(position[:, 0], axis=0)
    found = []
    if np.ptp(place[:, 1]) > 0.0:
        half, middle = 0.5 * float(np.ptp(place[:, 1])), 0.5 * float(place[:, 1].min() + place[:, 1].max())
        found.append(
            Candidate(
                "LateralBias", (Free("slope", "1/m", around(0.0, 0.25 / half)),),
                lambda v: library.LateralBias(v[0], (0.0, 1.0, 0.0), (0.0, middle, 0.0)), np.zeros((1, 1)), "position",
            )
        )  # fmt: skip
    if np.ptp(place[:, 0]) > 0.0:
        begin, way = float(place[:, 0].min()), float(np.ptp(place[:, 0]))
        found.append(
            Candidate(
                "AngularityLoss", (Free("length", "m", above_zero(2.0 * way, 0.8)),),
                lambda v: library.AngularityLoss(v[0], (1.0, 0.0, 0.0), (begin, 0.0, 0.0)), np.zeros((1, 1)), "position",
            )
        )  # fmt: skip
    if len(place) >= 8:
        found.append(_patch(position, float(past.begin.min()), float(past.end.max())))
    return found


def _patch(position: np.ndarray, first: float, last: float) -> Candidate:
    """A round patch about any place of a plan, that holds 2 to a third of the points; each set of points once.

    `position` (l, m, 3) of plates. The patch is there from the beginning, or from some progress between `first` and `last` on: three
    to two.
    """
    place = np.unique(position[:, 0], axis=0)
    middles, radii, share = _round_sets(place)
    middles = np.concatenate([middles, np.tile(place.mean(axis=0), (2, 1))])
    radii = np.append(radii, [2.0 * np.ptp(place, axis=0).sum(), 0.0])  # all of it
    middles[-1] += 4.0 * np.ptp(place, axis=0)  # and nothing
    number = Free("patch", "-", lambda u: u)

    def build(value: Sequence[float]) -> Suspect:
        x, y, z = middles[round(value[2])].tolist()
        return library.BuildUp((x, y, z), float(radii[round(value[2])]), value[0], value[1])

    covers = np.zeros((0, 0), bool)
    if (position == position[:, :1]).all():
        apart = np.linalg.norm(position[:, 0] - middles[:-2, None], axis=2)
        covers = apart <= radii[:-2, None]
    later = between(first - 1.5 * (last - first), last)
    since = Free("since", "progress", lambda u: max(later(u), 0.0))
    starts = product([-0.3], [0.0, 0.6, 1.1], np.arange(len(share), dtype=float).tolist())
    return Candidate(
        "BuildUp", (Free("ratio", "-", between(0.0, 1.0)), since, number), build, starts, "position", share=share, covers=covers,
    )  # fmt: skip


def _round_sets(place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sets of 2 to a third of the places (p, 3) that a circle can hold without the others, each once: middles (k, 3), radii, shares (k,).

    Middles lie on a grid that reaches half the spacing of points beyond the outermost (a liner does not end at its last marked point),
    and at the points; all radii are as probable. So a set is as probable as there are patches that cover it and no other, and a set that
    the grid misses has less than a cell of it.
    """
    low, high = place.min(axis=0), place.max(axis=0)
    beyond = 0.5 * (high - low) / np.sqrt(len(place))
    steps = int(np.ceil(GRID * np.sqrt(len(place))))
    grid = [
        np.linspace(a, b, steps if b > a else 1).tolist()
        for a, b in zip(low - beyond, high + beyond, strict=True)
    ]
    flat = min(len(axis) for axis in grid) == 1  # a plan has a grid; in space, points do
    middle = np.concatenate([place, product(*grid)]) if flat else place
    away = np.linalg.norm(middle[:, None] - place, axis=2)
    order = np.argsort(away, axis=1, kind="stable")
    far = np.take_along_axis(away, order, 1)
    middles, radii, weights = [], [], []
    for count in range(2, min(max(3, len(place) // 3), len(place) - 1) + 1):
        width = far[:, count] - far[:, count - 1]
        held = np.zeros(away.shape, bool)
        np.put_along_axis(held, order[:, :count], True, 1)
        _, first, which = np.unique(
            np.packbits(held[width > 0.0], axis=1), axis=0, return_index=True, return_inverse=True
        )
        own = np.flatnonzero(width > 0.0)[first]
        middles.append(middle[own])
        radii.append(0.5 * (far[own, count - 1] + far[own, count]))
        weights.append(np.bincount(which.ravel(), width[width > 0.0]))
    share = np.concatenate(weights)
    return np.concatenate(middles), np.concatenate(radii), share / share.sum()


def curves(past: History, depth: np.ndarray, knots: int = KNOTS) -> list[Candidate]:
    """A free curve over each single quantity: depth, progress, each axis, and every column that varies.

    `depth` are those at which there are readings. Impact angle has none: the effect of that name is such a curve.
    """
    found = [
        _curve(
            "depth",
            "m",
            0.5 * _knots(depth, knots)
            + 0.5 * np.linspace(0.0, 0.95 * depth.max(), len(_knots(depth, knots))),
        )
    ]
    ends = np.unique(past.end[past.end > past.begin])
    if len(ends) >= KNOTS:
        found.append(_curve("throughput", "progress", _knots(0.5 * (ends[1:] + ends[:-1]), knots)))
    for name, value in past.feature.items():
        if name == "position":
            for axis in range(3):
                if len(np.unique(value[..., axis])) >= KNOTS:
                    found.append(_curve(name, "m", _knots(value[..., axis], knots), axis))
        elif name != "impact_angle" and len(np.unique(value)) >= 3:
            found.append(_curve(name, "SI", _knots(value, knots)))
    return found


def _curve(feature: str, unit: str, at: np.ndarray, axis: int = -1) -> Candidate:
    label = feature if axis < 0 else "xyz"[axis]
    places = tuple(float(a) for a in at)
    return Candidate(
        f"FactorCurve({label})", tuple(_ratio_at(f"{a:.4g}") for a in places[1:]),
        lambda v: FactorCurve(feature, places, _walk(v), axis), np.zeros((1, len(places) - 1)),
        "date" if label == "throughput" else label, penalty=CURVE_PENALTY,
    )  # fmt: skip


def _ratio_at(place: str) -> Free:
    """A ratio of a curve; its coordinate is the step from the knot before"""
    return Free(f"ratio_at_{place}", "-", lambda u: u)


def log_steps(coordinate: Sequence[float] | np.ndarray) -> np.ndarray:
    """Steps of the logarithm of a curve from knot to knot: small ones are normal, large ones less rare (hyperbolic sine)"""
    width = CURVE_STEP * np.sqrt((KNOTS - 1) / len(coordinate))
    return width * np.sinh(np.clip(coordinate, -5.0, 5.0))


def _walk(coordinate: Sequence[float]) -> tuple[float, ...]:
    """Ratios at the knots of a curve; the first is 1"""
    return (1.0, *(float(r) for r in np.exp(np.clip(np.cumsum(log_steps(coordinate)), -13.0, 13.0))))


def _knots(value: np.ndarray, most: int) -> np.ndarray:
    """Places where a curve may bend: quantiles of what occurs"""
    distinct = np.unique(value)
    return (
        distinct if len(distinct) <= most else np.unique(np.quantile(distinct, np.linspace(0.0, 1.0, most)))
    )


def _varies(value: np.ndarray) -> bool:
    return float(np.ptp(value)) > 1e-9 * float(np.abs(value).max(initial=0.0))
