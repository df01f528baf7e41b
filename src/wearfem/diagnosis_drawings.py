"""The pictures of a diagnosis, as data addresses that a page carries in itself."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wearfem.report_drawings import ACCENT, INK, page_figure
from wearfem.survey.backtest import NAMES, BackTest
from wearfem.survey.columns import Column
from wearfem.survey.diagnose import WIDTH_90, Diagnosis
from wearfem.survey.forecast import SHARE, Forecast, posterior
from wearfem.survey.identify import Fit
from wearfem.survey.survey import Survey
from wearfem.survey.words import first_points
from wearfem.wear.features import FEATURES

QUIET, GRID, WARM = "#8a949e", "#d9dee3", "#c8641b"
MODEL_COLOURS = (QUIET, WARM, ACCENT)  # straight line, coefficient alone, with the effect
BINS = 8  # of readings in the order of a quantity
WRITTEN = {"pa": "Pa", "kpa": "kPa", "mpa": "MPa", "gpa": "GPa", "hv": "HV", "c": "°C", "k": "K", "deg": "°", "n": "N",
    "kn": "kN", "m_s": "m/s", "mm_s": "mm/s", "j_m2": "J/m²", "kj_m2": "kJ/m²", "percent": "%", "mm3": "mm³", "cm3": "cm³", "um": "µm",
}  # fmt: skip


@dataclass(frozen=True)
class Quantity:
    """What readings are drawn against: (n,) numbers with a label that tells their unit."""

    name: str
    label: str
    value: np.ndarray


def unit_words(unit: str) -> str:
    """A unit as people write it"""
    return WRITTEN.get(unit, unit or "-")


def quantities(fitted: Fit, columns: Mapping[str, Column]) -> list[Quantity]:
    """What the readings of a survey may depend on: wear, service, date, place and every column that varies, in the survey's own units.

    Parameters
    ----------
    fitted
        Whose wear is taken, and whose readings.
    columns
        The columns that the survey's files have, by the name of the feature.
    """
    data = fitted.readings
    survey = data.survey
    worn = data.past.of_rows(fitted.depth) / survey.measured_factor
    found = [
        Quantity("depth", f"wear by the model [{unit_words(survey.measured_unit)}]", worn),
        Quantity("date", _progress_label(survey), survey.progress),
    ]
    for name, value in survey.feature.items():
        if name == "position":
            found += [
                Quantity(axis, f"{axis} [m]", value[:, i])
                for i, axis in enumerate("xyz")
                if np.ptp(value[:, i]) > 0.0
            ]
        elif len(np.unique(value[np.isfinite(value)])) > 2:
            label, shown = in_own_unit(name, value, columns)
            found.append(Quantity(name, label, shown))
    return found


def in_own_unit(name: str, value: np.ndarray, columns: Mapping[str, Column]) -> tuple[str, np.ndarray]:
    """A label with the unit, and values of a feature [SI] in the unit that the survey's column has."""
    words = name.replace("_", " ")
    if name in columns:
        own = columns[name]
        return f"{words} [{unit_words(own.unit)}]", (value - own.offset) / own.factor
    unit = FEATURES[name].unit if name in FEATURES else "-"
    return f"{words} [{unit}]", value


def draw_readings(found: Diagnosis) -> str:
    """Every reading over service, a line for each plate; those that were doubted are crossed."""
    survey = found.survey
    pictures: list[str] = []
    with page_figure(pictures, 7.4, 3.2) as (axes,):
        for life in np.unique(survey.life):
            rows = np.flatnonzero(survey.life == life)
            rows = rows[np.argsort(survey.progress[rows], kind="stable")]
            axes.plot(
                survey.progress[rows], survey.reading[rows] / survey.measured_factor, "o-", color=ACCENT, alpha=0.35,
                markersize=2.5, linewidth=0.8,
            )  # fmt: skip
        for doubt in found.doubts:
            axes.plot(
                survey.progress[doubt.row], doubt.reading / survey.measured_factor, "x", color="#b00020", markersize=9,
                markeredgewidth=2, label="doubted, left out",
            )  # fmt: skip
        if found.doubts:
            _legend(axes, first=True)
        _axes(axes, _progress_label(survey), _measured_label(survey))
        if survey.sign > 0.0:
            axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    return pictures[0]


