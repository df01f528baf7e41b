"""When the liner's bending matters to the flow, and how a bent liner is given to it: two-way stiffness without inertia.

Particles see the worn face as rigid. `flexure` says when that is wrong, `exchange` gives the displacement for
`wear_surface(liner, displacement)` when it is.
"""

from dataclasses import dataclass
from math import atan, exp, inf, pi, sqrt

import numpy as np

from wearfem.errors import UserError, in_words
from wearfem.liner.breakthrough import thickness
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.mesh import WEAR, LinerMesh
from wearfem.liner.solve import Factorised
from wearfem.liner.traction import facet_force
from wearfem.loads import FacetLoads
from wearfem.material import Material

OF_RADIUS = 0.1  # deflection over particle radius: below the spread of sizes in any ore that was screened
OF_FRICTION = (
    0.05  # change of slope over friction angle: a degree in 25, as well as that angle is ever measured
)
OF_OVERLAP = (
    0.05  # yielding in an impact over overlap: as well as a coefficient of restitution is ever measured
)
AMPLIFIED = 0.05  # more than static: the error of leaving inertia out
FIRST_OVERLAP = 1.25**0.4  # largest overlap of a Hertz impact in units of speed x time


@dataclass(frozen=True)
class Ore:
    """What the liner meets, as far as its bending asks."""

    material: Material  # with its true shear modulus, not one softened for longer time steps
    radius: float  # [m] of the particles: the smallest that should feel the liner's true shape
    speed: float  # [m/s] at which they meet it
    friction: float  # [-] between them and the liner
    loading_frequency: (
        float  # [1/s] of the changes of the load: shaking, passes of a scraper, dumps; 0 for a steady flow
    )

    def __post_init__(self) -> None:
        for what in ("radius", "speed", "friction"):
            if not 0.0 < getattr(self, what) < inf:
                raise UserError(
                    f"the ore's {what} is {getattr(self, what)!r}; it must be above 0 and finite."
                )
        if not 0.0 <= self.loading_frequency < inf:
            raise UserError(
                f"the loading frequency is {self.loading_frequency!r} 1/s; it must be 0 or more, and finite."
            )


@dataclass(frozen=True)
class Flexure:
    """How far the liner bends, in units of what the flow notices."""

    deflection: float  # [m] largest of the worn face
    slope: float  # [rad] largest turn of a worn facet
    radius: float  # [m] of the particles
    friction_angle: float  # [rad]
    overlap: float  # [m] of a particle that meets a rigid liner
    yielding: float  # [m] by which the liner gives way under that impact
    frequency: float  # [Hz] lowest of the liner
    loading_frequency: float  # [1/s]

    @property
    def of_radius(self) -> float:
        """Deflection over particle radius: how far the channel moves, as particles see it [-]"""
        return self.deflection / self.radius

    @property
    def of_friction(self) -> float:
        """Change of slope over friction angle: what it changes in the balance of gravity and friction [-]"""
        return self.slope / self.friction_angle

    @property
    def of_overlap(self) -> float:
        """Yielding over overlap; the rebound speed falls by 0.95 times this share [-]"""
        return self.yielding / self.overlap

    @property
    def amplification(self) -> float:
        """Dynamic over static deflection of an undamped liner, 1 / (1 - (f / f_1)^2); infinite from resonance on [-]"""
        ratio = self.loading_frequency / self.frequency
        return 1.0 / (1.0 - ratio**2) if ratio < 1.0 else inf

    @property
    def shape_matters(self) -> bool:
        """Whether particles should meet the bent shape: use `exchange`."""
        return self.of_radius > OF_RADIUS or self.of_friction > OF_FRICTION

    @property
    def impact_matters(self) -> bool:
        """Whether impacts feel the liner give way: lower the coefficient of restitution."""
        return self.of_overlap > OF_OVERLAP

    @property
    def quasi_static(self) -> bool:
        """Whether the liner follows its load without inertia."""
        return self.amplification <= 1.0 + AMPLIFIED

    @property
    def matters(self) -> bool:
        """Whether the flow would notice at all."""
        return self.shape_matters or self.impact_matters or not self.quasi_static

    @property
    def verdict(self) -> str:
        """All of it in a sentence or two."""
        numbers = (
            f"the worn face moves {self.of_radius:.2g} particle radii and turns {self.of_friction:.2g} friction angles, an impact "
            f"pushes it {self.of_overlap:.2g} overlaps"
        )
        if self.loading_frequency:
            numbers += f", and its lowest frequency is {self.frequency / self.loading_frequency:.3g} times that of the load"
        if not self.matters:
            return f"Deflection does not matter to the flow: {numbers}."
        advice = []
        if self.shape_matters:
            advice.append("give the bent shape to the particles (exchange)")
        if self.impact_matters:
            advice.append("lower the coefficient of restitution by what the liner takes")
        if not self.quasi_static:
            advice.append("expect vibration, which is not modelled")
        return f"Deflection matters to the flow: {numbers}; {in_words(advice)}."


