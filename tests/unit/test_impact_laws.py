"""Laws of impact against values worked out by hand, and what the classes of a sample keep."""

import math

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.loads import FacetLoads
from wearfem.wear.impact_laws import (
    DNV,
    Finnie,
    KineticEnergy,
    NeilsonGilchrist,
    Oka,
    ShearImpactEnergy,
    impact_points,
)
from wearfem.wear.laws import Archard, Combined, ShearWork, worn_depth

EXACT = 1e-13  # relative: a dozen roundings
DEGREE = math.pi / 180.0
SPEED_EDGE = 10.0 ** np.arange(-3, 3)
ALL = (
    Finnie(1e9, 0.5),
    KineticEnergy(1e-11, 1.0),
    Oka.sand_on_metal(60e-9, 1.8e9, 3e-3),
    DNV(),
    NeilsonGilchrist(1e10, 5e10, 5.0),
    ShearImpactEnergy(1e9),
)


def loads(*impacts, **given):
    """Two blocks of 2 s and 4 s on three facets, the last without area; impacts are (block, facet, energy, degrees, speed)."""
    zeros = {name: np.zeros((2, 3)) for name in FacetLoads.__dataclass_fields__}
    energy, moment = np.zeros((2, 3, 9, 5)), np.zeros((2, 3, 9, 5, 5))
    for block, facet, joule, degrees, speed in impacts:
        a, v = min(int(degrees / 10.0), 8), int(np.searchsorted(SPEED_EDGE, speed, "right")) - 1
        angle, log = degrees * DEGREE, math.log(speed)
        energy[block, facet, a, v] += joule
        moment[block, facet, a, v] += joule * np.array([angle, angle**2, log, log**2, angle * log])
    kept = {"duration": np.array([2.0, 4.0]), "area": np.array([1e-2, 2e-2, 0.0])}
    kept |= {"impact_energy": energy, "impact_moment": moment, "tangential_impulse": np.zeros((2, 3, 3))}
    kept |= {"angle_edge": np.linspace(0.0, 90.0, 10), "speed_edge": SPEED_EDGE}
    return FacetLoads(**(zeros | kept | given))


def per_joule(law, degrees, speed):
    return float(law.volume_per_energy(np.array(degrees * DEGREE), np.array(speed)))


@pytest.mark.parametrize("degrees", [1.0, 10.0, 18.0])
def test_finnie_leaves_the_surface(degrees):
    # M v^2 / (8 p) (sin 2a - 3 sin^2 a), Svanberg et al. 2021, eq. (4), with M v^2 = 2 J and p = 1e9 Pa
    a = degrees * DEGREE
    expected = 2.0 / 8e9 * (math.sin(2 * a) - 3.0 * math.sin(a) ** 2)
    assert per_joule(Finnie(1e9, cutting_share=0.5), degrees, 7.0) == pytest.approx(expected, rel=EXACT)
    assert per_joule(Finnie(1e9, cutting_share=1.0), degrees, 7.0) == pytest.approx(2 * expected, rel=EXACT)


@pytest.mark.parametrize("degrees", [19.0, 45.0, 89.0])
def test_finnie_stays_in_the_surface(degrees):
    expected = 2.0 / 24e9 * math.cos(degrees * DEGREE) ** 2  # the second line of eq. (4)
    assert per_joule(Finnie(1e9, cutting_share=0.5), degrees, 7.0) == pytest.approx(expected, rel=EXACT)


def test_finnie_is_smooth_where_its_branches_meet():
    law, border, h = Finnie(1e9, 1.0), math.atan(1.0 / 3.0), 1e-6
    before, at, after = law.volume_per_energy(border + np.array([-h, 0.0, h]), np.ones(3))
    # a jump in the slope s would leave s h; the curvature, up to 12 by the formula, leaves h^2 of that
    assert abs(after - 2.0 * at + before) < 20.0 * h**2 * 5e-10


def test_kinetic_energy():
    law = KineticEnergy(3e-12)
    struck = loads((0, 0, 0.5, 5.0, 2.0), (1, 1, 2.0, 85.0, 30.0), friction_work=np.full((2, 3), 0.25))
    np.testing.assert_allclose(law.volume(struck), [3e-12, 12e-12, 0.0], rtol=EXACT)  # K m v^2 = 2 K E
    # with the work of friction, 0.25 J in each of two blocks: 2 K x 0.5 J more
    np.testing.assert_allclose(KineticEnergy(3e-12, 1.0).volume(struck), [6e-12, 15e-12, 3e-12], rtol=EXACT)


