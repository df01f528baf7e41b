"""Two touching bodies and their normal impact in closed form: Hertz, damped Hertz, linear spring-dashpot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from scipy.special import gamma

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sphere:
    """A homogeneous elastic sphere: radius [m], density [kg/m3], elastic modulus [Pa], Poisson ratio [-]."""

    radius: float
    density: float
    elastic_modulus: float
    poisson_ratio: float

    @property
    def mass(self) -> float:
        """Mass [kg]: 4/3 pi R^3 rho."""
        return 4.0 / 3.0 * math.pi * self.radius**3 * self.density

    @property
    def inertia(self) -> float:
        """Moment of inertia about a diameter [kg.m2]: 2/5 m R^2."""
        return 0.4 * self.mass * self.radius**2

    @property
    def spin_per_impulse(self) -> float:
        """Change of angular velocity by a unit tangential impulse at the surface [rad/(N.s2)]: R / I."""
        return self.radius / self.inertia


@dataclass(frozen=True)
class Plane:
    """A fixed half-space; the default is rigid. Elastic modulus [Pa], Poisson ratio [-]."""

    elastic_modulus: float = math.inf
    poisson_ratio: float = 0.3
    radius: float = math.inf
    mass: float = math.inf
    spin_per_impulse: float = 0.0


Body = Sphere | Plane


@dataclass(frozen=True)
class ContactPair:
    """What two touching bodies amount to in an impact.

    Attributes
    ----------
    effective_radius : float
        R* [m], 1/R* = 1/R1 + 1/R2.
    effective_mass : float
        m* [kg], 1/m* = 1/m1 + 1/m2.
    effective_modulus : float
        E* [Pa], 1/E* = sum (1 - nu^2)/E = sum (1 - nu)/(2 G).
    effective_shear_modulus : float
        G* [Pa], 1/G* = sum (2 - nu)/G.
    tangential_mass : float
        Inertia against slip [kg], 1/m_t = sum (1/m + R^2/I); 2/7 m* for homogeneous spheres and planes.

    Notes
    -----
    **Source** Johnson (1985), Contact Mechanics, sections 4.2 and 7.2; Maw, Barber and Fawcett (1976), Wear
    38, 101.
    """

    effective_radius: float
    effective_mass: float
    effective_modulus: float
    effective_shear_modulus: float
    tangential_mass: float

    @property
    def stiffness_ratio(self) -> float:
        """Tangential over normal tangent stiffness [-]: 8 G* a / (2 E* a).

        2(1 - nu)/(2 - nu) if one body is rigid or both are alike.
        """
        return 4.0 * self.effective_shear_modulus / self.effective_modulus

    @property
    def chi(self) -> float:
        """The one parameter of an elastic oblique impact [-]: half the stiffness ratio times m*/m_t.

        (1 - nu)(1 + 1/K^2)/(2 - nu) in **Source** Maw, Barber and Fawcett (1976), with K^2 = I/(m R^2).
        """
        return 0.5 * self.stiffness_ratio * self.effective_mass / self.tangential_mass


def contact_pair(first: Body, second: Body) -> ContactPair:
    """Combine two bodies into the constants of their contact (see `ContactPair`)."""
    bodies = (first, second)
    shear_moduli = [body.elastic_modulus / (2.0 * (1.0 + body.poisson_ratio)) for body in bodies]
    return ContactPair(
        effective_radius=1.0 / sum(1.0 / body.radius for body in bodies),
        effective_mass=1.0 / sum(1.0 / body.mass for body in bodies),
        effective_modulus=1.0 / sum((1.0 - body.poisson_ratio**2) / body.elastic_modulus for body in bodies),
        effective_shear_modulus=1.0
        / sum((2.0 - body.poisson_ratio) / shear for body, shear in zip(bodies, shear_moduli, strict=True)),
        tangential_mass=1.0
        / sum(
            1.0 / body.mass + (body.radius * body.spin_per_impulse if isinstance(body, Sphere) else 0.0)
            for body in bodies
        ),
    )


@dataclass(frozen=True)
class NormalImpact:
    """A normal impact in numbers: duration [s], largest force [N], largest overlap [m], v'/v [-]."""

    duration: float
    maximum_force: float
    maximum_overlap: float
    restitution: float


