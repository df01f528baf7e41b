"""Pin on disc: the wear of one revolution beside theory and the paper, and what must not change it."""

from collections.abc import Iterator
from math import pi
from pathlib import Path

import numpy as np

from wearfem.case import Outcome, load_case
from wearfem.proof import Claim
from wearfem.run import run_stages

CASE = Path(__file__).parents[3] / "cases" / "pin_on_disc"
TURN = 2.0 * pi * 22e-3  # [m]
SHORT = 5e-3  # [m] enough to cross ten joints and more
PAPER = "Sensitivity analysis of DEM prediction for sliding wear by single iron ore particle"


def claims() -> Iterator[Claim]:
    """Wear of a revolution; the force at joints; and wear for each size of mesh, force and time step."""
    outcome, theory = slide(distance=TURN)
    volume, slid = wear(outcome)
    yield Claim(
        "wear of one revolution", "alpha (F + m g) 2 pi r", theory, volume / slid * TURN, "m3", 1e-4, True,
        "0.01 % is asked; the sum itself is exact to rounding",
    )  # fmt: skip
    yield Claim(
        "wear of one revolution", f"{PAPER}, section 5.1", 4.50e-12, volume / slid * TURN, "m3", 0.005e-12, False,
        "half the last printed digit",
    )  # fmt: skip
    force = np.array([flow.particles.force[0, 2] for flow in outcome["slide"].snapshots])
    load = theory / 6.51e-12 / TURN
    yield Claim(
        "largest deviation of the normal force, joints included", "F + m g is constant", 0.0,
        float(np.abs(force / load - 1.0).max()), "-", 1e-6, False, "the paper saw kicks at joints",
    )  # fmt: skip
    for name, values in (
        ("mesh_size", (0.55e-3, 2.2e-3, 4.4e-3)),
        ("force", (3.0, 9.0)),
        ("time_step", (1.0e-6, 1.8e-6)),
    ):
        for value in values:
            outcome, theory = slide(distance=SHORT, **{name: value})
            volume, slid = wear(outcome)
            yield Claim(
                f"wear of one revolution, {name} = {value:g}", "alpha (F + m g) 2 pi r", theory, volume / slid * TURN,
                "m3", 1e-9, True, f"from {1e3 * SHORT:g} mm of sliding: rounding, and what is left of settling",
            )  # fmt: skip


def slide(**settings: float) -> tuple[Outcome, float]:
    """The case run, and the wear of one revolution by theory [m3]."""
    case = load_case(CASE, settings)
    particle = case.flow.particles
    load = case.settings["force"] + float(particle.mass[0]) * 9.81
    return run_stages(case, quiet=True), case.settings["specific_wear_rate"] * load * TURN


def wear(outcome: Outcome) -> tuple[float, float]:
    """Wear volume [m3] and distance slid [m]; the distance is the disc's, known without the particles."""
    loads = outcome["slide"].loads
    return float(6.51e-12 * loads.load_distance.sum()), float(6.82 * 22e-3 * loads.duration.sum())
