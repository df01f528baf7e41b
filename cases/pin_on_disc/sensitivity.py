"""What changes the wear of the pin on the disc, and what does not: all nine parameters of the paper's Table X, and its section 5.2.

    python cases/pin_on_disc/sensitivity.py [--out DIR]

Every value is one revolution of its own, the others as in the reference case. It prints the table and the trends beside the
paper's, and writes `sensitivity.json`, `sensitivity.png` and `section_5_2.png` into DIR; what the README prints is kept beside this file.

Time steps here go to 240 % of the Rayleigh time, which a run refuses: the limit is for a packing. One sphere on a rigid plane is
a single oscillator, stable as long as omega dt < 2 or so; these runs step past the check, and the table shows what comes of it.
"""

import argparse
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from wearfem import __version__, report
from wearfem.case import Figure, load_case
from wearfem.dem.sample import Stepper
from wearfem.dem.tally import LOAD_DISTANCE
from wearfem.errors import in_a_sentence
from wearfem.record import RunFolder, write_json
from wearfem.run import figure_table

CASE = Path(__file__).parent
RESULTS = CASE / "sensitivity.json"
LEAST_TERM = 1e-9  # [1e-12 m3] of a fit: below, it is rounding
IN_PRINT = {
    "radius": "0.0002 x^3 - 0.0002 x^2 + 0.0007 x + 4.4953",
    "density": "3e-7 x + 4.4959",
    "force": "0.8992 x + 0.0017",
}
REFERENCE = {
    "radius": 2e-3,
    "density": 4850.0,
    "poisson_ratio": 0.24,
    "shear_modulus": 65e9,
    "rotation_speed": 6.82,
    "mesh_size": 1.1e-3,
    "restitution": 0.4,
    "force": 5.0,
    "time_step": 1.5e-6,
}
TABLE_X = {
    "radius": (1e-3, 2e-3, 3e-3, 4e-3),
    "density": (4750.0, 4850.0, 4950.0, 5050.0),
    "poisson_ratio": (0.23, 0.24, 0.25, 0.26),
    "shear_modulus": (60e9, 65e9, 70e9, 75e9),
    "rotation_speed": (2.27, 6.82, 11.36, 15.91),
    "mesh_size": (0.55e-3, 1.1e-3, 2.2e-3, 4.4e-3),
    "restitution": (0.35, 0.40, 0.45, 0.50),
    "force": (3.0, 5.0, 7.0, 9.0),
    "time_step": (1.0e-6, 1.5e-6, 2.0e-6, 2.5e-6),
}
SECTION_5_2 = {
    "shear_modulus": (65e9, 65e9 / 10, 65e9 / 40, 65e9 / 70, 65e9 / 100),
    "time_step": (3.0e-6, 3.5e-6, 4.0e-6, 4.5e-6),
}
UNITS = {
    "radius": (1e-3, "mm"),
    "density": (1.0, "kg/m3"),
    "poisson_ratio": (1.0, "-"),
    "shear_modulus": (1e9, "GPa"),
    "rotation_speed": (1.0, "rad/s"),
    "mesh_size": (1e-3, "mm"),
    "restitution": (1.0, "-"),
    "force": (1.0, "N"),
    "time_step": (1e-6, "us"),
}
PAPER = {  # Table XI: polynomials of the value in these units, highest power first, in 1e-12 m3
    "radius": (0.0002, -0.0002, 0.0007, 4.4953),
    "density": (3e-7, 4.4959),
    "force": (0.8992, 0.0017),
}
NO_INFLUENCE = ("poisson_ratio", "shear_modulus", "rotation_speed", "mesh_size", "restitution", "time_step")


@dataclass(frozen=True)
class Row:
    """One revolution with one parameter changed."""

    parameter: str
    value: float  # SI
    volume: float  # [m3] of one revolution
    theory: float  # [m3] alpha (F + m g) 2 pi r
    force_deviation: float  # [-] of the normal force at the end, from F + m g
    overlap: float  # [m] at the end
    step_share: float  # [-] time step over Rayleigh time


def revolution(parameter: str, value: float, turns: float = 1.0) -> Row:
    """The row of one value; `turns` other than 1 slide so many revolutions and scale the volume to one."""
    case = load_case(CASE, {parameter: value})
    given, model, particle = case.settings, case.stages[1].model, case.flow.particles
    stepper = Stepper(case.flow, model)
    stepper.advance(round(case.stages[0].window.duration / model.time_step))
    before = stepper.tally.sums[:, LOAD_DISTANCE].sum()
    steps = round(turns * 2.0 * pi / given["rotation_speed"] / model.time_step)
    stepper.advance(steps)
    turned = steps * model.time_step * given["rotation_speed"] / (2.0 * pi)
    volume = given["specific_wear_rate"] * (stepper.tally.sums[:, LOAD_DISTANCE].sum() - before) / turned
    load = given["force"] - float(particle.mass[0]) * model.gravity[2]
    return Row(
        parameter,
        value,
        float(volume),
        given["specific_wear_rate"] * load * 2.0 * pi * given["track_radius"],
        float(stepper.particles.force[0, 2] / load - 1.0),
        float(given["radius"] - stepper.particles.position[0, 2]),
        model.time_step / model.rayleigh_time(particle),
    )


