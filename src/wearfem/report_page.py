"""One page on the life of a liner, for the planner of its maintenance: a file that needs no network and prints well."""

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from wearfem.case import Figure, LifeCase
from wearfem.errors import UserError
from wearfem.forecast import QUANTILES
from wearfem.foretell import Asked, Foretold, foretell_history, percent, plans_of, shares
from wearfem.history import CYCLES, History, computing_of, cycles_of, read_cycle, read_history
from wearfem.life import words
from wearfem.liner.liner import wear_surface
from wearfem.page import rendered
from wearfem.progress import clock
from wearfem.record import (
    figure_list,
    now,
    read_manifest,
    require_writable,
    whole_file,
    write_json,
)
from wearfem.report_drawings import Curve, colour_table, draw_curve, draw_maps
from wearfem.report_facts import (
    CONFIDENCE,
    End,
    case_of_run,
    corrected_thickness,
    corrected_volume,
    deviations,
    end_of,
    lag_of,
    least,
    mesh_hash,
    thickness_at,
    warnings_of,
    wear_by_zone,
    zones_of,
)
from wearfem.sharpness import Sharpness, of_whole_face
from wearfem.units import day, kilotonne, tonne

PAGE = "report.html"
MOST_NUMBERS = 2_000_000  # coordinates and values in the view that turns: some 10 MB of page
MOST_FRAMES = 40


@dataclass(frozen=True)
class Frame:
    """The worn face at one moment, as the view that turns shows it."""

    title: str
    point: np.ndarray  # (p, 3) [m]
    triangle: np.ndarray  # (t, 3)
    thickness: np.ndarray  # (t,) [m]; NaN where none is measured
    depth: np.ndarray  # (t,) [m] worn off since the liner was new


def write_report(
    run: Path, out: Path | None = None, json_file: Path | None = None, asked: Asked | None = None
) -> tuple[Figure, ...]:
    """Write the page of a life: what was run, when it ends and how surely, what is left where, and what to beware of.

    Parameters
    ----------
    run
        The run folder of a life, finished or not, with two cycles at least.
    out
        The file to write; `report.html` in the run folder if not given. A page is made from what the run has written, and is written
        anew each time.
    json_file
        Where else to write the figures.
    asked
        What the forecast on the page is to know and to tell: limits, the next stop, prices. The limits of the case without it.

    Returns
    -------
    tuple of Figure
        What the page says in numbers.

    Raises
    ------
    UserError
        for a folder that is no run or no life's, a life of fewer than two cycles that were kept, and files cut off or damaged.
    """
    begun = read_manifest(run)
    place = run / PAGE if out is None else out
    for file in filter(None, (place, json_file)):
        require_writable(file)
    if not cycles_of(run):
        raise UserError(
            f"{run} has no cycles: a report is of a life, a case in cycles such as cases/wearing_plate, that has run for two or more"
        )
    case = case_of_run(begun)
    history = read_history(run)
    if len(history.samples) < 2:
        raise UserError(
            f"{run} has one cycle that was kept, and a report needs two, to see the liner wear: go on with wearfem resume {run}"
        )
    page, figures = compose(run, begun, history, case, asked)
    with whole_file(place) as temporary:
        temporary.write_text(page, encoding="utf-8")
    if json_file:
        write_json(json_file, figure_list(figures))
    print(f"wrote {place}")
    return figures


