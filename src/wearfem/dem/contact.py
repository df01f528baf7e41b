"""Contact laws: what two touching bodies do to each other. [PLUG]

A law is a NamedTuple of numbers whose methods are the formulas, on scalars, in SI. Four kinds of formula make a `Contact`:
the force of overlap and slip (`HertzMindlin`, `LinearSpringDashpot`), the resistance to rolling (`NoRolling`,
`ConstantTorque`, `ElasticPlasticRolling`) and to twisting (`NoTwisting`, `FrictionTwisting`). `respond` turns them into forces.

Frame: n is the unit normal from the partner to the particle; the relative velocity is particle minus partner.
"""

import math
from typing import Any, NamedTuple

from wearfem.jit import inlined, law_method
from wearfem.vector import cross, dot, norm, tangent


class Pair(NamedTuple):
    """What a law may know of the two bodies in contact (scalars)."""

    effective_radius: float  # [m] 1/R* = 1/R1 + 1/R2; a wall has 1/R = 0
    effective_mass: float  # [kg] 1/m* = 1/m1 + 1/m2; a wall has 1/m = 0
    effective_modulus: float  # [Pa] E*
    effective_shear_modulus: float  # [Pa] G*
    damping_ratio: float  # [-] beta(e)
    friction: float  # [-]
    rolling_friction: float  # [-]


@law_method
def elastic_force(self, overlap, pair): ...
@law_method
def elastic_energy(self, overlap, pair): ...
@law_method
def normal_damping(self, overlap, pair): ...
@law_method
def tangential_stiffness(self, overlap, pair): ...
@law_method
def tangential_damping(self, overlap, pair): ...
@law_method
def active(self): ...
@law_method
def memory_size(self): ...
@law_method
def rolling_stiffness(self, normal_stiffness, pair): ...
@law_method
def rolling_damping(self, stiffness, time_step, pair): ...
@law_method
def rolling_limit(self, load, pair): ...
@law_method
def twisting_stiffness(self, tangential_stiffness, overlap, pair): ...
@law_method
def twisting_limit(self, load, overlap, pair): ...


DAMPING = 2.0 * math.sqrt(5.0 / 6.0)  # of a Hertz contact whose restitution does not depend on speed


class HertzMindlin(NamedTuple):
    """Elastic spheres: Hertz normally, Mindlin's no-slip stiffness tangentially, and dashpots that restore e at any speed.

    Normal force 4/3 E* sqrt(R* d^3) + C_n v_n, never below zero; tangential stiffness S_t = 8 G* sqrt(R* d);
    C = 2 sqrt(5/6) beta sqrt(S m*) with S_n = 2 E* sqrt(R* d) (Tsuji et al. 1992). The damping ratio beta belongs to a contact
    that never pulls (`material.damping_ratio`), so that e is met and friction acts until the bodies part.

    **Valid for** small overlaps (d < 0.05 R), no adhesion.
    """

    shear_damping: float = 1.0  # [-] factor on the tangential dashpot: 1 as in the formula, 0 for none

    def elastic_force(self, overlap, pair):
        """4/3 E* sqrt(R* d) d [N]"""
        return 4.0 / 3.0 * pair.effective_modulus * math.sqrt(pair.effective_radius * overlap) * overlap

    def elastic_energy(self, overlap, pair):
        """8/15 E* sqrt(R* d) d^2 [J]"""
        return (
            8.0
            / 15.0
            * pair.effective_modulus
            * math.sqrt(pair.effective_radius * overlap)
            * overlap
            * overlap
        )

    def normal_damping(self, overlap, pair):
        """2 sqrt(5/6) beta sqrt(S_n m*) [N s/m]"""
        stiffness = 2.0 * pair.effective_modulus * math.sqrt(pair.effective_radius * overlap)
        return DAMPING * pair.damping_ratio * math.sqrt(stiffness * pair.effective_mass)

    def tangential_stiffness(self, overlap, pair):
        """S_t = 8 G* sqrt(R* d) [N/m]"""
        return 8.0 * pair.effective_shear_modulus * math.sqrt(pair.effective_radius * overlap)

    def tangential_damping(self, overlap, pair):
        """2 sqrt(5/6) beta sqrt(S_t m*) [N s/m]"""
        stiffness = 8.0 * pair.effective_shear_modulus * math.sqrt(pair.effective_radius * overlap)
        return self.shear_damping * DAMPING * pair.damping_ratio * math.sqrt(stiffness * pair.effective_mass)


