"""Two-way stiffness: natural frequencies of plates, when bending matters by hand-worked numbers, and the filtered exchange."""

from collections.abc import Iterator
from dataclasses import replace
from math import exp, gamma, pi, sqrt, tanh

import numpy as np
from scipy.integrate import quad, solve_ivp

from wearfem.liner.block import Cut, Hexahedra, block, mapped, sheet
from wearfem.liner.flexure import FIRST_OVERLAP, Flexure, Ore, exchange, flexure, impact
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import ShellMesh, SolidMesh
from wearfem.liner.solve import Factorised, Load, Structure, factorise
from wearfem.liner.support import EVERY, Fixed, Support, X, Y, Z
from wearfem.liner.traction import facet_force
from wearfem.liner.vibration import lowest_frequencies, mass_matrix
from wearfem.loads import FacetLoads
from wearfem.material import Material
from wearfem.proof import Claim
from wearfem.verification.plate_theory import (
    Plate,
    clamped_frequency,
    clamped_plate,
    supported_frequency,
    supported_plate,
)

STEEL = Material("steel", 7850.0, 80e9, 0.3)
IRON_ORE = Material("iron ore", 4865.0, 65e9, 0.24)  # of the bionic chute
ROCK = Material("rock", 3700.0, 45e9 / 2.6, 0.3)  # of the rope shovel, E = 45 GPa
PRESSURE = 10e3  # [Pa] half a metre of ore
EDGES = [  # simply supported, hard: edges neither sink nor twist, as Mindlin's sine has it; held in the plane at two of them
    Fixed("x_low", EVERY, (X,)), Fixed("x_high", (Z,), (X,)), Fixed("y_low", EVERY, (Y,)), Fixed("y_high", (Z,), (Y,))
]  # fmt: skip
CUBIC = (
    4.0 / 5.0 * 1.25**1.6 * gamma(1.6) * gamma(0.5) / gamma(2.1)
)  # int x^3 dt of x'' = -x^(3/2), x'(0) = 1: 1.730


def claims() -> Iterator[Claim]:
    """Frequencies, the impact behind the indicator, the indicator, and the exchange."""
    yield from frequencies()
    yield from impacts()
    yield from indicator()
    yield from moving_load()
    yield from memory()


def supported_sheet(thickness: float, cells: int) -> Factorised:
    """A simply supported square of 1 m."""
    mesh = sheet((0.0, 0.0), (1.0, 1.0), (cells, cells), thickness)
    return factorise(Liner(mesh, STEEL), Structure(EDGES))


def quarter(thickness: float, cells: int, clamped: bool, kind: Cut = Hexahedra) -> Factorised:
    """A quarter of a square of 1 m, simply supported or clamped, with finer cells at the edge if clamped."""

    def graded(place: np.ndarray) -> np.ndarray:
        return np.column_stack([0.5 * np.sin(0.5 * pi * place[:, :2]), place[:, 2]])

    unit = block((0.0, 0.0, -0.5 * thickness), (1.0, 1.0, 0.5 * thickness), (cells, cells, 2), kind)
    mesh = mapped(unit, graded if clamped else lambda place: place * (0.5, 0.5, 1.0))
    edge: list[Support] = [Fixed("x_high"), Fixed("y_high")]
    if not clamped:
        edge = [Fixed("x_high", (Y, Z)), Fixed("y_high", (X, Z))]
    return factorise(Liner(mesh, STEEL), Structure([Fixed("x_low", (X,)), Fixed("y_low", (Y,)), *edge]))


