"""Oblique impact of elastic spheres: partial slip (Maw, Barber and Fawcett) and the spring of a DEM engine.

Both are written in the variables of Maw, Barber and Fawcett (1976). With the stiffness ratio
kappa = 4 G*/E* [-], friction mu [-], approach speed v [m/s] and slip velocity v_s [m/s], the angles of
incidence and reflection are

    psi_1 = kappa v_s / (mu v),    psi_2 = kappa v_s' / (mu v)    (v_s' > 0: still sliding forwards),

and an elastic impact depends on psi_1 and chi = kappa m*/(2 m_t) alone; for a sphere (K^2 = 2/5)
chi = (1 - nu)(1 + 1/K^2)/(2 - nu). The overlap x is in units of the largest elastic Hertz overlap D, time in
D/v, forces in m* v^2/D (tangential ones over mu): F = 5/4 x^(3/2), tangent stiffness 15/8 sqrt(x), slip
velocity psi' = -2 chi q. Fixed facts of the curve: the contact sticks at first touch for psi_1 < 1, and
slides to the end, psi_2 = psi_1 - 4 chi, for psi_1 > 4 chi - 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from wearfem.verification.impact_theory import (
    Array,
    Body,
    ContactPair,
    Sphere,
    contact_pair,
    hertz_impact,
    restitution_at_zero_overlap,
    restitution_without_tension,
)
from wearfem.verification.rigid_impact import Impact, Rebound, apply_impulse, slip_velocity

STIFFNESS = 15.0 / 8.0


def incidence(pair: ContactPair, slip: float, approach_speed: float, friction: float) -> float:
    """Normalised angle of incidence psi_1 [-]: kappa |v_s| / (mu v)."""
    return pair.stiffness_ratio * abs(slip) / (friction * approach_speed)


def sliding_incidence(chi: float) -> float:
    """psi_1 [-] above which the contact slides from first touch to the end: 4 chi - 1 (Maw et al. 1976)."""
    return 4.0 * chi - 1.0


# ----------------------------------------------------------------------------------- Maw, Barber and Fawcett


def slip_limited(displacement: Array, increment: Array | float, bound: Array) -> Array:
    """Tangential displacement of the rings after a common increment: it follows up to the bound."""
    return np.clip(displacement + increment, -bound, bound)


@dataclass(frozen=True)
class PartialSlip:
    """Elastic oblique impacts with partial slip, one row per incidence.

    Attributes
    ----------
    incidence, reflection : (n,) array
        psi_1 and psi_2 [-].
    time : (t,) array
        Time over D/v [-], 0 to 2.9433.
    slip, force : (n, t) array
        psi(t) [-] and tangential force over mu m* v^2/D [-] at those times.
    """

    incidence: Array
    reflection: Array
    time: Array
    slip: Array
    force: Array


def partial_slip_impact(chi: float, incidences: Array | list[float] | float, rings: int = 400) -> PartialSlip:
    """Reflection psi_2 of elastic spheres with partial slip, the problem of Maw, Barber and Fawcett.

    The contact is cut into rings that stick or slip one by one. In the Abel transform of the Hertzian
    traction (method of dimensionality reduction) the rings decouple: ring z carries 15/8 (x - z^2) of the
    normal and 15/8 u of the tangential force, touches while x > z^2, and |u| <= x - z^2. This is the
    Cattaneo-Mindlin-Deresiewicz contact for any history of loading. Ring j is placed where the contact
    edge stands at step j, so first touch and release fall on steps; the normal motion is exact; leapfrog
    in time. Error of psi_2 below 2 / rings^2.

    **Source** Maw, Barber and Fawcett (1976), Wear 38, 101; (1981), J. Lubr. Technol. 103, 74; Popov and
    Hess (2015), Method of Dimensionality Reduction, ch. 5 and 8; Jaeger (1994), Appl. Mech. Rev. 47, 35.
    **Valid for** spheres and half-spaces that are elastically alike (or one rigid, nu coupling neglected),
    e = 1, in-plane motion.
    """
    start = np.atleast_1d(np.asarray(incidences, dtype=np.float64))
    loading, time_step = _normal_loading(rings)
    overlap = np.concatenate([loading, loading[-2::-1]])
    weight = STIFFNESS * _ring_weights(np.sqrt(loading))
    displacement = np.zeros((start.size, rings + 1))
    velocity = start.copy()
    slip, force = np.empty((start.size, overlap.size)), np.zeros((start.size, overlap.size))
    slip[:, 0] = velocity
    for step in range(1, overlap.size):
        bound = np.maximum(overlap[step] - loading, 0.0)
        displacement = slip_limited(displacement, velocity[:, None] * time_step, bound)
        force[:, step] = displacement @ weight
        slip[:, step] = velocity - chi * force[:, step] * time_step
        velocity = velocity - 2.0 * chi * force[:, step] * time_step
    time = np.linspace(0.0, time_step * (overlap.size - 1), overlap.size)
    return PartialSlip(start, slip[:, -1], time, slip, force)


def _ring_weights(edge: Array) -> Array:
    """Weights of int u dz at nodes z = edge, u linear in z^2 between them: exact for the bound x - z^2."""
    left, right = edge[:-1], edge[1:]
    to_right = ((right**3 - left**3) / 3.0 - left**2 * (right - left)) / (right**2 - left**2)
    weight = np.zeros(edge.size)
    weight[1:] += to_right
    weight[:-1] += right - left - to_right
    return weight


def _normal_loading(steps: int) -> tuple[Array, float]:
    """Normalised overlap at `steps` + 1 even times from first touch to the turn, and the time step."""

    def turned(_: float, state: Array) -> float:
        return float(state[1])

    turned.terminal, turned.direction = True, -1  # type: ignore[attr-defined]
    run = solve_ivp(
        lambda _, state: [state[1], -1.25 * max(state[0], 0.0) ** 1.5],
        (0.0, 2.0),
        [0.0, 1.0],
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
        events=turned,
        dense_output=True,
    )
    time = np.linspace(0.0, float(run.t_events[0][0]), steps + 1)
    overlap = run.sol(time)[0]
    overlap[0], overlap[-1] = 0.0, 1.0
    return overlap, float(time[1])


# -------------------------------------------------------------------------------- the spring of a DEM engine


@dataclass(frozen=True)
class SpringImpact:
    """An oblique impact by the spring law.

    Slip velocity after, kappa v_s'/(mu v) [-] (psi_2 if e = 1), restitution v'/v [-], whether the contact
    slid at every moment, and the mean lever of the friction force over R [-].
    """

    slip: float
    restitution: float
    sliding: bool
    lever: float = 1.0


def spring_impact(
    chi: float,
    incidence: float,
    stiffness_ratio: float,
    damping: float = 0.0,
    tension: bool = True,
    rescale: bool = True,
    depth: float = 0.0,
    spin: float = 0.0,
) -> SpringImpact:
    """Oblique impact by Hertz, one tangential spring and a Coulomb limit, integrated from event to event.

    Spring force q = k d, k = 8 G* a. While it holds d' = v_s; on increasing overlap `rescale` keeps the
    force as k grows (Mindlin: the new contact area is laid down unstressed), otherwise, and on decreasing
    overlap, the displacement is kept. At |q| = mu F the spring slips: q = mu F, until it alone would fall
    behind mu F. Dashpot c v_s, c = 2 sqrt(5/6) beta sqrt(k m*), as far as the limit leaves room for it:
    T = q + c v_s, cut off at mu F on both sides. Friction has no hold while the normal force pulls, so the
    tangential motion is the same with and without tension.

    Parameters
    ----------
    chi, incidence, stiffness_ratio : float
        chi, psi_1 >= 0 and kappa [-] (kappa matters with damping only).
    damping : float
        beta [-] of both dashpots.
    tension : bool
        Contact ends at zero overlap (True) or where the normal force would pull (False).
    rescale : bool
        Constant force on increasing overlap.
    depth : float
        How far body 1 is flattened at the largest elastic overlap D, over R [-]: friction acts at the lever
        R (1 - depth x), where the surfaces touch. 0 is the limit of small overlaps, as in the theory.
    spin : float
        The part of psi_1 that is spin, kappa R w/(mu v) [-]; it matters with depth only.

    Notes
    -----
    **Source** Mindlin and Deresiewicz (1953), J. Appl. Mech. 20, 327; "no-slip" laws compared in Thornton,
    Cummins and Cleary (2011), Powder Technol. 210, 189. With `rescale` the contact sticks at first touch
    for psi_1 < 1 as in theory, without for psi_1 < 2/3. It slides to the end for psi_1 > 4 chi - 2/3
    (theory 4 chi - 1), or with damping for psi_1 > 2 chi (1 + e).
    **Valid for** homogeneous bodies, in-plane motion; with tension beta < 1. DOP853, rtol 1e-11.
    """
    return _SpringContact(chi, stiffness_ratio, damping, tension, rescale, depth).run(incidence, spin)


class _SpringContact:
    """The spring law as two motions, the spring holds or slips, and the events between them.

    State: x, x', velocity of translation and of spin along the surface, spring. The spring is held as its force
    while the overlap grows (with rescaling), else as its displacement.
    """

    def __init__(
        self,
        chi: float,
        stiffness_ratio: float,
        damping: float,
        tension: bool,
        rescale: bool,
        depth: float = 0.0,
    ) -> None:
        self.depth = depth
        self.rate_of_translation, self.rate_of_spin = stiffness_ratio, 2.0 * chi - stiffness_ratio
        self.normal_dashpot = 2.5 * damping
        self.tangential_dashpot = 2.5 * damping / math.sqrt(stiffness_ratio)
        self.pushed = restitution_without_tension(damping)
        self.restitution = restitution_at_zero_overlap(damping) if tension else self.pushed
        self.rescale = rescale
        self.keeps_force = rescale
        self.sign = 1.0

    def normal_force(self, state: Array) -> float:
        overlap = max(state[0], 0.0)
        return float(1.25 * overlap**1.5 + self.normal_dashpot * overlap**0.25 * state[1])

    def limit(self, state: Array) -> float:
        """mu F over mu."""
        return max(self.normal_force(state), 0.0)

    def lever(self, state: Array) -> float:
        """Distance of the touching surfaces from the centre, over R."""
        return float(1.0 - self.depth * max(state[0], 0.0))

    def slip(self, state: Array) -> float:
        return float(state[2] + self.lever(state) * state[3])

    def spring(self, state: Array) -> float:
        return float(state[4] if self.keeps_force else STIFFNESS * math.sqrt(max(state[0], 0.0)) * state[4])

    def held(self, force: float, overlap: float) -> float:
        return force if self.keeps_force else force / (STIFFNESS * math.sqrt(overlap))

    def rates(self, state: Array, spring: float, held_rate: float) -> list[float]:
        """Motion under spring and dashpot together, cut off at the limit."""
        limit = self.limit(state)
        pull = spring + self.tangential_dashpot * max(state[0], 0.0) ** 0.25 * self.slip(state)
        pull = min(max(pull, -limit), limit)
        turning = -self.rate_of_spin * self.lever(state) * pull
        return [state[1], -self.normal_force(state), -self.rate_of_translation * pull, turning, held_rate]

    def stick(self, _: float, state: Array) -> list[float]:
        stiffness = STIFFNESS * math.sqrt(max(state[0], 0.0)) if self.keeps_force else 1.0
        return self.rates(state, self.spring(state), stiffness * self.slip(state))

    def slide(self, _: float, state: Array) -> list[float]:
        return self.rates(state, self.sign * self.limit(state), 0.0)

    def over_limit(self, _: float, state: Array) -> float:
        return abs(self.spring(state)) - self.limit(state)

    def sticks_again(self, _: float, state: Array) -> float:
        """How much faster the spring at its limit would grow than the limit does; over sqrt(x)."""
        overlap, rate = max(state[0], 1e-30), state[1]
        limit_rate, lost = 1.875 * rate, 0.625 * rate
        if self.normal_dashpot > 0.0:
            change = 0.25 * rate**2 / overlap - self.normal_force(state)
            limit_rate += self.normal_dashpot * overlap**-0.25 * change
            lost += 0.5 * self.normal_dashpot * overlap**-1.25 * rate**2
        own = STIFFNESS * self.sign * self.slip(state)
        return float(own - limit_rate if self.keeps_force else own + lost - limit_rate)

    def turned(self, _: float, state: Array) -> float:
        return float(state[1])

    def released(self, _: float, state: Array) -> float:
        return float(1.25 * max(state[0], 0.0) ** 1.25 + self.normal_dashpot * state[1])

    def run(self, incidence: float, spin: float = 0.0) -> SpringImpact:
        time = 1e-10
        force = STIFFNESS * incidence * time**1.5 * (2.0 / 3.0 if self.rescale else 1.0)
        state = np.array([time, 1.0, incidence - spin, spin, self.held(force, time)])
        sticking = abs(self.spring(state)) < self.limit(state)
        growing = True
        for _ in range(10_000):
            motion = self.stick if sticking else self.slide
            changes = _event(self.over_limit, 1) if sticking else _event(self.sticks_again, -1)
            events = [_event(self.released, -1), changes] + ([_event(self.turned, -1)] if growing else [])
            leg = solve_ivp(
                motion, (time, 1e4), state, method="DOP853", rtol=1e-11, atol=1e-14, events=events
            )
            time, state = float(leg.t[-1]), leg.y[:, -1].copy()
            if leg.t_events[0].size:
                change, turned = state[2] - (incidence - spin), state[3] - spin
                most = self.rate_of_translation * (1.0 + self.pushed)
                lever = turned / change * self.rate_of_translation / self.rate_of_spin if change else 1.0
                sliding = bool(abs(abs(change) - most) < 1e-7)
                return SpringImpact(float(state[2] + state[3]), self.restitution, sliding, float(lever))
            if growing and leg.t_events[2].size:
                kept = self.spring(state)
                growing, self.keeps_force = False, False
                state[4] = self.held(kept, state[0])
                continue
            if sticking:
                self.sign = math.copysign(1.0, self.spring(state))
            state[4] = self.held(self.sign * self.limit(state), state[0])
            sticking = not sticking
        raise RuntimeError("the spring contact changed between stick and slip more than 10 000 times")


def _event(function: Callable[[float, Array], float], direction: int) -> Callable[[float, Array], float]:
    """A terminal event of `solve_ivp` from a method (methods carry no attributes)."""

    def event(time: float, state: Array) -> float:
        return function(time, state)

    event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
    return event


# ------------------------------------------------------------------------------------- in SI, for two bodies


def _rebound(
    first: Body,
    second: Body,
    impact: Impact,
    friction: float,
    slip: float,
    restitution: float,
    sliding: bool,
    lever: float = 1.0,
) -> Rebound:
    """Rebound from the normalised slip velocity after the impact and the mean lever of the friction force."""
    pair = contact_pair(first, second)
    before = slip_velocity(first, second, impact)
    after = math.copysign(1.0, before) * slip * friction * impact.approach_speed / pair.stiffness_ratio
    shift = 1.0 / pair.effective_mass
    mobility = shift + lever * (1.0 / pair.tangential_mass - shift)
    separation = restitution * impact.approach_speed
    return apply_impulse(first, second, impact, separation, (after - before) / mobility, sliding, lever)


def partial_slip_rebound(
    first: Body, second: Body, impact: Impact, friction: float, rings: int = 400
) -> Rebound:
    """Elastic rebound with partial slip (see `partial_slip_impact`), in SI."""
    pair = contact_pair(first, second)
    angle = incidence(pair, slip_velocity(first, second, impact), impact.approach_speed, friction)
    after = float(partial_slip_impact(pair.chi, angle, rings).reflection[0])
    return _rebound(first, second, impact, friction, after, 1.0, angle >= sliding_incidence(pair.chi))


def spring_rebound(
    first: Body,
    second: Body,
    impact: Impact,
    friction: float,
    damping: float = 0.0,
    tension: bool = True,
    rescale: bool = True,
    flattened: bool = False,
) -> Rebound:
    """Rebound by the spring law (see `spring_impact`), in SI.

    `flattened`: friction acts where the surfaces touch, R - d from the centre of a sphere on a plane and R1 - d R2/(R1 + R2) in
    general, as in an engine; otherwise at R, as in the theory of small overlaps. Both levers are shortened by the
    factor of body 1: right on a plane, for equal spheres, and where body 2 is so heavy that its spin stays.
    """
    pair = contact_pair(first, second)
    slip = slip_velocity(first, second, impact)
    angle = incidence(pair, slip, impact.approach_speed, friction)
    depth, spin = 0.0, 0.0
    if flattened:
        bodies = [body for body in (first, second) if isinstance(body, Sphere)]
        flattening = pair.effective_radius / first.radius**2
        depth = hertz_impact(pair, impact.approach_speed).maximum_overlap * flattening
        rolling = sum(b.radius * w for b, w in zip(bodies, impact.angular_velocity, strict=False))
        spin = angle * rolling / slip if slip else 0.0
    after = spring_impact(pair.chi, angle, pair.stiffness_ratio, damping, tension, rescale, depth, spin)
    return _rebound(
        first, second, impact, friction, after.slip, after.restitution, after.sliding, after.lever
    )


def energy_loss(incidence: Array | float, reflection: Array | float) -> Array:
    """Share of the slip energy 1/2 m_t v_s^2 that an elastic oblique impact loses [-]: 1 - (psi_2/psi_1)^2.

    The normal motion is elastic and the rest of the tangential motion is kept (`apply_impulse`), so this is
    all that friction takes.
    """
    return np.asarray(1.0 - np.square(np.asarray(reflection) / np.asarray(incidence)))