class LinearSpringDashpot(NamedTuple):
    """Springs of constant stiffness with dashpots that restore e (Cundall and Strack 1979); moduli are not used."""

    stiffness: float  # [N/m] normal
    shear_ratio: float = 2.0 / 7.0  # [-] tangential over normal stiffness
    shear_damping: float = 1.0  # [-] factor on the tangential dashpot

    def elastic_force(self, overlap, pair):
        """k d [N]"""
        return self.stiffness * overlap

    def elastic_energy(self, overlap, pair):
        """k d^2 / 2 [J]"""
        return 0.5 * self.stiffness * overlap * overlap

    def normal_damping(self, overlap, pair):
        """2 beta sqrt(k m*) [N s/m]"""
        return 2.0 * pair.damping_ratio * math.sqrt(self.stiffness * pair.effective_mass)

    def tangential_stiffness(self, overlap, pair):
        """k_t = shear_ratio k [N/m]"""
        return self.shear_ratio * self.stiffness

    def tangential_damping(self, overlap, pair):
        """2 beta sqrt(k_t m*) [N s/m]"""
        stiffness = self.shear_ratio * self.stiffness
        return self.shear_damping * 2.0 * pair.damping_ratio * math.sqrt(stiffness * pair.effective_mass)


class NoRolling(NamedTuple):
    """Spheres roll freely."""

    factor: float = 0.0

    def active(self):
        return False

    def memory_size(self):
        return 0

    def rolling_stiffness(self, normal_stiffness, pair):
        return 0.0

    def rolling_damping(self, stiffness, time_step, pair):
        return 0.0

    def rolling_limit(self, load, pair):
        return 0.0


class ConstantTorque(NamedTuple):
    """A torque mu_r F_n R* against the relative rolling velocity (Ai et al. 2011, model A; "directional constant torque").

    Within one time step the torque never does more than stop the rolling: its "dashpot" is the rolling inertia over the step.
    """

    factor: float = 1.0  # [-] on rolling_friction

    def active(self):
        return True

    def memory_size(self):
        return 0

    def rolling_stiffness(self, normal_stiffness, pair):
        return 0.0

    def rolling_damping(self, stiffness, time_step, pair):
        """I_r / dt [N m s], with I_r the smaller body's inertia about the contact, 7/5 m* R*^2 at least"""
        return 1.4 * pair.effective_mass * pair.effective_radius * pair.effective_radius / time_step

    def rolling_limit(self, load, pair):
        """mu_r F_n R* [N m]"""
        return self.factor * pair.rolling_friction * load * pair.effective_radius


class ElasticPlasticRolling(NamedTuple):
    """A rolling spring and dashpot that slip at mu_r F_n R* (Ai et al. 2011, model C; Iwashita and Oda 1998).

    k_r = 2.25 k_n (mu_r R*)^2 and C_r = 2 eta sqrt(I_r k_r): a heap at rest stays at rest, where a constant torque rocks.
    """

    damping: float = 0.3  # [-] eta, of the rolling dashpot while the spring holds
    stiffness_factor: float = 2.25  # [-]

    def active(self):
        return True

    def memory_size(self):
        return 3

    def rolling_stiffness(self, normal_stiffness, pair):
        """2.25 k_n (mu_r R*)^2 [N m/rad]"""
        arm = pair.rolling_friction * pair.effective_radius
        return self.stiffness_factor * normal_stiffness * arm * arm

    def rolling_damping(self, stiffness, time_step, pair):
        """2 eta sqrt(I_r k_r) [N m s]"""
        inertia = 1.4 * pair.effective_mass * pair.effective_radius * pair.effective_radius
        return 2.0 * self.damping * math.sqrt(inertia * stiffness)

    def rolling_limit(self, load, pair):
        """mu_r F_n R* [N m]"""
        return pair.rolling_friction * load * pair.effective_radius


class NoTwisting(NamedTuple):
    """Spheres spin freely about the contact normal."""

    factor: float = 0.0

    def active(self):
        return False

    def memory_size(self):
        return 0

    def twisting_stiffness(self, tangential_stiffness, overlap, pair):
        return 0.0

    def twisting_limit(self, load, overlap, pair):
        return 0.0