def compose(
    run: Path, begun: Mapping[str, Any], history: History, case: LifeCase | None, asked: Asked | None = None
) -> tuple[str, tuple[Figure, ...]]:
    """The page as text, and its figures."""
    confidence = case.goal.confidence if case else CONFIDENCE
    end = end_of(history.life[-1], history, -1, confidence)
    thickness = thickness_at(history, end.time)
    frames = frames_of(run, history, end, thickness)
    limits = _limits(corrected_thickness(history), thickness)
    mesh, first = history.state.now.liner.mesh, read_cycle(run, 1)[0].kept
    assert first is not None  # a cycle keeps what it sampled first
    last = float(history.service_time[-1])
    moments = {
        "at the first cycle": float(history.service_time[0]),
        f"now: {words(last)} served": last,
        f"end of life: {words(end.time)}": end.time,
    }
    in_order = sorted(moments.items(), key=lambda moment: moment[1])
    maps = [(title, thickness_at(history, time)) for title, time in in_order]
    foretold, refused = _foretold(history, case, asked)
    sharper = foretold.sharpness if foretold else of_whole_face(history, case)
    figures = figures_of(history, end, foretold, sharper)
    page = rendered(
        "page.html",
        {"time": words, "mass": mass, "millimetre": _millimetre, "clock": clock},
        case=begun["case"],
        begun=begun,
        written=now().isoformat(timespec="seconds"),
        history=history,
        end=end,
        left=corrected_thickness(history),
        volume=corrected_volume(history),
        lag=float(np.abs(lag_of(history)).max()),
        least=least,
        confidence=f"{confidence:.0%}",
        zones=wear_by_zone(history, confidence),
        grouped=any(name in mesh.group for name in zones_of(mesh)),
        warnings=warnings_of(history, begun, case, end),
        figures=figures,
        foretold=foretold,
        smoothed=smoothed_less(sharper, end.time) if sharper else [],
        smoothing_length=sharper.length if sharper else 0.0,
        refused=refused,
        shares=shares,
        percent=percent,
        planned=plans_of(foretold) if foretold else [],
        chances=[(curve.title, draw_curve(curve)) for curve in chances_of(foretold)] if foretold else [],
        case_figures=_case_figures(run),
        settings=begun["settings"],
        versions=begun["versions"],
        mesh=mesh,
        first_mesh=first.liner.mesh,
        mesh_hash=mesh_hash(first.liner.mesh),
        maps=draw_maps(mesh, maps, limits),
        curves=[(curve.title, draw_curve(curve)) for curve in curves_of(history, confidence)],
        strain=history.reports[-1].strain,
        rate_unit=day * 1e3,
        day=day,
        computing=computing_of(run),
        script=(files("wearfem") / "page" / "view.js").read_text(encoding="utf-8"),
        view=view_data(frames, limits),
    )
    return page, figures


def _foretold(history: History, case: LifeCase | None, asked: Asked | None) -> tuple[Foretold | None, str]:
    """The forecast, or the sentence that says why there is none. What was asked for is not passed over in silence."""
    try:
        return foretell_history(history, case, asked or Asked()), ""
    except UserError as error:
        if asked is not None and asked != Asked():
            raise
        return None, str(error)


def chances_of(foretold: Foretold) -> list[Curve]:
    """The chance that the whole worn face lasts, and where prices are given the cost by the time of change."""
    lives = np.sort(foretold.forecast.zone[0].draw) / day
    left = 100.0 * (1.0 - np.arange(len(lives)) / len(lives))
    some = np.linspace(0, len(lives) - 1, 40).round().astype(int)
    title = f"Chance to last, until {foretold.forecast.zone[0].until}"
    curves = [Curve(title, lives[some], left[some], "service time [d]", "chance [%]")]
    if foretold.costs:
        cost = np.array([foretold.per_tonne(rate) for rate in foretold.costs.rate])
        unit = f"cost [{foretold.cost_unit}]"
        curves.append(
            Curve("Cost by the time of change", foretold.costs.time / day, cost, "service time [d]", unit)
        )
    return curves


def smoothed_less(sharper: Sharpness, life: float) -> list[tuple[float, float, float]]:
    """Lengths [m] shorter than the smoothing of the run, and by what each would change a life [s], with its standard error [s]"""
    return list(
        zip(
            sharper.over.tolist(),
            ((sharper.kept - 1.0) * life).tolist(),
            (sharper.error * life).tolist(),
            strict=True,
        )
    )