def flexure(liner: Liner, displacement: np.ndarray, ore: Ore, frequency: float) -> Flexure:
    """How much the liner's bending matters to the flow.

    Three things that particles would notice, each in its own unit, and whether statics is enough:

    - *Where the face is*: deflection over particle radius. A face that moves less than a tenth of a radius guides the flow as before,
      for particles of one batch differ more.
    - *How it slopes*: turn over friction angle. A particle slides on at g sin(slope - angle) / cos(angle), so slope counts as friction
      angle does, and 5 % of that is what tests repeat.
    - *How it gives way in an impact*: yielding over overlap. Within the time of a contact no wave comes back from the supports, so a
      plate answers as an endless one, by a dashpot Z = 8 sqrt(D rho h): it moves by u = 2 m v / Z while a Hertz overlap reaches
      d = (5/4)^(2/5) v T, T = (m / (k sqrt(v)))^(2/5), k = 4/3 E* sqrt(R). u / d = 1.83 lambda, and the rebound speed falls by
      1.73 lambda, with Zener's lambda = m / (T Z).
    - *Inertia*: at a loading frequency f, deflection is 1 / (1 - (f / f_1)^2) of the static one; below 1.05 for f_1 > 4.6 f.

    The static deflection itself may be many overlaps: a load of many particles adds up. It is no reason of its own, for
    contacts measure overlap from where the face is; but a face that is moved must be moved slowly (`exchange`).

    Parameters
    ----------
    liner
        As it is now; impacts are taken where it is thinnest.
    displacement
        (n, 3) [m] under the load, as `Strength.displacement`.
    ore
        What it meets.
    frequency
        [Hz] its lowest natural one: `lowest_frequencies`.

    Source
    ------
    Zener 1941, Phys. Rev. 59, 669-673 (impact on large plates); Cremer, Heckl and Petersson, Structure-Borne Sound (2005), section 5.1
    (Z). 1.83 = 2 / (5/4)^(2/5) and 1.73 = int x^3 dt of the Hertz impact are worked out in `wearfem verify flexure`.

    Valid for
    ---------
    plates and shells with thickness above the contact's width; u / d up to 0.2 (beyond it, only that it matters); lambda is too
    large for sheets so small that the wave comes back during a contact.
    """
    if not 0.0 < frequency < inf:
        raise UserError(
            f"{liner.mesh.name}: the lowest frequency is {frequency!r} Hz; give that of lowest_frequencies, above 0."
        )
    displacement = _checked(liner.mesh, displacement)
    node = np.unique(liner.mesh.wear)
    before, after = wear_surface(liner), wear_surface(liner, displacement)
    apart = np.linalg.norm(after.normal - before.normal, axis=1)
    left = thickness(liner.mesh)
    overlap, yielding = impact(liner.material, float(left[np.isfinite(left)].min(initial=inf)), ore)
    return Flexure(
        float(np.linalg.norm(displacement[node], axis=1).max()),
        float(2.0 * np.arcsin(0.5 * apart.max())),
        ore.radius,
        atan(ore.friction),
        overlap,
        yielding,
        frequency,
        ore.loading_frequency,
    )


