"""What moves the wear that the convexes save: `python cases/bionic_chute/reasons.py`.

The base case and the smooth chute on the upper half of zone 2, each once more with one thing changed: a shortcut taken less far, or
what the paper leaves open. Results are kept in `reasons.json`.
"""

import argparse
import json
import os
from collections.abc import Callable
from dataclasses import replace
from math import cos, sin
from pathlib import Path

import numpy as np
from scipy.stats import t as student

from wearfem.case import LifeCase, Window, load_any_case, parts_of
from wearfem.cycle import Particles
from wearfem.dem.flow import Model
from wearfem.errors import in_a_sentence
from wearfem.liner.liner import wear_surface
from wearfem.surface import Surface
from wearfem.units import GPa

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "reasons.json"
PARTS = parts_of(FOLDER)
MIDDLE = PARTS.MIDDLE  # [rad] of zone 2
MESH = {"sectors": 8, "rings": 3, "rings_around": 1, "end": MIDDLE}
FILL, MEASURE, BLOCKS = 0.35, 0.15, 8  # [s], [s], [-]


def as_it_falls(model: Model) -> Model:
    """Nothing changed"""
    return model


def without_its_fall(model: Model) -> Model:
    """Ore that comes on along the chute with the speed that it has falling, so that it loses none where it lands."""
    chute = PARTS.chute
    speed = float(np.linalg.norm(chute.VELOCITY))
    tangent = (speed * sin(chute.ONSET), 0.0, -speed * cos(chute.ONSET))
    return replace(model, inlets=tuple(replace(inlet, velocity=tangent) for inlet in model.inlets))


VARIANTS: dict[str, tuple[dict, Callable[[Model], Model]]] = {
    "as in trends.py": ({}, as_it_falls),
    "mesh twice as fine": ({"sectors": 16, "rings": 6, "rings_around": 2}, as_it_falls),
    "ore that loses no speed where it lands": ({}, without_its_fall),
    "the same, convexes at corners of rectangles": ({"staggered": False}, without_its_fall),
    "slice twice as wide": ({"spacings": 2}, as_it_falls),
    "ore ten times as stiff, 0.65 GPa": ({"shear_modulus": 0.65 * GPa}, as_it_falls),
    "half the time step": ({"time_step_share": 0.125}, as_it_falls),
}


def measured(settings: dict, change: Callable[[Model], Model]) -> dict[str, list[float]]:
    """On the upper half of zone 2: wear [m3/s] by block, mean normal force on the whole width [N], mean slip speed under it [m/s]"""
    case: LifeCase = load_any_case(FOLDER, {**MESH, **settings})
    model = case.sampler.model

    def changed(surface: Surface) -> Model:
        return change(model(surface))

    sampler, surface = Particles(changed), wear_surface(case.liner)
    flow, _ = sampler.sample(case.flow, surface, Window(FILL))
    _, loads = sampler.sample(flow, surface, Window(MEASURE, BLOCKS))
    where = case.measure.where
    pressed = float((loads.normal_impulse @ where.zone_2).sum())  # [N s]
    return {
        "wear": where.volume_rate(loads).tolist(),
        "force": [pressed / float(loads.duration.sum()) / where.share],
        "slip": [float((loads.load_distance @ where.zone_2).sum()) / pressed],
    }


def saved(smooth: list[float], embossed: list[float]) -> tuple[float, float]:
    """Wear saved and half of its 90 % interval [-], from the blocks of one run each, taken as independent"""
    low, high = np.array(embossed), np.array(smooth)
    error = np.hypot(low.std(ddof=1) / high.mean(), low.mean() * high.std(ddof=1) / high.mean() ** 2)
    return 1.0 - low.mean() / high.mean(), float(student.ppf(0.95, len(low) - 1) * error / np.sqrt(len(low)))


def table() -> str:
    """All variants that have been run; Markdown."""
    done = json.loads(RESULTS.read_text())
    lines = [
        "| | smooth | convexes | saved | normal force | slip speed |",
        "|---|---|---|---|---|---|",
        "| | 1e-10 m3/s | 1e-10 m3/s | % | - | - |",
    ]
    for name in VARIANTS:
        if name in done:
            smooth, embossed = done[name]
            value, half = saved(smooth["wear"], embossed["wear"])
            force, slip = (embossed[what][0] / smooth[what][0] for what in ("force", "slip"))
            lines.append(
                f"| {name} | {1e10 * np.mean(smooth['wear']):.3f} | {1e10 * np.mean(embossed['wear']):.3f} "
                f"| {100 * value:.1f} +- {100 * half:.1f} | x {force:.2f} | x {slip:.2f} |"
            )
    return "\n".join(lines)


def main() -> None:
    """Run what is missing, print what there is."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--table", action="store_true", help="run nothing")
    given = parser.parse_args()
    done = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    for name, (settings, change) in VARIANTS.items():
        if name not in done and not given.table:
            done[name] = [measured({**settings, "convexes": convexes}, change) for convexes in (False, True)]
            beside = RESULTS.with_suffix(".new")
            beside.write_text(json.dumps(done, indent=1) + "\n")
            os.replace(beside, RESULTS)
            print(f"{name}: done", flush=True)
    print(table())


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
