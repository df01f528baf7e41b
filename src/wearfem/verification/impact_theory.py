"""Single impacts in closed form: Hertz, damped Hertz, linear spring-dashpot, and rigid bodies with friction.

Conventions (plane of impact): body 1 lies above body 2, the normal points from 2 to 1 along +y, the tangent is +x and
angular velocities are positive anticlockwise. The slip velocity of the touching surfaces is therefore
``(vx1 + R1 w1) - (vx2 - R2 w2)``. A plane is a body of infinite radius, mass and inertia. Gravity is left out.
"""

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
    **Source** Johnson (1985), Contact Mechanics, eqs. (4.17), (4.20), (7.43); Maw, Barber and Fawcett (1976), Wear 38, 101.
    """

    effective_radius: float
    effective_mass: float
    effective_modulus: float
    effective_shear_modulus: float
    tangential_mass: float

    @property
    def stiffness_ratio(self) -> float:
        """Tangential over normal tangent stiffness [-]: 8 G* a / (2 E* a); 2(1-nu)/(2-nu) if one body is rigid or both are alike."""
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
            1.0 / body.mass + (body.radius * body.spin_per_impulse if isinstance(body, Sphere) else 0.0) for body in bodies
        ),
    )


@dataclass(frozen=True)
class NormalImpact:
    """A normal impact in three numbers and the restitution: duration [s], largest force [N], largest overlap [m], v'/v [-]."""

    duration: float
    maximum_force: float
    maximum_overlap: float
    restitution: float


@dataclass(frozen=True)
class History:
    """A normal impact in time, each of shape (n,): time [s], overlap [m], approach speed [m/s], compressive force [N]."""

    time: Array
    overlap: Array
    approach_speed: Array
    force: Array


# ---------------------------------------------------------------------------------------------------- Hertz, elastic


def hertz_impact(pair: ContactPair, approach_speed: float) -> NormalImpact:
    """Elastic normal impact of two bodies by Hertz's law F = 4/3 E* sqrt(R*) d^(3/2).

    d_max = (15 m* v^2 / (16 E* sqrt(R*)))^(2/5); T = 4 sqrt(pi) Gamma(2/5) / (5 Gamma(9/10)) d_max / v = 2.9433 d_max/v.

    **Source** Johnson (1985), Contact Mechanics, section 11.4, eqs. (11.23)-(11.24); Timoshenko and Goodier (1951), art. 126.
    **Valid for** impacts that are slow against the elastic wave speed and contacts that are small against R*.
    """
    stiffness = 4.0 / 3.0 * pair.effective_modulus * math.sqrt(pair.effective_radius)
    overlap = (1.25 * pair.effective_mass * approach_speed**2 / stiffness) ** 0.4
    factor = 4.0 * math.sqrt(math.pi) * gamma(0.4) / (5.0 * gamma(0.9))
    return NormalImpact(factor * overlap / approach_speed, stiffness * overlap**1.5, overlap, 1.0)


# ------------------------------------------------------------------------------------- dashpots: what restitution results


def damping_ratio(restitution: float) -> float:
    """Damping ratio beta [-] of a dashpot whose contact ends at zero overlap: -ln e / sqrt(ln^2 e + pi^2).

    Exact for the linear spring-dashpot and for Hertz with damping proportional to d^(1/4) (see `damped_hertz_impact`).

    **Source** Tsuji, Tanaka and Ishida (1992), Powder Technol. 71, 239; Antypov and Elliott (2011), EPL 94, 50004.
    **Valid for** 0 < e <= 1.
    """
    logarithm = math.log(restitution)
    return -logarithm / math.hypot(logarithm, math.pi)


def restitution_at_zero_overlap(damping: float) -> float:
    """Restitution [-] if contact ends when the overlap is zero, tension included: exp(-pi beta / sqrt(1 - beta^2)).

    **Source** Antypov and Elliott (2011), EPL 94, 50004. **Valid for** 0 <= beta < 1; inverse of `damping_ratio`.
    """
    return math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))


def restitution_without_tension(damping: float) -> float:
    """Restitution [-] if the contact force is cut off where it would pull: exp(-2 beta arccos(beta) / sqrt(1 - beta^2)).

    The same for the linear spring-dashpot and for damped Hertz: with tau = int d^(1/4) dt and y = d^(5/4) the damped Hertz
    contact *is* the linear one, its force vanishes where y'' = 0, at tau = 2 arccos(beta) / omega_d. Always above the
    restitution with tension: 0.253 instead of 0.1, 0.550 instead of 0.5. Beyond critical damping arccos becomes arccosh.

    **Source** linear case Schwager and Poeschel (2007), Granular Matter 9, 465; Hertz by the substitution above.
    **Valid for** beta >= 0.
    """
    if damping < 1.0:
        exponent = 2.0 * damping * math.acos(damping) / math.sqrt(1.0 - damping**2)
    elif damping > 1.0:
        exponent = 2.0 * damping * math.acosh(damping) / math.sqrt(damping**2 - 1.0)
    else:
        exponent = 2.0
    return math.exp(-exponent)