@dataclass(frozen=True)
class History:
    """A normal impact in time, each (n,): time [s], overlap [m], approach speed [m/s], force [N]."""

    time: Array
    overlap: Array
    approach_speed: Array
    force: Array


# -------------------------------------------------------------------------------------------- Hertz, elastic


def hertz_impact(pair: ContactPair, approach_speed: float) -> NormalImpact:
    """Elastic normal impact of two bodies by Hertz's law F = 4/3 E* sqrt(R*) d^(3/2).

    d_max = (15 m* v^2 / (16 E* sqrt(R*)))^(2/5),
    T = 4 sqrt(pi) Gamma(2/5) / (5 Gamma(9/10)) d_max/v = 2.9433 d_max/v.

    **Source** Johnson (1985), Contact Mechanics, section 11.4; Timoshenko and Goodier, Theory of Elasticity.
    **Valid for** impacts slow against the elastic wave speed and contacts small against R*.
    """
    stiffness = 4.0 / 3.0 * pair.effective_modulus * math.sqrt(pair.effective_radius)
    overlap = (1.25 * pair.effective_mass * approach_speed**2 / stiffness) ** 0.4
    factor = float(4.0 * math.sqrt(math.pi) * gamma(0.4) / (5.0 * gamma(0.9)))
    return NormalImpact(factor * overlap / approach_speed, stiffness * overlap**1.5, overlap, 1.0)


# ------------------------------------------------------------------------ dashpots: what restitution results


def damping_ratio(restitution: float) -> float:
    """Damping ratio beta [-] of a dashpot whose contact ends at zero overlap: -ln e / sqrt(ln^2 e + pi^2).

    Exact for the linear spring-dashpot and for Hertz with damping proportional to d^(1/4) (see
    `damped_hertz_impact`).

    **Source** Tsuji, Tanaka and Ishida (1992), Powder Technol. 71, 239; Antypov and Elliott (2011), EPL
    94, 50004.
    **Valid for** 0 < e <= 1.
    """
    logarithm = math.log(restitution)
    return abs(logarithm) / math.hypot(logarithm, math.pi)


def restitution_at_zero_overlap(damping: float) -> float:
    """Restitution [-] if contact ends at zero overlap, tension included: exp(-pi beta / sqrt(1 - beta^2)).

    Inverse of `damping_ratio`.

    **Source** Antypov and Elliott (2011), EPL 94, 50004. **Valid for** 0 <= beta < 1.
    """
    return math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))


def _turn(damping: float) -> float:
    """Phase w t of the largest overlap of a damped oscillator [-]: arccos(beta) / sqrt(1 - beta^2)."""
    if damping < 1.0:
        return math.acos(damping) / math.sqrt(1.0 - damping**2)
    return math.acosh(damping) / math.sqrt(damping**2 - 1.0) if damping > 1.0 else 1.0


def restitution_without_tension(damping: float) -> float:
    """Restitution [-] if the contact force is cut off where it would pull.

    e_0 = exp(-2 beta arccos(beta) / sqrt(1 - beta^2)), arccosh beyond critical damping. The same for the
    linear spring-dashpot and for damped Hertz: with tau = int d^(1/4) dt and y = d^(5/4) the damped Hertz
    contact *is* the linear one, and its force vanishes where y'' = 0, at twice the phase of the turn.
    Always above the restitution with tension: 0.253 instead of 0.1, 0.550 instead of 0.5.

    **Source** linear case Schwager and Poeschel (2007), Granular Matter 9, 465; Hertz by the substitution.
    **Valid for** beta >= 0.
    """
    return math.exp(-2.0 * damping * _turn(damping))