def draw_residual(
    quantity: Quantity, panels: Sequence[tuple[str, np.ndarray]], gauge: float, unit: str
) -> str:
    """What is left of the readings against one quantity, before and after, with the noise of one reading as a band.

    Parameters
    ----------
    quantity
        Along the axis.
    panels
        Titles, and read less modelled (n,) in `unit`.
    gauge
        Standard error of a reading in `unit`.
    """
    pictures: list[str] = []
    with page_figure(pictures, 3.6 * len(panels) + 0.4, 2.7, len(panels)) as axes:
        known = np.isfinite(quantity.value)
        for place, (title, left) in zip(axes, panels, strict=True):
            place.axhspan(-WIDTH_90 * gauge, WIDTH_90 * gauge, color=ACCENT, alpha=0.12, linewidth=0)
            place.axhline(0.0, color=QUIET, linewidth=0.8)
            place.plot(quantity.value[known], left[known], ".", color=QUIET, markersize=3, alpha=0.6)
            middle, mean, error = _binned(quantity.value[known], left[known])
            place.errorbar(middle, mean, error, fmt="o", color=WARM, markersize=4, capsize=2, linewidth=1.2)
            place.set_title(title, loc="left", fontsize=9, fontweight="bold")
            _axes(place, quantity.label, f"read less modelled [{unit}]" if place is axes[0] else "")
            place.sharey(axes[0])
    return pictures[0]


def _binned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middles, means and 90 % half widths of y in bins of x with as many readings in each, or at each value of x where they are few"""
    values = np.unique(x)
    edges = values if len(values) <= BINS else np.unique(np.quantile(x, np.linspace(0.0, 1.0, BINS + 1))[:-1])
    number = np.searchsorted(edges, x, side="right") - 1
    groups = [(x[number == i], y[number == i]) for i in np.unique(number)]
    error = [WIDTH_90 * np.std(b, ddof=1) / np.sqrt(len(b)) if len(b) > 1 else 0.0 for _, b in groups]
    return np.array([a.mean() for a, _ in groups]), np.array([b.mean() for _, b in groups]), np.array(error)


def draw_map(position: np.ndarray, panels: Sequence[tuple[str, np.ndarray]], unit: str) -> str:
    """What is left (n,) at places (n, 3) [m], mean of each place over all its readings, from above; one scale for before and after."""
    pictures: list[str] = []
    spots, of = np.unique(position[:, :2], axis=0, return_inverse=True)
    of = of.ravel()
    means = [np.bincount(of, left) / np.bincount(of) for _, left in panels]
    most = max(float(np.abs(mean).max()) for mean in means) or 1.0
    with page_figure(pictures, 3.9 * len(panels) + 0.6, 2.9, len(panels)) as axes:
        for place, (title, _), mean in zip(axes, panels, means, strict=True):
            drawn = place.scatter(
                *spots.T, c=mean, cmap="RdBu_r", vmin=-most, vmax=most, s=60, edgecolors=INK, linewidths=0.5
            )
            place.set_title(title, loc="left", fontsize=9, fontweight="bold")
            _axes(place, "x, along the flow [m]", "y, across [m]" if place is axes[0] else "")
        axes[0].figure.colorbar(drawn, ax=list(axes), label=f"read less modelled [{unit}]")
    return pictures[0]


def draw_effect(fitted: Fit, number: int, columns: Mapping[str, Column]) -> str | None:
    """The factor of an effect over the quantity that it depends on, with an 80 % band; None where it has no such curve."""
    suspect = fitted.suspects[number]
    first = fitted.readings.coefficients + sum(len(s.free) for s in fitted.suspects[:number])
    own = slice(first, first + len(suspect.free))
    effect: Any = suspect.effect(fitted.coordinate[own])
    needs: tuple[str, ...] = getattr(effect, "needs", ())
    if len(needs) != 1:
        return None
    data = fitted.readings
    survey, past = data.survey, data.past
    axis = 1 if needs == ("position",) and suspect.quantity == "position" else getattr(effect, "axis", -1)
    if needs == ("depth",):
        label = f"wear so far [{unit_words(survey.measured_unit)}]"
        grid = np.linspace(0.0, data.deepest, 121)
        shown, known = grid / survey.measured_factor, grid
    elif needs == ("throughput",):
        grid = np.linspace(0.0, float(past.end.max()), 241)
        label, shown, known = _progress_label(survey), grid, grid
    elif needs == ("position",):
        axis = 0 if suspect.name == "AngularityLoss" else axis
        place = past.feature["position"].reshape(-1, 3)
        grid = np.linspace(place[:, axis].min(), place[:, axis].max(), 121)
        known = np.tile(np.median(place, axis=0), (len(grid), 1))
        known[:, axis] = grid
        label, shown = f"{'xyz'[axis]} [m]", grid
    else:
        value = past.feature[needs[0]]
        grid = np.linspace(value.min(), value.max(), 121)
        label, shown = in_own_unit(needs[0], grid, columns)
        known = grid

    def factor(coordinate: np.ndarray) -> np.ndarray:
        one: Any = suspect.effect(coordinate[own])
        return np.broadcast_to(one.factor(**{needs[0]: known}), grid.shape)

    drawn = np.stack([factor(c) for c in posterior(fitted, 200, np.random.default_rng(0))])
    low, high = np.quantile(drawn, [0.5 - 0.5 * SHARE, 0.5 + 0.5 * SHARE], axis=0)
    pictures: list[str] = []
    with page_figure(pictures, 4.6, 2.7) as (axes,):
        axes.fill_between(shown, low, high, color=ACCENT, alpha=0.2, linewidth=0)
        axes.plot(shown, factor(fitted.coordinate), color=ACCENT, linewidth=1.6)
        _axes(axes, label, "factor on the rate of wear [-]")
        axes.set_ylim(bottom=0.0)
    return pictures[0]


def draw_errors(rows: Sequence[tuple[str, float, float | None]], noise: float, unit: str) -> str:
    """Errors on readings fitted and never fitted, by model, with the gauge's."""
    pictures: list[str] = []
    with page_figure(pictures, 6.4, 0.55 * len(rows) + 1.1) as (axes,):
        place = np.arange(len(rows))[::-1]
        axes.barh(
            place + 0.19, [train for _, train, _ in rows], 0.34, color=GRID, label="readings it was fitted to"
        )
        held = [np.nan if h is None else h for _, _, h in rows]
        axes.barh(place - 0.19, held, 0.34, color=ACCENT, label="readings never fitted")
        axes.axvline(
            noise, color=INK, linestyle="--", linewidth=1.0, label=f"one reading's noise, {noise:.2g} {unit}"
        )
        axes.set_yticks(place, [name for name, _, _ in rows])
        _axes(axes, f"error, RMSE [{unit}]", "")
        axes.grid(visible=False, axis="y")
        axes.legend(frameon=False, fontsize=8)
    return pictures[0]


