"""What the command `forecast` does: read a run and what else is known, foretell its life, say it in words, write it down."""

import ast
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np

from wearfem.case import LifeCase
from wearfem.costs import Costs, Prices, costs
from wearfem.errors import UserError, in_words
from wearfem.forecast import Forecast, Known, ZoneLife, forecast
from wearfem.history import History, cycles_of, read_history
from wearfem.life import words
from wearfem.record import read_manifest, require_writable, write_json
from wearfem.report_facts import case_of_run, throughput_at
from wearfem.settings import did_you_mean, parse_value
from wearfem.sharpness import Sharpness, of_whole_face
from wearfem.units import day, tonne

UNITS = {
    "time": {"millisecond", "second", "minute", "hour", "day"},
    "mass": {"gram", "kg", "tonne", "kilotonne", "kt"},
    "length": {"um", "mm", "cm", "m", "km"},
    "stress": {"Pa", "kPa", "MPa", "GPa"},
}
EXAMPLE = {"time": "600*hour", "mass": "60*kt", "length": "8*mm", "stress": "250*MPa"}
CALIBRATED = NormalDist().inv_cdf(0.95)  # deviations to either side in the 90 % interval of a calibration


@dataclass(frozen=True)
class Asked:
    """What the user wants to know and what is known, as given on the command line."""

    limit: str = ""
    stress_limit: str = ""
    next_stop: str = ""
    coefficient_error: str = ""
    calibration: Path | None = None
    study: Path | None = None
    frozen: Path | None = None
    prices: Prices | None = None
    draws: int = 1000
    seed: int = 0


@dataclass(frozen=True)
class Foretold:
    """A forecast, and what follows from it for a plan of maintenance."""

    forecast: Forecast
    history: History
    next_stop: float | None  # [s] service time
    costs: Costs | None
    at_stop: float | None  # [currency/s] with a change at the next stop
    tonnes: float  # [t/s] throughput of the run; not a number where it counts none
    frozen_run: float | None  # [s] end of life of a run with frozen geometry
    sharpness: Sharpness | None = None  # what smoothing took off the deepest rate

    def per_tonne(self, rate: float) -> float:
        """[currency/t], or [currency/h] where the run counts no throughput, of a cost [currency/s]"""
        return rate / self.tonnes if np.isfinite(self.tonnes) else rate * 3600.0

    @property
    def cost_unit(self) -> str:
        """Of `per_tonne`"""
        currency = self.costs.prices.currency if self.costs else "money"
        return f"{currency}/t" if np.isfinite(self.tonnes) else f"{currency}/h of service"


def asked_for(
    *,
    price: float | None,
    unplanned_price: float | None,
    hour_price: float | None,
    planned_hours: float | None,
    unplanned_hours: float | None,
    currency: str,
    **asked: Any,
) -> Asked:
    """What was asked by the options of the command line, where None is what was not given."""
    other = (unplanned_price, hour_price, planned_hours, unplanned_hours, currency or None)
    if price is None and any(value is not None for value in other):
        raise UserError(
            "prices were given without --price, that of a new liner: costs cannot be told without it"
        )
    prices = None
    if price is not None:
        prices = Prices(
            price,
            unplanned_price or 0.0,
            hour_price or 0.0,
            planned_hours or 0.0,
            unplanned_hours or 0.0,
            currency or "money",
        )
    return Asked(prices=prices, **asked)


def forecast_run(run: Path, asked: Asked, out: Path | None = None, json_file: Path | None = None) -> Foretold:
    """Foretell the life of a run, print it, and write it where asked."""
    for file in filter(None, (out, json_file)):
        require_writable(file)
    found = foretell(run, asked)
    lines = list(forecast_lines(found))
    print("\n".join([f"forecast of {run}", *lines]))
    if out:
        out.write_text("\n".join([f"forecast of {run}", *lines, ""]), encoding="utf-8")
    if json_file:
        write_json(json_file, {"run": str(run)} | forecast_values(found))
    for file in filter(None, (out, json_file)):
        print(f"wrote {file}")
    return found