class FrictionTwisting(NamedTuple):
    """Friction of the contact circle against spin about the normal (Marshall 2009, eqs 27-32).

    k = S_t a^2 / 2 and limit 2/3 a mu F_n, with a = sqrt(R* d) the radius of the contact circle.
    """

    factor: float = 1.0  # [-] on the limit

    def active(self):
        return True

    def memory_size(self):
        return 1

    def twisting_stiffness(self, tangential_stiffness, overlap, pair):
        """S_t a^2 / 2 [N m/rad]"""
        return 0.5 * tangential_stiffness * pair.effective_radius * overlap

    def twisting_limit(self, load, overlap, pair):
        """2/3 a mu F_n [N m]"""
        return self.factor * 2.0 / 3.0 * math.sqrt(pair.effective_radius * overlap) * pair.friction * load


class Contact(NamedTuple):
    """The laws of one model, for particles and walls alike."""

    force: Any = HertzMindlin()
    rolling: Any = NoRolling()
    twisting: Any = NoTwisting()


class Kinematics(NamedTuple):
    """Where and how two bodies touch (scalars, one frame)."""

    overlap: float  # [m]
    nx: float  # normal, from the partner to the particle
    ny: float
    nz: float
    vx: float  # [m/s] velocity of the particle's contact point relative to the partner's
    vy: float
    vz: float
    wx: float  # [rad/s] angular velocity of the particle relative to the partner's
    wy: float
    wz: float
    spin: float  # [rad/s] mean angular velocity of the two bodies about the normal


class Memory(NamedTuple):
    """What a contact remembers from one step to the next.

    `sx, sy, sz` is the tangential displacement one half step ahead, s + v_t dt/2: the trapezoidal rule in one number,
    so that displacement is second order in the step with velocities at whole steps. `stiffness` is the tangential
    stiffness that it was stored at; 0 marks a contact without history.
    """

    sx: float  # [m]
    sy: float
    sz: float
    stiffness: float  # [N/m]
    rx: float  # [rad] rolled angle held by the rolling spring, one half step ahead like s
    ry: float
    rz: float
    twist: float  # [rad]


class Response(NamedTuple):
    """Force and couple on the particle (the partner gets the opposite), and where the energy went."""

    normal_force: float  # [N] along n, never negative
    fx: float  # [N] tangential force
    fy: float
    fz: float
    mx: float  # [N m] rolling and twisting couple
    my: float
    mz: float
    slip_power: float  # [W] dissipated by Coulomb slip
    stiffness_power: (
        float  # [W] lost as the tangential stiffness changes under load (the spring law's micro-slip)
    )
    damping_power: float  # [W] dissipated by dashpots
    rolling_power: float  # [W] dissipated by rolling and twisting
    slip: float  # [m] slid in this step


@inlined
def carry(x, y, z, nx, ny, nz, turn):
    """Turn a stored tangential vector with the contact: by `turn` [rad] about n, then into the new tangent plane, length kept."""
    before = dot(x, y, z, x, y, z)
    tx, ty, tz = cross(nx, ny, nz, x, y, z)
    x, y, z = x + turn * tx, y + turn * ty, z + turn * tz
    x, y, z = tangent(x, y, z, nx, ny, nz)
    after = dot(x, y, z, x, y, z)
    scale = math.sqrt(before / after) if after > 0.0 else 0.0
    return x * scale, y * scale, z * scale


@inlined
def spring_slider(ux, uy, uz, vx, vy, vz, stiffness, damping, limit):
    """A spring that slips at `limit`, and a dashpot that adds what the limit leaves: force, spring displacement, slip, power.

    The dashpot's force is -g c v with the largest g in [0, 1] that keeps |k u + g c v| within the limit. So both only ever
    dissipate, sliding friction is the limit from the first touch on, and no energy comes back that was not put in.
    """
    length = norm(ux, uy, uz)
    pull = stiffness * length
    factor = limit / pull if pull > limit else 1.0
    hold = stiffness * factor
    kx, ky, kz = hold * ux, hold * uy, hold * uz
    dx, dy, dz = damping * vx, damping * vy, damping * vz
    square = dot(dx, dy, dz, dx, dy, dz)
    along = dot(kx, ky, kz, dx, dy, dz)
    room = limit * limit - dot(kx, ky, kz, kx, ky, kz)
    room = room if room > 0.0 else 0.0
    root = math.sqrt(along * along + square * room)
    over = (
        room if along > 0.0 else root - along
    )  # the same root of the quadratic, written so that nothing cancels
    under = root + along if along > 0.0 else square
    part = over / under if under > 0.0 else 0.0
    part = part if part < 1.0 else 1.0
    part = part if square > 0.0 else 0.0
    slid = (1.0 - factor) * length
    power = part * damping * dot(vx, vy, vz, vx, vy, vz)
    return (
        -kx - part * dx,
        -ky - part * dy,
        -kz - part * dz,
        factor * ux,
        factor * uy,
        factor * uz,
        slid,
        power,
    )


