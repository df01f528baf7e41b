"""What a case knows of its metal: plain depths beside integrals by hand, and jumps that need no samples for what is known."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.cycle import first_state
from wearfem.proofs.cycle import ALLOWED, QUIET, RATE, lived, plate, untold
from wearfem.report_facts import wear_by_zone
from wearfem.units import day, mm
from wearfem.wear.effect import Log
from wearfem.wear.effects import BuildUp, Corrosion, FactorCurve, HardnessGradient, Overlay, RunningIn
from wearfem.wear.jump import Bounds, Goal, choose_jump, end_of_life, is_trusted
from wearfem.wear.metal import CHANGE, Metal, in_plain_depths
from wearfem.wear.sampling import Sample

TABLE = (
    CHANGE**2 * ALLOWED
)  # straight lines over cells in which E changes by a part in a hundred, the trapezoid rule
EXACT = 1e-12  # relative: some roundings
NEW = np.zeros(3)


def known(*effects, begun=NEW, allowed=ALLOWED):
    return Metal.known_by(effects, begun, np.full(len(begun), allowed))


@pytest.mark.parametrize(
    ("effect", "plain"),
    [
        (HardnessGradient(50.0), lambda d: d - 25.0 * d**2),
        (
            RunningIn(1.0, 2 * mm),
            lambda d: d + 2 * mm * np.log((1.0 + np.exp(-d / (2 * mm))) / 2.0),
        ),
        (Overlay(4.3 * mm, 3.0), lambda d: np.minimum(d, 4.3 * mm) + np.maximum(d - 4.3 * mm, 0.0) / 3.0),
        (FactorCurve("depth", (0.0, 2.0 * ALLOWED), (1.0, 5.0)), lambda d: ALLOWED / 2.0 * np.log1p(2.0 * d / ALLOWED)),
    ],
)  # fmt: skip
def test_plain_depths_are_integrals(effect, plain):
    for depth in (np.array([0.0, 1 * mm, 4.2 * mm]), np.array([4.4 * mm, 7 * mm, 10 * mm])):
        metal = known(effect)
        assert metal.plain_of(depth) == pytest.approx(plain(depth), abs=TABLE)
        assert metal.depth_of(metal.plain_of(depth)) == pytest.approx(depth, abs=EXACT * ALLOWED)
        assert metal.factor(depth) == pytest.approx(effect.factor(depth=depth), rel=CHANGE**2)
        begun = known(effect, begun=np.full(3, 2 * mm))  # counted from where the facets began
        assert begun.plain_of(depth) == pytest.approx(plain(depth + 2 * mm) - plain(2 * mm), abs=TABLE)
        assert begun.depth_of(begun.plain_of(depth)) == pytest.approx(depth, abs=EXACT * ALLOWED)


def test_a_border_is_met_where_it_is():
    metal = known(Overlay(4.3 * mm, 3.0))
    ends = 4.3 * mm + (np.array([5.0, 7.0, 10.0]) * mm - 4.3 * mm) / 3.0
    assert metal.plain_of(np.array([5.0, 7.0, 10.0]) * mm) == pytest.approx(
        ends, rel=1e-9
    )  # 2^-40 of a reach
    assert np.isinf(metal.plain_of(np.full(3, np.inf))).all()


def test_what_never_wears_is_never_worn_out():
    assert (
        known(Overlay(5 * mm, 0.0)).plain_of(np.full(3, 10 * mm)).min() > 1e3
    )  # m: 5 mm over a factor of 1e-6


def test_only_what_depth_alone_tells_is_known():
    case, _ = plate(law="constant", **QUIET)
    others = (
        Corrosion(1e-12),
        BuildUp((0.0, 0.0, 0.0), 0.01),
        FactorCurve("pressure", (0.0, 1.0), (1.0, 2.0)),
        FactorCurve("depth", (0.0, 1.0), (1.0, 2.0), log=Log((0.0, 1.0), (0.0, 1.0))),
    )
    assert first_state(replace(case, effects=others)).now.metal is None
    both = first_state(replace(case, effects=(*others, Overlay(5 * mm, 2.0)))).now.metal
    assert both.factor(np.full(len(both.begun), 6 * mm)) == pytest.approx(2.0, rel=EXACT)


def test_where_nothing_is_known_nothing_is_touched():
    goal = Goal(np.full(3, ALLOWED))
    samples = (Sample(0.0, np.full((8, 3), RATE), 0.25, depth=NEW),)
    assert in_plain_depths(samples, None) is samples
    assert goal.plain is goal


def samples_of(law, times, metal):
    """Exact rates of a law of depth at shapes worn in steps of time, each by the rate before (Euler)"""
    depth, samples = np.zeros(1), []
    for number, time in enumerate(times):
        samples.append(Sample(time, np.repeat(law(depth)[None], 8, axis=0), 0.25, depth=depth))
        if number + 1 < len(times):
            depth = depth + (times[number + 1] - time) * law(depth)
    return samples


def test_a_life_in_a_known_metal_needs_two_samples():
    hard = HardnessGradient(50.0)
    metal = known(hard, begun=np.zeros(1))
    samples = samples_of(lambda d: RATE * hard.factor(depth=d), (0.0, 2e6), metal)
    told = end_of_life(samples, Goal(np.array([ALLOWED]), metal=metal))
    assert told.time == pytest.approx((ALLOWED - 25.0 * ALLOWED**2) / RATE, rel=CHANGE**2)  # closed form
    blind = end_of_life(samples, Goal(np.array([ALLOWED])))
    assert blind.time > 1.05 * told.time


def test_were_the_knowledge_wrong_the_life_would_still_be_right():
    """Running-in is told that is not there: rates over it bend, and the life is that of many samples all the same."""
    metal = known(RunningIn(1.0, 2 * mm), begun=np.zeros(1))
    goal = Goal(np.array([ALLOWED]), tolerance=1e-3, metal=metal)
    errors = []
    for count in (20, 40):
        samples = samples_of(lambda d: RATE * np.ones(1), np.linspace(0.0, ALLOWED / RATE, count + 1), metal)
        told = end_of_life(samples, goal)
        errors.append(abs((told.time + told.bias) * RATE / ALLOWED - 1.0))
    assert errors[0] < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.25)  # order of the trapezoid rule


def test_a_jump_recedes_by_metres_that_wear():
    metal = known(Overlay(0.5 * mm, 3.0), begun=np.zeros(1))
    goal = Goal(np.array([ALLOWED]), metal=metal)
    samples = [Sample(0.0, np.full((40, 1), RATE), 0.25, depth=np.zeros(1))]
    jump = choose_jump(samples, np.zeros(1), goal, at_most=2e6)
    assert jump.duration <= 2e6
    into = RATE * jump.duration - 0.5 * mm  # plain, beyond the border
    assert into > 0.0
    assert jump.recession == pytest.approx(0.5 * mm + 3.0 * into, rel=1e-9)
    there = Sample(jump.duration, np.full((40, 1), 3.0 * RATE), 0.25, depth=jump.recession)
    assert is_trusted([*samples, there, replace(there, service_time=2 * jump.duration)], goal)


def test_bounds_hold_beyond_a_border():
    metal = known(Overlay(1 * mm, 3.0), begun=np.zeros(1))
    goal = Goal(np.array([ALLOWED]), tolerance=0.5, metal=metal)
    samples = [Sample(0.0, np.full((40, 1), RATE), 0.25, depth=np.zeros(1))]
    for bounds in (Bounds(8 * mm), Bounds(particle_radius=8 * mm), Bounds(curvature=np.array([125.0]))):
        jump = choose_jump(samples, np.zeros(1), goal, bounds)
        assert jump.recession[0] <= 2 * mm * (1.0 + 1e-9)  # a quarter; rounding of the table
        assert jump.recession[0] > 1.5 * mm  # equal parts of what is left are taken


@pytest.mark.parametrize("effect", [Overlay(4.3 * mm, 3.0), HardnessGradient(50.0)])
def test_a_known_metal_costs_no_jumps(effect):
    """Five cycles at the bounds of the mesh and no more; the same in the flow costs several times that, and jumps are taken back."""
    case, _ = plate(law="constant", tolerance=1e-3, **QUIET)
    case = replace(case, effects=(effect,))
    metal = known(effect)
    life = float(metal.plain_of(np.full(3, ALLOWED))[0]) / RATE
    history = lived(case)
    assert history.life[-1].time == pytest.approx(life, rel=CHANGE**2)
    assert len(history.reports) < 0.6 * len(lived(untold(case)).reports)
    assert history.rejected == 0


def test_noise_meets_a_known_border_as_a_plate_of_one_metal():
    """In plain depths nothing is left of the layer: the relative error of life is that of the same noise on an even plate."""
    even, _ = plate(law="constant", cells=4)
    layered = replace(even, effects=(Overlay(4.3 * mm, 3.0),))
    ends = [lived(case).life[-1] for case in (even, layered)]
    plain = 4.3 * mm + 5.7 * mm / 3.0
    assert ends[1].time / (plain / RATE) == pytest.approx(
        ends[0].time / (ALLOWED / RATE), abs=0.02
    )  # what is asked
    assert ends[1].noise / ends[1].time == pytest.approx(
        ends[0].noise / ends[0].time, rel=0.5
    )  # windows differ


def test_a_life_that_was_stopped_goes_on_in_the_known_metal():
    case, _ = plate(law="hardness_gradient", stop=20 * day, **QUIET)
    history, life = lived(case), (ALLOWED - 25.0 * ALLOWED**2) / RATE
    assert history.life[-1].time == pytest.approx(life, rel=CHANGE**2)
    for zone in wear_by_zone(history, 0.9):
        assert zone.end is not None
        assert zone.end.time == pytest.approx(life, rel=CHANGE**2)