def frequencies() -> Iterator[Claim]:
    """The lowest natural frequency of plates, and the mass behind it."""
    for h in (0.01, 0.1):
        plate = Plate(1.0, h, STEEL.young_modulus, 0.3, 0.0)
        theory = supported_frequency(plate, STEEL.density)
        for what, ready in (
            ("shell, 16 x 16", supported_sheet(h, 16)),
            ("solid, quarter of 8 x 8 x 2", quarter(h, 8, False)),
        ):
            yield Claim(
                f"lowest frequency, simply supported, h / a = {h}, {what}", "Mindlin (1951)", theory,
                float(lowest_frequencies(ready)[0]), "Hz", 0.01, True, "1 % is asked",
            )  # fmt: skip
    plate = Plate(1.0, 0.01, STEEL.young_modulus, 0.3, 0.0)
    clamped = sheet((0.0, 0.0), (1.0, 1.0), (24, 24), 0.01)
    held = factorise(Liner(clamped, STEEL), Structure([Fixed("rim")]))
    for what, ready in (("shell, 24 x 24", held), ("solid, quarter of 8 x 8 x 2", quarter(0.01, 8, True))):
        yield Claim(
            f"lowest frequency, clamped, h / a = 0.01, {what}", "Leissa (1973)", clamped_frequency(plate, STEEL.density),
            float(lowest_frequencies(ready)[0]), "Hz", 0.01, True, "1 % is asked",
        )  # fmt: skip
    lifted = replace(clamped, offset=np.full(len(clamped.node), 0.005))
    moved = factorise(Liner(lifted, STEEL), Structure([Fixed("rim")]))
    yield Claim(
        "lowest frequency of a clamped sheet with its nodes on the back", "the same body", float(lowest_frequencies(held)[0]),
        float(lowest_frequencies(moved)[0]), "Hz", 1e-7, True, "what Lanczos leaves; rim nodes are clamped, so levers do not matter",
    )  # fmt: skip
    for ready in (moved, quarter(0.01, 4, True)):
        body = ready.body
        volume = 0.01 if isinstance(body.mesh, ShellMesh) else 0.0025
        motion = body.rigid_motions.reshape(-1, 6)
        yield Claim(
            f"mass of a rigid translation, {'shell' if isinstance(body.mesh, ShellMesh) else 'solid'}", "density x volume",
            STEEL.density * volume, float(motion[:, 2] @ (mass_matrix(body) @ motion[:, 2])), "kg", 1e-12, True, "rounding",
        )  # fmt: skip


def rebound(softness: float) -> float:
    """Rebound over impact speed of x'' = -x^(3/2) - lambda (x^(3/2))': a Hertz contact in series with a dashpot (Zener's equation 20)."""

    def slope(_: float, state: np.ndarray) -> list[float]:
        x, sphere = state
        force = max(x, 0.0) ** 1.5
        return [sphere - softness * force, -force]

    def apart(_: float, state: np.ndarray) -> float:
        return float(state[0])

    apart.terminal, apart.direction = True, -1.0  # type: ignore[attr-defined]
    done = solve_ivp(slope, (0.0, 100.0), [0.0, 1.0], events=apart, rtol=1e-10, atol=1e-12)
    return -float(done.y[1, -1])


def impacts() -> Iterator[Claim]:
    """The impact on a plate as Zener has it."""
    closed = quad(lambda u: u**3 / sqrt(1.0 - u**2.5), 0.0, 1.0, limit=200)[0]
    yield Claim(
        "int x^3 dt of a Hertz impact", "(4/5) (5/4)^(8/5) B(8/5, 1/2), by quadrature", 2.0 * FIRST_OVERLAP**4 * closed, CUBIC, "-", 1e-6,
        True, "quadrature at a singular end",
    )  # fmt: skip
    for softness in (1e-3, 1e-2):
        yield Claim(
            f"loss of rebound speed at lambda = {softness:g}", "1.73 lambda, from the work done on the dashpot", CUBIC * softness,
            1.0 - rebound(softness), "-", 2.0 * softness, True, "first order in lambda; the next term is of its square",
        )  # fmt: skip
    rigid = replace(IRON_ORE, shear_modulus=1e20)
    ore = Ore(rigid, 5e-3, 3.0, 0.5, 0.0)
    overlap, yielding = impact(STEEL, 0.01, ore)
    speed = sqrt(STEEL.young_modulus / (1.0 - 0.3**2) / STEEL.density)
    zener = pi**0.6 / sqrt(3.0) * 0.5**2 * (3.0 / speed) ** 0.2 * (IRON_ORE.density / STEEL.density) ** 0.6
    yield Claim(
        "lambda of a rigid sphere on a steel plate", "Zener (1941): pi^(3/5) / sqrt(3) (R/h)^2 (v/c)^(1/5) (rho_s/rho_p)^(3/5)", zener,
        0.5 * FIRST_OVERLAP * yielding / overlap, "-", 1e-9, True, "1e20 Pa is not quite rigid",
    )  # fmt: skip