def impact(plate: Material, thick: float, ore: Ore) -> tuple[float, float]:
    """Overlap of a particle with a rigid face, and how far a plate of thickness `thick` yields under that impact [m]; see `flexure`."""
    if thick == inf:
        return 1.0, 0.0
    stiff = [(1.0 - one.poisson_ratio) / (2.0 * one.shear_modulus) for one in (plate, ore.material)]
    mass = 4.0 / 3.0 * pi * ore.radius**3 * ore.material.density
    hertz = 4.0 / 3.0 / sum(stiff) * sqrt(ore.radius)
    time = (mass / (hertz * sqrt(ore.speed))) ** 0.4
    bending = plate.young_modulus * thick**3 / (12.0 * (1.0 - plate.poisson_ratio**2))
    impedance = 8.0 * sqrt(bending * plate.density * thick)
    return FIRST_OVERLAP * ore.speed * time, 2.0 * mass * ore.speed / impedance


def exchange(
    ready: Factorised,
    liner: Liner,
    loads: FacetLoads,
    previous: np.ndarray | None = None,
    *,
    time_constant: float,
) -> np.ndarray:
    """The displacement to give back to the particles, from the load history so far.

    An exponential moving average over the blocks, u <- u + (1 - exp(-dt / tau)) (K^-1 f - u): the answer of a liner in equilibrium
    with its load, behind a first-order lag tau. As K^-1 is linear, the average is taken of the loads and solved for once.

    Why an average: the force on a facet comes from a few particles at a time, and a face that followed each of them would shake the bed by
    noise of the sampling; of noise without memory the average lets through tanh(dt / 2 tau) of the variance. Why exponential: it needs
    no past but `previous`, any blocks go together (two halves of a block do what the whole does), and a
    change of the flow is followed with the one time told here.

    Parameters
    ----------
    ready
        The liner factorised as it is now.
    liner
        The same liner.
    loads
        Of a sample on it, in blocks.
    previous
        (n, 3) [m] the displacement given back before; none at the start, where the average is over these blocks alone.
    time_constant
        tau [s]: longer than a block and than 1 / f_1 of the liner (so that leaving inertia out is right), shorter than the changes of the
        flow that the liner should follow.

    Returns
    -------
    numpy.ndarray
        (n, 3) [m] for `wear_surface(liner, displacement)`. Of a shell, that of its nodes: its worn face turns about
        them besides, by the slope times half the thickness.

    Raises
    ------
    UserError
        for a liner that is not the one factorised, loads of other facets, a displacement of the wrong shape or not finite, a
        time constant that is not above zero.
    """
    body = ready.body
    if body.mesh is not liner.mesh:
        raise UserError(f"{liner.mesh.name} has changed since it was factorised; factorise it again.")
    if not 0.0 < time_constant < inf:
        raise UserError(f"the time constant is {time_constant!r} s; it must be above 0 and finite.")
    fade = loads.duration / time_constant
    later = np.append(np.cumsum(fade[::-1])[::-1][1:], 0.0)
    weight = -np.expm1(-fade) * np.exp(-later)
    new = -np.expm1(-fade.sum())
    if previous is None:
        weight, new = weight / new, 1.0
    force = np.einsum("b,bfa->fa", weight, facet_force(loads, liner))
    load = body.load(WEAR, force) + new * body.weight(np.array(ready.structure.gravity, float))
    answer = ready.respond(load)[: len(liner.mesh.node), :3]
    return answer if previous is None else answer + exp(-fade.sum()) * _checked(liner.mesh, previous)


def _checked(mesh: LinerMesh, displacement: np.ndarray) -> np.ndarray:
    displacement = np.asarray(displacement, float)
    if displacement.shape != mesh.node.shape or not np.isfinite(displacement).all():
        raise UserError(
            f"{mesh.name}: a displacement of shape {displacement.shape} was given; finite numbers in m of shape {mesh.node.shape} are "
            "needed, of this mesh as it is now."
        )
    return displacement