def foretell(run: Path, asked: Asked) -> Foretold:
    """The forecast of a run folder.

    Raises
    ------
    UserError
        for a folder that is no life's, and for wishes that make no sense; see `forecast`.
    """
    begun = read_manifest(run)
    if not cycles_of(run):
        raise UserError(
            f"{run} has no cycles: a forecast is of a life, a case in cycles such as cases/wearing_plate, that has run for two or more"
        )
    return foretell_history(read_history(run), case_of_run(begun), asked)


def foretell_history(history: History, case: LifeCase | None, asked: Asked) -> Foretold:
    """The forecast of a life that is at hand, with its case if that is there."""
    limit = quantity("limit", asked.limit, "length") if asked.limit else None
    stress = quantity("stress-limit", asked.stress_limit, "stress") if asked.stress_limit else None
    stop = stop_time(history, asked.next_stop) if asked.next_stop else None
    known = Known(coefficient_error(asked), mesh_error(asked.study) if asked.study else None)
    found = forecast(
        history, limit, known, stress_limit=stress, case=case, draws=asked.draws, seed=asked.seed
    )
    passed = history.throughput[-1] - history.throughput[0]
    tonnes = passed / tonne / (history.service_time[-1] - history.service_time[0]) if passed > 0.0 else np.nan
    life, prices = found.zone[0].draw, asked.prices
    return Foretold(
        forecast=found,
        history=history,
        next_stop=stop,
        costs=costs(life, prices) if prices else None,
        at_stop=float(costs(life, prices, [stop]).rate[0]) if prices and stop is not None else None,
        tonnes=float(tonnes),
        frozen_run=_end_of_frozen(asked.frozen) if asked.frozen else None,
        sharpness=of_whole_face(history, case),
    )


def _end_of_frozen(run: Path) -> float:
    """[s] end of life of a run with frozen geometry"""
    case = case_of_run(read_manifest(run))
    if case is not None and not case.frozen:
        raise UserError(
            f"{run} was given as a run with frozen geometry, but its geometry moves: give one of a case with frozen=True"
        )
    return read_history(run).life[-1].time


def quantity(option: str, text: str, *kinds: str) -> float:
    """The value [SI] of an expression with a unit, like `8*mm`, for an option of the command line.

    Raises
    ------
    UserError
        for what cannot be read, for a unit of another kind and for none.
    """
    try:
        value = parse_value(option, text)
    except UserError as error:
        raise UserError(str(error).replace(f'--set {option}="{text}"', f"--{option} {text}")) from None
    names = {node.id for node in ast.walk(ast.parse(text, mode="eval")) if isinstance(node, ast.Name)}
    allowed = set().union(*(UNITS[kind] for kind in kinds))
    if isinstance(value, bool) or not isinstance(value, int | float) or not names or not names <= allowed:
        near = did_you_mean(next(iter(names - allowed), ""), allowed)
        raise UserError(
            f"--{option} was given {text}{near}, and it needs a number with a unit of {in_words(list(kinds), 'or')}, such as "
            f"{in_words([EXAMPLE[kind] for kind in kinds], 'or')}"
        )
    return float(value)


def stop_time(history: History, text: str) -> float:
    """The service time [s] of a stop that is given as service time or as throughput, both since the liner was new.

    Raises
    ------
    UserError
        for a stop in the past, and for a throughput where the run counts none.
    """
    value = quantity("next-stop", text, "time", "mass")
    names = {node.id for node in ast.walk(ast.parse(text, mode="eval")) if isinstance(node, ast.Name)}
    served, passed = float(history.service_time[-1]), float(history.throughput[-1])
    if names <= UNITS["mass"]:
        if not passed > history.throughput[0]:
            raise UserError(
                f"--next-stop was given {text}, and this run counts no throughput: give it as a time of service"
            )
        slope = (passed - history.throughput[0]) / (served - history.service_time[0])
        value = served + (value - passed) / slope
    if not value > served:
        raise UserError(
            f"--next-stop {text} is in the past: the liner has served {words(served)}"
            + (f" and {passed / tonne:.4g} t" if passed > 0.0 else "")
            + "; count the stop from when the liner was new"
        )
    return value


