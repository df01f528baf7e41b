"""The eight impact tests of Chung and Ooi (2011), on planes and on meshes, against closed forms and an independent integrator."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from wearfem.dem.contact import HertzMindlin, LinearSpringDashpot
from wearfem.jit import set_thread_count, thread_count
from wearfem.proof import Claim
from wearfem.proofs._impact_rig import MESH, Cut, Rig, grid, scattered
from wearfem.verification import impact_tests as published
from wearfem.verification import impact_theory as theory
from wearfem.verification.impact_tests import ImpactTest, Variant
from wearfem.verification.impact_theory import Sphere
from wearfem.verification.oblique_theory import (
    incidence,
    partial_slip_rebound,
    sliding_incidence,
    spring_rebound,
)
from wearfem.verification.rigid_impact import Impact, Rebound, rigid_rebound, slip_velocity

CHUNG_OOI = "Chung and Ooi (2011), Granular Matter 13, 643"
HERTZ = "Hertz: Johnson (1985), Contact Mechanics, section 11.4"
DAMPED = "damped oscillator without tension: Schwager and Poeschel (2007); Antypov and Elliott (2011)"
RIGID = "rigid bodies with friction: Walton (1993); Foerster et al. (1994), Phys. Fluids 6, 1108"
SAME_LAW = "the same law integrated from event to event by DOP853 (verification/oblique_theory.py)"
PARTIAL_SLIP = "Maw, Barber and Fawcett (1976), Wear 38, 101, by 400 rings"


def rig(test: ImpactTest, variant: Variant, cut: Cut | None = None) -> Rig:
    """The rig of a published test."""
    return Rig(variant, test.friction, test.restitutions[0], cut=cut)


def walls_of(variant: Variant) -> dict[str, Cut | None]:
    """What body 2 is made of in turn, with words for it: a plane and a mesh, or nothing to choose for a sphere."""
    return {"": None} if isinstance(variant.second, Sphere) else {" on a plane": None, " on a mesh": MESH}


def linear_law(rig: Rig, speed: float) -> LinearSpringDashpot:
    """The linear spring whose contact lasts as long as Hertz's at `speed`: k = m* (pi/T)^2."""
    duration = theory.hertz_impact(rig.pair, speed).duration
    return LinearSpringDashpot(rig.pair.effective_mass * (math.pi / duration) ** 2)


# ------------------------------------------------------------------------------------------- normal impacts


def claims() -> Iterator[Claim]:
    """All claims, test by test; on one thread, since two bodies give others nothing to do but wait."""
    threads = thread_count()
    set_thread_count(1)
    try:
        yield from normal_claims()
        yield from restitution_claims()
        yield from order_claims()
        yield from sliding_claims()
        yield from spinning_alike_claims()
        yield from same_law_claims()
        yield from partial_slip_claims()
        yield from mesh_claims()
    finally:
        set_thread_count(threads)


def normal_claims() -> Iterator[Claim]:
    """Tests 1 and 2: elastic normal impacts are Hertz's."""
    for test in (published.NORMAL_SPHERES, published.NORMAL_PLANE):
        for variant in test.variants:
            for words, cut in walls_of(variant).items():
                one = rig(test, variant, cut)
                impact = test.impacts[0]
                found, told = one.watch(impact), one.expected(impact.approach_speed)
                name = f"test {test.number}, {variant.name}{words}"
                for what, unit in (("duration", "s"), ("maximum_force", "N"), ("maximum_overlap", "m")):
                    yield Claim(
                        f"{name}: {what.replace('_', ' ')}",
                        HERTZ,
                        getattr(told, what),
                        getattr(found, what),
                        unit,
                        0.005,
                        True,
                    )
                yield Claim(
                    f"{name}: restitution", "energy is kept", 1.0, found.restitution, "-", 0.002, False
                )