def judged(thickness: float, ore: Ore) -> Flexure:
    """A clamped steel plate of 1 m under half a metre of ore."""
    mesh = sheet((0.0, 0.0), (1.0, 1.0), (16, 16), thickness)
    ready = factorise(Liner(mesh, STEEL), Structure([Fixed("rim")]))
    force = np.tile([0.0, 0.0, -PRESSURE / len(mesh.wear)], (len(mesh.wear), 1))
    state = ready.solve(Load({"wear": force}))
    return flexure(Liner(mesh, STEEL), state.displacement, ore, float(lowest_frequencies(ready)[0]))


FINES = Ore(IRON_ORE, 2.5e-3, 5.0, 0.46, 16.0)  # 5 mm, on a feeder that shakes at 16 Hz
LUMPS = Ore(ROCK, 0.1, 5.0, 0.53, 16.0)  # 200 mm


def indicator() -> Iterator[Claim]:
    """A 40 mm plate under 5 mm ore, and a 1 mm sheet under lumps, worked out by hand."""
    for what, h, ore in (("40 mm plate, 5 mm ore", 0.04, FINES), ("1 mm sheet, 200 mm lumps", 1e-3, LUMPS)):
        found = judged(h, ore)
        plate = Plate(1.0, h, STEEL.young_modulus, 0.3, PRESSURE)
        thin = 0.00126532 * PRESSURE / plate.bending_stiffness
        by_hand, source = (
            (thin, "0.00126532 q a^4 / D R")
            if h < 0.01
            else (clamped_plate(plate), "Ritz's method on Mindlin's energy")
        )
        yield Claim(
            f"deflection over radius, {what}", f"{source}, clamped", by_hand / ore.radius, found.of_radius, "-", 0.02, True, "the mesh",
        )  # fmt: skip
        frequency = clamped_frequency(Plate(1.0, h, STEEL.young_modulus, 0.3, 0.0), STEEL.density)
        yield Claim(
            f"lowest frequency over that of the load, {what}", "35.992 / 2 pi a^2 sqrt(D / rho h) / 16", frequency / 16.0,
            found.frequency / found.loading_frequency, "-", 0.03, True, "16 x 16 cells; shear lowers that of the thick plate by 1.5 %",
        )  # fmt: skip
        yield Claim(
            f"deflection matters (1) or not (0), {what}", "all ratios far on one side of their limits", float(h < 0.01),
            float(found.matters), "-", 0.0, False, found.verdict,
        )  # fmt: skip


def pressing(liner: Liner, force: np.ndarray, duration: float) -> FacetLoads:
    """Loads that press with `force` (b, f) [N] on each facet in blocks of `duration` [s]; nothing else happens."""
    blocks, facets = force.shape
    none = np.zeros((blocks, facets))
    one = np.zeros((blocks, facets, 1))
    return FacetLoads(
        np.full(blocks, duration), np.ones(facets), force * duration, np.zeros((blocks, facets, 3)), none, none, none, none, none, none,
        one, one, one[..., None], np.array([0.0, 1.0]), np.array([0.0, 90.0]), np.array([0.0, 1.0]),
    )  # fmt: skip


