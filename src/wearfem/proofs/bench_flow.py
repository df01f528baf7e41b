"""The flows that are timed are the flows of the other codes: means over all particles, against LIGGGHTS, LAMMPS and Yade."""

from collections.abc import Iterator

import numpy as np

from wearfem.benchmarks import BENCHMARKS, Benchmark
from wearfem.dem.energy import touching_pairs
from wearfem.dem.flow import Flow
from wearfem.dem.sample import Stepper
from wearfem.proof import Claim

PEERS = "LIGGGHTS 3.8.0, LAMMPS 2025-07-22 and Yade 2023.02a run from the same packing"
BEDS = {"bed_5000": 4.71, "bed_20000": 4.94, "bed_100000": 5.18}  # contacts a particle when settled
PLATE_STEPS = 1500
SPEED = (1.186, 1.205)  # [m/s] least and most of the peers: mean down the slope
ENERGY = (10.15, 10.37)  # [J] least and most of the peers: of translation
PLATE_CONTACTS = 1.5


def claims() -> Iterator[Claim]:
    """Contacts in the beds, then speed, energy and contacts on the plate."""
    for benchmark in BENCHMARKS[:-1]:
        yield bed_claim(benchmark)
    yield from plate_claims()


def bed_claim(benchmark: Benchmark) -> Claim:
    """Contacts a particle in a bed that was let settle a little further."""
    flow = _advanced(benchmark, benchmark.warm)
    return Claim(
        claim=f"{benchmark.text}: contacts between particles, a particle",
        source=PEERS,
        expected=BEDS[benchmark.name],
        computed=contacts(flow),
        unit="-",
        tolerance=0.01,
        relative=True,
        note="contacts about to open come and go by less than 1 %",
    )


def plate_claims() -> Iterator[Claim]:
    """After 1500 steps, where codes differ by their restitution and friction of the first touch."""
    flow = _advanced(BENCHMARKS[-1], PLATE_STEPS)
    p = flow.particles
    given = (
        ("mean speed down the slope", *SPEED, float(p.velocity[:, 0].mean()), "m/s"),
        (
            "kinetic energy of translation",
            *ENERGY,
            float(0.5 * (p.mass * (p.velocity**2).sum(axis=1)).sum()),
            "J",
        ),
    )
    for what, low, high, computed, unit in given:
        yield Claim(
            claim=f"plate, {PLATE_STEPS} steps: {what}",
            source=PEERS,
            expected=0.5 * (low + high),
            computed=computed,
            unit=unit,
            tolerance=0.5 * (high - low),
            relative=False,
            note=f"the codes themselves give {low:g} to {high:g}",
        )
    yield Claim(
        claim=f"plate, {PLATE_STEPS} steps: contacts between particles, a particle",
        source=PEERS,
        expected=PLATE_CONTACTS,
        computed=contacts(flow),
        unit="-",
        tolerance=0.1,
        relative=False,
        note="the source gives one decimal",
    )


def contacts(flow: Flow) -> float:
    """Contacts of particles with each other, a particle: each counts for both."""
    return 2.0 * len(touching_pairs(flow)) / flow.particles.count


def _advanced(benchmark: Benchmark, steps: int) -> Flow:
    flow, model = benchmark.start()
    stepper = Stepper(flow, model)
    stepper.advance(steps)
    if not np.isfinite(stepper.particles.velocity).all():
        raise ArithmeticError(f"{benchmark.name}: a velocity is not a number")
    return stepper.result()
