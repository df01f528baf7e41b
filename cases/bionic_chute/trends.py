"""How much wear the convexes save, for every geometry of Table 4: `python cases/bionic_chute/trends.py --until 3`.

Each run is a fresh chute that fills with ore, without convexes or with them, by the same seed. All geometries are compared on the upper
half of zone 2, which costs a sixth: ore that slides faster than waves travel in it does not feel what comes later. Some are run on the
whole of it. Done runs are kept in `trends.json`, so the script goes on where it stopped and other seeds are added to those that are
there. `--table` prints what there is.
"""

import argparse
import json
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import t as student

from wearfem import __version__
from wearfem.case import Window, load_any_case, parts_of
from wearfem.errors import in_a_sentence
from wearfem.liner.chute import facet_angle
from wearfem.liner.liner import wear_surface
from wearfem.units import degree, mm
from wearfem.wear.sampling import standard_error

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "trends.json"
PARTS = parts_of(FOLDER)
MIDDLE = PARTS.MIDDLE  # [rad] of zone 2
SPANS = {
    "upper half": (MIDDLE, 0.35, 0.15),
    "zone 2": (64.15 * degree, 0.6, 0.2),
}  # end [rad], to fill [s], to measure [s]
BLOCKS = 8
MESH = {"sectors": 8, "rings": 3, "rings_around": 1}  # mesh: see README.md for what it does

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

    settings: dict[str, Any]
    upper: list[float]  # [m3/s] by block, worn off the upper half of zone 2
    lower: list[float]  # [m3/s] by block, worn off the lower half, if it is in the model
    on_convexes: list[float]  # [m3/s] by block, worn off the convexes of the upper half
    convex_area: float  # [-] their share of its area
    friction: float  # [-] friction force over normal force there
    speed: float  # [m/s] mean of all ore on the chute at the end
    particles: int
    wall_time: float  # [s]
    version: str = __version__

    @property
    def rate(self) -> float:
        """[m3/s] of what was to be measured: the upper half, or all of zone 2"""
        return float(np.mean(self.upper) + np.mean(self.lower))

    @property
    def error(self) -> float:
        """[m3/s] standard error of the rate, from its blocks"""
        return float(standard_error((np.array(self.upper) + np.array(self.lower))[:, None])[0])


def settings_of(seeds: int) -> Iterator[dict[str, Any]]:
    """What to run, the most wanted first: smooth, base case, the levels with a printed figure, the ends of each row, the others."""
    printed = [(name, level) for name, (_, _, known) in LEVELS.items() for level in known]
    ends = [(name, levels[k]) for name, (_, levels, _) in LEVELS.items() for k in (0, -1)]
    every = [(name, level) for name, (_, levels, _) in LEVELS.items() for level in levels]
    ordered = list(dict.fromkeys(printed + ends + every))
    others = [{**BASE, name: level * mm} for name, level in ordered if level * mm != BASE[name]]
    first = ({**BASE, "convexes": False}, BASE, {**BASE, "staggered": False})
    yield from ({**one, "span": "upper half", "seed": 1} for one in (*first, *others))
    yield from ({**one, "span": "zone 2", "seed": 1} for one in first)
    for seed in range(2, seeds + 1):
        yield from ({**one, "span": "upper half", "seed": seed} for one in (*first, *others))
    for seed in range(2, seeds + 1):
        yield from ({**one, "span": "zone 2", "seed": seed} for one in first)