def damping_ratio_without_tension(restitution: float) -> float:
    """Damping ratio [-] for a wanted restitution when the force is cut off at zero.

    Inverse of `restitution_without_tension`, a root found to 1e-14, no fit. Above 1 for e < exp(-2).

    **Valid for** 0 < e <= 1.
    """

    def excess(damping: float) -> float:
        return restitution_without_tension(damping) - restitution

    upper = 1.0
    while excess(upper) > 0.0:
        upper *= 2.0
    return float(brentq(excess, 0.0, upper, xtol=1e-15, rtol=1e-14)) if restitution < 1.0 else 0.0


def _end(damping: float, tension: bool) -> tuple[float, float]:
    """Phase w t of the end of contact and the restitution [-]."""
    if tension:
        return math.pi / math.sqrt(1.0 - damping**2), restitution_at_zero_overlap(damping)
    return 2.0 * _turn(damping), restitution_without_tension(damping)


def linear_impact(
    pair: ContactPair, approach_speed: float, stiffness: float, damping: float, tension: bool = True
) -> NormalImpact:
    """Normal impact by the linear spring-dashpot F = k d + 2 beta sqrt(k m*) d', in closed form.

    With w = sqrt(k/m*), s = sqrt(1 - beta^2) and the turn at t_1 = arccos(beta)/(w s): T = pi/(w s), or
    2 t_1 without tension; d_max = v/w exp(-beta w t_1); F_max = m* v w exp(-beta (3 w t_1 - pi/s)) for
    beta < 1/2, else 2 beta m* v w, at first touch.

    **Source** linear oscillator; Schwager and Poeschel (2007), Granular Matter 9, 465.
    **Valid for** beta >= 0, with tension beta < 1.
    """
    frequency = math.sqrt(stiffness / pair.effective_mass)
    end, restitution = _end(damping, tension)
    turn = _turn(damping)
    peak = (
        math.exp(-damping * (3.0 * turn - math.pi / math.sqrt(1.0 - damping**2)))
        if damping < 0.5
        else 2.0 * damping
    )
    return NormalImpact(
        duration=end / frequency,
        maximum_force=pair.effective_mass * approach_speed * frequency * peak,
        maximum_overlap=approach_speed / frequency * math.exp(-damping * turn),
        restitution=restitution,
    )


def _hertz_length(pair: ContactPair, approach_speed: float) -> float:
    """Length scale of a Hertz impact [m]: (m* v^2 / (E* sqrt(R*)))^(2/5)."""
    stiffness = pair.effective_modulus * math.sqrt(pair.effective_radius)
    return float((pair.effective_mass * approach_speed**2 / stiffness) ** 0.4)


def damped_hertz_impact(
    pair: ContactPair, approach_speed: float, damping: float, tension: bool = True
) -> NormalImpact:
    """Normal impact by Hertz with a Tsuji dashpot, by a change of variables that makes it linear.

    F = 4/3 E* sqrt(R*) d^(3/2) + 2 sqrt(5/6) beta sqrt(S_n m*) d', S_n = 2 E* sqrt(R* d). In
    x = d (E* sqrt(R*) / (m* v^2))^(2/5) and its own time, tau = int x^(1/4) dt and y = x^(5/4) obey
    y'' + 2 beta w y' + w^2 y = 0 with w^2 = 5/3, y'(0) = 5/4. So the restitution and the largest overlap,
    x_max = (5/(4 w) exp(-beta arccos(beta) / sqrt(1 - beta^2)))^(4/5), are closed; the duration
    int dtau y^(-1/5) is a quadrature, the largest force 4/5 max(-y'' y^(1/5)) a root.

    **Source** Antypov and Elliott (2011), EPL 94, 50004.
    **Valid for** beta >= 0, with tension beta < 1.
    """
    frequency = math.sqrt(5.0 / 3.0)
    root = math.sqrt(abs(1.0 - damping**2))
    (end, restitution), turn = _end(damping, tension), _turn(damping)

    def motion(phase: float) -> tuple[float, float, float]:
        """y, dy/dphase and -d2y/dphase2 at phase = w tau."""
        size = 1.25 / frequency * math.exp(-damping * phase)
        if damping < 1.0:
            sine, cosine = math.sin(root * phase) / root, math.cos(root * phase)
        else:
            sine = math.sinh(root * phase) / root if damping > 1.0 else phase
            cosine = math.cosh(root * phase)
        y, y_rate = size * sine, size * (cosine - damping * sine)
        return y, y_rate, y + 2.0 * damping * y_rate

    def force_slope(phase: float) -> float:
        """Sign of the rate of the force, -y'' y^(1/5)."""
        y, y_rate, push = motion(phase)
        return (y_rate - 2.0 * damping * push) * y + 0.2 * push * y_rate

    def time_between(end_phase: float, phase: float) -> float:
        """Time over 1/w; phase = end + (phase - end) u^(5/4) removes the singular y^(-1/5) at the end."""

        def integrand(u: float) -> float:
            y = motion(end_phase + (phase - end_phase) * u**1.25)[0]
            return float(1.25 * u**0.25 * y**-0.2 * abs(phase - end_phase))

        return float(quad(integrand, 0.0, 1.0, epsabs=0.0, epsrel=1e-12, limit=200)[0])

    length = _hertz_length(pair, approach_speed)
    peak = float(brentq(force_slope, 1e-9, turn, xtol=1e-15)) if force_slope(turn) < 0.0 else turn
    y, _, push = motion(peak)
    unit_force = pair.effective_mass * approach_speed**2 / length
    return NormalImpact(
        duration=(time_between(0.0, turn) + time_between(end, turn)) / frequency * length / approach_speed,
        maximum_force=0.8 * frequency**2 * push * y**0.2 * unit_force,
        maximum_overlap=length * motion(turn)[0] ** 0.8,
        restitution=restitution,
    )


