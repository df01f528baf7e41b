"""The eight impact tests of Chung and Ooi (2011) as data, with the source of each number.

Chung Y.C. and Ooi J.Y., "Benchmark tests for verifying discrete element modelling codes at particle impact
level", Granular Matter 13 (2011) 643-656, doi 10.1007/s10035-011-0277-0. The paper itself was not at hand:
every parameter is read from input files that others published for these tests, and from curves that they
digitised from the paper's figures; `confirmed_by` names them, `unconfirmed` says what rests on one source,
on a reading of a graph, or on our choice.

Conventions of motion and sign are those of `rigid_impact`: body 1 above body 2, x along the plane, angular
velocity positive anticlockwise, so a positive spin or velocity of body 1 moves its surface along +x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from wearfem.verification.impact_theory import Body, Plane, Sphere
from wearfem.verification.rigid_impact import Impact

YADE = "Yade, benchmark scripts 'Chung and Ooi (2011)' Test1-Test4.py (Angelidakis, Chareyre and Caulk, 2023)"
KRATOS = (
    "KratosMultiphysics/Kratos, DEMApplication: benchmark<n>DEM.mdpa or Materials<n>.json, "
    "and DEM_benchmarks_class.py"
)
PYSPH = "PySPH, DEM examples test 1 to 8, which cite doi 10.1007/s10035-011-0277-0"
GRAPHS = (
    "figures of the paper as digitised in KratosMultiphysics/Kratos (paper_data), "
    "DEM3D_chung_ooi_tests/.../benchmark<n>_graph<m>.dat"
)


@dataclass(frozen=True)
class Variant:
    """One pair of bodies of a test, by the name of its material (and case)."""

    name: str
    first: Sphere
    second: Body


@dataclass(frozen=True)
class Comparison:
    """What is held against what: the deviation allowed is relative (`relative`) or in the unit of the
    quantity.
    """

    quantity: str
    against: str
    tolerance: float
    relative: bool
    where: str = "everywhere"


@dataclass(frozen=True)
class PublishedCurve:
    """Points read from a published figure: (x, y) with what they are and who read them."""

    name: str
    x_name: str
    y_name: str
    points: tuple[tuple[float, float], ...]
    source: str


@dataclass(frozen=True)
class ImpactTest:
    """One test: bodies, the impacts swept, friction [-], restitution [-] values, comparisons and sources."""

    number: int
    title: str
    variants: tuple[Variant, ...]
    swept: str
    impacts: tuple[Impact, ...]
    friction: float
    restitutions: tuple[float, ...]
    comparisons: tuple[Comparison, ...]
    confirmed_by: tuple[str, ...]
    unconfirmed: tuple[str, ...] = ()
    published: tuple[PublishedCurve, ...] = ()


RIGID = (
    "The plane is rigid (infinite modulus); Kratos gives its walls 1e20 Pa, Yade a "
    "thousand times the sphere, PySPH the sphere's own modulus."
)

HERTZ = (
    Comparison("duration", "hertz_impact(...).duration", 0.005, True),
    Comparison("maximum force", "hertz_impact(...).maximum_force", 0.005, True),
    Comparison("maximum overlap", "hertz_impact(...).maximum_overlap", 0.005, True),
    Comparison("restitution", "1", 0.002, False),
)

SLIDING = "gross sliding: rigid_rebound(...).sliding, psi_1 > 2 chi (1 + e)"
MICRO_SLIP = "micro-slip: psi_1 < 4 chi - 1"
BESIDE_PARTIAL_SLIP = Comparison(
    "slip velocity after impact",
    "partial_slip_rebound (e = 1), shown beside: the difference of a no-slip spring is reported, not bounded",
    math.inf,
    True,
    MICRO_SLIP,
)
SAME_LAW = Comparison(
    "psi_2 = kappa slip'/(mu v_n)", "spring_rebound (the same law, another integrator)", 0.01, False
)

# -- materials: density kg/m3, elastic modulus Pa, Poisson ratio; each as in the tests below
GLASS = (2800.0, 4.8e10, 0.20)
LIMESTONE = (2500.0, 2.0e10, 0.25)
ALUMINIUM_ALLOY_2 = (2699.0, 7.0e10, 0.30)
MAGNESIUM_ALLOY = (1800.0, 4.0e10, 0.35)
ALUMINIUM_OXIDE = (4000.0, 3.8e11, 0.23)
CAST_IRON = (7000.0, 1.0e11, 0.25)
ALUMINIUM_ALLOY = (2700.0, 7.0e10, 0.33)
STEEL = (7850.0, 2.08e11, 0.30)
POLYETHYLENE = (1400.0, 1.0e9, 0.40)
NYLON = (1000.0, 2.5e9, 0.40)
COPPER = (8900.0, 1.2e11, 0.35)


def _sphere(
    radius: float, material: tuple[float, float, float], stiffer: float = 1.0, denser: float = 1.0
) -> Sphere:
    density, modulus, poisson_ratio = material
    return Sphere(radius, denser * density, stiffer * modulus, poisson_ratio)


def _on_rigid_plane(radius: float, **materials: tuple[float, float, float]) -> tuple[Variant, ...]:
    return tuple(
        Variant(name.replace("_", " "), _sphere(radius, material), Plane(poisson_ratio=material[2]))
        for name, material in materials.items()
    )


def _alike(radius: float, **materials: tuple[float, float, float]) -> tuple[Variant, ...]:
    return tuple(
        Variant(name.replace("_", " "), _sphere(radius, material), _sphere(radius, material))
        for name, material in materials.items()
    )


INCIDENCE_DEGREES = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0)
TANGENTIAL_SPEEDS = (0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.5, 5.0, 6.0, 7.5, 9.0, 15.0, 30.0)
SPINS = tuple(2.0 * math.tan(math.radians(5.0 * step)) for step in range(1, 18))

NORMAL_SPHERES = ImpactTest(
    1,
    "Elastic normal impact of two identical spheres",
    _alike(0.010, glass=GLASS, limestone=LIMESTONE),
    "nothing",
    (Impact(approach_speed=20.0),),
    0.35,
    (1.0,),
    HERTZ,
    (
        YADE + ": both materials, radius, 10 m/s each",
        KRATOS + ": limestone, radius, 10 m/s each",
        PYSPH + ": radius",
    ),
    ("Glass rests on Yade's script, and on the digitised force at 265 um, which fits glass within 0.1 %.",),
    (
        PublishedCurve(
            "glass",
            "overlap [m]",
            "force [N]",
            ((94.286e-6, 2183.9), (148.10e-6, 4232.6), (200.95e-6, 6709.2), (265.24e-6, 10176.4)),
            GRAPHS,
        ),
    ),
)

NORMAL_PLANE = ImpactTest(
    2,
    "Elastic normal impact of a sphere with a rigid plane",
    _on_rigid_plane(0.100, aluminium_alloy=ALUMINIUM_ALLOY_2, magnesium_alloy=MAGNESIUM_ALLOY),
    "nothing",
    (Impact(approach_speed=0.2),),
    0.0,
    (1.0,),
    HERTZ,
    (
        YADE + ": both materials, radius, speed",
        KRATOS + ": aluminium alloy, speed",
        PYSPH + ": radius",
    ),
    ("Magnesium alloy rests on Yade's script alone.", RIGID),
    (
        PublishedCurve(
            "aluminium alloy",
            "overlap [m]",
            "force [N]",
            ((21.025e-6, 3101.1), (34.970e-6, 6741.6), (44.982e-6, 9685.4), (49.988e-6, 11325.8)),
            GRAPHS,
        ),
    ),
)

RESTITUTION = ImpactTest(
    3,
    "Normal impact of a sphere with a rigid plane at different restitution coefficients",
    _on_rigid_plane(0.0025, aluminium_oxide=ALUMINIUM_OXIDE, cast_iron=CAST_IRON),
    "restitution",
    (Impact(approach_speed=3.9),),
    0.0,
    tuple(round(0.1 * step, 1) for step in range(1, 11)),
    (
        Comparison("restitution", "the value asked for", 0.002, False),
        Comparison("duration", "damped_hertz_impact(...).duration", 0.005, True),
        Comparison("maximum force", "damped_hertz_impact(...).maximum_force", 0.005, True),
        Comparison("maximum overlap", "damped_hertz_impact(...).maximum_overlap", 0.005, True),
    ),
    (YADE + ": both materials, radius, speed", KRATOS + ": aluminium oxide, radius, speed, e = 0, 0.2 .. 1"),
    (
        "The paper sweeps e = 0 (or 0.2) to 1 in steps of 0.2; we sweep 0.1 to 1.0.",
        "Cast iron rests on Yade's script alone.",
        RIGID,
    ),
)

OBLIQUE_ANGLES = ImpactTest(
    4,
    "Oblique impact of a sphere with a rigid plane at constant speed and different incidence angles",
    _on_rigid_plane(0.0025, aluminium_oxide=ALUMINIUM_OXIDE, aluminium_alloy=ALUMINIUM_ALLOY),
    "incidence angle from the normal, 5 to 85 degrees",
    tuple(
        Impact(3.9 * math.cos(math.radians(degrees)), (3.9 * math.sin(math.radians(degrees)), 0.0))
        for degrees in INCIDENCE_DEGREES
    ),
    0.092,
    (0.98,),
    (
        Comparison("tangential restitution of the centre", "rigid_rebound", 0.01, True, SLIDING),
        Comparison("angular velocity after impact", "rigid_rebound", 0.01, True, SLIDING),
        Comparison(
            "rebound angle of the contact patch, atan(slip'/v_n')", "rigid_rebound", 0.01, True, SLIDING
        ),
        SAME_LAW,
        BESIDE_PARTIAL_SLIP,
    ),
    (
        YADE + ": both materials, radius, speed, friction, restitution",
        KRATOS + ": aluminium oxide, radius, speed, friction, restitution",
        PYSPH + ": both materials, radius, speed, friction, restitution",
        GRAPHS + ": the angles",
    ),
    (
        "The angles are read from the digitised abscissae (4.90, 9.96, 14.93 .. 84.78 degrees) and rounded.",
        RIGID,
    ),
    (
        PublishedCurve(
            "experiment of Kharaz, Gorham and Salman (2001), aluminium oxide on soda-lime glass",
            "incidence angle [degree]",
            "rebound angle of the contact patch [degree]",
            (
                (2.10, 0.77),
                (3.94, 0.77),
                (9.72, -1.06),
                (20.31, -8.53),
                (30.16, -2.55),
                (39.12, 9.91),
                (49.51, 30.02),
                (59.90, 49.95),
                (70.46, 66.90),
                (78.86, 78.87),
                (84.78, 85.68),
            ),
            GRAPHS,
        ),
        PublishedCurve(
            "DEM of Chung and Ooi (2011), both materials",
            "incidence angle [degree]",
            "rebound angle of the contact patch [degree]",
            (
                (4.90, 3.76),
                (9.96, -1.56),
                (14.93, -5.54),
                (19.99, -7.54),
                (24.96, -7.54),
                (29.92, -3.55),
                (34.96, 3.43),
                (39.92, 11.57),
                (49.83, 29.35),
                (59.99, 47.79),
                (69.74, 64.58),
                (79.82, 78.70),
                (84.78, 84.52),
            ),
            GRAPHS,
        ),
    ),
)

OBLIQUE_SPEEDS = ImpactTest(
    5,
    "Oblique impact of a sphere with a rigid plane at constant normal speed and different tangential speeds",
    _on_rigid_plane(1.0e-5, steel=STEEL, polyethylene=POLYETHYLENE),
    "tangential speed, 0.1 to 30 m/s",
    tuple(Impact(5.0, (speed, 0.0)) for speed in TANGENTIAL_SPEEDS),
    0.3,
    (1.0,),
    (
        Comparison("slip'/(mu v_n')", "rigid_rebound", 0.01, True, SLIDING),
        Comparison("R w'/(mu v_n)", "rigid_rebound", 0.01, True, SLIDING),
        SAME_LAW,
        BESIDE_PARTIAL_SLIP,
    ),
    (
        PYSPH + ": both materials, radius, normal speed, friction, restitution",
        KRATOS + ": steel, radius, normal speed, friction, restitution",
        GRAPHS + ": the tangential speeds",
    ),
    (
        "The speeds are read from the digitised abscissae v_t/(mu v_n) = 0.058 .. 20 and rounded.",
        "Polyethylene rests on PySPH's script alone.",
        RIGID,
    ),
    (
        PublishedCurve(
            "finite elements, elastic sphere on a plane (shown in the paper)",
            "v_t/(mu v_n) [-]",
            "R w'/(mu v_n) [-]",
            (
                (0.318, -0.187),
                (0.595, -0.406),
                (0.890, -0.665),
                (1.185, -0.982),
                (1.532, -1.355),
                (1.896, -1.793),
                (2.277, -2.321),
                (2.763, -2.856),
                (3.301, -3.441),
                (3.890, -4.041),
                (4.688, -4.569),
                (5.659, -4.941),
                (7.029, -4.941),
                (9.040, -4.972),
                (12.335, -4.970),
                (18.803, -4.975),
            ),
            GRAPHS,
        ),
        PublishedCurve(
            "DEM of Chung and Ooi (2011), steel",
            "v_t/(mu v_n) [-]",
            "R w'/(mu v_n) [-]",
            (
                (0.058, -0.106),
                (0.353, -0.430),
                (0.682, -0.820),
                (0.994, -1.250),
                (1.341, -1.664),
                (1.688, -2.094),
                (2.000, -2.524),
                (2.329, -2.978),
                (2.988, -3.904),
                (3.318, -4.293),
                (3.994, -4.837),
                (5.000, -5.007),
                (6.006, -5.006),
                (10.012, -5.004),
                (20.000, -4.991),
            ),
            GRAPHS,
        ),
    ),
)

SPINNING_PLANE = ImpactTest(
    6,
    "Normal impact of a spinning sphere with a rigid plane at different angular velocities",
    _on_rigid_plane(0.100, aluminium_alloy=ALUMINIUM_ALLOY, nylon=NYLON),
    "angular velocity 0.175 to 22.86 rad/s: surface speed over normal speed = tan(5, 10 .. 85 degrees)",
    tuple(Impact(0.2, angular_velocity=(spin, 0.0)) for spin in SPINS),
    0.4,
    (0.5,),
    (
        Comparison(
            "tangential restitution of the contact, -slip'/slip", "rigid_rebound", 0.01, True, SLIDING
        ),
        Comparison("tan of the rebound angle, slip'/v_n'", "rigid_rebound", 0.01, True, SLIDING),
        SAME_LAW,
    ),
    (
        KRATOS + ": aluminium alloy, radius, normal speed, spins, friction, restitution",
        PYSPH + ": nylon's constants, in test 8",
        GRAPHS + " (test 8, curve 'sphere vs rigid surface (test 6)'): 3.5 mu (1 + e) v_n/v_s = "
        "0.187 .. 23.97, so the spins",
    ),
    (
        "That nylon is the second material rests on the labels of Kratos's plots; its "
        "constants are those of PySPH's test 8.",
        RIGID,
    ),
)

SPINNING_SPHERES = ImpactTest(
    7,
    "Impact of two identical spheres at constant normal speed and opposite angular velocities",
    _alike(0.100, aluminium_alloy=ALUMINIUM_ALLOY, copper=COPPER),
    "angular velocity of both, opposite, 0.175 to 22.86 rad/s",
    tuple(Impact(0.4, angular_velocity=(spin, -spin)) for spin in SPINS),
    0.4,
    (0.5,),
    (
        Comparison(
            "tangential velocity of the centres over R w",
            "0: the touching surfaces move together",
            1e-9,
            False,
        ),
        Comparison("angular velocity after impact", "that before impact", 1e-9, True),
    ),
    (
        KRATOS + ": aluminium alloy, radius, 0.2 m/s each, spins, friction, restitution",
        PYSPH + ": copper, radius, 0.2 m/s each, friction, restitution",
        GRAPHS + " (test 7): angular velocities before and after are the same numbers",
    ),
    (
        "PySPH prints 7e11 Pa for the aluminium alloy of this test, 7e10 Pa in all its "
        "others and in Kratos: 7e10 is taken.",
    ),
)

SPINNING_UNLIKE = ImpactTest(
    8,
    "Impact of a spinning sphere with a resting sphere five times larger",
    tuple(
        Variant(f"{name}, case {case}", _sphere(0.100, material), _sphere(0.500, material, stiffer, 1000.0))
        for name, material in (("aluminium alloy", ALUMINIUM_ALLOY), ("nylon", NYLON))
        for case, stiffer in (("A", 1000.0), ("B", 1.0))
    ),
    "angular velocity of the small sphere, 0.175 to 22.86 rad/s",
    tuple(Impact(0.2, angular_velocity=(spin, 0.0)) for spin in SPINS),
    0.4,
    (0.5,),
    (
        Comparison(
            "tangential restitution of the contact, -slip'/slip", "rigid_rebound", 0.01, True, SLIDING
        ),
        Comparison("tan of the rebound angle, slip'/v_n'", "rigid_rebound", 0.01, True, SLIDING),
        Comparison(
            "case A beside test 6",
            "rigid_rebound on a rigid plane (the large sphere weighs 125 000 times more)",
            0.01,
            True,
            SLIDING,
        ),
        SAME_LAW,
    ),
    (
        KRATOS + ": aluminium alloy, radii, spins, case A (density and modulus of the large sphere x "
        "1000), friction, restitution",
        PYSPH + ": both materials, radii, speeds, cases A and B, friction, restitution",
    ),
    (
        "Case B (density x 1000, modulus of the small sphere) rests on PySPH's script; its "
        "case A multiplies the shear modulus of both.",
        "That nylon belongs to this test rests on PySPH's script alone.",
    ),
)

IMPACT_TESTS = (
    NORMAL_SPHERES,
    NORMAL_PLANE,
    RESTITUTION,
    OBLIQUE_ANGLES,
    OBLIQUE_SPEEDS,
    SPINNING_PLANE,
    SPINNING_SPHERES,
    SPINNING_UNLIKE,
)