def restitution_claims() -> Iterator[Claim]:
    """Test 3: what restitution is asked for is what comes out, for both force laws."""
    test = published.RESTITUTION
    impact = test.impacts[0]
    for variant in test.variants:
        for words, cut in walls_of(variant).items():
            base = rig(test, variant, cut)
            for law in (HertzMindlin(), linear_law(base, impact.approach_speed)):
                rigs = [replace(base, law=law, restitution=e) for e in test.restitutions]
                found = [one.watch(impact) for one in rigs]
                told = [one.expected(impact.approach_speed) for one in rigs]
                name = f"test 3, {variant.name}{words}, {type(law).__name__}"
                for what, unit in (("duration", "s"), ("maximum_force", "N"), ("maximum_overlap", "m")):
                    yield worst(
                        f"{name}: {what.replace('_', ' ')}",
                        DAMPED,
                        test.restitutions,
                        "e",
                        [getattr(one, what) for one in told],
                        [getattr(one, what) for one in found],
                        unit,
                        0.005,
                        True,
                    )
                asked, got = list(test.restitutions), [one.restitution for one in found]
                yield worst(
                    f"{name}: restitution", "the value asked for", asked, "e", asked, got, "-", 0.002, False
                )


def order_claims() -> Iterator[Claim]:
    """How errors fall with the time step: velocity Verlet is of second order while the force is smooth."""
    test = published.RESTITUTION
    impact = test.impacts[0]
    for restitution, expected, tolerance, note in (
        (1.0, 2.0, 0.1, "order of the largest force's error, from 250 and 1000 steps in a contact"),
        (0.5, 1.0, math.inf, "the dashpot's force begins as d^(1/4): its first step is taken too coarsely"),
    ):
        base = replace(rig(test, test.variants[0]), restitution=restitution)
        force = base.expected(impact.approach_speed).maximum_force
        coarse, fine = (abs(replace(base, steps=n).watch(impact).maximum_force - force) for n in (250, 1000))
        yield Claim(
            f"test 3, e = {restitution:g}: order of convergence with the time step",
            "velocity Verlet" if tolerance < math.inf else "a force that is not smooth at first touch",
            expected,
            math.log(coarse / fine) / math.log(4.0),
            "-",
            tolerance,
            False,
            note,
        )


def worst(
    claim: str,
    source: str,
    swept: Sequence[float],
    symbol: str,
    expected: Sequence[float],
    computed: Sequence[float],
    unit: str,
    tolerance: float,
    relative: bool,
    note: str = "",
) -> Claim:
    """The claim about a sweep, with the numbers of its worst point."""
    each = [
        Claim("", "", one, other, unit, tolerance, relative)
        for one, other in zip(expected, computed, strict=True)
    ]
    at = int(np.argmax([one.difference for one in each]))
    words = f"{claim} (worst of {len(each)}, at {symbol} = {swept[at]:.4g})"
    return replace(each[at], claim=words, source=source, note=note)


# ------------------------------------------------------------------------------------------ oblique impacts

OBLIQUE = (
    published.OBLIQUE_ANGLES,
    published.OBLIQUE_SPEEDS,
    published.SPINNING_PLANE,
    published.SPINNING_UNLIKE,
)


def angle_of(rig: Rig, impact: Impact) -> float:
    """Normalised angle of incidence psi_1 [-]."""
    slip = slip_velocity(rig.variant.first, rig.variant.second, impact)
    return incidence(rig.pair, slip, impact.approach_speed, rig.friction)


def reflection_of(rig: Rig, impact: Impact, after: Rebound) -> float:
    """Normalised slip velocity after the impact, psi_2 for e = 1 [-]: kappa slip'/(mu v), positive if it goes on forwards."""
    before = slip_velocity(rig.variant.first, rig.variant.second, impact)
    return (
        rig.pair.stiffness_ratio
        * after.slip_velocity
        / (rig.friction * math.copysign(impact.approach_speed, before))
    )


def theory_of(rig: Rig, impact: Impact) -> Rebound:
    """The rebound of rigid bodies."""
    return rigid_rebound(rig.variant.first, rig.variant.second, impact, rig.friction, rig.restitution)


def sliding_claims() -> Iterator[Claim]:
    """Tests 4, 5, 6 and 8 where the surfaces slide to the end: rigid bodies."""
    for test in OBLIQUE:
        for variant in test.variants:
            for words, cut in walls_of(variant).items():
                name = f"test {test.number}, {variant.name}{words}"
                yield from _sliding(test.impacts, rig(test, variant, cut), name)
    test = published.OBLIQUE_SPEEDS
    slow = [Impact(0.1 * one.approach_speed, (0.1 * one.tangential_velocity[0], 0.0)) for one in test.impacts]
    yield from _sliding(slow, rig(test, test.variants[1]), "test 5 at a tenth of all speeds, polyethylene")


