"""More virtual plants, written after the diagnosis was: noise that neighbours share, points elsewhere than told, shapes that wear, two
mechanisms, and laws that are not in the library. Nothing from wearfem; the numbers are a choice made once.
"""

from pathlib import Path

import numpy as np
from identification import plants
from identification.plants import Plant, march

END = 1000.0  # kt


class TwoMechanisms(Plant):
    """A plant whose exposure is told by mechanism."""

    def write(self, folder: Path) -> tuple[Path, Path]:
        survey, exposure = super().write(folder)
        exposure.write_text(exposure.read_text().replace("point,exposure,", "point,exposure_sliding,", 1))
        return survey, exposure


def field(rng: np.random.Generator, where: np.ndarray, length: float) -> np.ndarray:
    """(p,) of unit variance: a Gaussian field with this correlation length [m]"""
    apart = np.linalg.norm(where[:, None] - where, axis=2)
    root = np.linalg.cholesky(np.exp(-0.5 * (apart / length) ** 2) + 1e-9 * np.eye(len(where)))
    return root @ rng.normal(size=len(where))


def plant(
    name: str, seed: int, *, noise: float = 0.1, points: int = 40, occasions: int = 8, length: float = 0.8
) -> Plant:
    """A plant by name; see `NAMES`. `length` [m] is that of what neighbours have in common."""
    rng = np.random.default_rng([seed, 77, NAMES.index(name)])
    plain = plants.plant("none", seed + 5000, noise=noise, points=points, occasions=occasions)
    where, tonnage = plain.point, plain.tonnage
    x, y = where[:, 0], where[:, 1]
    exposure, told, clean = plain.exposure, plain.exposure, plain.clean
    columns, log = dict(plain.point_column), dict(plain.occasion_column)
    shared = np.zeros_like(clean)
    truth: tuple[str, ...] = ()
    parameter: dict[str, float] = {}
    if name in ("bent_scans", "bent_scans_gradient"):
        shared = np.stack([field(rng, where, length) for _ in tonnage], axis=1) * 2.0 * noise
    if name in ("bent_scans_gradient", "gradient"):
        truth, parameter = ("HardnessGradient",), {"loss_per_mm": float(rng.uniform(0.018, 0.03))}
        clean = march(
            exposure, tonnage, lambda d, t, j: 1.0 / np.maximum(1.0 - parameter["loss_per_mm"] * d, 0.3)
        )
    if name == "wrong_map":  # the model's map of exposure is off by 5 %, smoothly
        clean = march(
            exposure * (1.0 + 0.05 * field(rng, where, length)), tonnage, lambda d, t, j: np.ones(points)
        )
    if (
        name == "elsewhere"
    ):  # all points lie some centimetres beside where they are told to be, each by a little more

        def bump(where: np.ndarray) -> np.ndarray:
            return 12e-3 * (0.3 + 1.2 * np.exp(-((where[:, 0] - 1.8) ** 2) / 0.5) * np.cos(0.9 * where[:, 1]))

        moved = where + np.append(rng.normal(0.0, 0.04, 2), 0.0) + rng.normal(0.0, 0.01, where.shape)
        told, clean = bump(where), march(bump(moved), tonnage, lambda d, t, j: np.ones(points))
        columns = {}
    if (
        name == "levelling"
    ):  # high places wear faster until all is level: what a place wears depends on how far its neighbours are
        near = np.exp(-0.5 * (np.linalg.norm(where[:, None] - where, axis=2) / 0.5) ** 2)
        near /= near.sum(axis=1, keepdims=True)
        clean = march(exposure, tonnage, lambda d, t, j: np.clip(1.0 + 0.05 * (near @ d - d), 0.2, 3.0))
    if name == "hollow":  # a hollow gathers the flow: wear makes wear, everywhere by its own shape
        gain = 0.02 + 0.03 * np.cos(1.3 * x + 2.0 * y) * rng.uniform(0.5, 1.0, points)
        clean = march(exposure, tonnage, lambda d, t, j: np.clip(1.0 + gain * d, 0.3, 3.0))
    if name == "hollow_alike":  # the same everywhere: no reading can tell that from a softer core
        clean = march(exposure, tonnage, lambda d, t, j: 1.0 + 0.03 * d)
    if (
        name == "transition"
    ):  # ore that is harder than the steel cuts, softer ore rubs: a step over the ratio of hardness
        truth = ("OreHardness",)
        ore = log["ore_hardness_hv"]
        middle = float(rng.uniform(850.0, 950.0))
        clean = march(
            exposure,
            tonnage,
            lambda d, t, j: np.full(points, 0.4 + 0.9 / (1.0 + np.exp(-(ore[j] - middle) / 25.0))),
        )
    if name == "tonnage_exponent":  # depth goes as tonnage to a power
        parameter = {"power": float(rng.choice([0.75, 1.3]))}
        n = parameter["power"]
        clean = exposure[:, None] * END * (tonnage / END) ** n
    if name in ("two_mechanisms", "two_mechanisms_gradient"):
        impact = 12e-3 * np.exp(-((x - 0.6) ** 2) / 0.4) * rng.uniform(0.8, 1.25, points)
        parameter = {"sliding": 0.7, "impact": 1.6}
        total = parameter["sliding"] * exposure + parameter["impact"] * impact
        columns = columns | {"exposure_impact": impact}
        loss = 0.0
        if name.endswith("gradient"):
            truth, loss = ("HardnessGradient",), float(rng.uniform(0.018, 0.03))
            parameter |= {"loss_per_mm": loss}
        clean = march(total, tonnage, lambda d, t, j: 1.0 / np.maximum(1.0 - loss * d, 0.3))
    reading = np.round(clean + shared + rng.normal(0.0, noise, clean.shape), 3)
    kind = TwoMechanisms if name.startswith("two_mechanisms") else Plant
    return kind(name, truth, where, tonnage, told, clean, reading, noise, columns, log, parameter)


NAMES = (
    "plain", "bent_scans", "wrong_map", "elsewhere", "gradient", "bent_scans_gradient", "levelling", "hollow", "hollow_alike",
    "transition", "tonnage_exponent", "two_mechanisms", "two_mechanisms_gradient",
)  # fmt: skip
NOTHING = ("plain", "bent_scans", "wrong_map", "elsewhere", "two_mechanisms")  # no physical effect is missing
SEPARABLE = ("gradient", "bent_scans_gradient", "two_mechanisms_gradient")