def hertz_history(
    pair: ContactPair, approach_speed: float, damping: float = 0.0, tension: bool = True, samples: int = 401
) -> tuple[NormalImpact, History]:
    """Overlap and force in time, and the numbers of the impact, by integration (DOP853, rtol 1e-12).

    The law of `damped_hertz_impact`, independent of its closed forms: no substitution, the end is found as
    an event. Times are evenly spaced, shape (samples,).
    """
    scale = _hertz_length(pair, approach_speed)
    dashpot = 2.0 * math.sqrt(5.0 / 3.0) * damping

    def force(state: Array) -> Array:
        overlap = np.maximum(state[0], 0.0)
        return np.asarray(4.0 / 3.0 * overlap**1.5 + dashpot * overlap**0.25 * state[1])

    def rate(_: float, state: Array) -> list[float]:
        return [float(state[1]), -float(force(state))]

    def released(_: float, state: Array) -> float:
        return float(state[0] if tension else 4.0 / 3.0 * max(state[0], 0.0) ** 1.25 + dashpot * state[1])

    released.terminal, released.direction = True, -1  # type: ignore[attr-defined]

    def turned(_: float, state: Array) -> float:
        return float(state[1])

    # the dashpot's x^(1/4) is not smooth at first touch: start on x = t, v = 1 - 4/5 c t^(5/4)
    start = 1e-12
    first = [start, 1.0 - 0.8 * dashpot * start**1.25]
    run = solve_ivp(
        rate,
        (start, 1e3),
        first,
        method="DOP853",
        rtol=1e-12,
        atol=1e-15,
        events=(released, turned),
        dense_output=True,
    )
    end = float(run.t_events[0][0])
    time = np.linspace(0.0, end, samples)
    state = run.sol(np.maximum(time, start))
    fine = run.sol(np.linspace(start, end, 20 * samples))
    at = int(np.clip(np.argmax(force(fine)), 1, fine.shape[1] - 2))
    curve, slope, middle = np.polyfit(np.arange(-1.0, 2.0), force(fine)[at - 1 : at + 2], 2)
    peak = float(middle - slope**2 / (4.0 * curve))
    unit_force = pair.effective_mass * approach_speed**2 / scale
    impact = NormalImpact(
        duration=end * scale / approach_speed,
        maximum_force=peak * unit_force,
        maximum_overlap=float(run.y_events[1][0][0]) * scale,
        restitution=-float(run.y_events[0][0][1]),
    )
    return impact, History(
        time * scale / approach_speed, state[0] * scale, state[1] * approach_speed, force(state) * unit_force
    )
