"""What mesh and smoothing length do to the new chute's deepest rate, on one and the same stream: no noise between them.

    python cases/transfer_chute/sensitivity.py [--seconds 2] [--loads FILE.npz]

One stream is sampled over facets of 2.5 mm, with `--loads` only where that file is not there yet. Its loads are then summed over facets of
5, 10, 20 and 40 mm, and the rates evened out over lengths of 0 to 80 mm: what the mesh and the smoothing length of the case do to the
rate, apart from what they do to the shape of the worn chute later. Told is the deepest rate, on which the first estimate of the life
rests; it is kept in `sensitivity.json`. The size of the ore, the time step and the modulus are in `shortcuts.py`; what the tolerance
of the jumps does to a whole life:

    wearfem study cases/transfer_chute "tolerance=0.12,0.06,0.03" --set coarsening=3 --set "slice_width=105*mm" --size tolerance
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wearfem import __version__
from wearfem.case import LifeCase, Window, load_any_case, parts_of
from wearfem.convergence import Converged, converged
from wearfem.cycle import Particles
from wearfem.dem.sample import sample
from wearfem.errors import UserError, in_a_sentence
from wearfem.liner.liner import Liner, wear_surface
from wearfem.sharpness import deepest as deepest_of_halves
from wearfem.units import day
from wearfem.wear.sampling import standard_error
from wearfem.wear.smooth import HelmholtzFilter

CASE = Path(__file__).parent
RESULTS = CASE / "sensitivity.json"
DEFAULT_MESH = 10e-3  # [m]
FINEST = 2.5e-3  # [m]
ORE = {"coarsening": 2.0, "slice_width": 0.07}
MERGED = (1, 2, 4, 8, 16)  # facets into one
LENGTHS = (0.0, 10e-3, 20e-3, 30e-3, 40e-3, 60e-3, 80e-3)  # [m]


def load_distance(seconds: float, file: Path | None) -> np.ndarray:
    """(b, f) [N m/s] of facets in a row down the chute, by block"""
    if file and file.exists():
        try:
            return np.load(file)["load_distance"]
        except (OSError, ValueError, KeyError, IndexError) as error:
            raise UserError(
                f"{file} cannot be read ({error}): give --loads a file that this script has written, or a new one"
            ) from error
    case = load_any_case(CASE, ORE | {"mesh_size": FINEST})
    assert isinstance(case, LifeCase)
    surface = wear_surface(case.liner)
    assert isinstance(case.sampler, Particles)
    model = case.sampler.model(surface)
    flow, _, _ = sample(case.flow, model, Window(case.warm_up))
    _, loads, _ = sample(flow, model, Window(seconds, round(seconds / 0.05)))
    rate = loads.load_distance / loads.duration[:, None]
    if file:
        np.savez(file, load_distance=rate)
    return rate


def depth_rate(work: np.ndarray, merged: int, length: float) -> np.ndarray:
    """(b, f) [m/s] on facets of `merged` of the finest, evened out over `length` [m]"""
    case = load_any_case(CASE, ORE | {"mesh_size": FINEST})
    assert isinstance(case, LifeCase)
    chute = parts_of(CASE)
    width = case.settings["slice_width"]
    total = len(work[0]) // merged * merged
    summed = work[:, :total].reshape(len(work), -1, merged).sum(axis=2)
    size = chute.CHUTE.length / len(work[0]) * merged
    rate = chute.SPECIFIC_WEAR_RATE * summed / (size * width)
    if length == 0.0:
        return rate
    surface = wear_surface(Liner(chute.CHUTE.slice(width, size), chute.STEEL))
    count = min(surface.facet_count, rate.shape[1])
    return HelmholtzFilter(surface, length)(
        np.pad(rate[:, :count], ((0, 0), (0, surface.facet_count - count)), "edge")
    )


def deepest(rate: np.ndarray) -> tuple[float, float]:
    """The largest mean rate [nm/s] and the standard error of the mean there"""
    place = int(np.argmax(rate.mean(axis=0)))
    return 1e9 * float(rate.mean(axis=0)[place]), 1e9 * float(standard_error(rate)[place])


def apart(rate: np.ndarray) -> float:
    """The deepest rate [nm/s], its place from one half of the blocks and its value from the other"""
    return 1e9 * float(deepest_of_halves(rate, np.full(len(rate), 1.0 / len(rate))).mean())


def gone_after(value: float) -> float:
    """[d] in which 12 mm are gone at a rate [nm/s]"""
    return 12e-3 / (1e-9 * value) / day


def read() -> dict[str, Any]:
    """What is shipped."""
    return json.loads(RESULTS.read_text())


def meshes() -> str:
    """The deepest rate by the size of facets; Markdown."""
    rows = read()["meshes"]
    lines = ["| facets, at 30 mm of smoothing | deepest rate | 12 mm gone after |", "|---|---|---|"]
    for size, value, error in rows:
        lines.append(f"| {1e3 * size:g} mm | {value:.3f} +- {error:.3f} nm/s | {gone_after(value):.1f} d |")
    answer = towards_zero(rows)
    told = (
        f"{answer.value:.3f} nm/s | {gone_after(answer.value):.1f} d, order {answer.order:.1f}"
        if answer.told
        else f"no answer | {answer.reason}"
    )
    return "\n".join([*lines, f"| towards 0 | {told} |"])


def lengths() -> str:
    """The deepest rate by the length of smoothing; Markdown."""
    lines = [
        "| smoothing, facets of 5 mm | deepest rate | 12 mm gone after | place and rate apart |",
        "|---|---|---|---|",
    ]
    for length, value, error, halves in read()["lengths"]:
        lines.append(
            f"| {1e3 * length:g} mm | {value:.2f} +- {error:.2f} nm/s | {gone_after(value):.1f} d | {halves:.2f} nm/s |"
        )
    return "\n".join(lines)


def mesh_in_short() -> str:
    """How far the mesh of the default is from the converged answer; words."""
    rows = read()["meshes"]
    answer = towards_zero(rows)
    if not answer.told:
        return f"no converged answer ({answer.reason})"
    value = next(value for size, value, _ in rows if size == DEFAULT_MESH)
    return f"facets of 10 mm are {100.0 * abs(value / answer.value - 1.0):.1f} % from the converged answer"


def smoothing_in_short() -> str:
    """What smoothing takes off the deepest rate; words."""
    halves = {length: value for length, _, _, value in read()["lengths"]}
    lost = [100.0 * (1.0 - halves[length] / halves[0.0]) for length in (30e-3, 10e-3)]
    return f"30 mm flatten the deepest rate of a new chute by {lost[0]:.0f} %, 10 mm by {lost[1]:.0f} %"


def towards_zero(rows: Sequence[Sequence[float]]) -> Converged:
    """What the deepest rates tend to with the size of facets"""
    return converged(*np.array([(size, value) for size, value, _ in rows]).T)


def main() -> None:
    """Sample once, keep what is told, print both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=2.0, help="of steady stream")
    parser.add_argument("--loads", type=Path, metavar="FILE.npz")
    given = parser.parse_args()
    work = load_distance(given.seconds, given.loads)
    rates = [depth_rate(work, 2, length) for length in LENGTHS]
    kept = {
        "version": __version__,
        "seconds": given.seconds,
        "meshes": [(FINEST * merged, *deepest(depth_rate(work, merged, 30e-3))) for merged in MERGED],
        "lengths": [
            (length, *deepest(rate), apart(rate)) for length, rate in zip(LENGTHS, rates, strict=True)
        ],
    }
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n")
    print(meshes(), lengths(), sep="\n\n")


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
