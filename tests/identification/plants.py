"""Virtual plants: surveys with a hidden effect, made by their own equations (an explicit march in small steps, nothing from wearfem).

The numbers below are a choice made once: a liner that loses 5 to 25 mm at 40 points over about 1000 kt, read by an ultrasonic gauge.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

SUBSTEPS = 60  # explicit steps between two occasions


@dataclass
class Plant:
    """What a survey of the plant looks like, in the units of a survey file, and what nobody is told."""

    name: str
    truth: tuple[str, ...]  # effect classes that count as right; empty for none
    point: np.ndarray  # (p, 3) m
    tonnage: np.ndarray  # (o,) kt
    exposure: np.ndarray  # (p,)
    clean: np.ndarray  # (p, o) mm worn
    reading: np.ndarray  # (p, o) mm as read
    sigma: float  # mm
    point_column: dict[str, np.ndarray] = field(default_factory=dict)  # (p,)
    occasion_column: dict[str, np.ndarray] = field(default_factory=dict)  # (o,)
    parameter: dict[str, float] = field(default_factory=dict)

    def write(self, folder: Path) -> tuple[Path, Path]:
        """Survey and exposure as CSV files."""
        folder.mkdir(parents=True, exist_ok=True)
        survey, exposure = folder / "survey.csv", folder / "exposure.csv"
        head = [
            "point",
            "occasion",
            "tonnage_kt",
            "depth_mm",
            "sigma_mm",
            "x_m",
            "y_m",
            "z_m",
            *self.occasion_column,
        ]
        rows = [",".join(head)]
        for j in range(len(self.tonnage)):
            for i in range(len(self.point)):
                more = [column[j] for column in self.occasion_column.values()]
                values = [self.tonnage[j], self.reading[i, j], self.sigma, *self.point[i], *more]
                rows.append(f"P{i:03d},{j + 1}," + ",".join(f"{value:.6g}" for value in values))
        survey.write_text("\n".join(rows) + "\n")
        rows = [",".join(["point", "exposure", *self.point_column])]
        for i in range(len(self.point)):
            values = [self.exposure[i], *(column[i] for column in self.point_column.values())]
            rows.append(f"P{i:03d}," + ",".join(f"{value:.6g}" for value in values))
        exposure.write_text("\n".join(rows) + "\n")
        return survey, exposure


Rate = Callable[[np.ndarray, float, int], np.ndarray]  # depth (p,) mm, tonnage kt, interval -> factor (p,)


def march(exposure: np.ndarray, tonnage: np.ndarray, factor: Rate, added: Rate | None = None) -> np.ndarray:
    """Depth (p, o) [mm]: d' = exposure x factor + added, explicit midpoint steps"""
    depth, before = np.zeros(len(exposure)), 0.0
    out = np.empty((len(exposure), len(tonnage)))
    for j, after in enumerate(tonnage):
        h = (after - before) / SUBSTEPS
        for i in range(SUBSTEPS):
            at = before + i * h

            def slope(d: np.ndarray, t: float, j: int = j) -> np.ndarray:
                return exposure * factor(d, t, j) + (0.0 if added is None else added(d, t, j))

            half = depth + 0.5 * h * slope(depth, at + 1e-9 * h)
            depth = depth + h * slope(half, at + 0.5 * h)
        out[:, j] = depth
        before = after
    return out