def draw_zero_errors(zero: Mapping[str, Mapping[str, Any]], unit: str) -> str:
    """Zero errors of campaigns with their 90 % intervals"""
    pictures: list[str] = []
    with page_figure(pictures, 4.6, 2.5) as (axes,):
        for number, told in enumerate(zero.values()):
            low, high = told["interval"]
            axes.plot([number, number], [low, high], color=ACCENT, linewidth=1.6)
            axes.plot(number, told["value"], "o", color=ACCENT, markersize=4)
        axes.axhline(0.0, color=QUIET, linewidth=0.8)
        axes.set_xticks(range(len(zero)), list(zero))
        _axes(axes, "occasion", f"reads too high by [{unit}]")
    return pictures[0]


def draw_ahead(found: Forecast, fitted: Fit, place: str) -> str:
    """Readings of one point, and what each model lets expect of it with 80 % bands, to the limit."""
    survey = found.survey
    number = max(i for i, name in enumerate(found.places) if name == place)
    life = found.plates[number]
    rows = fitted.readings.survey.life == life
    factor = survey.measured_factor
    shown = found.progress <= _far_enough(found, number)
    pictures: list[str] = []
    with page_figure(pictures, 4.6, 2.8) as (axes,):
        for outlook, colour in zip(found.outlooks, MODEL_COLOURS, strict=False):
            low, middle, high = outlook.worn[:, number][:, shown] / factor
            axes.fill_between(found.progress[shown], low, high, color=colour, alpha=0.2, linewidth=0)
            axes.plot(found.progress[shown], middle, color=colour, linewidth=1.5, label=outlook.name)
        data = fitted.readings
        axes.plot(data.survey.progress[rows], data.worn[rows] / factor, "o", color=INK, markersize=3.5)
        if np.isfinite(found.allowed[number]):
            axes.axhline(
                found.allowed[number] / factor, color="#b00020", linewidth=1.0, linestyle="--", label="limit"
            )
        if found.next_stop is not None:
            axes.axvline(found.next_stop, color=QUIET, linewidth=1.0, linestyle=":", label="next stop")
        axes.set_title(f"point {place}", loc="left", fontsize=10, fontweight="bold")
        _axes(axes, _progress_label(survey), f"wear [{unit_words(survey.measured_unit)}]")
        axes.legend(frameon=False, fontsize=7)
    return pictures[0]


