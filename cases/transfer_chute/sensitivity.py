"""What mesh and smoothing length do to the new chute's deepest rate, on one and the same stream: no noise between them.

    python cases/transfer_chute/sensitivity.py [--seconds 2] [--loads FILE.npz]

One stream is sampled over facets of 2.5 mm, with `--loads` only where that file is not there yet. Its loads are then summed over facets of
5, 10, 20 and 40 mm, and the rates evened out over lengths of 0 to 80 mm: what the mesh and the smoothing length of the case do to the
rate, apart from what they do to the shape of the worn chute later. Told are the deepest rate, on which the first estimate of the life
rests, and the rate of zone 2. The size of the ore, the time step and the modulus are in `shortcuts.py`; what the tolerance
of the jumps does to a whole life:

    wearfem study cases/transfer_chute "tolerance=0.12,0.06,0.03" --set coarsening=3 --set "slice_width=105*mm" --size tolerance
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from wearfem.case import LifeCase, Window, load_any_case, parts_of
from wearfem.convergence import converged
from wearfem.cycle import Particles
from wearfem.dem.sample import sample
from wearfem.errors import UserError, in_a_sentence
from wearfem.liner.liner import Liner, wear_surface
from wearfem.wear.sampling import standard_error
from wearfem.wear.smooth import HelmholtzFilter

CASE = Path(__file__).parent
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


def table(title: str, sizes: Sequence[float], rows: Sequence[tuple[float, float]]) -> None:
    """A size a line, and what the results tend to as it goes to zero."""
    print(f"\n{title:<44}deepest rate [nm/s]   12 mm gone after [d]")
    for size, (value, error) in zip(sizes, rows, strict=True):
        life = 12e-3 / (1e-9 * value) / 86400.0
        print(
            f"{1e3 * size:>16.4g} mm {value:>38.4f} +- {error:.4f}   {life:>10.2f} +- {life * error / value:.2f}"
        )
    used = [(size, value) for size, (value, _) in zip(sizes, rows, strict=True) if size > 0.0]
    answer = converged(*np.array(used).T)
    life = 12e-3 / (1e-9 * answer.value) / 86400.0
    told = (
        f"{answer.value:.4f} nm/s, {life:.2f} d; order {answer.order:.2f}"
        if answer.told
        else f"no answer: {answer.reason}"
    )
    print(f"towards 0, without the row of 0: {told}")


def main() -> None:
    """Sample once, and print both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=2.0, help="of steady stream")
    parser.add_argument("--loads", type=Path, metavar="FILE.npz")
    given = parser.parse_args()
    work = load_distance(given.seconds, given.loads)
    meshes = [deepest(depth_rate(work, merged, 30e-3)) for merged in MERGED]
    table("facets, at 30 mm of smoothing", [FINEST * merged for merged in MERGED], meshes)
    lengths = [deepest(depth_rate(work, 2, length)) for length in LENGTHS]
    table("smoothing length, on facets of 5 mm", LENGTHS, lengths)


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