def test_oka():
    law = Oka(60e-9, 2e9, 326e-6, sine_exponent=1.0, hardness_exponent=2.0, speed_exponent=2.3)
    # at normal impact and the reference speed: 2 x 60e-9 m3/kg / (104 m/s)^2
    assert per_joule(law, 90.0, 104.0) == pytest.approx(120e-9 / 104.0**2, rel=EXACT)
    # at 30 degrees: sin a = 0.5, g = 0.5 x (1 + 2 x 0.5)^2 = 2; at half the speed 0.5^0.3 of it
    assert per_joule(law, 30.0, 104.0) == pytest.approx(240e-9 / 104.0**2, rel=EXACT)
    assert per_joule(law, 30.0, 52.0) == pytest.approx(240e-9 / 104.0**2 * 0.5**0.3, rel=EXACT)
    # a grain ten times as large: 10^0.19
    large = Oka(60e-9, 2e9, 3260e-6, 1.0, 2.0, 2.3)
    assert per_joule(large, 90.0, 104.0) == pytest.approx(120e-9 / 104.0**2 * 10**0.19, rel=EXACT)
    # at 1 GPa the powers of hardness are 1
    sand = Oka.sand_on_metal(60e-9, 1e9, 1e-3)
    assert (sand.sine_exponent, sand.hardness_exponent, sand.speed_exponent) == (0.71, 2.4, 2.3)


def test_dnv():
    # F(90 degrees) = 0.6 but for exp(-20 pi/2) = 2e-14; at 10 m/s 2 K F 10^0.6 / rho
    assert per_joule(DNV(), 90.0, 10.0) == pytest.approx(2.0 * 2e-9 * 0.6 * 10**0.6 / 7850.0, rel=EXACT)
    # at 30 degrees: 0.6 x (0.5 + 7.2 x 0.25)^0.6 x (1 - exp(-20 pi/6)) = 0.6 x 2.3^0.6 x 0.99997
    expected = 0.6 * 2.3**0.6 * (1.0 - math.exp(-20.0 * math.pi / 6.0))
    assert float(DNV.angle_factor(30.0 * DEGREE)) == pytest.approx(expected, rel=EXACT)
    assert float(DNV.angle_factor(0.0)) == 0.0


def test_neilson_gilchrist():
    law = NeilsonGilchrist(
        cutting_energy=1e10, deformation_energy=5e10, angle_constant=4.5, threshold_speed=2.0
    )
    # normal impact at 10 m/s: (1 - 2/10)^2 / 5e10
    assert per_joule(law, 90.0, 10.0) == pytest.approx(0.64 / 5e10, rel=EXACT)
    # at 30 degrees, above 90/4.5 = 20 degrees, all speed along the surface is spent: 0.75 / 1e10, and (0.5 - 0.2)^2 / 5e10
    assert per_joule(law, 30.0, 10.0) == pytest.approx(0.75e-10 + 0.09 / 5e10, rel=EXACT)
    # at 10 degrees sin(45 degrees) of it; 10 m/s x sin 10 degrees = 1.7 m/s lies below the threshold
    expected = math.cos(10 * DEGREE) ** 2 * math.sqrt(0.5) * 1e-10
    assert per_joule(law, 10.0, 10.0) == pytest.approx(expected, rel=EXACT)


def test_shear_impact_energy():
    rubbed = loads(friction_work=np.array([[4.0, 0.0, 0.0], [0.0, 8.0, 0.0]]))
    law = ShearImpactEnergy(2e9)  # a quarter of 4 J and of 8 J over 2e9 Pa
    np.testing.assert_allclose(law.volume(rubbed), [0.5e-9, 1e-9, 0.0], rtol=EXACT)
    np.testing.assert_allclose(worn_depth(law, rubbed), [0.5e-7, 0.5e-7, 0.0], rtol=EXACT)