def damping_ratio_without_tension(restitution: float) -> float:
    """Damping ratio [-] that gives a wanted restitution when the force is cut off at zero: inverse of `restitution_without_tension`.

    **Valid for** 0 < e <= 1 (found to 1e-14; no fit).
    """
    if restitution == 1.0:
        return 0.0
    upper = 1.0
    while restitution_without_tension(upper) > restitution:
        upper *= 2.0
    return float(brentq(lambda beta: restitution_without_tension(beta) - restitution, 0.0, upper, xtol=1e-15, rtol=1e-14))


def _oscillator_peak_force(damping: float) -> float:
    """Largest -y'' of y'' + 2 beta y' + y = 0, y(0) = 0, y'(0) = 1: exp(-beta (3 arccos beta - pi) / sqrt(1 - beta^2)), or 2 beta."""
    if damping >= 0.5:
        return 2.0 * damping
    return math.exp(-damping * (3.0 * math.acos(damping) - math.pi) / math.sqrt(1.0 - damping**2))


def linear_impact(pair: ContactPair, approach_speed: float, stiffness: float, damping: float, tension: bool = True) -> NormalImpact:
    """Normal impact by the linear spring-dashpot F = k d + 2 beta sqrt(k m*) d', in closed form.

    With w = sqrt(k/m*) and s = sqrt(1 - beta^2): T = pi/(w s) (2 arccos(beta)/(w s) without tension),
    d_max = v/w exp(-beta arccos(beta)/s), F_max = m* v w exp(-beta (3 arccos(beta) - pi)/s), or 2 beta m* v w (at first touch) for beta >= 1/2.

    **Source** linear oscillator; Schwager and Poeschel (2007), Granular Matter 9, 465. **Valid for** 0 <= beta < 1.
    """
    frequency = math.sqrt(stiffness / pair.effective_mass)
    root = math.sqrt(1.0 - damping**2)
    phase = math.pi if tension else 2.0 * math.acos(damping)
    restitution = restitution_at_zero_overlap(damping) if tension else restitution_without_tension(damping)
    return NormalImpact(
        duration=phase / (frequency * root),
        maximum_force=pair.effective_mass * approach_speed * frequency * _oscillator_peak_force(damping),
        maximum_overlap=approach_speed / frequency * math.exp(-damping * math.acos(damping) / root),
        restitution=restitution,
    )


def damped_hertz_impact(pair: ContactPair, approach_speed: float, damping: float, tension: bool = True) -> NormalImpact:
    """Normal impact by Hertz with a Tsuji dashpot: F = 4/3 E* sqrt(R*) d^(3/2) + 2 sqrt(5/6) beta sqrt(S_n m*) d', S_n = 2 E* sqrt(R* d).

    In x = d (E* sqrt(R*) / (m* v^2))^(2/5) and its own time, tau = int x^(1/4) dt and y = x^(5/4) obey
    y'' + 2 beta w y' + w^2 y = 0 with w^2 = 5/3, y'(0) = 5/4. So the restitution, the largest overlap
    x_max = (sqrt(15)/4 exp(-beta arccos(beta)/sqrt(1-beta^2)))^(4/5) are closed; the duration int dtau y^(-1/5) is a quadrature and
    the largest force 4/5 max(-y'' y^(1/5)) a root.

    **Source** Antypov and Elliott (2011), EPL 94, 50004. **Valid for** 0 <= beta < 1.
    """
    frequency, root = math.sqrt(5.0 / 3.0), math.sqrt(1.0 - damping**2)
    scale = (pair.effective_mass * approach_speed**2 / (pair.effective_modulus * math.sqrt(pair.effective_radius))) ** 0.4
    end = math.pi if tension else 2.0 * math.acos(damping)
    lag = math.acos(damping)

    def motion(phase: float) -> tuple[float, float]:
        """y and -y'' at phase = w s tau."""
        size = 1.25 / (frequency * root) * math.exp(-damping * phase / root)
        return size * math.sin(phase), frequency**2 * size * math.sin(2.0 * lag - phase)

    def slope_of_force(phase: float) -> float:
        """d(log of force)/d(phase) times y (-y''): zero at the largest force."""
        y, pull = motion(phase)
        decay = 1.25 / (frequency * root) * math.exp(-damping * phase / root)
        y_rate = decay * (math.cos(phase) - damping / root * math.sin(phase))
        pull_rate = frequency**2 * decay * (-math.cos(2.0 * lag - phase) - damping / root * math.sin(2.0 * lag - phase))
        return pull_rate * y + 0.2 * pull * y_rate

    # t = int y^(-1/5) dphase/(w s); phase = end u^(5/4) (and its mirror image) removes the singular ends
    def piece(start: float, stop: float) -> float:
        def integrand(u: float) -> float:
            phase = start + (stop - start) * u**1.25
            return 1.25 * u**0.25 * motion(phase)[0] ** -0.2 * abs(stop - start)

        return float(quad(integrand, 0.0, 1.0, epsabs=0.0, epsrel=1e-12, limit=200)[0])

    time = (piece(0.0, lag) + piece(end, lag)) / (frequency * root)
    peak = float(brentq(slope_of_force, 1e-9, lag, xtol=1e-15)) if slope_of_force(lag) < 0.0 else lag
    y, pull = motion(peak)
    return NormalImpact(
        duration=time * scale / approach_speed,
        maximum_force=0.8 * pull * y**0.2 * pair.effective_mass * approach_speed**2 / scale,
        maximum_overlap=scale * motion(lag)[0] ** 0.8,
        restitution=restitution_at_zero_overlap(damping) if tension else restitution_without_tension(damping),
    )