def coefficient_error(asked: Asked) -> float | None:
    """[-] relative standard deviation of the wear coefficient, given or from what `wearfem calibrate --json` wrote."""
    if asked.coefficient_error and asked.calibration:
        raise UserError(
            "both --coefficient-error and --calibration were given: each tells the doubt of the coefficient, so give one of them"
        )
    if asked.coefficient_error:
        value = parse_value("coefficient-error", asked.coefficient_error)
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise UserError(
                f"--coefficient-error was given {asked.coefficient_error}, and it needs a part of 1, such as 0.1 or 10*percent"
            )
        return float(value)
    if not asked.calibration:
        return None
    told = _json(asked.calibration, "wearfem calibrate --json")
    try:
        value, (low, high) = told["coefficient"]["value"], told["coefficient"]["interval"]
        error = (high - low) / (2.0 * CALIBRATED * value)
    except (KeyError, TypeError, ValueError, ZeroDivisionError) as wrong:
        raise UserError(
            f"{asked.calibration} holds no coefficient with an interval: give the file that wearfem calibrate --json wrote"
        ) from wrong
    return float(error)


def mesh_error(study: Path) -> float:
    """[-] relative standard deviation of life from the mesh: half of the error of the finest run of a study.

    That error is 1.25 times the distance from the converged answer, meant to hold the truth in 95 % (Roache): two deviations.
    """
    answers = _json(study / "converged.json", "wearfem study --size")
    try:
        told = [answer["answer"] for answer in answers if answer["figure"] == "end of life"]
        found = [
            0.5 * one["error"] / abs(one["value"])
            for one in told
            if one["value"] and one["error"] is not None
        ]
    except (KeyError, TypeError):
        found = []
    if not found:
        raise UserError(
            f"{study} tells no converged end of life: give a study of this case over a mesh size, with --size, that came to an answer"
        )
    return float(max(found))


def _json(file: Path, source: str) -> Any:
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UserError(f"there is no file {file}: give what {source} wrote") from None
    except (OSError, ValueError) as error:
        raise UserError(f"{file} cannot be read ({error}): give what {source} wrote") from error


def forecast_lines(found: Foretold) -> Iterable[str]:
    """A forecast in plain words, line by line."""
    told = found.forecast
    yield f"{told.samples} samples, {words(told.served)} served; times are of service since the liner was new"
    if found.history.ended == "end of life":
        yield "this life was followed to its end: what the case allows is gone, and the first table tells how surely that was then"
    for until in dict.fromkeys(zone.until for zone in told.zone):
        yield ""
        yield from _table(found, [zone for zone in told.zone if zone.until == until], until)
    first = told.zone[0]
    yield ""
    yield f"what the width of the first line comes from: {shares(first.share)}"
    if found.sharpness:
        yield found.sharpness.words(first.quantile[1])
    if told.left_out:
        yield f"not included, since not given: {in_words(list(told.left_out))}"
    yield "straight line: the depth so far over the time so far. frozen geometry: the rates of the new liner, kept"
    if found.frozen_run is not None:
        yield f"the run with frozen geometry ended at {words(found.frozen_run)}"
    if found.costs:
        yield ""
        yield from _cost_lines(found)


def _table(found: Foretold, zones: list[ZoneLife], until: str) -> Iterable[str]:
    stop = found.next_stop
    head = ["zone", "in 8 of 10 cases", "middle", "straight line", "frozen geometry"]
    rows = [
        [
            zone.zone,
            f"{words(low)} to {words(high)}",
            words(middle),
            words(zone.straight_line),
            words(zone.frozen),
        ]
        for zone in zones
        for low, middle, high in [zone.quantile]
    ]
    if stop is not None:
        head.append(f"reaches the stop at {words(stop)}")
        for row, zone in zip(rows, zones, strict=True):
            row.append(percent(zone.probability_to_reach(stop)))
    yield f"until {until}:"
    width = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    for row in [head, *rows]:
        yield "  " + "   ".join(word.ljust(size) for word, size in zip(row, width, strict=True)).rstrip()


