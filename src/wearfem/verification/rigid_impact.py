"""Oblique impact of rigid spheres with friction, and the book-keeping of any oblique impact.

Conventions (plane of impact): body 1 lies above body 2, the normal points from 2 to 1 along +y, the tangent
is +x, angular velocities are positive anticlockwise. The slip velocity of the touching surfaces is then
(vx1 + R1 w1) - (vx2 - R2 w2). A plane is a body of infinite radius, mass and inertia. No gravity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from wearfem.verification.impact_theory import Body, ContactPair, Sphere, contact_pair


@dataclass(frozen=True)
class Impact:
    """Motion just before contact.

    Approach speed [m/s] (> 0 closing), tangential [m/s] and angular velocities [rad/s] of both bodies.
    """

    approach_speed: float
    tangential_velocity: tuple[float, float] = (0.0, 0.0)
    angular_velocity: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Rebound:
    """Motion just after contact.

    Separation speed [m/s], tangential [m/s] and angular velocities [rad/s] of both bodies, slip velocity
    [m/s], tangential impulse on body 1 [N.s], and whether the surfaces slid to the end.
    """

    separation_speed: float
    tangential_velocity: tuple[float, float]
    angular_velocity: tuple[float, float]
    slip_velocity: float
    tangential_impulse: float
    sliding: bool


def _lever(body: Body) -> float:
    return body.radius if isinstance(body, Sphere) else 0.0


def slip_velocity(first: Body, second: Body, impact: Impact | Rebound) -> float:
    """Velocity of surface 1 over surface 2 at the contact point [m/s]: (vx1 + R1 w1) - (vx2 - R2 w2)."""
    velocity, spin = impact.tangential_velocity, impact.angular_velocity
    return velocity[0] + _lever(first) * spin[0] - velocity[1] + _lever(second) * spin[1]


def apply_impulse(
    first: Body,
    second: Body,
    impact: Impact,
    separation_speed: float,
    tangential_impulse: float,
    sliding: bool,
    lever: float = 1.0,
) -> Rebound:
    """Motion after a tangential impulse [N.s] on body 1 at the contact point (and its reaction on body 2).

    vx1' = vx1 + J/m1, w1' = w1 + R1 J/I1, vx2' = vx2 - J/m2, w2' = w2 + R2 J/I2: momentum and angular
    momentum are kept. `lever` [-] shortens both R where spheres are flattened by their contact.
    """
    velocity, spin = impact.tangential_velocity, impact.angular_velocity
    after = Rebound(
        separation_speed=separation_speed,
        tangential_velocity=(
            velocity[0] + tangential_impulse / first.mass,
            velocity[1] - tangential_impulse / second.mass,
        ),
        angular_velocity=(
            spin[0] + lever * first.spin_per_impulse * tangential_impulse,
            spin[1] + lever * second.spin_per_impulse * tangential_impulse,
        ),
        slip_velocity=0.0,
        tangential_impulse=tangential_impulse,
        sliding=sliding,
    )
    return Rebound(**{**after.__dict__, "slip_velocity": slip_velocity(first, second, after)})


def rigid_rebound(first: Body, second: Body, impact: Impact, friction: float, restitution: float) -> Rebound:
    """Oblique impact of rigid bodies with Coulomb friction: sliding throughout, or rolling at the end.

    J = -sign(slip) min(mu (1 + e) m* v_n, m_t |slip|). Sliding throughout if |slip| is at least
    mu (1 + e) (m*/m_t) v_n, for homogeneous spheres 7/2 mu (1 + e) v_n; then, for slip > 0,
    slip' = slip - 7/2 mu (1 + e) v_n and, against a plane, R w' = R w - 5/2 mu (1 + e) v_n.

    **Source** Walton (1993), in Particulate Two-Phase Flow, 884; Foerster et al. (1994), Phys. Fluids 6,
    1108.
    **Valid for** rigid bodies; an elastic contact agrees in gross sliding only, and a damped one only if
    its pushing force sums to m* (1 + e) v_n: so it is without tension. With tension the push sums to
    m* (1 + e_0) v_n, e_0 = `restitution_without_tension` (3.4 % more friction at e = 0.5), since friction
    has no hold while the contact pulls.
    """
    pair = contact_pair(first, second)
    slip = slip_velocity(first, second, impact)
    largest = friction * (1.0 + restitution) * pair.effective_mass * impact.approach_speed
    sticking = pair.tangential_mass * abs(slip)
    impulse = -math.copysign(min(largest, sticking), slip)
    return apply_impulse(
        first, second, impact, restitution * impact.approach_speed, impulse, sticking >= largest
    )


def sliding_limit(pair: ContactPair, friction: float, restitution: float) -> float:
    """Tangent |slip|/v_n [-] above which rigid bodies slide to the end: mu (1 + e) m*/m_t."""
    return friction * (1.0 + restitution) * pair.effective_mass / pair.tangential_mass


def tangential_restitution(impact: Impact, rebound: Rebound) -> float:
    """Ratio vx'/vx of body 1's centre [-]: the coefficient of Kharaz et al. (2001) and of test 4."""
    return rebound.tangential_velocity[0] / impact.tangential_velocity[0]


def kinetic_energy(first: Body, second: Body, motion: Impact | Rebound) -> float:
    """Kinetic energy [J] of tangential motion, spin, and normal motion relative to the centre of mass."""
    pair = contact_pair(first, second)
    speed = motion.approach_speed if isinstance(motion, Impact) else motion.separation_speed
    energy = 0.5 * pair.effective_mass * speed**2
    for body, velocity, spin in zip(
        (first, second), motion.tangential_velocity, motion.angular_velocity, strict=True
    ):
        if isinstance(body, Sphere):
            energy += 0.5 * body.mass * velocity**2 + 0.5 * body.inertia * spin**2
    return energy
