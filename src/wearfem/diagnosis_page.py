"""One page on a diagnosis, for who reads the gauge and who plans: the story in order, in a file that needs no network and prints well."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wearfem.diagnosis_drawings import (
    draw_ahead,
    draw_back_test,
    draw_effect,
    draw_errors,
    draw_map,
    draw_readings,
    draw_residual,
    draw_zero_errors,
    left_over,
    quantities,
    shortest_lived,
    unit_words,
)
from wearfem.errors import in_words
from wearfem.page import rendered
from wearfem.record import file_hash, now, this_machine, whole_file
from wearfem.survey.backtest import NAMES, BackTest, advised
from wearfem.survey.choose import Choice
from wearfem.survey.columns import Column, column, read_table
from wearfem.survey.diagnose import NOISE_LEVEL, Diagnosis
from wearfem.survey.forecast import DRAWS, SHARE, End, Forecast, Outlook
from wearfem.survey.survey import KNOWN_AS
from wearfem.survey.words import (
    VERDICT,
    advice_words,
    effect_words,
    end_words,
    first_points,
    limit_words,
    more_words,
    progress_unit,
    says,
)

PAGE = "report.html"
MOST_QUANTITIES = 8  # against which the residual is drawn, those first that it depends on most
MOST_POINTS = 4  # whose forecast is drawn
MOST_SUSPECTS = 12
MOST_ROWS = 40  # of the table of points


@dataclass(frozen=True)
class Suspected:
    """A model that was tried: in words, how many times as probable as the coefficient alone, and its share of all belief."""

    words: str
    odds: str
    share: float
    chosen: bool


def write_page(
    page: Path, found: Diagnosis, ahead: Forecast, tested: BackTest, read: Sequence[Path], seed: int = 0
) -> None:
    """Write the page of a diagnosis.

    Parameters
    ----------
    page
        The file; it is written anew each time.
    found, ahead, tested
        What the page tells.
    read
        The files that the survey was read from, for their hashes and for the units of their columns.
    seed
        Of the draws.
    """
    text = compose(found, ahead, tested, read, seed)
    with whole_file(page) as temporary:
        temporary.write_text(text, encoding="utf-8")


def compose(found: Diagnosis, ahead: Forecast, tested: BackTest, read: Sequence[Path], seed: int = 0) -> str:
    """The page as text."""
    survey, choice, advice = found.survey, found.choice, advised(ahead, tested)
    unit = unit_words(survey.measured_unit)
    columns = columns_of(read)
    panels = left_over(found)
    gauge = found.noise_floor
    carried = {test.quantity: test for test in found.tests_before}
    drawn = sorted(
        quantities(choice.best, columns), key=lambda q: carried[q.name].p if q.name in carried else 1.0
    )
    position = choice.plain.readings.survey.feature.get("position")
    if position is not None and not (np.ptp(position[:, :2], axis=0) > 0.0).all():
        position = None  # places in a line make no map
    zero: Any = found.nuisance["zero_error"]
    fitted = choice.best
    return rendered(
        "diagnosis.html",
        {"error": lambda value: "none held out" if value is None else f"{value:.3g} {unit}"},
        found=found,
        survey=survey,
        unit=unit,
        service=progress_unit(survey),
        measured=survey.measured_name.removesuffix(f"_{survey.measured_unit}").replace("_", " "),
        title=Path(survey.source).stem if Path(survey.source).stem != "survey" else _folder(survey.source),
        verdict=VERDICT[found.verdict],
        plain=plain_words(found),
        more=more_words(found) if found.effects and found.more_than_noise else "",
        errors=_errors(found),
        error_picture=draw_errors(_errors(found), found.noise_floor, unit),
        readings_picture=draw_readings(found),
        residuals=[(q.name, draw_residual(q, panels, gauge, unit)) for q in drawn[:MOST_QUANTITIES]],
        left_out=[q.label for q in drawn[MOST_QUANTITIES:]],
        map=None if position is None else draw_map(position, panels, unit),
        noise_level=NOISE_LEVEL,
        suspects=suspected(choice),
        tried=len(choice.tried),
        effects=[
            (effect, effect_words(effect, survey), draw_effect(fitted, i, columns))
            for i, effect in enumerate(found.effects)
        ],
        in_words=in_words,
        zero=zero,
        zero_picture=draw_zero_errors(zero, unit) if zero else None,
        nuisances=_nuisances(found, unit),
        ahead=ahead,
        limit=limit_words(ahead),
        places=places_of(ahead, advice.outlook),
        advice=advice,
        advice_words=advice_words(ahead, tested),
        hidden=max(0, len(set(ahead.places)) - MOST_ROWS),
        ahead_pictures=[(p, draw_ahead(ahead, fitted, p)) for p in shortest_lived(ahead, MOST_POINTS)],
        share=f"{SHARE:.0%}",
        tested=tested,
        models=NAMES,
        test_picture=draw_back_test(tested, survey) if tested.occasions else None,
        factor=survey.measured_factor,
        machine=this_machine(),
        hashes={file.name: file_hash(file) for file in read},
        seed=seed,
        draws=DRAWS,
        written=now().isoformat(timespec="seconds"),
    )  # fmt: skip


@dataclass(frozen=True)
class Place:
    """A row of the forecast: a zone or a point, when it is worn out by the forecast to plan by and by each model, and how surely it lasts
    to the next stop."""

    kind: str
    name: str
    end: str
    ends: tuple[str, ...]
    reaches: str


def places_of(ahead: Forecast, advised: Outlook) -> list[Place]:
    """All zones, then the points that come to the limit first; none where no limit was given."""
    if ahead.limit is None:
        return []
    zone, point = ("zone" if ahead.survey.zone else ""), "point"
    rows: list[tuple[str, str, Callable[[Outlook, str], End]]]
    rows = [(zone, name, ahead.of_zone) for name in dict.fromkeys(ahead.zones)]
    rows += [(point, name, ahead.of_place) for name in first_points(ahead)[:MOST_ROWS]]
    found = []
    for kind, name, of in rows:
        first = of(advised, name)
        reaches = "" if first.reaches is None else f"{100.0 * first.reaches:.0f} %"
        ends = tuple(end_words(of(outlook, name), ahead) for outlook in ahead.outlooks)
        found.append(Place(kind, name, end_words(first, ahead), ends, reaches))
    return found


def plain_words(found: Diagnosis) -> str:
    """The verdict for people who read nothing else."""
    if found.verdict == "adequate":
        return (
            "The readings say nothing that one coefficient of wear, the noise of the gauge and the usual errors of campaigns do not "
            "explain. Nothing needs to be added to the model."
        )
    if not found.effects:
        return (
            "What is left of the readings is more than noise, and no quantity that the survey tells carries it. Look at the notes, and at "
            "what was never written down."
        )
    named = in_words([says(effect) for effect in found.effects])
    if found.verdict == "effect_found":
        return f"The model lacks something, and the readings tell what: {named}."
    if found.verdict == "unexplained":
        return f"The model lacks something that no effect of the library describes. What was found is a curve, and no cause: {named}."
    others = [other for effect in found.effects for other in effect.indistinguishable_from]
    return f"The model lacks something, and these readings fit more than one explanation: {named}; or {in_words(others, 'or')}."


def suspected(choice: Choice) -> list[Suspected]:
    """The models that were tried, the most probable first, always with the coefficient alone."""
    order = sorted(choice.tried, key=choice.belief, reverse=True)
    weight = np.exp([choice.belief(f) - choice.belief(order[0]) for f in order])
    share = weight / weight.sum()
    shown = [i for i, f in enumerate(order) if i < MOST_SUSPECTS or not f.suspects or f is choice.best]
    plain = choice.belief(choice.plain)
    return [
        Suspected(f.name, odds_words(choice.belief(f) - plain), float(share[i]), f is choice.best)
        for i, f in enumerate(order)
        if i in shown
    ]


def odds_words(nats: float) -> str:
    """Odds as people say them: `20 to 1`, `10^12 to 1`, `1 to 8`."""
    if abs(nats) < 0.05:
        return "1 to 1"
    size = abs(nats)
    number = f"{np.exp(size):.2g}" if size < np.log(1e4) else f"10^{size / np.log(10.0):.0f}"
    number = f"{np.exp(size):.0f}" if np.log(10.0) <= size < np.log(1e4) else number
    return f"{number} to 1" if nats > 0.0 else f"1 to {number}"


def columns_of(read: Sequence[Path]) -> dict[str, Column]:
    """The columns of files by the name of the feature that each becomes."""
    told = [column(name) for file in read for name in read_table(file)]
    return {KNOWN_AS.get(one.quantity, one.quantity): one for one in told}


def _errors(found: Diagnosis) -> list[tuple[str, float, float | None]]:
    rows = [
        ("coefficient alone", found.baseline.train_rmse, found.baseline.heldout_rmse),
        ("straight line per point", found.straight_line.train_rmse, found.straight_line.heldout_rmse),
    ]
    name = f"with {found.choice.best.name}" if found.effects else "coefficient alone, nuisances off"
    return [*rows, (name, found.improved.train_rmse, found.improved.heldout_rmse)]


def _nuisances(found: Diagnosis, unit: str) -> list[tuple[str, str]]:
    told: Mapping[str, Any] = found.nuisance
    return [
        ("error of one reading, as the scatter tells", f"{found.noise_floor:.2g} {unit}"),
        ("zero error of a campaign", f"{told['zero_error_deviation']:.2g} {unit}"),
        ("error of a campaign in proportion to wear", f"{100.0 * told['scale_error_deviation']:.2g} %"),
        ("error of the tonnage book in an interval", f"{100.0 * told['tonnage_book_deviation']:.2g} %"),
        ("smooth error of the rate over place", f"{100.0 * told['smooth_error_of_the_rate']:.2g} %"),
        ("the run's own sampling", f"{100.0 * told['run_own_sampling']:.2g} %"),
        ("smooth error of a campaign over place", f"{told['smooth_error_of_a_campaign']:.2g} {unit}"),
        ("own change of each place's rate, at the deepest wear", f"{100.0 * told['bend_deviation']:.2g} %"),
        ("scatter between places exposed alike", f"{100.0 * told['place_to_place_scatter']:.2g} %"),
        ("new thickness about what is told", f"{told['initial_reading_deviation']:.2g} {unit}"),
    ]


def _folder(source: str) -> str:
    """The name of the folder that a survey lies in; of a case, where it lies in that one's `measured`"""
    folder = Path(source).resolve().parent
    return (folder.parent.name if folder.name == "measured" else folder.name).replace("_", " ")