def study(values: Mapping[str, tuple[float, ...]]) -> Iterator[Row]:
    """A row for each value of each parameter; the reference case is run once."""
    reference = None
    for parameter, all_of_it in values.items():
        for value in all_of_it:
            if value != REFERENCE[parameter]:
                yield revolution(parameter, value)
                continue
            reference = reference or revolution(parameter, value)
            yield Row(**(vars(reference) | {"parameter": parameter, "value": value}))


def column(rows: list[Row], parameter: str, name: str) -> np.ndarray:
    """One field of all rows of a parameter."""
    return np.array([getattr(row, name) for row in rows if row.parameter == parameter])


def trends(rows: list[Row]) -> tuple[Figure, ...]:
    """How wear depends on each parameter, in the paper's units (1e-12 m3; mm, kg/m3, N), beside theory and the paper's fit (Table XI)."""
    fits = {
        name: np.polyfit(
            column(rows, name, "value") / UNITS[name][0], 1e12 * column(rows, name, "volume"), degree
        )
        for name, degree in (("radius", 3), ("density", 1), ("force", 1))
    }
    given = load_case(CASE).settings
    each_newton = 1e12 * given["specific_wear_rate"] * 2.0 * pi * given["track_radius"]
    ball = 4.0 / 3.0 * pi * 9.81
    cubic = each_newton * ball * 1e-9 * given["density"]
    by_density = each_newton * ball * given["radius"] ** 3
    spread = (
        Figure(
            f"{name}: largest change",
            float(np.abs(column(rows, name, "volume") / column(rows, name, "theory") - 1.0).max()),
            "-",
            0.0,
            "paper: no influence",
            1e-4,
        )
        for name in NO_INFLUENCE
    )
    return (
        Figure("radius: x^3", fits["radius"][0], "1e-12 m3/mm3", cubic, "theory; paper 0.0002", 1e-4 * cubic),
        Figure("radius: x^2", fits["radius"][1], "1e-12 m3/mm2", 0.0, "theory; paper -0.0002", 1e-6),
        Figure("radius: x", fits["radius"][2], "1e-12 m3/mm", 0.0, "theory; paper 0.0007", 1e-6),
        Figure("radius: 1", fits["radius"][3], "1e-12 m3", 5.0 * each_newton, "theory; paper 4.4953", 1e-5),
        Figure(
            "density: slope",
            fits["density"][0],
            "1e-12 m3/(kg/m3)",
            by_density,
            "theory; paper 3e-7",
            1e-3 * by_density,
        ),
        Figure("density: 1", fits["density"][1], "1e-12 m3", 5.0 * each_newton, "theory; paper 4.4959", 1e-5),
        Figure("force: slope", fits["force"][0], "1e-12 m3/N", each_newton, "theory; paper 0.8992", 1e-5),
        Figure(
            "force: 1",
            fits["force"][1],
            "1e-12 m3",
            by_density * given["density"],
            "theory; paper 0.0017",
            1e-5,
        ),
        *spread,
    )


def table(rows: list[Row]) -> str:
    """The rows as text."""
    lines = [
        f"{'parameter':<15}{'value':>9} {'':<6}{'wear [1e-12 m3]':>16}{'theory':>10}{'force off by':>14}{'overlap [um]':>14}{'dt/T_R':>8}"
    ]
    for row in rows:
        unit, name = UNITS[row.parameter]
        lines.append(
            f"{row.parameter:<15}{row.value / unit:>9.4g} {name:<6}{1e12 * row.volume:>16.6f}{1e12 * row.theory:>10.6f}"
            f"{row.force_deviation:>14.1e}{1e6 * row.overlap:>14.4f}{row.step_share:>8.2f}"
        )
    return "\n".join(lines)


def draw(rows: list[Row], extended: list[Row], folder: Path) -> None:
    """Figures 13 to 15 of the paper and the six that show nothing, then Figures 16 and 17."""
    with report.picture(folder / "sensitivity.png", 3, 3, size=(4.0, 3.0)) as axes:
        for one, parameter in zip(axes, TABLE_X, strict=True):
            _draw_volume(one, rows, parameter)
            if parameter not in ("radius", "density", "force"):
                one.set_ylim(4.45, 4.55)
    with report.picture(folder / "section_5_2.png", 3, size=(4.0, 3.0)) as (soft, overlap, long):
        _draw_volume(soft, extended, "shear_modulus")
        _draw_volume(long, extended, "time_step")
        for one in (soft, long):
            one.set_ylim(4.45, 4.55)
        x = column(extended, "shear_modulus", "value") / 1e9
        depth = 1e6 * column(extended, "shear_modulus", "overlap")
        report.draw_lines(overlap, x, {"overlap": depth}, "shear modulus [GPa]", "overlap [um]", "o-")
        overlap.set_xscale("log")
        soft.set_xscale("log")