def plant(
    name: str, seed: int, *, noise: float = 0.1, points: int = 40, occasions: int = 8, scatter: float = 0.0,
    book: float = 0.0, campaign_zero: float = 0.0, wrong: int = 0,
) -> Plant:  # fmt: skip
    """A plant by name; see `NAMES`.

    `noise` [mm] of the gauge; `scatter` [-] of the rate between places; `book` [-] of the tonnage book in each interval;
    `campaign_zero` [mm] of each campaign; `wrong` readings are typing errors of 3 mm.
    """
    rng = np.random.default_rng([seed, NAMES.index(name)])
    across = max(2, round(np.sqrt(points / 2.5)))
    along = -(-points // across)
    x, y = np.meshgrid(np.linspace(0.2, 3.8, along), np.linspace(-0.75, 0.75, across), indexing="ij")
    x, y = x.ravel()[:points], y.ravel()[:points]
    where = np.stack(
        [x + rng.normal(0, 0.03, points), y + rng.normal(0, 0.02, points), np.zeros(points)], axis=1
    )
    end = 1000.0
    tonnage = np.round(
        end * (np.arange(1, occasions + 1) + rng.uniform(-0.25, 0.25, occasions)) / occasions, 1
    )
    x, y = where[:, 0], where[:, 1]
    # pressure and speed cross in the exposure, so neither is the exposure over again
    pressure = (
        40e3 * np.exp(-((x - 2.2) ** 2) / 1.6) * (1 + 0.3 * np.cos(3 * y)) * rng.uniform(0.8, 1.25, points)
        + 8e3
    )
    speed = (1.2 + 0.7 * x) * rng.uniform(0.85, 1.15, points)
    exposure = pressure * speed
    exposure = np.round(exposure / exposure.mean(), 6) * 12.0e-3  # mm/kt
    if name in SAME_EXPOSURE:
        exposure = np.full(points, 15.0e-3)
    angle = np.clip(55.0 - 12.0 * x + rng.normal(0, 4.0, points), 8.0, 80.0)  # deg
    rolling = np.clip(
        0.5 + 0.35 * np.sin(1.7 * x + 1.0) * np.cos(2.0 * y) + rng.normal(0, 0.06, points), 0.03, 0.97
    )
    friction = 0.46 * (1.0 - rolling)  # tangential over normal impulse
    days = np.round(
        tonnage / end * 900.0 * (1 + 0.25 * np.sin(2.2 * tonnage / end * np.pi)), 0
    )  # plant idles at times
    days = np.maximum.accumulate(days)
    ore = 900.0 + 200.0 * rng.uniform(-1, 1, occasions)  # HV
    warm = (
        18.0
        + 14.0 * np.sin(2 * np.pi * (tonnage / end * 2.5 + rng.uniform()))
        + rng.normal(0, 1.5, occasions)
    )  # C
    scale = float(rng.uniform(0.9, 1.1))
    per_point = {
        "pressure_pa": pressure,
        "slip_speed_m_s": speed,
        "impact_angle_deg": angle,
        "mobilised_friction": friction,
    }
    per_occasion = {"days": days, "ore_hardness_hv": ore, "temperature_c": warm}
    truth: tuple[str, ...] = ()
    parameter: dict[str, float] = {}
    zero = np.zeros(occasions)
    added: Rate | None = None

    def even(d: np.ndarray, t: float, j: int) -> np.ndarray:
        return np.ones(points)

    factor: Rate = even
    if name in ("hardness_gradient", "same_exposure"):
        truth, parameter = ("HardnessGradient",), {"loss_per_mm": float(rng.uniform(0.018, 0.03))}
        factor = lambda d, t, j: 1.0 / np.maximum(1.0 - parameter["loss_per_mm"] * d, 0.3)  # noqa: E731
    elif name == "overlay":
        truth, parameter = (
            ("Overlay",),
            {"thickness_mm": float(rng.uniform(3.0, 6.0)), "ratio": float(rng.uniform(1.6, 2.4))},
        )
        factor = lambda d, t, j: np.where(d < parameter["thickness_mm"], 1.0, parameter["ratio"])  # noqa: E731
    elif name == "running_in":
        truth, parameter = (
            ("RunningIn",),
            {"excess": float(rng.uniform(0.7, 1.3)), "depth_mm": float(rng.uniform(1.0, 2.5))},
        )
        factor = lambda d, t, j: 1.0 + parameter["excess"] * np.exp(-d / parameter["depth_mm"])  # noqa: E731
    elif name == "ore_change":
        truth = ("OreChange",)
        parameter = {"at_kt": float(rng.uniform(0.35, 0.65) * end), "ratio": float(rng.choice([0.7, 1.4]))}
        factor = lambda d, t, j: np.full(points, 1.0 if t < parameter["at_kt"] else parameter["ratio"])  # noqa: E731
    elif name == "ore_hardness":
        truth, parameter = ("OreHardness",), {"exponent": float(rng.uniform(1.0, 2.0))}
        factor = lambda d, t, j: np.full(points, (ore[j] / 900.0) ** parameter["exponent"])  # noqa: E731
    elif name == "temperature":
        truth, parameter = ("Temperature",), {"softening": float(rng.uniform(0.01, 0.02))}
        factor = lambda d, t, j: np.full(points, np.exp(parameter["softening"] * (warm[j] - 18.0)))  # noqa: E731
    elif name == "corrosion":
        truth, parameter = ("Corrosion",), {"um_per_day": float(rng.uniform(2.0, 4.0))}
        before = np.concatenate([[0.0], tonnage[:-1]])
        daily = np.diff(days, prepend=0.0) / (tonnage - before)  # days per kt in each interval
        added = lambda d, t, j: np.full(points, 1e-3 * parameter["um_per_day"] * daily[j])  # noqa: E731
    elif name == "lateral_bias":
        truth, parameter = ("LateralBias",), {"slope": float(rng.choice([-1, 1]) * rng.uniform(0.25, 0.45))}
        factor = lambda d, t, j: 1.0 + parameter["slope"] * y  # noqa: E731
    elif name == "pressure_exponent":
        truth, parameter = ("PressureExponent",), {"exponent": float(rng.choice([0.7, 1.35]))}
        factor = lambda d, t, j: (pressure / 30e3) ** (parameter["exponent"] - 1.0)  # noqa: E731
    elif name == "speed_exponent":
        truth, parameter = ("SpeedExponent",), {"exponent": float(rng.uniform(0.5, 1.0))}
        factor = lambda d, t, j: (speed / 2.5) ** parameter["exponent"]  # noqa: E731
    elif name == "impact_angle":
        truth = ("ImpactAngleCurve",)
        factor = lambda d, t, j: 0.6 + 0.8 * np.sin(np.radians(angle) * 2.0) ** 2  # noqa: E731
    elif name == "three_body":
        truth, parameter = ("SlipShare",), {"rolling_ratio": float(rng.uniform(0.2, 0.5))}
        factor = lambda d, t, j: parameter["rolling_ratio"] * rolling + (1.0 - rolling)  # noqa: E731
    elif name == "build_up":
        truth = ("BuildUp",)
        middle = where[rng.integers(points)] + rng.normal(0, 0.1, 3)
        near = np.hypot(x - middle[0], y - middle[1])
        covered = near <= np.sort(near)[max(2, points // 8)]
        parameter = {"ratio": float(rng.uniform(0.1, 0.4))}
        factor = lambda d, t, j: np.where(covered, parameter["ratio"], 1.0)  # noqa: E731
    elif name == "zero_error":
        campaign = int(rng.integers(1, occasions))
        parameter = {
            "occasion": campaign + 1.0,
            "zero_mm": float(rng.choice([-1, 1]) * rng.uniform(0.4, 0.6)),
        }
        zero[campaign] = parameter["zero_mm"]
    elif name == "two_effects":
        truth = ("HardnessGradient", "OreHardness")
        parameter = {"loss_per_mm": float(rng.uniform(0.02, 0.03)), "exponent": float(rng.uniform(1.2, 2.0))}
        factor = lambda d, t, j: (  # noqa: E731
            (ore[j] / 900.0) ** parameter["exponent"] / np.maximum(1.0 - parameter["loss_per_mm"] * d, 0.3)
        )
    elif name == "outside_library":
        truth = ("FactorCurve",)  # a hump over depth: a soft band inside the plate
        parameter = {"middle_mm": float(rng.uniform(4.0, 6.0))}
        factor = lambda d, t, j: 1.0 + 1.2 * np.exp(-(((d - parameter["middle_mm"]) / 1.5) ** 2))  # noqa: E731
    own = np.random.default_rng(
        [seed, NAMES.index(name), 1]
    )  # apart, so that plants without these stay as they are
    uneven = np.exp(own.normal(0.0, scatter, points))
    booked = 1.0 + own.normal(0.0, book, occasions)  # what was carried, over what the book says
    zero = zero + own.normal(0.0, campaign_zero, occasions)
    depth = march(scale * exposure * uneven, tonnage, lambda d, t, j: factor(d, t, j) * booked[j], added)
    reading = np.round(depth + zero + rng.normal(0.0, noise, depth.shape), 3)
    typed = own.choice(reading.size, wrong, replace=False)
    reading.flat[typed] += 3.0 * own.choice([-1.0, 1.0], wrong)
    return Plant(
        name, truth, where, tonnage, exposure, depth, reading, noise, per_point, per_occasion, parameter
    )


SAME_EXPOSURE = ("same_exposure",)
NAMES = (
    "none", "hardness_gradient", "overlay", "running_in", "ore_change", "ore_hardness", "temperature", "corrosion",
    "lateral_bias", "pressure_exponent", "speed_exponent", "impact_angle", "three_body", "build_up", "zero_error",
    "two_effects", "outside_library", "same_exposure",
)  # fmt: skip
SEPARABLE = tuple(
    name for name in NAMES if name not in ("none", "zero_error", "same_exposure", "outside_library")
)