def run(settings: dict[str, Any]) -> Run:
    """Fill the chute with ore, then measure. A slice narrower than 30 mm is too narrow for ore of 8 mm: two spacings then."""
    begun = time.monotonic()
    keywords = {**MESH, **settings, "spacings": 2 if settings["spacing_across"] < 30 * mm else 1}
    end, fill, measure = SPANS[keywords.pop("span")]
    case = load_any_case(FOLDER, {**keywords, "end": end})
    surface = wear_surface(case.liner)
    where = case.measure.where
    upper = (facet_angle(surface) < MIDDLE).astype(float)
    flow, _ = case.sampler.sample(case.flow, surface, Window(fill))
    flow, loads = case.sampler.sample(flow, surface, Window(measure, BLOCKS))
    area = loads.area * where.zone_2 * upper
    shear = (where.zone_2 * upper) @ np.linalg.norm(loads.tangential_impulse.sum(axis=0), axis=1)
    lower = (1.0 - upper) * (end > MIDDLE)
    return Run(
        settings,
        where.volume_rate(loads, upper).tolist(),
        where.volume_rate(loads, lower).tolist(),
        where.volume_rate(loads, upper * where.on_convex).tolist(),
        float(area @ where.on_convex / area.sum()),
        float(shear / (loads.normal_impulse.sum(axis=0) @ (where.zone_2 * upper))),
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


@dataclass(frozen=True)
class Saved:
    """Wear saved [-] by convexes, against the smooth chute of the same seed."""

    by_seed: tuple[float, ...]
    by_blocks: float  # standard error of their mean, from the blocks of the runs

    @property
    def mean(self) -> float:
        """Over seeds"""
        return float(np.mean(self.by_seed))

    @property
    def half(self) -> float:
        """Half of the 90 % interval: Student's over three seeds and more, else from the blocks of the runs"""
        count = len(self.by_seed)
        if count > 2:
            return float(student.ppf(0.95, count - 1) * np.std(self.by_seed, ddof=1) / count**0.5)
        return float(student.ppf(0.95, BLOCKS - 1)) * self.by_blocks

    def __str__(self) -> str:
        """In per cent, with the number of seeds and where the interval comes from"""
        source = "seeds" if len(self.by_seed) > 2 else "blocks"
        return f"{100 * self.mean:.1f} +- {100 * self.half:.1f} ({len(self.by_seed)}, {source})"


def saved(runs: list[Run], span: str, **settings: Any) -> Saved | None:
    """What a geometry saves on a span; None where it has not been run."""

    def rates(wanted: dict[str, Any]) -> dict[int, tuple[float, float]]:
        known = [({k: v for k, v in one.settings.items() if k != "seed"}, one) for one in runs]
        return {
            one.settings["seed"]: (one.rate, one.error)
            for given, one in known
            if given == {**wanted, "span": span}
        }

    smooth, embossed = rates({**BASE, "convexes": False}), rates({**BASE, **settings})
    both = [(embossed[seed], smooth[seed]) for seed in sorted(embossed) if seed in smooth]
    if not both:
        return None
    errors = [np.hypot(e / s, r * d / s**2) for (r, e), (s, d) in both]
    return Saved(tuple(1.0 - r / s for (r, _), (s, _) in both), float(np.linalg.norm(errors)) / len(both))


def table() -> str:
    """The wear saved beside the printed figures, of what there is; Markdown."""
    runs = read()
    rows = [("base, rhombi", {}, 30.7), ("base, rectangles", {"staggered": False}, 30.7)]
    for name, (letter, values, printed) in LEVELS.items():
        rows += [(f"{letter} = {level:g} mm", {name: level * mm}, printed.get(level)) for level in values]
    lines = ["| | upper half of zone 2 | zone 2 | printed, zone 2 |", "|---|---|---|---|"]
    for name, settings, printed in rows:
        both = " | ".join(str(saved(runs, span, **settings) or "") for span in SPANS)
        lines.append(f"| {name} | {both} | {printed or ''} |")
    return "\n".join(lines)


def base_case(runs: list[Run]) -> list[Run]:
    """The base case on the upper half of zone 2, one run a seed."""
    return [one for one in runs if {**one.settings, "seed": 0} == {**BASE, "span": "upper half", "seed": 0}]


def shares() -> str:
    """What convexes bear; a sentence."""
    base = base_case(read())
    area = base[0].convex_area
    share = np.array([sum(one.on_convexes) / sum(one.upper) for one in base])
    times = share / area * (1.0 - area) / (1.0 - share)
    return (
        f"convexes are {100 * area:.1f} % of the area and bear {100 * share.mean():.1f} % of the wear: "
        f"{times.mean():.1f} times the depth rate of the rest ({times.min():.1f} to {times.max():.1f} over {len(base)} seeds)"
    )


def rhombi() -> str:
    """Wear saved in the base case"""
    return _per_cent(saved(read(), "upper half"))


def rectangles() -> str:
    """Wear saved in the base case, read as rectangles"""
    return _per_cent(saved(read(), "upper half", staggered=False))


def _per_cent(one: Saved | None) -> str:
    return f"{100 * one.mean:.0f} %" if one else "not run"


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
            print(f"{settings}  {1e10 * one.rate:.3f}e-10 m3/s  {one.wall_time:.0f} s", flush=True)
    print(table())
    print(f"In the base case {shares()}.")


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