def hertz_history(
    pair: ContactPair, approach_speed: float, damping: float = 0.0, tension: bool = True, samples: int = 401
) -> tuple[NormalImpact, History]:
    """Overlap and force in time, and the numbers of the impact, by an eighth-order integration of the same law (DOP853, rtol 1e-12).

    Independent of the closed forms: no substitution, the end is found as an event. Times are evenly spaced, shape (samples,).
    """
    scale = (pair.effective_mass * approach_speed**2 / (pair.effective_modulus * math.sqrt(pair.effective_radius))) ** 0.4
    dashpot = 2.0 * math.sqrt(5.0 / 3.0) * damping

    def force(state: Array) -> Array:
        overlap = np.maximum(state[0], 0.0)
        return 4.0 / 3.0 * overlap**1.5 + dashpot * overlap**0.25 * state[1]

    def rate(_: float, state: Array) -> list[float]:
        return [float(state[1]), -float(force(state))]

    def released(_: float, state: Array) -> float:
        return float(state[0] if tension else 4.0 / 3.0 * max(state[0], 0.0) ** 1.25 + dashpot * state[1])

    released.terminal, released.direction = True, -1  # type: ignore[attr-defined]

    def turned(_: float, state: Array) -> float:
        return float(state[1])

    # The dashpot's x^(1/4) is not smooth at first touch: start on the exact leading terms, x = t and v = 1 - 4/5 c t^(5/4).
    start = 1e-12
    first = [start, 1.0 - 0.8 * dashpot * start**1.25]
    run = solve_ivp(
        rate, (start, 1e3), first, method="DOP853", rtol=1e-12, atol=1e-15, events=(released, turned), dense_output=True
    )
    end = float(run.t_events[0][0])
    time = np.linspace(0.0, end, samples)
    state = run.sol(np.maximum(time, start))
    fine = run.sol(np.linspace(start, end, 20 * samples))
    at = int(np.argmax(force(fine)))
    parabola = np.polyfit(np.arange(-1.0, 2.0), force(fine)[at - 1 : at + 2], 2) if 0 < at < 20 * samples - 1 else None
    peak = float(force(fine)[at]) if parabola is None else float(parabola[2] - parabola[1] ** 2 / (4.0 * parabola[0]))
    unit_force = pair.effective_mass * approach_speed**2 / scale
    impact = NormalImpact(
        duration=end * scale / approach_speed,
        maximum_force=peak * unit_force,
        maximum_overlap=float(run.y_events[1][0][0]) * scale,
        restitution=-float(run.y_events[0][0][1]),
    )
    return impact, History(time * scale / approach_speed, state[0] * scale, state[1] * approach_speed, force(state) * unit_force)


# --------------------------------------------------------------------------------------------- oblique impact, rigid bodies


@dataclass(frozen=True)
class Impact:
    """Motion just before contact: approach speed [m/s] (> 0 closing), tangential velocities [m/s] and angular velocities [rad/s] of both."""

    approach_speed: float
    tangential_velocity: tuple[float, float] = (0.0, 0.0)
    angular_velocity: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Rebound:
    """Motion just after contact: separation speed, tangential and angular velocities of both, slip velocity [m/s] and the
    tangential impulse [N.s] on body 1; `sliding` says whether the surfaces slid to the end."""

    separation_speed: float
    tangential_velocity: tuple[float, float]
    angular_velocity: tuple[float, float]
    slip_velocity: float
    tangential_impulse: float
    sliding: bool