def figures_of(
    history: History, end: End, foretold: Foretold | None = None, sharper: Sharpness | None = None
) -> tuple[Figure, ...]:
    """The numbers of the page."""
    low, high = end.interval
    left = least(corrected_thickness(history)[-1])
    figures = [
        Figure("end of life", end.time / day, "d"),
        Figure("end of life, from", low / day, "d"),
        Figure("end of life, to", high / day, "d"),
        Figure("service time at the last cycle", float(history.service_time[-1]) / day, "d"),
        Figure("least thickness at the last cycle", 1e3 * left, "mm"),
        Figure("deepest wear at the last cycle", 1e3 * float(history.depth[-1].max()), "mm"),
        Figure("volume worn off at the last cycle", 1e6 * float(corrected_volume(history)[-1]), "cm3"),
        Figure("largest rate of the last cycle", 1e3 * day * float(history.rate[-1].max()), "mm/d"),
    ]
    if np.isfinite(end.throughput):
        figures.insert(3, Figure("throughput at end of life", end.throughput / tonne, "t"))
    for length, change, error in smoothed_less(sharper, end.time) if sharper else ():
        name = f"change of the end of life, had the rate been smoothed over {1e3 * length:.3g} mm"
        figures.append(Figure(name, change / day, "d"))
        figures.append(Figure(f"{name}, standard error", error / day, "d"))
    for zone in foretold.forecast.zone if foretold else ():
        name = f"{zone.zone}, until {zone.until}"
        for part, quantile in zip(QUANTILES, zone.quantile, strict=True):
            figures.append(
                Figure(f"life foretold, {name}, {part:.0%} of the draws end before", quantile / day, "d")
            )
        if foretold and foretold.next_stop is not None:
            reached = zone.probability_to_reach(foretold.next_stop)
            figures.append(Figure(f"probability to reach the next stop, {name}", reached, "-"))
    if foretold:
        figures += [Figure(f"cost, {way}", cost, foretold.cost_unit) for way, cost in plans_of(foretold)]
    return tuple(figures)


def curves_of(history: History, confidence: float) -> list[Curve]:
    """Wear against throughput, or against service time where the case counts no throughput; and how the told life has changed."""
    counts = history.throughput[-1] > history.throughput[0]
    large = history.throughput[-1] >= 2.0 * kilotonne
    unit, name = (kilotonne, "kt") if large else (tonne, "t")
    x = history.throughput / unit if counts else history.service_time / day
    label = f"throughput [{name}]" if counts else "service time [d]"
    cycle, fastest = np.arange(len(x)), history.rate.argmax(axis=1)
    ends = [end_of(life, history, number, confidence) for number, life in enumerate(history.life)]
    curves = [
        Curve("Deepest wear", x, 1e3 * history.depth.max(axis=1), label, "depth [mm]"),
        Curve("Volume worn off", x, 1e6 * corrected_volume(history), label, "volume [cm³]"),
        Curve(
            "Largest rate of wear",
            x,
            1e3 * day * history.rate[cycle, fastest],
            label,
            "rate [mm/d]",
            1e3 * day * deviations(confidence) * history.error[cycle, fastest],
        ),
        Curve(
            "End of life as told after each cycle",
            x,
            np.array([end.time for end in ends]) / day,
            label,
            "end of life [d]",
            np.array([end.half for end in ends]) / day,
        ),
    ]
    if np.isfinite(history.largest_von_mises).all():
        stress = 1e-6 * history.largest_von_mises
        curves.append(Curve("Largest von Mises stress", x, stress, label, "stress [MPa]"))
    if np.isfinite(history.least_reserve).all():
        curves.append(Curve("Reserve against yield", x, history.least_reserve, label, "reserve factor [-]"))
    return curves