def _draw_volume(axes: Any, rows: list[Row], parameter: str) -> None:
    """Ours as dots, theory as a line, the paper's fit as a dashed line where it has one."""
    unit, name = UNITS[parameter]
    x = column(rows, parameter, "value") / unit
    label = f"{parameter.replace('_', ' ')} [{name}]"
    ours, theory = (1e12 * column(rows, parameter, what) for what in ("volume", "theory"))
    lines = [("theory", theory, "-"), ("this study", ours, "o")]
    if parameter in PAPER:
        lines.append(("paper's fit", np.polyval(PAPER[parameter], x), "--"))
    for what, y, style in lines:
        report.draw_lines(axes, x, {what: y}, label, "wear [1e-12 m3]", style)
    axes.legend(frameon=False, fontsize="small")
    axes.ticklabel_format(useOffset=False)


def shipped(name: str) -> list[Row]:
    """Rows of the shipped results: `table_x` or `section_5_2`"""
    return [Row(**row) for row in json.loads(RESULTS.read_text())[name]]


def beside_the_paper() -> str:
    """The trends beside the paper's fits and theory; Markdown."""
    rows = shipped("table_x")
    figure = {one.name: one for one in trends(rows)}

    def terms(parameter: str, which: str) -> str:
        found = [
            (name.partition(": ")[2], getattr(one, which))
            for name, one in figure.items()
            if name.startswith(f"{parameter}: ")
        ]
        powers = {"x^3": " x^3", "x^2": " x^2", "x": " x", "slope": " x", "1": ""}
        return " + ".join(f"{value:.6g}{powers[name]}" for name, value in found if abs(value) >= LEAST_TERM)

    lines = [
        "| parameter | paper (Table XI, 1e-12 m3; mm, kg/m3, N) | here | theory alpha (F + m g) 2 pi r |",
        "|---|---|---|---|",
    ]
    for parameter, words in (
        ("radius", "radius 1-4 mm"),
        ("density", "density 4750-5050 kg/m3"),
        ("force", "force 3-9 N"),
    ):
        lines.append(
            f"| {words} | {IN_PRINT[parameter]} | {terms(parameter, 'value')} | {terms(parameter, 'expected')} |"
        )
    most = max(one.value for name, one in figure.items() if name.endswith("largest change"))
    names = "Poisson's ratio, shear modulus, speed, mesh size, restitution, time step"
    return "\n".join([*lines, f"| {names} | no influence | largest change {most:.1e} of the wear | none |"])


def softer() -> str:
    """What a lower modulus and longer time steps do; words."""
    rows = shipped("section_5_2")
    overlap = 1e6 * column(rows, "shear_modulus", "overlap")
    wear = np.array([row.volume / row.theory for row in rows])
    share = max(row.step_share for row in rows if row.parameter == "time_step")
    return (
        f"a shear modulus 10 to 100 times lower leaves the wear and raises the overlap from {overlap.min():.2f} to {overlap.max():.1f} um; "
        f"up to {100.0 * share:.0f} % of the Rayleigh time the volume is the same (largest change of all these rows "
        f"{np.abs(wear - 1.0).max():.1e})"
    )


def main() -> None:
    """Run it all."""
    parser = argparse.ArgumentParser(description="Sensitivity of the wear of the pin on the disc.")
    parser.add_argument(
        "--out", type=Path, help="the folder to make; runs/pin_on_disc_sensitivity if not given"
    )
    out = parser.parse_args().out
    folder = RunFolder.create(out) if out else RunFolder.create_free("pin_on_disc_sensitivity")
    rows, extended = list(study(TABLE_X)), list(study(SECTION_5_2))
    figures = trends(rows)
    print(
        "Table X\n" + table(rows),
        "\nSection 5.2\n" + table(extended),
        "\nTrends",
        figure_table(figures),
        sep="\n",
    )
    write_json(
        folder.path / "sensitivity.json",
        {
            "table_x": [vars(row) for row in rows],
            "section_5_2": [vars(row) for row in extended],
            "trends": figures,
        },
    )
    kept = {"version": __version__, "table_x": rows, "section_5_2": extended}
    write_json(RESULTS, kept)
    draw(rows, extended, folder.path)
    print(f"wrote {folder.path}")


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