def percent(part: float) -> str:
    """A probability as people say it, never surer than the draws"""
    if part > 0.995:
        return "above 99 %"
    return "below 1 %" if part < 0.005 else f"{part:.0%}".replace("%", " %")


def shares(share: Mapping[str, float]) -> str:
    """What the width of an interval comes from, the largest first"""
    share = dict(sorted(share.items(), key=lambda item: -item[1]))
    return ", ".join(
        f"{source} {part:.0%}".replace("%", " %") for source, part in share.items() if part > 0.0
    )


def _cost_lines(found: Foretold) -> Iterable[str]:
    told, unit = found.costs, found.cost_unit
    assert told is not None
    prices = told.prices
    yield (
        f"costs: a planned change {prices.planned:,.0f} {prices.currency}, an unplanned one {prices.unplanned:,.0f} {prices.currency}"
    )
    plans = plans_of(found)
    width = max(len(way) for way, _ in plans)
    for way, cost in plans:
        yield f"  {way.ljust(width)}   {cost:.4g} {unit}"
    if not np.isfinite(told.best):
        yield "  no planned change is cheaper than running until it fails"


def plans_of(found: Foretold) -> list[tuple[str, float]]:
    """Ways to plan the change in words, with what each costs [`cost_unit`]; none without prices."""
    told = found.costs
    if told is None:
        return []
    plans = [("run until it fails", told.to_the_end)]
    if found.at_stop is not None and found.next_stop is not None:
        plans.append((f"change at the next stop, {words(found.next_stop)}", found.at_stop))
    if np.isfinite(told.best):
        plans.append((f"change at {words(told.best)}, the cheapest time", float(told.rate.min())))
    return [(way, found.per_tonne(rate)) for way, rate in plans]


def forecast_values(found: Foretold) -> dict[str, Any]:
    """A forecast as JSON has it: times in days of service since the liner was new."""
    told = found.forecast
    zones = [
        {
            "zone": zone.zone,
            "until": zone.until,
            "life_d": dict(zip(("10%", "50%", "90%"), (q / day for q in zone.quantile), strict=True)),
            "throughput_t": dict(
                zip(
                    ("10%", "50%", "90%"),
                    (throughput_at(found.history, q) / tonne for q in zone.quantile),
                    strict=True,
                )
            ),
            "straight_line_d": zone.straight_line / day,
            "frozen_geometry_d": zone.frozen / day,
            "last_rate_d": zone.last_rate / day,
            "share_of_variance": zone.share,
            "probability_to_reach_next_stop": (
                None if found.next_stop is None else zone.probability_to_reach(found.next_stop)
            ),
        }
        for zone in told.zone
    ]
    values: dict[str, Any] = {
        "served_d": told.served / day,
        "samples": told.samples,
        "next_stop_d": None if found.next_stop is None else found.next_stop / day,
        "frozen_run_d": None if found.frozen_run is None else found.frozen_run / day,
        "not_included": list(told.left_out),
        "smoothing": None
        if found.sharpness is None
        else {
            "length_m": found.sharpness.length,
            "shorter_m": found.sharpness.over,
            "life_over_told": found.sharpness.kept,
            "standard_error": found.sharpness.error,
        },
        "zones": zones,
    }
    if found.costs:
        values["costs"] = {
            "unit": found.cost_unit,
            "prices": found.costs.prices,
            "run_until_it_fails": found.per_tonne(found.costs.to_the_end),
            "change_at_next_stop": None if found.at_stop is None else found.per_tonne(found.at_stop),
            "change_at_d": found.costs.time / day,
            "cost": [found.per_tonne(rate) for rate in found.costs.rate.tolist()],
            "cheapest_change_d": found.costs.best / day,
        }
    return values