def _far_enough(found: Forecast, number: int) -> float:
    """Progress up to which a forecast is worth drawing: somewhat beyond the end of life, or as far again as the survey"""
    ends = [np.median(o.end[:, number]) for o in found.outlooks]
    finite = [e for e in ends if np.isfinite(e)]
    last = max([found.next_stop or 0.0, *finite]) if finite else 2.0 * found.now
    return min(
        found.now + 1.3 * (last - found.now) + 2.0 * (found.progress[1] - found.progress[0]),
        found.progress[-1],
    )


def draw_back_test(found: BackTest, survey: Survey) -> str:
    """Errors of the forecasts of each occasion by model; and how many readings their 80 % intervals held."""
    pictures: list[str] = []
    with page_figure(pictures, 7.6, 2.7, 2) as (left, right):
        at = [f.progress for f in found.occasions]
        for i, (name, colour) in enumerate(zip(NAMES, MODEL_COLOURS, strict=True)):
            rmse = np.array([f.rmse[i] for f in found.occasions]) / survey.measured_factor
            left.plot(at, rmse, "o-", color=colour, markersize=4, linewidth=1.4, label=name)
            right.barh(-i, 100.0 * found.coverage[i], 0.6, color=colour)
        left.legend(frameon=False, fontsize=7)
        left.set_ylim(bottom=0.0)
        _axes(
            left,
            f"foretold occasion: {_progress_label(survey)}",
            f"error, RMSE [{unit_words(survey.measured_unit)}]",
        )
        right.axvline(100.0 * SHARE, color=INK, linestyle="--", linewidth=1.0)
        right.set_yticks([-i for i in range(len(NAMES))], NAMES)
        right.set_xlim(0.0, 100.0)
        _axes(right, f"readings in the {SHARE:.0%} interval [%]", "")
        right.grid(visible=False, axis="y")
    return pictures[0]


def left_over(found: Diagnosis) -> list[tuple[str, np.ndarray]]:
    """Read less modelled (n,) [measured unit], of the coefficient alone and, where something was added, with it.

    After, the nuisances are taken off too, as far as the readings tell them.
    """
    factor = found.survey.measured_factor
    plain, best = found.choice.plain, found.choice.best
    data = plain.readings
    panels = [("coefficient alone", (data.worn - data.past.of_rows(plain.depth)) / factor)]
    after = (data.worn - best.predict(best.readings)) / factor
    title = "with what was found, nuisances off" if best.suspects else "nuisances off"
    return [*panels, (title, after)]


def shortest_lived(found: Forecast, count: int) -> list[str]:
    """Points that come to the limit first; without a limit those that are worn most"""
    if found.limit is not None:
        return first_points(found)[:count]
    worn = found.outlooks[-1].worn[1, :, 0]
    return list(dict.fromkeys(found.places[i] for i in np.argsort(-worn, kind="stable")))[:count]


def _axes(axes: Any, x: str, y: str) -> None:
    axes.set(xlabel=x, ylabel=y)
    axes.grid(color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _legend(axes: Any, first: bool) -> None:
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles[:1] if first else handles, labels[:1] if first else labels, frameon=False, fontsize=8)


def _progress_label(survey: Survey) -> str:
    name = survey.progress_name.removesuffix(f"_{survey.progress_unit}").replace("_", " ")
    return f"{name} [{unit_words(survey.progress_unit)}]"


def _measured_label(survey: Survey) -> str:
    name = survey.measured_name.removesuffix(f"_{survey.measured_unit}").replace("_", " ")
    return f"{name} as read [{unit_words(survey.measured_unit)}]"