def _sliding(impacts: Sequence[Impact], one: Rig, name: str) -> Iterator[Claim]:
    first, second = one.variant.first, one.variant.second
    sliding = [impact for impact in impacts if theory_of(one, impact).sliding]
    told, found = [theory_of(one, i) for i in sliding], [one.rebound(i) for i in sliding]
    flattened = [spring_law(one, i) for i in sliding]
    angles = [angle_of(one, impact) for impact in sliding]
    speed = max(impact.approach_speed for impact in sliding)
    depth = theory.hertz_impact(one.pair, speed).maximum_overlap / first.radius
    lever = f"friction acts at R - d, where the surfaces touch, in theory at R; here d is up to {100 * depth:.2g} % of R"
    tolerance = 0.01
    if depth > 0.01:
        tolerance, lever = math.inf, lever + "; judged below at a tenth of the speed, with a smaller overlap"

    def compare(
        what: str, value: Callable[[Impact, Rebound], float], tolerance: float, relative: bool, note: str
    ) -> Claim:
        expected, computed = (
            [value(impact, after) for impact, after in zip(sliding, several, strict=True)]
            for several in (told, found)
        )
        claim = f"{name}: {what}"
        return worst(claim, RIGID, angles, "psi_1", expected, computed, "-", tolerance, relative, note)

    yield compare(
        "slip after over slip before",
        lambda impact, after: after.slip_velocity / slip_velocity(first, second, impact),
        tolerance,
        False,
        lever,
    )
    yield compare(
        "slip after over rebound speed",
        lambda impact, after: after.slip_velocity / after.separation_speed,
        math.inf,
        True,
        f"the tangent of the patch's rebound angle, relative to a value that goes through zero near here; {lever}",
    )
    ratio = [[after.slip_velocity / after.separation_speed for after in rows] for rows in (flattened, found)]
    yield worst(
        f"{name}: slip after over rebound speed, friction at R - d",
        SAME_LAW,
        angles,
        "psi_1",
        ratio[0],
        ratio[1],
        "-",
        0.01,
        True,
        "what is left when theory puts friction where the surfaces touch",
    )
    yield compare(
        "surface speed of spin after over approach speed",
        lambda impact, after: first.radius * after.angular_velocity[0] / impact.approach_speed,
        tolerance,
        True,
        lever,
    )
    if any(impact.tangential_velocity[0] for impact in sliding):
        yield compare(
            "tangential restitution of the centre",
            lambda impact, after: after.tangential_velocity[0] / impact.tangential_velocity[0],
            0.01,
            True,
            "friction's impulse is mu times that of the push, wherever it acts",
        )


def spinning_alike_claims() -> Iterator[Claim]:
    """Test 7: touching surfaces that move together stay so."""
    test = published.SPINNING_SPHERES
    for variant in test.variants:
        one = rig(test, variant)
        spins = [impact.angular_velocity[0] for impact in test.impacts]
        found = [one.rebound(impact) for impact in test.impacts]
        rolled = [
            after.tangential_velocity[0] / (variant.first.radius * spin)
            for after, spin in zip(found, spins, strict=True)
        ]
        kept = [after.angular_velocity[0] / spin for after, spin in zip(found, spins, strict=True)]
        name, zeros, ones = f"test 7, {variant.name}", [0.0] * len(spins), [1.0] * len(spins)
        yield worst(
            f"{name}: tangential velocity over R w", CHUNG_OOI, spins, "w", zeros, rolled, "-", 1e-9, False
        )
        yield worst(
            f"{name}: spin after over spin before", CHUNG_OOI, spins, "w", ones, kept, "-", 1e-9, True
        )


def same_law_claims() -> Iterator[Claim]:
    """Tests 4, 5, 6 and 8 at all angles: the engine integrates its law right."""
    for test in OBLIQUE:
        for variant in test.variants:
            one = rig(test, variant)
            angles = [angle_of(one, impact) for impact in test.impacts]
            found = [reflection_of(one, impact, one.rebound(impact)) for impact in test.impacts]
            told = [reflection_of(one, impact, spring_law(one, impact)) for impact in test.impacts]
            yield worst(
                f"test {test.number}, {variant.name}: psi_2 = kappa slip'/(mu v)",
                SAME_LAW,
                angles,
                "psi_1",
                told,
                found,
                "-",
                0.01,
                False,
                "stick and slip, all angles; with friction at R - d in both",
            )


