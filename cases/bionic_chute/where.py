"""Which convexes save the wear: `python cases/bionic_chute/where.py RUN`, RUN a folder that decay.py has lived to its end.

The same stretch is measured (upper half of zone 2) over faces that have convexes everywhere, nowhere, only above zone 2 where the ore falls
on, or only in zone 2; and over the face that is left when the convexes are worn down, below convexes as new and below a smooth face.
Results are kept in `where.json`.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import t as student

from wearfem import __version__
from wearfem.case import Window, load_any_case
from wearfem.errors import UserError, in_a_sentence
from wearfem.history import cycles_of, read_cycle
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.mesh import ShellMesh

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "where.json"
SEEDS = (1, 2)
FILL, MEASURE, BLOCKS = 0.45, 0.4, 16  # [s], [s], [-] for each seed


def worn_down(run: Path, new: ShellMesh) -> ShellMesh:
    """The face in the end of a life that began with `new`"""
    count = cycles_of(run)
    worn = read_cycle(run, count)[0].now.liner.mesh if count else None
    if not isinstance(worn, ShellMesh) or worn.element.shape != new.element.shape:
        raise UserError(
            f"{run} holds no life of this chute: give the folder that decay.py has lived in to its end"
        )
    return worn


def faces(run: Path) -> dict[str, ShellMesh]:
    """The faces by name: the stretch above zone 2 and zone 2 itself, put together."""
    new, smooth = (load_any_case(FOLDER, {"convexes": there}).liner.mesh for there in (True, False))
    worn = worn_down(run, new)
    wears = worn.thickness < new.thickness  # what lies above zone 2 was kept as new

    def put(above: ShellMesh, below: ShellMesh) -> ShellMesh:
        return replace(
            new,
            thickness=np.where(wears, below.thickness, above.thickness),
            offset=np.where(wears, below.offset, above.offset),
        )

    return {
        "smooth everywhere": smooth,
        "convexes everywhere": new,
        "convexes only above zone 2": put(new, smooth),
        "convexes only in zone 2": put(smooth, new),
        "convexes above, zone 2 as it is in the end": put(new, worn),
        "smooth above, zone 2 as it is in the end": put(smooth, worn),
    }


def relief(run: Path) -> dict[str, float]:
    """[m] the worn face in the end, beside the mean of what was no convex: standard deviation, highest, lowest"""
    case = load_any_case(FOLDER, {})
    new = case.liner.mesh
    worn = worn_down(run, new)
    wears = worn.thickness < new.thickness
    height = worn.thickness[wears] - worn.thickness[wears & (case.measure.where.height == 0.0)].mean()
    return {"deviation": float(height.std()), "highest": float(height.max()), "lowest": float(height.min())}


def measured(mesh: ShellMesh) -> list[float]:
    """Wear of zone 2 as far as it is in the model [m3/s], by block of all seeds"""
    found: list[float] = []
    for seed in SEEDS:
        case = load_any_case(FOLDER, {"seed": seed})
        surface = wear_surface(Liner(mesh, case.liner.material))
        flow, _ = case.sampler.sample(case.flow, surface, Window(FILL))
        _, loads = case.sampler.sample(flow, surface, Window(MEASURE, BLOCKS))
        found += case.measure.where.volume_rate(loads).tolist()
    return found


def table() -> str:
    """Wear saved on each face, 90 % intervals from blocks; Markdown."""
    rows = json.loads(RESULTS.read_text())["wear"]
    smooth = np.array(rows["smooth everywhere"])
    lines = ["| | wear | saved |", "|---|---|---|", "| | 1e-10 m3/s | % |"]
    for name, blocks in rows.items():
        wear = np.array(blocks)
        error = np.hypot(wear.std(ddof=1), wear.mean() / smooth.mean() * smooth.std(ddof=1))
        half = student.ppf(0.95, len(wear) - 1) * error / np.sqrt(len(wear)) / smooth.mean()
        saved = (
            ""
            if name == "smooth everywhere"
            else f"{100 * (1 - wear.mean() / smooth.mean()):.1f} +- {100 * half:.1f}"
        )
        lines.append(f"| {name} | {1e10 * wear.mean():.3f} | {saved} |")
    return "\n".join(lines)


def left_standing() -> str:
    """The relief of the worn face in words."""
    told = {name: 1e3 * value for name, value in json.loads(RESULTS.read_text())["relief"].items()}
    deviation = f"standard deviation {told['deviation']:.2f} mm"
    return f"{told['highest']:.2f} mm above to {-told['lowest']:.2f} mm below the face between ({deviation})"


def main() -> None:
    """Measure all faces, print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path, metavar="RUN")
    given = parser.parse_args()
    wear = {}
    for name, mesh in faces(given.run).items():
        wear[name] = measured(mesh)
        print(f"{name}: {1e10 * np.mean(wear[name]):.3f}e-10 m3/s", flush=True)
    told = {"version": __version__, "wear": wear, "relief": relief(given.run)}
    RESULTS.write_text(json.dumps(told, indent=1) + "\n")
    print(table())


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
