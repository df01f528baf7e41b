"""Effects against values worked out by hand; how features reach them; what is refused."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import ShellMesh
from wearfem.loads import FacetLoads
from wearfem.material import Material
from wearfem.wear import effects
from wearfem.wear.effect import FactorEffect, Log, all_factors
from wearfem.wear.features import FEATURES, features

EXACT = 1e-14  # relative: a few roundings
LOG = Log((0.0, 100.0), (20.0, 40.0))

# effect, features, factor by hand
BY_HAND = [
    (effects.HardnessGradient(10.0), {"depth": 0.02}, 1.0 / 0.8),
    (effects.HardnessGradient(10.0, exponent=2.0), {"depth": 0.02}, 1.0 / 0.64),
    (effects.HardnessGradient(10.0, core=0.5), {"depth": 0.09}, 2.0),
    (effects.Overlay(0.005, 3.0), {"depth": 0.0049}, 1.0),
    (effects.Overlay(0.005, 3.0), {"depth": 0.005}, 3.0),
    (effects.Overlay(0.005, 3.0, 0.002), {"depth": 0.0055}, 2.5),
    (effects.RunningIn(0.8, 1e-3), {"depth": 1e-3 * math.log(2.0)}, 1.4),
    (effects.RunningInByThroughput(0.8, 1e6), {"throughput": 1e6 * math.log(4.0)}, 1.2),
    (effects.WorkHardening(0.4, 5e5), {"impact_work": 5e5 * math.log(2.0)}, 0.8),
    (effects.WorkHardeningByDepth(0.4, 1e-3), {"depth": 1e-3 * math.log(4.0)}, 0.7),
    (effects.OreChange((2e6, 5e6), (1.5, 0.7)), {"throughput": 1.9e6}, 1.0),
    (effects.OreChange((2e6, 5e6), (1.5, 0.7)), {"throughput": 2e6}, 1.5),
    (effects.OreChange((2e6, 5e6), (1.5, 0.7)), {"throughput": 9e6}, 0.7),
    (effects.OreChangeByTime((3600.0,), (1.5,)), {"service_time": 3601.0}, 1.5),
    (effects.OreHardness(2.0, 5e9), {"ore_hardness": 6e9}, 1.44),
    (effects.Temperature(math.log(2.0) / 100.0, 20.0), {"temperature": 120.0}, 2.0),
    (effects.PressureExponent(1.5, 1e4), {"pressure": 4e4}, 2.0),
    (effects.PressureExponent(0.5, 1e4), {"pressure": 4e4}, 0.5),
    (effects.PressureExponent(0.5, 1e4), {"pressure": 0.0}, 1.0),
    (effects.PressureExponent(1.5, 1e4), {"pressure": 0.0}, 0.0),
    (effects.SpeedExponent(2.0, 5.0), {"slip_speed": 10.0}, 4.0),
    (effects.ImpactAngleCurve((0.0, 0.5, 1.5), (0.2, 1.0, 0.5)), {"impact_angle": 1.0}, 0.75),
    (effects.SlipShare(0.1, 0.5), {"mobilised_friction": 0.25}, 0.55),
    (effects.SlipShare(0.1, 0.5), {"mobilised_friction": 0.9}, 1.0),
    (effects.BuildUp((0.0, 0.0, 0.0), 1.0), {"position": np.array([0.0, 0.6, 0.7]), "throughput": 0.0}, 0.0),
    (effects.BuildUp((0.0, 0.0, 0.0), 1.0), {"position": np.array([0.0, 0.8, 0.7]), "throughput": 0.0}, 1.0),
    (effects.BuildUp((0, 0, 0), 1.0, 0.2, 5.0), {"position": np.zeros(3), "throughput": 4.0}, 1.0),
    (effects.BuildUp((0, 0, 0), 1.0, 0.2, 5.0), {"position": np.zeros(3), "throughput": 5.0}, 0.2),
    (effects.DeadZone(0.1, 0.3), {"slip_speed": 0.05}, 0.3),
    (effects.DeadZone(0.1, 0.3), {"slip_speed": 0.1}, 1.0),
    (effects.LateralBias(0.5, (0.0, 2.0, 0.0)), {"position": np.array([9.0, 0.4, 9.0])}, 1.2),
    (effects.LateralBias(0.5, (0.0, 2.0, 0.0)), {"position": np.array([9.0, -3.0, 9.0])}, 0.0),
    (
        effects.AngularityLoss(2.0, (3.0, 0.0, 0.0)),
        {"position": np.array([2.0 * math.log(2.0), 5.0, 5.0])},
        0.5,
    ),
    (effects.AngularityLoss(2.0, (3.0, 0.0, 0.0)), {"position": np.array([-1.0, 5.0, 5.0])}, 1.0),
    (effects.FactorCurve("pressure", (1e3, 2e3), (1.0, 2.0)), {"pressure": 1.25e3}, 1.25),
    (effects.FactorCurve("pressure", (1e3, 2e3), (1.0, 2.0)), {"pressure": 5e3}, 2.0),
    (
        effects.FactorCurve("position", (0.0, 1.0), (1.0, 3.0), 1),
        {"position": np.array([9.0, 0.5, 9.0])},
        2.0,
    ),
]


@pytest.mark.parametrize(("effect", "given", "expected"), BY_HAND, ids=lambda x: type(x).__name__)
def test_factor_by_hand(effect, given, expected):
    assert set(given) == set(effect.needs) <= set(FEATURES)
    assert float(effect.factor(**given)) == pytest.approx(expected, rel=EXACT)
    # a survey has one value for each reading
    many = {name: np.array([value, value]) for name, value in given.items()}
    assert np.shape(effect.factor(**many)) == (2,)
    assert effect.factor(**many).tolist() == [float(effect.factor(**given))] * 2


def test_every_effect_has_a_value_by_hand():
    tested = {type(effect) for effect, _, _ in BY_HAND}
    there = {one for one in vars(effects).values() if isinstance(one, type) and issubclass(one, FactorEffect)}
    assert there - {FactorEffect} == tested


def liner(service_time=50.0):
    """A square shell of two triangles, 2 and 1 mm worn."""
    node = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 3.0, 0.0], [0.0, 3.0, 0.0]])
    element = np.array([[0, 1, 2], [0, 2, 3]])
    mesh = ShellMesh(node, element, np.full(4, 0.02), np.zeros(4), {"wear": element})
    steel = Material("steel", 7850.0, 7.8e10, 0.3)
    return Liner(mesh, steel, np.array([2e-3, 1e-3]), service_time, 7e6)


def loads():
    """Two blocks of 1 s and 3 s; the second facet has no contact."""
    zeros = {name: np.zeros((2, 2)) for name in FacetLoads.__dataclass_fields__}
    push = np.zeros((2, 2, 3))
    push[:, 0, 0] = 4.0
    energy, moment = np.zeros((2, 2, 9, 5)), np.zeros((2, 2, 9, 5, 5))
    energy[0, 0, 3, 3], moment[0, 0, 3, 3] = 8.0, 8.0 * np.array([0.6, 0.36, 0.0, 0.0, 0.0])
    given = {"duration": np.array([1.0, 3.0]), "area": np.array([4.5, 4.5]), "tangential_impulse": push}
    given |= {"normal_impulse": np.array([[6.0, 0.0], [30.0, 0.0]]), "impact_energy": energy}
    given |= {"load_distance": np.array([[12.0, 0.0], [60.0, 0.0]]), "impact_moment": moment}
    return FacetLoads(**(zeros | given))


def test_features_by_hand():
    expected = {
        "depth": [2e-3, 1e-3],
        "service_time": 50.0,
        "throughput": 7e6,
        "position": [[2.0, 1.0, 0.0], [1.0, 2.0, 0.0]],
        "pressure": [36.0 / (4.5 * 4.0), 0.0],
        "slip_speed": [72.0 / 36.0, 0.0],
        "mobilised_friction": [8.0 / 36.0, 0.0],
        "impact_angle": [0.6, 0.0],
        "impact_work": [8.0 / (4.5 * 4.0) * 50.0, 0.0],
    }
    found = features(tuple(expected), loads(), liner())
    assert set(expected) == {name for name, feature in FEATURES.items() if feature.of}
    for name, value in expected.items():
        # the spread of a beam comes out as the root of a rounding, 1e-8
        np.testing.assert_allclose(found[name], value, rtol=1e-7 if name == "impact_angle" else EXACT)


def test_modify_multiplies_each_facet():
    rate = np.array([[1.0, 2.0], [3.0, 4.0]])
    effect = effects.HardnessGradient(100.0)
    modified = effect.modify(rate, loads(), liner())
    np.testing.assert_allclose(modified, rate / [0.8, 0.9], rtol=EXACT)
    assert rate.tolist() == [[1.0, 2.0], [3.0, 4.0]]  # the given rate is left alone


def test_one_value_for_all_facets():
    rate = np.ones((2, 2))
    warm = effects.Temperature(0.01, 20.0, LOG).modify(rate, loads(), liner())
    np.testing.assert_allclose(warm, math.exp(0.1), rtol=EXACT)  # 30 degrees after 50 s
    hard = effects.OreHardness(1.0, 15.0, LOG).modify(rate, loads(), liner(service_time=500.0))
    np.testing.assert_allclose(hard, 40.0 / 15.0, rtol=EXACT)  # constant beyond the log
    ore = effects.OreChange((5e6,), (1.5,)).modify(rate, loads(), liner())
    np.testing.assert_allclose(ore, 1.5, rtol=EXACT)


def test_corrosion_adds():
    rate = np.array([[0.0, 2.0], [3.0, 4.0]])
    slow = effects.Corrosion(1.0, calendar_per_service=1.5)
    np.testing.assert_array_equal(slow.modify(rate, loads(), liner()), rate + 1.5)
    assert slow.addition() == 1.5


def test_all_factors():
    both = (effects.HardnessGradient(10.0), effects.SpeedExponent(2.0, 5.0))
    known = {"depth": np.array([0.02, 0.0]), "slip_speed": np.array([10.0, 5.0]), "pressure": 1.0}
    np.testing.assert_allclose(all_factors(both, known), [5.0, 1.0], rtol=EXACT)
    assert all_factors((), known) == 1.0
    with pytest.raises(UserError, match="SpeedExponent needs slip_speed; known are depth"):
        all_factors(both, {"depth": 0.0})


@pytest.mark.parametrize("effect", [effects.Temperature(0.01, 20.0), effects.OreHardness(1.0, 5e9)])
def test_without_a_log_a_run_is_refused(effect):
    with pytest.raises(UserError, match="give the effect a `log`"):
        effect.modify(np.ones((2, 2)), loads(), liner())


@dataclass(frozen=True)
class Moon(FactorEffect):
    needs = ("phase",)

    def factor(self, *, phase):
        return phase


def test_a_feature_that_does_not_exist():
    with pytest.raises(UserError, match="no feature phase; the features are depth, impact_angle"):
        Moon().modify(np.ones((2, 2)), loads(), liner())


@pytest.mark.parametrize(
    "make",
    [
        lambda: effects.HardnessGradient(math.nan),
        lambda: effects.HardnessGradient(10.0, core=0.0),
        lambda: effects.Overlay(-1e-3, 2.0),
        lambda: effects.RunningIn(-1.5, 1e-3),
        lambda: effects.RunningIn(1.0, 0.0),
        lambda: effects.WorkHardening(1.5, 1e5),
        lambda: effects.OreChange((), ()),
        lambda: effects.OreChange((1.0, 2.0), (1.0,)),
        lambda: effects.OreChange((2.0, 1.0), (1.0, 1.0)),
        lambda: effects.OreChange((1.0,), (-1.0,)),
        lambda: effects.Corrosion(-1e-12),
        lambda: effects.Corrosion(1e-12, 0.5),
        lambda: effects.PressureExponent(1.0, 0.0),
        lambda: effects.SlipShare(0.1, 0.0),
        lambda: effects.LateralBias(1.0, (0.0, 0.0, 0.0)),
        lambda: effects.AngularityLoss(0.0, (1.0, 0.0, 0.0)),
        lambda: Log((1.0, 1.0), (2.0, 3.0)),
    ],
)
def test_what_means_nothing_is_refused(make):
    with pytest.raises(UserError, match="must|needs"):
        make()
