"""Readings that do not go with their neighbours, whatever the model: found before anything is fitted."""

from dataclasses import dataclass

import numpy as np

from wearfem.survey.survey import Survey

FAR = 6.0  # robust standard deviations: 1e-9 of normal readings lie beyond
LEAST = 12  # readings with neighbours, below which no scale can be told


@dataclass(frozen=True)
class Doubt:
    """A reading that was left out, and why."""

    row: int
    point: str
    occasion: str
    reading: float
    expected: float
    why: str


def doubted(survey: Survey) -> tuple[Doubt, ...]:
    """Readings further than 6 robust standard deviations from what the readings before and after let expect.

    The line between the neighbours in progress of the same plate is laid, the median of the occasion is taken off (a zero error is no
    outlier), and the scale is 1.4826 times the median of distances. The worst of each plate is taken out and the rest looked at anew. No
    model of wear enters, so no effect is thrown away as an outlier.
    """
    live = np.ones(survey.size, bool)
    found: list[Doubt] = []
    for _ in range(3):
        apart, spread = _apart(survey, live)
        usable = np.isfinite(apart) & live
        if usable.sum() < LEAST:
            break
        scaled = apart / spread
        scaled[usable] -= _medians(scaled[usable], survey.occasion[usable])
        width = 1.4826 * float(np.median(np.abs(scaled[usable])))
        told = 0.5 * float(np.nanmedian(survey.sigma)) if np.isfinite(survey.sigma).any() else 0.0
        width = max(width, told, 1e-12 * float(np.abs(survey.reading).max()))
        taken = False
        for life in np.unique(survey.life):
            rows = np.flatnonzero(usable & (survey.life == life))
            if not len(rows):
                continue
            row = rows[np.argmax(np.abs(scaled[rows]))]
            if abs(scaled[row]) > FAR * width and _alone(survey, live, int(row), scaled):
                live[row] = False
                taken = True
                found.append(_doubt(survey, int(row), float(apart[row]), abs(scaled[row]) / width))
        if not taken:
            break
    return tuple(found)


def _alone(survey: Survey, live: np.ndarray, row: int, scaled: np.ndarray) -> bool:
    """Whether the readings before and after lie off to the other side: one wrong reading bends the line twice, a kink once."""
    rows = np.flatnonzero(live & (survey.life == survey.life[row]))
    rows = rows[np.argsort(survey.progress[rows], kind="stable")]
    place = int(np.flatnonzero(rows == row)[0])
    beside = [scaled[r] for r in rows[[place - 1, place + 1]] if np.isfinite(scaled[r])]
    return bool(beside) and all(-b * np.sign(scaled[row]) > 0.2 * abs(scaled[row]) for b in beside)


def _doubt(survey: Survey, row: int, apart: float, times: float) -> Doubt:
    expected = survey.reading[row] - apart
    side = "above" if apart > 0.0 else "below"
    return Doubt(
        row, survey.point_names[survey.point[row]], survey.occasion_names[survey.occasion[row]],
        float(survey.reading[row]), float(expected),
        f"{abs(apart) / survey.measured_factor:.3g} {survey.measured_unit} {side} the line between its neighbours, {times:.0f} standard "
        "deviations of such distances",
    )  # fmt: skip


def _apart(survey: Survey, live: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance of each reading from the line through its neighbours, and its standard deviation over that of a reading."""
    apart = np.full(survey.size, np.nan)
    spread = np.ones(survey.size)
    for life in np.unique(survey.life):
        rows = np.flatnonzero(live & (survey.life == life))
        rows = rows[np.argsort(survey.progress[rows], kind="stable")]
        for before, row, after in zip(rows, rows[1:], rows[2:], strict=False):
            span = survey.progress[after] - survey.progress[before]
            part = (survey.progress[row] - survey.progress[before]) / span if span > 0.0 else 0.5
            line = (1.0 - part) * survey.reading[before] + part * survey.reading[after]
            apart[row] = survey.reading[row] - line
            spread[row] = np.sqrt(1.0 + part**2 + (1.0 - part) ** 2)
    return apart, spread


def _medians(value: np.ndarray, group: np.ndarray) -> np.ndarray:
    """The median of its group, for each value; groups of fewer than four have none."""
    middle = np.zeros(len(value))
    for name in np.unique(group):
        inside = group == name
        if inside.sum() > 3:
            middle[inside] = np.median(value[inside])
    return middle