def frames_of(run: Path, history: History, end: End, thickness: np.ndarray) -> list[Frame]:
    """The worn face of every cycle that was kept, as it was sampled, and at the end of life, if that is still to come.

    Of many cycles a part is shown, evenly spread, always with the first and the last. At the end of life the shape is that of the last
    jump, the thickness the one that is foretold.
    """
    kept = [report for report in history.reports if report.kept]
    surface = wear_surface(history.state.now.liner)
    each = 3 * len(surface.point) + 2 * len(surface.triangle)
    count = int(np.clip(MOST_NUMBERS // each, 2, MOST_FRAMES))
    shown = np.unique(np.linspace(0, len(kept) - 1, min(count, len(kept))).round().astype(int))
    known, frames = corrected_thickness(history), []
    for number in shown:
        report = kept[number]
        title = f"cycle {report.cycle}: {words(report.service_time)} served"
        if report.throughput > 0.0:
            title += f", {mass(report.throughput)}"
        frame, facet = _worn_face(run / CYCLES / f"{report.cycle:04d}.vtkhdf", title)
        if len(report.depth) == len(
            history.area
        ):  # the mesh is still the same: what is known since is better
            frame = replace(frame, thickness=known[number][facet], depth=history.depth[number][facet])
        frames.append(frame)
    ahead = end.time - float(history.service_time[-1])
    if ahead > 0.0:
        depth = history.depth[-1] + ahead * history.rate[-1]
        title = f"end of life, foretold: {words(end.time)}"
        frames.append(
            Frame(title, surface.point, surface.triangle, thickness[surface.facet], depth[surface.facet])
        )
    return frames


def _worn_face(file: Path, title: str) -> tuple[Frame, np.ndarray]:
    """The worn face that a cycle wrote, and the facet (t,) of each triangle."""
    try:
        with h5py.File(file, "r") as content:
            root = content["VTKHDF"]
            thickness = root["CellData/thickness [m]"][()]
            frame = Frame(
                title,
                root["Points"][()],
                root["Polygons/Connectivity"][()].reshape(-1, 3),
                np.where(np.isfinite(thickness), thickness, np.nan),
                root["CellData/depth [m]"][()],
            )
            return frame, root["CellData/facet"][()]
    except (OSError, KeyError, RuntimeError, ValueError) as error:
        raise UserError(
            f"{file} is missing, cut off or damaged ({error}): put it back, or move away this cycle and all later ones and use "
            "wearfem resume"
        ) from error


def view_data(frames: Sequence[Frame], limits: tuple[float, float]) -> str:
    """What the view that turns needs, as JSON that may stand in a page; arrays are base64 of little-endian numbers.

    Coordinates are taken from the middle of the first frame, in mm; triangles are told again only where they have changed.
    """
    middle = 0.5 * (frames[0].point.min(axis=0) + frames[0].point.max(axis=0))
    told, before = [], np.zeros((0, 3), int)
    for frame in frames:
        same = np.array_equal(before, frame.triangle)
        before = frame.triangle
        told.append(
            {
                "title": frame.title,
                "point": _numbers(1e3 * (frame.point - middle), "<f4"),
                "triangle": None if same else _numbers(frame.triangle, "<u4"),
                "thickness": _numbers(1e3 * frame.thickness, "<f4"),
                "depth": _numbers(1e3 * frame.depth, "<f4"),
            }
        )
    deepest = max(float(frame.depth.max()) for frame in frames)
    content = {
        "frames": told,
        "limits": {
            "thickness": [1e3 * limits[0], 1e3 * limits[1]],
            "depth": [0.0, 1e3 * deepest if deepest > 0.0 else 1.0],
        },
        "colours": _numbers(colour_table(), "u1"),
    }
    return json.dumps(content, allow_nan=False).replace("<", "\\u003c")


def _numbers(array: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(array, kind).tobytes()).decode()


def _limits(*thickness: np.ndarray) -> tuple[float, float]:
    """[m] the ends of the colours of thickness: the least and the most that are known, never the same"""
    known = np.concatenate([one.ravel() for one in thickness])
    known = known[np.isfinite(known)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1e-3)
    return (low, high) if high > low else (0.0, high or 1e-3)


def _case_figures(run: Path) -> list[dict[str, Any]]:
    """What the case itself measured, where the run is finished."""
    file = run / "figures.json"
    if not file.exists():
        return []
    try:
        return list(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise UserError(
            f"{file} is cut off or damaged ({error}): remove it, and the report is made without"
        ) from error


def mass(kilogram: float) -> str:
    """A throughput as people say it: `12.3 kt`, `850 t`, `3 kg`."""
    for unit, name in ((kilotonne, "kt"), (tonne, "t")):
        if abs(kilogram) >= 2.0 * unit:
            return f"{kilogram / unit:.4g} {name}"
    return f"{kilogram:.3g} kg"


def _millimetre(metre: float) -> str:
    return f"{1e3 * metre:.4g} mm" if np.isfinite(metre) else "not measured"