def _lever(body: Body) -> float:
    return body.radius if isinstance(body, Sphere) else 0.0


def slip_velocity(first: Body, second: Body, impact: Impact | Rebound) -> float:
    """Velocity of surface 1 over surface 2 at the contact point along +x [m/s]: (vx1 + R1 w1) - (vx2 - R2 w2)."""
    velocity, spin = impact.tangential_velocity, impact.angular_velocity
    return velocity[0] + _lever(first) * spin[0] - velocity[1] + _lever(second) * spin[1]


def apply_impulse(
    first: Body, second: Body, impact: Impact, separation_speed: float, tangential_impulse: float, sliding: bool
) -> Rebound:
    """Motion after a tangential impulse [N.s] on body 1 at the contact point (and its reaction on body 2).

    vx1' = vx1 + J/m1, w1' = w1 + R1 J/I1, vx2' = vx2 - J/m2, w2' = w2 + R2 J/I2: momentum and angular momentum are kept.
    """
    velocity, spin = impact.tangential_velocity, impact.angular_velocity
    after = Rebound(
        separation_speed=separation_speed,
        tangential_velocity=(velocity[0] + tangential_impulse / first.mass, velocity[1] - tangential_impulse / second.mass),
        angular_velocity=(
            spin[0] + first.spin_per_impulse * tangential_impulse,
            spin[1] + second.spin_per_impulse * tangential_impulse,
        ),
        slip_velocity=0.0,
        tangential_impulse=tangential_impulse,
        sliding=sliding,
    )
    return Rebound(**{**after.__dict__, "slip_velocity": slip_velocity(first, second, after)})


def rigid_rebound(first: Body, second: Body, impact: Impact, friction: float, restitution: float) -> Rebound:
    """Oblique impact of rigid bodies with Coulomb friction: sliding throughout, or rolling (zero slip) at the end.

    J = -sign(slip) min(mu (1 + e) m* v_n, m_t |slip|). Sliding throughout if |slip| >= mu (1 + e) (m*/m_t) v_n = 7/2 mu (1 + e) v_n
    for homogeneous spheres; then slip' = slip - 7/2 mu (1 + e) v_n and R w' = R w -+ 5/2 mu (1 + e) v_n against a plane.

    **Source** Walton (1993), in Particulate Two-Phase Flow, 884; Foerster et al. (1994), Phys. Fluids 6, 1108.
    **Valid for** rigid bodies; an elastic contact agrees in gross sliding only, and a damped one only if its pushing force sums to
    m* (1 + e) v_n: so it is without tension. With tension the push sums to m* (1 + e_0) v_n, e_0 = `restitution_without_tension`
    (3.4 % more friction at e = 0.5), since friction has no hold while the contact pulls.
    """
    pair = contact_pair(first, second)
    slip = slip_velocity(first, second, impact)
    largest = friction * (1.0 + restitution) * pair.effective_mass * impact.approach_speed
    sticking = pair.tangential_mass * abs(slip)
    impulse = -math.copysign(min(largest, sticking), slip)
    return apply_impulse(first, second, impact, restitution * impact.approach_speed, impulse, sticking >= largest)


def sliding_limit(pair: ContactPair, friction: float, restitution: float) -> float:
    """Tangent of the incidence angle, |slip|/v_n [-], above which rigid bodies slide to the end: mu (1 + e) m*/m_t."""
    return friction * (1.0 + restitution) * pair.effective_mass / pair.tangential_mass


def tangential_restitution(impact: Impact, rebound: Rebound) -> float:
    """Ratio of the tangential velocities of body 1's centre [-], vx'/vx: the coefficient of Kharaz et al. (2001) and of test 4."""
    return rebound.tangential_velocity[0] / impact.tangential_velocity[0]


def kinetic_energy(first: Body, second: Body, motion: Impact | Rebound) -> float:
    """Kinetic energy [J] of tangential motion, spin, and normal motion relative to the common centre of mass."""
    pair = contact_pair(first, second)
    speed = motion.approach_speed if isinstance(motion, Impact) else motion.separation_speed
    energy = 0.5 * pair.effective_mass * speed**2
    for body, velocity, spin in zip((first, second), motion.tangential_velocity, motion.angular_velocity, strict=True):
        if isinstance(body, Sphere):
            energy += 0.5 * body.mass * velocity**2 + 0.5 * body.inertia * spin**2
    return energy