def spring_law(one: Rig, impact: Impact, flattened: bool = True) -> Rebound:
    """The rebound by the independent integrator."""
    return spring_rebound(
        one.variant.first, one.variant.second, impact, one.friction, one.damping, False, flattened=flattened
    )


def partial_slip_claims() -> Iterator[Claim]:
    """Tests 4 and 5 beside partial slip: what a spring that sticks as a whole leaves out, shown at its worst and for steel whole."""
    note = "micro-slip: real contacts slip from their rim inwards, one spring sticks or slips as a whole"
    for test in (published.OBLIQUE_ANGLES, published.OBLIQUE_SPEEDS):
        for variant in test.variants:
            one = rig(test, variant)
            limit = sliding_incidence(one.pair.chi)
            impacts = [impact for impact in test.impacts if angle_of(one, impact) < limit]
            angles = [angle_of(one, impact) for impact in impacts]
            exact = [
                partial_slip_rebound(variant.first, variant.second, impact, test.friction)
                for impact in impacts
            ]
            told = [reflection_of(one, i, after) for i, after in zip(impacts, exact, strict=True)]
            found = [reflection_of(one, impact, one.rebound(impact)) for impact in impacts]
            name = f"test {test.number}, {variant.name}: psi_2 in micro-slip"
            yield worst(name, PARTIAL_SLIP, angles, "psi_1", told, found, "-", math.inf, False, note)
            if variant.name == "steel":
                for angle, expected, computed in zip(angles, told, found, strict=True):
                    yield Claim(
                        f"{name} at psi_1 = {angle:.3f}",
                        PARTIAL_SLIP,
                        expected,
                        computed,
                        "-",
                        math.inf,
                        False,
                    )


# -------------------------------------------------------------------------------------------------- meshes

TILTED = Rotation.from_euler("xyz", (0.4, 0.7, 1.1)).as_matrix()  # a frame along which no coordinate is round


def mesh_claims() -> Iterator[Claim]:
    """Tests 2 to 6: a mesh is a plane, wherever it is hit."""
    cuts = {
        "squares of half a radius": grid(0.5),
        "squares of a fifth of a radius": grid(0.2, turn=0.3, mirrored=True),
        "scattered points": scattered(0.5, seed=3),
    }
    spots = {
        "vertex": (0.0, 0.0),
        "edge": (0.0, 0.07),
        "diagonal": (0.06, 0.06),
        "1e-8 R beside an edge": (0.02, 1e-8),
        "face": (0.11, 0.037),
    }
    for test, impact in (
        (published.RESTITUTION, published.RESTITUTION.impacts[0]),
        (published.OBLIQUE_ANGLES, published.OBLIQUE_ANGLES.impacts[3]),
        (published.OBLIQUE_SPEEDS, published.OBLIQUE_SPEEDS.impacts[13]),
        (published.SPINNING_PLANE, published.SPINNING_PLANE.impacts[9]),
    ):
        plane = replace(rig(test, test.variants[1]), frame=TILTED)
        for words, cut in cuts.items():
            differences = {
                name: difference_from(plane, replace(plane, cut=cut), spot, impact)
                for name, spot in spots.items()
            }
            at = max(differences, key=differences.__getitem__)
            yield Claim(
                f"test {test.number}, mesh of {words}: velocities after, less those on a plane (worst at: {at})",
                "a plane, however it is cut",
                0.0,
                differences[at],
                "impact speeds",
                1e-9,
                False,
            )


def difference_from(plane: Rig, mesh: Rig, spot: tuple[float, float], impact: Impact) -> float:
    """Largest difference of any component of velocity or surface speed between two rigs, over the impact's speed [-].

    `spot` is in radii.
    """
    radius = plane.variant.first.radius
    here = (spot[0] * radius, spot[1] * radius)
    velocity, spin = plane.velocities(impact)
    other_velocity, other_spin = replace(mesh, spot=here).velocities(impact)
    speed = math.hypot(
        impact.approach_speed, slip_velocity(plane.variant.first, plane.variant.second, impact)
    )
    apart = max(np.abs(velocity - other_velocity).max(), radius * np.abs(spin - other_spin).max())
    return float(apart / speed)