def test_combined_is_the_sum():
    both = loads(
        (0, 0, 1.0, 30.0, 3.0),
        (1, 1, 2.0, 60.0, 8.0),
        load_distance=np.ones((2, 3)),
        friction_work=np.ones((2, 3)),
    )
    law = Combined(Archard(1e-12), DNV())
    total = Archard(1e-12).depth_rate(both) + DNV().depth_rate(both)
    np.testing.assert_array_equal(law.depth_rate(both), total)
    np.testing.assert_array_equal(law.volume(both), Archard(1e-12).volume(both) + DNV().volume(both))


@pytest.mark.parametrize("law", ALL, ids=lambda law: type(law).__name__)
def test_depth_rate_and_volume_agree_and_are_never_negative(law):
    random = np.random.default_rng(4)
    hit = [
        (int(b), int(f), e, d, v)
        for b, f, e, d, v in zip(
            random.integers(0, 2, 50),
            random.integers(0, 2, 50),
            random.random(50),
            random.uniform(0.0, 90.0, 50),
            random.uniform(0.01, 30.0, 50),
            strict=True,
        )
    ]
    struck = loads(*hit, friction_work=np.array([[1.0, 2.0, 0.0], [3.0, 0.0, 0.0]]))
    rate = law.depth_rate(struck)
    assert rate.shape == (2, 3)
    assert (rate >= 0.0).all()
    np.testing.assert_allclose(worn_depth(law, struck) * struck.area, law.volume(struck), rtol=EXACT)
    assert (law.depth_rate(loads()) == 0.0).all()  # exactly, where nothing hits


@pytest.mark.parametrize("degrees", [0.0, 3.0, 10.0, 37.0, 90.0])
def test_a_beam_is_kept_exactly(degrees):
    """All impacts at one angle and speed: the points are there, wherever in the class."""
    points = impact_points(
        loads((0, 1, 1.0, degrees, 5.33), (0, 1, 3.0, degrees, 5.33), (1, 0, 2.0, degrees, 5.33))
    )
    # a spread of 0 comes out as the root of a rounding: 1e-8 of the value
    np.testing.assert_allclose(points.angle, degrees * DEGREE, rtol=1e-7, atol=1e-15)
    np.testing.assert_allclose(points.speed, 5.33, rtol=1e-7)
    np.testing.assert_allclose(points.total(points.energy), [[0.0, 4.0, 0.0], [2.0, 0.0, 0.0]], rtol=EXACT)


def test_points_keep_the_moments_of_a_class():
    impacts = [(0, 0, 1.0, 31.0, 2.0), (0, 0, 2.0, 36.0, 3.0), (0, 0, 0.5, 39.0, 7.0)]
    struck = loads(*impacts)
    points = impact_points(struck)
    log = np.log(points.speed)
    for k, power in enumerate((points.angle, points.angle**2, log, log**2, points.angle * log)):
        kept = float((points.energy * power).sum())
        assert kept == pytest.approx(float(struck.impact_moment[0, 0, 3, 3, k]), rel=EXACT)


def test_without_moments_the_middle_of_the_class_stands_for_it():
    points = impact_points(loads((0, 0, 1.0, 31.0, 2.0), impact_moment=None))
    assert points.angle.tolist() == pytest.approx([35.0 * DEGREE], rel=EXACT)
    assert points.speed.tolist() == pytest.approx([math.sqrt(10.0)], rel=EXACT)  # between 1 and 10 m/s


@pytest.mark.parametrize(
    "make",
    [
        lambda: Finnie(0.0, 0.5),
        lambda: Finnie(1e9, -0.5),
        lambda: Finnie(1e9, 0.5, force_ratio=0.0),
        lambda: KineticEnergy(-1e-12),
        lambda: Oka(60e-9, 1e9, 0.0, 0.7, 1.3, 2.3),
        lambda: Oka.sand_on_metal(60e-9, 0.0, 1e-3),
        lambda: DNV(density=0.0),
        lambda: NeilsonGilchrist(0.0, 1e10, 5.0),
        lambda: ShearImpactEnergy(math.nan),
    ],
)
def test_coefficients_that_mean_nothing(make):
    with pytest.raises(UserError, match="must be"):
        make()


def test_the_two_sliding_laws_take_part_in_combined():
    assert Combined(ShearWork(1e-11), KineticEnergy(1e-11)).volume(loads()).tolist() == [0.0, 0.0, 0.0]
