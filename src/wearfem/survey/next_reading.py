"""The one reading that would tell most: by how much it is expected to narrow what is known.

Between two explanations that predict d1 and d2 with variances v1 and v2, a reading with gauge error s tells on average about

    1/2 ln(1 + (d1 - d2)^2 / (s^2 + v1 + v2))   [nats];

for one explanation, 1/2 ln(1 + v/s^2), v the variance of its prediction.

**Source** Lindley, Ann. Math. Statist. 27 (1956) 986-1005: expected information of an experiment; normal approximation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wearfem.survey.candidates import curves
from wearfem.survey.history import History, depths
from wearfem.survey.identify import Fit, fit, model_at

AHEAD = (0.5, 1.0, 2.0)  # intervals between occasions, after the last
SCALED = (0.5, 2.0)  # a new point that is exposed so many times the median


@dataclass(frozen=True)
class Suggestion:
    """A reading to take: in words, with what it is expected to tell."""

    sentence: str
    information: float  # [nats]


def suggestion(best: Fit, others: Sequence[Fit], played_by: Sequence[Sequence[str]]) -> Suggestion | None:
    """The reading that tells most between the best model and its nearest rival, or about the parameters of the best."""
    if not best.suspects:
        return None
    rival = others[0] if others else None
    if rival is None and any("date" in names for names in played_by):
        rival = fit(
            best.readings,
            [c for c in curves(best.readings.past, best.readings.depth_knots) if c.quantity == "date"][:1],
        )
    data = best.readings
    survey = data.survey
    last = float(data.past.end.max())
    gaps = np.diff(np.unique(np.append(0.0, data.past.end)))
    step = float(np.median(gaps)) if len(gaps) else last
    found: list[tuple[float, str]] = []
    unit = survey.progress_unit or survey.progress_name
    for ahead in (0.0, *AHEAD):
        past = _longer(data.past, ahead * step)
        when = last + ahead * step
        for factor in (1.0, *SCALED):
            if (factor == 1.0 and ahead == 0.0) or (factor != 1.0 and rival is None):
                continue
            seen = past if factor == 1.0 else _exposed(past, factor)
            told = _information(best, rival, seen)
            life = int(np.argmax(told))
            name = survey.point_names[survey.life_point[life]]
            if factor == 1.0:
                words = f"read point {name} at {when:.4g} {unit}"
            else:
                words = f"read a new point that is exposed {factor:g} times the median, at {when:.4g} {unit}"
            found.append((float(told[life]), words))
    information, words = max(found)
    against = (
        f", where it parts from {rival.name}" if rival is not None else ", which narrows its parameters most"
    )
    return Suggestion(f"{words}{against}: expected information {information:.2g} nats", information)


def _longer(past: History, more: float) -> History:
    """One interval after the last, like it"""
    end = past.end[:, -1:]

    def again(value: np.ndarray) -> np.ndarray:
        return np.concatenate([value, value[:, -1:]], axis=1)

    calendar = None
    if past.calendar is not None:
        total = past.calendar.sum(axis=1, keepdims=True) / (end - past.start[:, None])
        calendar = np.concatenate([past.calendar, total * more], axis=1)
    return replace(
        past, begin=np.concatenate([past.begin, end], axis=1), end=np.concatenate([past.end, end + more], axis=1),
        exposure=again(past.exposure), others=np.array([again(o) for o in past.others]).reshape(-1, *end.shape[:1], past.end.shape[1] + 1),
        feature={n: again(v) for n, v in past.feature.items()}, calendar=calendar,
        occasion=again(past.occasion),
    )  # fmt: skip


def _exposed(past: History, factor: float) -> History:
    """Every point exposed as many times the median of all"""
    alike = [np.full_like(e, factor * float(np.median(e))) for e in (past.exposure, *past.others)]
    return replace(
        past, exposure=alike[0], others=np.array(alike[1:]).reshape(past.others.shape), course=None
    )


def _information(best: Fit, rival: Fit | None, past: History) -> np.ndarray:
    """[nats] of one reading at the end of each life (l,)"""
    own, variance = _predicted(best, past)
    noise = best.spread.gauge**2
    if rival is None:
        return 0.5 * np.log1p(variance / noise)
    other, uncertain = _predicted(rival, past)
    return 0.5 * np.log1p((own - other) ** 2 / (noise + variance + uncertain))


def _predicted(fitted: Fit, past: History) -> tuple[np.ndarray, np.ndarray]:
    """Wear (l,) at the end of each life and its variance from the parameters"""

    def final(coordinate: np.ndarray) -> np.ndarray:
        return depths(past, model_at(fitted.readings, fitted.suspects, coordinate))[:, -1]

    wear = final(fitted.coordinate)
    slope = []
    for i in range(len(fitted.coordinate)):
        step = np.zeros(len(fitted.coordinate))
        step[i] = 1e-3 if fitted.deviation[i, i] > 0.0 else 0.0
        slope.append((final(fitted.coordinate + step) - wear) / 1e-3)
    jacobian = np.stack(slope, axis=1)
    return wear, np.einsum("li,ij,lj->l", jacobian, fitted.deviation, jacobian)