@inlined
def respond(contact, pair, touch, memory, time_step):
    """Forces of one contact, what it remembers, and the power it dissipates: the one place where laws become forces.

    Overlap must be positive. The stored displacement is carried with the contact frame. As overlap grows the spring *force* is kept,
    as it shrinks the *displacement* is kept, so a change of stiffness never creates energy (Walton and Braun 1986; Thornton 2013).
    """
    law = contact.force
    approach_speed = -dot(touch.vx, touch.vy, touch.vz, touch.nx, touch.ny, touch.nz)
    elastic = law.elastic_force(touch.overlap, pair)
    whole = elastic + law.normal_damping(touch.overlap, pair) * approach_speed
    load = whole if whole > 0.0 else 0.0
    vx, vy, vz = tangent(touch.vx, touch.vy, touch.vz, touch.nx, touch.ny, touch.nz)

    stiffness = law.tangential_stiffness(touch.overlap, pair)
    sx, sy, sz = carry(memory.sx, memory.sy, memory.sz, touch.nx, touch.ny, touch.nz, touch.spin * time_step)
    growth = memory.stiffness / stiffness
    ratio = growth if growth < 1.0 else 1.0
    lost = 0.5 * stiffness * (growth - ratio * ratio) * (sx * sx + sy * sy + sz * sz)
    half, rate = 0.5 * time_step, 1.0 / time_step
    ux, uy, uz = sx * ratio + half * vx, sy * ratio + half * vy, sz * ratio + half * vz
    limit = pair.friction * load
    shear_damping = law.tangential_damping(touch.overlap, pair)
    fx, fy, fz, hx, hy, hz, slip, power = spring_slider(
        ux, uy, uz, vx, vy, vz, stiffness, shear_damping, limit
    )

    mx, my, mz, rx, ry, rz, twist, rolling_power = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    along = dot(touch.wx, touch.wy, touch.wz, touch.nx, touch.ny, touch.nz)
    if contact.rolling.active():
        wx, wy, wz = touch.wx - along * touch.nx, touch.wy - along * touch.ny, touch.wz - along * touch.nz
        secant = elastic / touch.overlap
        spring = contact.rolling.rolling_stiffness(secant, pair)
        dashpot = contact.rolling.rolling_damping(spring, time_step, pair)
        rx, ry, rz = carry(
            memory.rx, memory.ry, memory.rz, touch.nx, touch.ny, touch.nz, touch.spin * time_step
        )
        lost += 0.5 * spring * (growth - ratio * ratio) * (rx * rx + ry * ry + rz * rz)
        rx, ry, rz = rx * ratio + half * wx, ry * ratio + half * wy, rz * ratio + half * wz
        most = contact.rolling.rolling_limit(load, pair)
        mx, my, mz, rx, ry, rz, rolled, rolling_power = spring_slider(
            rx, ry, rz, wx, wy, wz, spring, dashpot, most
        )
        rolling_power += most * rolled * rate
        rx, ry, rz = rx + half * wx, ry + half * wy, rz + half * wz
    if contact.twisting.active():
        spring = contact.twisting.twisting_stiffness(stiffness, touch.overlap, pair)
        most = contact.twisting.twisting_limit(load, touch.overlap, pair)
        angle = memory.twist + half * along
        tx, _, _, hold, _, _, turned, _ = spring_slider(angle, 0.0, 0.0, along, 0.0, 0.0, spring, 0.0, most)
        mx, my, mz = mx + tx * touch.nx, my + tx * touch.ny, mz + tx * touch.nz
        rolling_power += most * turned * rate
        twist = hold + half * along
    return (
        Response(
            load,
            fx,
            fy,
            fz,
            mx,
            my,
            mz,
            limit * slip * rate,
            lost * rate,
            (load - elastic) * approach_speed + power,
            rolling_power,
            slip,
        ),
        Memory(hx + half * vx, hy + half * vy, hz + half * vz, stiffness, rx, ry, rz, twist),
    )
