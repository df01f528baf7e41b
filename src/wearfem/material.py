"""What bodies are made of, and what happens where two of them touch."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from wearfem.errors import UserError


@dataclass(frozen=True)
class Material:
    """An isotropic elastic solid, with the contact coefficients it has against its own kind.

    Against another material without an `Interaction` of its own, restitution and both frictions are mixed by the
    geometric mean of the two materials' values (the rule of LAMMPS ``pair_style granular``, mixing "geometric").
    """

    name: str
    density: float  # [kg/m3]
    shear_modulus: float  # [Pa]
    poisson_ratio: float  # [-]
    restitution: float = 0.5  # [-] rebound speed over approach speed, in (0, 1]
    friction: float = 0.5  # [-] Coulomb, static and sliding
    rolling_friction: float = 0.0  # [-] torque limit over (normal force x effective radius)

    def __post_init__(self) -> None:
        _check(self.density > 0, self.name, "density", self.density, "above 0 kg/m3")
        _check(self.shear_modulus > 0, self.name, "shear_modulus", self.shear_modulus, "above 0 Pa")
        _check(-1 < self.poisson_ratio <= 0.5, self.name, "poisson_ratio", self.poisson_ratio, "in (-1, 0.5]")
        _check_contact(self.name, self.restitution, self.friction, self.rolling_friction)

    @property
    def young_modulus(self) -> float:
        """E = 2 G (1 + nu) [Pa]."""
        return 2.0 * self.shear_modulus * (1.0 + self.poisson_ratio)


@dataclass(frozen=True)
class Interaction:
    """Contact coefficients of one pair of materials, measured or calibrated; it overrides the mixing rule."""

    first: Material
    second: Material
    restitution: float  # [-]
    friction: float  # [-]
    rolling_friction: float = 0.0  # [-]

    def __post_init__(self) -> None:
        label = f"{self.first.name}/{self.second.name}"
        _check_contact(label, self.restitution, self.friction, self.rolling_friction)


def _check(holds: bool, name: str, what: str, given: float, expected: str) -> None:
    if not holds:
        raise UserError(f"{name}: {what} is {given!r}; it must be {expected}.")


def _check_contact(name: str, restitution: float, friction: float, rolling_friction: float) -> None:
    _check(0 < restitution <= 1, name, "restitution", restitution, "in (0, 1]")
    _check(0 <= friction < math.inf, name, "friction", friction, "0 or more")
    _check(0 <= rolling_friction < math.inf, name, "rolling_friction", rolling_friction, "0 or more")


class PairTable(NamedTuple):
    """Contact constants of every ordered pair of materials, shape (k, k); row and column are material numbers.

    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2,  1/G* = (2 - nu1)/G1 + (2 - nu2)/G2  (Johnson 1985, ch. 4 and 7),
    damping ratio: see `damping_ratio`.
    """

    effective_modulus: np.ndarray  # (k, k) [Pa]
    effective_shear_modulus: np.ndarray  # (k, k) [Pa]
    damping_ratio: np.ndarray  # (k, k) [-]
    friction: np.ndarray  # (k, k) [-]
    rolling_friction: np.ndarray  # (k, k) [-]


def restitution_of(damping_ratio: float) -> float:
    """Rebound over impact speed of a damped contact that never pulls [-].

    e = exp(-2 b arccos b / sqrt(1 - b^2)) for b < 1, exp(-2 b arcosh b / sqrt(b^2 - 1)) above (Schwager and Poeschel 2007 for the
    linear spring). It holds for Hertz contacts with the dashpot of `HertzMindlin` too, which turn into the linear
    oscillator by a change of variables (Antypov and Elliott 2011).
    """
    b = damping_ratio
    if abs(b - 1.0) < 1e-9:
        return math.exp(-2.0)
    if b < 1.0:
        return math.exp(-2.0 * b * math.acos(b) / math.sqrt(1.0 - b * b))
    return math.exp(-2.0 * b * math.acosh(b) / math.sqrt(b * b - 1.0))


def damping_ratio(restitution: float) -> float:
    """The damping ratio [-] with which a contact that never pulls rebounds at `restitution`; 0 for an elastic impact."""
    if restitution == 1.0:
        return 0.0
    return float(
        brentq(
            lambda b: math.log(restitution_of(b) / restitution),
            0.0,
            1.0 - 100.0 * math.log(restitution),
            xtol=1e-14,
        )
    )


def pair_table(materials: Sequence[Material], interactions: Sequence[Interaction] = ()) -> PairTable:
    """Constants for every pair of `materials`; pairs without an interaction are mixed."""
    given = {frozenset((one.first, one.second)): one for one in interactions}
    for one in interactions:
        for material in (one.first, one.second):
            if material not in materials:
                raise UserError(
                    f"The interaction {one.first.name}/{one.second.name} names {material.name}, which no particle or "
                    f"surface is made of; the materials are {', '.join(m.name for m in materials)}."
                )
    count = len(materials)
    table = PairTable(*(np.empty((count, count)) for _ in PairTable._fields))
    for i, a in enumerate(materials):
        for j, b in enumerate(materials):
            pair = given.get(frozenset((a, b)))
            if pair is None:
                pair = Interaction(
                    a,
                    b,
                    restitution=math.sqrt(a.restitution * b.restitution),
                    friction=math.sqrt(a.friction * b.friction),
                    rolling_friction=math.sqrt(a.rolling_friction * b.rolling_friction),
                )
            compliance = (1.0 - a.poisson_ratio) / (2.0 * a.shear_modulus)
            compliance += (1.0 - b.poisson_ratio) / (2.0 * b.shear_modulus)
            shear_compliance = (2.0 - a.poisson_ratio) / a.shear_modulus + (
                2.0 - b.poisson_ratio
            ) / b.shear_modulus
            table.effective_modulus[i, j] = 1.0 / compliance
            table.effective_shear_modulus[i, j] = 1.0 / shear_compliance
            table.damping_ratio[i, j] = damping_ratio(pair.restitution)
            table.friction[i, j] = pair.friction
            table.rolling_friction[i, j] = pair.rolling_friction
    return table