def sweeping(time_constant: float, sweeps: int, cells: int = 16) -> tuple[np.ndarray, np.ndarray, float]:
    """A line load that goes across a thin simply supported plate once a second, again and again.

    Returns the filtered displacement after a last whole sweep (n,) [m], the static one under the load spread evenly in time,
    and the deflection of the middle by Navier's series.
    """
    ready = supported_sheet(0.005, cells)
    mesh = ready.body.mesh
    assert not isinstance(mesh, SolidMesh)
    liner = Liner(mesh, STEEL)
    column = np.minimum((mesh.node[mesh.wear].mean(axis=1)[:, 0] * cells).astype(int), cells - 1)
    line = np.array(
        [np.where(column == k, PRESSURE / (2 * cells), 0.0) for k in range(cells)]
    )  # N a triangle
    loads = pressing(liner, line, 1.0 / cells)
    displacement: np.ndarray | None = None
    for _ in range(sweeps):
        displacement = exchange(ready, liner, loads, displacement, time_constant=time_constant)
    assert displacement is not None
    static = ready.solve(Load({"wear": facet_force(loads, liner).mean(axis=0)})).displacement
    theory = supported_plate(Plate(1.0, 0.005, STEEL.young_modulus, 0.3, PRESSURE))[0]
    return displacement[:, 2], static[:, 2], theory


def moving_load() -> Iterator[Claim]:
    """The filtered displacement tends to the analytic static one under a load that moves."""
    middle, apart = 8 * 17 + 8, []
    for tau in (4.0, 16.0):
        filtered, static, theory = sweeping(tau, 3)
        apart.append(float(np.abs(filtered - static).max() / np.abs(static).max()))
    yield Claim(
        "observed order of the ripple in 1 / tau, from 4 to 16 sweeps", "first-order lag: weights tilt by sweep over tau", 1.0,
        float(np.log(apart[0] / apart[1]) / np.log(4.0)), "-", 0.05, False,
        f"largest difference from the static displacement: {apart[0]:.1e} and {apart[1]:.1e} of it",
    )  # fmt: skip
    yield Claim(
        "deflection of the middle, tau = 16 s", "Navier's series under the pressure spread over time", theory, -float(filtered[middle]),
        "m", 0.01, True, "0.5 % of the mesh, and the ripple",
    )  # fmt: skip


def memory() -> Iterator[Claim]:
    """How the exchange forgets, on a small sheet."""
    ready = supported_sheet(0.01, 4)
    liner = Liner(ready.body.mesh, STEEL)
    facets = len(liner.mesh.wear)
    even = np.ones((8, facets))
    static = ready.solve(Load({"wear": facet_force(pressing(liner, even, 1.0), liner)[0]})).displacement
    rest = np.zeros_like(static)
    for taus in (1.0, 3.0):
        found = exchange(ready, liner, pressing(liner, even, taus / 8.0), rest, time_constant=1.0)
        yield Claim(
            f"share of the static displacement after {taus:g} tau, from rest", "1 - exp(-t / tau)", 1.0 - exp(-taus),
            float(found[:, 2] @ static[:, 2] / (static[:, 2] @ static[:, 2])), "-", 1e-12, True, "rounding",
        )  # fmt: skip
    passed = 0.0
    for k in range(12):  # noise is a sum of single blocks, each with its own weight
        single = np.zeros((12, facets))
        single[k] = 1.0
        found = exchange(ready, liner, pressing(liner, single, 1.0), rest, time_constant=1.0)
        passed += float(found[:, 2] @ static[:, 2] / (static[:, 2] @ static[:, 2])) ** 2
    yield Claim(
        "share of the variance of block noise that passes, tau = a block", "tanh(dt / 2 tau)", tanh(0.5), passed, "-", 1e-9, True,
        "blocks before the twelve: exp(-24)",
    )  # fmt: skip
