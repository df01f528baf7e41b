"""How much wear the convexes save, for every geometry of Table 4: `python cases/bionic_chute/trends.py --until 3`.

Each run is a fresh chute that fills with ore, first without convexes, then with them, by the same seed. Done runs are kept in
`trends.json`, so the script goes on where it stopped and other seeds are added to those that are there. `--table` prints what there is.
"""

import argparse
import json
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.stats import t as student

from wearfem import __version__
from wearfem.case import Window, load_any_case
from wearfem.liner.liner import wear_surface
from wearfem.units import mm

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "trends.json"
FILL, MEASURE, BLOCKS = 0.5, 0.2, 8  # [s], [s], [-]

BASE = {"major_radius": 3 * mm, "minor_radius": 2 * mm, "spacing_along": 40 * mm, "spacing_across": 30 * mm}
LEVELS = {  # [mm], and the wear saved that is printed for one level of each [%]
    "major_radius": ("a0", (2, 3, 4, 5), {2: 43.0, 3: 30.7}),
    "minor_radius": ("b0", (1.5, 2, 2.5, 3), {2: 30.7, 3: 63.0}),
    "spacing_along": ("c0", (30, 40, 50, 60), {30: 37.0, 40: 30.7}),
    "spacing_across": ("d0", (25, 30, 35, 40), {25: 38.0, 30: 30.7}),
}


@dataclass(frozen=True)
class Run:
    """What one run measured, for the whole width of the chute."""

    settings: dict[str, float]
    zone_2: list[float]  # [m3/s] by block
    on_convexes: list[float]  # [m3/s] of it
    convex_area: float  # [-] share of convexes in the area of zone 2
    friction: float  # [-] friction force over normal force in zone 2
    speed: float  # [m/s] mean of all ore on the chute at the end
    particles: int
    wall_time: float  # [s]
    version: str = __version__

    @property
    def rate(self) -> float:
        """[m3/s]"""
        return float(np.mean(self.zone_2))


def settings_of(seeds: int) -> Iterator[dict[str, float]]:
    """What to run, the most wanted first: the smooth chute and the base case, then each level, then other seeds."""
    levels = [
        {**BASE, name: level * mm}
        for name, (_, values, _) in LEVELS.items()
        for level in values
        if level * mm != BASE[name]
    ]
    for seed in range(1, seeds + 1):
        yield {**BASE, "convexes": False, "seed": seed}
        yield {**BASE, "seed": seed}
        yield {**BASE, "staggered": False, "seed": seed}
        if seed == 1:
            yield from ({**level, "seed": seed} for level in levels)
    for seed in range(2, seeds + 1):
        yield from ({**level, "seed": seed} for level in levels)


def run(settings: dict[str, float]) -> Run:
    """Fill the chute with ore, then measure."""
    begun = time.monotonic()
    case = load_any_case(FOLDER, settings)
    surface = wear_surface(case.liner)
    where = case.measure.where
    flow, _ = case.sampler.sample(case.flow, surface, Window(FILL))
    flow, loads = case.sampler.sample(flow, surface, Window(MEASURE, BLOCKS))
    area = loads.area * where.zone_2
    shear = where.zone_2 @ np.linalg.norm(loads.tangential_impulse.sum(axis=0), axis=1)
    return Run(
        settings,
        where.volume_rate(loads).tolist(),
        where.volume_rate(loads, where.on_convex).tolist(),
        float(area @ where.on_convex / area.sum()),
        float(shear / (loads.normal_impulse.sum(axis=0) @ where.zone_2)),
        float(np.linalg.norm(flow.particles.velocity, axis=1).mean()),
        flow.particles.count,
        time.monotonic() - begun,
    )


def read() -> list[Run]:
    """What has been run so far."""
    return [Run(**row) for row in json.loads(RESULTS.read_text())] if RESULTS.exists() else []


def write(runs: list[Run]) -> None:
    """All runs, whole or not at all."""
    beside = RESULTS.with_suffix(".new")
    beside.write_text(json.dumps([asdict(one) for one in runs], indent=1) + "\n")
    os.replace(beside, RESULTS)


def saved(runs: list[Run], **settings: float) -> list[float]:
    """[-] wear saved in zone 2, one number a seed: against the smooth chute of the same seed."""
    smooth = {one.settings["seed"]: one.rate for one in runs if one.settings.get("convexes") is False}
    wanted = {**BASE, **settings}
    found = {
        one.settings["seed"]: one.rate
        for one in runs
        if {k: v for k, v in one.settings.items() if k != "seed"} == wanted
    }
    return [1.0 - rate / smooth[seed] for seed, rate in sorted(found.items()) if seed in smooth]


def interval(values: list[float], confidence: float = 0.9) -> tuple[float, float]:
    """Mean and half of its interval (Student's t over seeds; not a number for one seed)."""
    count = len(values)
    spread = float(np.std(values, ddof=1)) if count > 1 else float("nan")
    return float(np.mean(values)), float(
        student.ppf(0.5 + 0.5 * confidence, max(count - 1, 1))
    ) * spread / count**0.5


def table(runs: list[Run]) -> None:
    """Print the wear saved beside the printed figures."""
    print("geometry                      wear saved [%] (90 % over seeds)   seeds   printed [%]")
    rows = [("base, rhombi", {}, 30.7), ("base, rectangles", {"staggered": False}, 30.7)]
    for name, (letter, values, printed) in LEVELS.items():
        rows += [(f"{letter} = {level:g} mm", {name: level * mm}, printed.get(level)) for level in values]
    for name, settings, printed in rows:
        if values := saved(runs, **settings):
            mean, half = interval([100.0 * one for one in values])
            print(
                f"{name:28s}  {mean:6.1f} +- {half:4.1f}                    {len(values):3d}     {printed or ''}"
            )
    for one in runs:
        if one.settings == {**BASE, "seed": 1}:
            share = sum(one.on_convexes) / sum(one.zone_2)
            print(
                f"base, seed 1: convexes are {one.convex_area:.1%} of the area and bear {share:.1%} of the wear: "
                f"{share / one.convex_area * (1 - one.convex_area) / (1 - share):.1f} times the depth rate of the matrix"
            )


def main() -> None:
    """Run what is missing, print what there is."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--until", type=int, default=3, metavar="SEEDS", help="how many seeds")
    parser.add_argument("--table", action="store_true", help="run nothing")
    given = parser.parse_args()
    if not given.table:
        for settings in settings_of(given.until):
            runs = read()
            if any(one.settings == settings for one in runs):
                continue
            one = run(settings)
            write([*read(), one])
            print(f"{settings}  zone 2: {1e10 * one.rate:.3f}e-10 m3/s  {one.wall_time:.0f} s", flush=True)
    table(read())


if __name__ == "__main__":
    main()
