"""Which effects the readings ask for: suspects tried alone and together, each new one against all that speaks for chance.

Half of the belief lies on the model as it is; the other half is shared by all suspects, so trying many does not find one by chance. An
effect is taken when the readings make it 19 times more probable than doing without (posterior probability 0.95).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wearfem.survey.candidates import Candidate, candidates, curves
from wearfem.survey.history import depths
from wearfem.survey.identify import Fit, Readings, fit, model_at, plain_fit
from wearfem.survey.nuisance import Spread, covariance
from wearfem.survey.residual import noise_tests

SURE = float(np.log(19.0))  # nats: odds of 0.95
SUSPECTED = float(np.log(3.0))  # nats: odds of 0.75, from which an effect is told with the doubt
ALIKE = 3.0  # nats: odds of 20 to 1, below which two models are not told apart
MOST_EFFECTS = 3
FINER = (9, 13)  # knots of a free curve that has been chosen
QUIET = 0.5  # p of all tests of noise together, above which no further effect is looked for
EVEN_SCATTER = 0.10  # [-] places that differ by more are not explained by chance
EVEN_BEND = 0.03  # [-] rates that change with depth by more, each place in its own way, are no chance either
EVEN_BOOK = 0.05  # [-] intervals that differ by more are no error of the tonnage book
EVEN_SCALE = 0.03  # [-] nor campaigns one of the gauge
MIMIC_KNOTS = 8
MIMIC_SQUARE = 9.0  # squared distance in standard deviations (3 of them), below which one model plays another


@dataclass(frozen=True)
class Choice:
    """The model that was chosen and what it was chosen from.

    Parameters
    ----------
    plain
        The coefficient alone.
    best
        The chosen model; `plain` where no effect is needed.
    tried
        Every fit that was made, of all models.
    odds
        [nats] prior log odds of each suspect against none.
    played_by
        For each effect of `best`, quantities whose free function would give these readings too.
    unsure
        Whether nuisances explain the readings nearly as well as the effect: more probable than not (3 to 1 where the nuisances are
        those of careful work), and not sure.
    """

    plain: Fit
    best: Fit
    tried: tuple[Fit, ...]
    odds: float
    played_by: tuple[tuple[str, ...], ...]
    unsure: bool = False

    def belief(self, fitted: Fit) -> float:
        """Evidence with prior odds [nats]"""
        return fitted.log_evidence + self.odds * len(fitted.suspects)

    def probability(self, name: str) -> float:
        """Posterior probability that an effect is in the model, over all models that were tried"""
        belief = np.array([self.belief(f) for f in self.tried])
        weight = np.exp(belief - belief.max())
        holds = np.array([name in [s.name for s in f.suspects] for f in self.tried])
        return float(weight[holds].sum() / weight.sum())

    def instead_of(self, place: int) -> list[Fit]:
        """Models as probable as the best within 20 to 1, with another effect in one place; the best first"""
        rest = {s.name for i, s in enumerate(self.best.suspects) if i != place}
        others = [
            f for f in self.tried
            if len(f.suspects) == len(self.best.suspects)
            and rest < {s.name for s in f.suspects}
            and f.name != self.best.name
            and self.best.log_evidence - f.log_evidence < ALIKE
        ]  # fmt: skip
        return sorted(others, key=lambda f: -f.log_evidence)


def choose(data: Readings) -> Choice:
    """Effects one by one, each the most probable of all; after each, those before are tried against the others again."""
    suspects = [*candidates(data.past, data.deepest), *curves(data.past, data.depth_knots)]
    odds = -float(np.log(len(suspects)))
    plain = plain_fit(data)
    data = plain.readings
    tried: dict[frozenset[str], Fit] = {frozenset(): plain}

    def tested(base: Fit, more: Sequence[Candidate]) -> Fit:
        """The best of a model with one more effect"""
        have = {s.name for s in base.suspects}
        curved = {s.quantity for s in base.suspects}
        for suspect in more:
            key = frozenset(have | {suspect.name})
            doubled = suspect.name.startswith("FactorCurve") and suspect.quantity in curved
            if suspect.name in have or key in tried or doubled:
                continue
            tried[key] = fit(data, [*base.suspects, suspect], base)
        return max((f for key, f in tried.items() if have < key and len(key) == len(have) + 1), key=_evidence)

    best = plain
    while len(best.suspects) < MOST_EFFECTS:
        if best.suspects and noise_tests(best)[0].p > QUIET:
            break
        found = tested(best, suspects)
        if found.log_evidence - best.log_evidence + odds < SURE:
            break
        best = _refined(data, found, tried)
        while len(best.suspects) > 1:  # was the first the right one, now that there is a second?
            before = best
            for suspect in best.suspects:
                rest = tuple(s for s in best.suspects if s is not suspect)
                key = frozenset(s.name for s in rest)
                base = tried[key] if key in tried else tried.setdefault(key, fit(data, rest))
                again = tested(base, suspects)
                best = max(best, again, key=_evidence)
            if best is before:
                break
    fewer = [f for f in tried.values() if len(f.suspects) < len(best.suspects)]
    best = max([best, *(f for f in fewer if f.log_evidence - odds > best.log_evidence)], key=_evidence)
    unsure = False
    if not best.suspects:
        single = max((f for f in tried.values() if len(f.suspects) == 1), key=_evidence)
        needed = 0.0 if uneven(plain.spread) else SUSPECTED
        unsure = single.log_evidence - plain.log_evidence + odds > needed
        best = single if unsure else best
    played = tuple(players(best, i) for i in range(len(best.suspects)))
    return Choice(plain, best, tuple(tried.values()), odds, played, unsure)


def uneven(spread: Spread) -> bool:
    """Whether places, campaigns or intervals differ by more than careful work lets them"""
    places = max(spread.scatter, spread.smooth)
    return (
        places > EVEN_SCATTER
        or spread.bend > EVEN_BEND
        or spread.book > EVEN_BOOK
        or spread.scale > EVEN_SCALE
    )


def _evidence(fitted: Fit) -> float:
    return fitted.log_evidence


def _refined(data: Readings, found: Fit, tried: dict[frozenset[str], Fit]) -> Fit:
    """A free curve with more knots, where the readings pay for them"""
    last = found.suspects[-1]
    if not last.free[0].name.startswith("ratio_at_"):
        return found
    base = found.suspects[:-1]
    start = tried.get(frozenset(s.name for s in base))
    for knots in FINER:
        for finer in [
            *candidates(data.past, data.deepest, knots),
            *curves(data.past, data.depth_knots, knots),
        ]:
            if finer.name == last.name and len(finer.free) > len(found.suspects[-1].free):
                again = fit(data, [*base, finer], start)
                if again.log_evidence > found.log_evidence:
                    found = again
    tried[frozenset(s.name for s in found.suspects)] = found
    return found


def players(best: Fit, place: int) -> tuple[str, ...]:
    """Quantities whose free function would give the same readings as an effect does.

    The model's own wear, without noise, is fitted with the effect taken out and put back as a free function of depth, or of the date (a
    factor for each interval, the same everywhere). If that comes closer than 3 standard deviations, these readings cannot tell which
    of the quantities carries the effect, however well a formula happens to fit.
    """
    suspect = best.suspects[place]
    r = best.readings
    exact = r.past.of_rows(best.depth)
    root = covariance(best.disturbance, _steady(best)).root()
    others = [s for i, s in enumerate(best.suspects) if i != place]
    if suspect.quantity == "depth":
        left = _by_interval(best, exact, root)
        return ("date",) if left < MIMIC_SQUARE else ()
    if suspect.quantity in _dated(best):
        left = _by_depth(best, others, exact, root)
        return ("depth",) if left < MIMIC_SQUARE else ()
    return ()


def _steady(best: Fit) -> Spread:
    """The gauge and the zero error only: what nuisances could swallow is not what physics explains"""
    return replace(best.spread, scatter=1e-4, book=1e-4, scale=1e-4, smooth=1e-4, shift=1e-5, bend=1e-4)


def _dated(best: Fit) -> set[str]:
    """Quantities that are the same at all places: they change with the date only"""
    past = best.readings.past
    same = {"date"}
    for name, value in past.feature.items():
        if name == "position" or value.ndim != 2:
            continue
        if (
            all(np.ptp(value[past.occasion == j]) == 0.0 for j in np.unique(past.occasion))
            and np.ptp(value) > 0.0
        ):
            same.add(name)
    return same


def _by_interval(best: Fit, exact: np.ndarray, root: np.ndarray) -> float:
    """Squared distance to the best model with a free factor for each interval in place of the effect"""
    r = best.readings
    model = model_at(r, best.suspects, best.coordinate)
    kept = [e for e in model.effects if "depth" not in e.needs]
    grown = np.diff(depths(r.past, replace(model, effects=tuple(kept), additions=())), axis=1, prepend=0.0)
    passed = np.arange(grown.shape[1])[None, :] <= r.past.row_interval[:, None]
    growth = grown[r.past.row_life] * passed
    column = np.zeros((len(exact), int(r.past.occasion.max()) + 1))
    for j in range(grown.shape[1]):
        np.add.at(column, (np.arange(len(exact)), r.past.occasion[r.past.row_life, j]), growth[:, j])
    left = root @ exact
    basis = root @ column
    solution = np.linalg.lstsq(basis, left, rcond=1e-9)[0]
    return float(np.sum((left - basis @ solution) ** 2))


def _by_depth(best: Fit, others: Sequence[Candidate], exact: np.ndarray, root: np.ndarray) -> float:
    """Squared distance to the best model with a free factor over depth in place of the effect"""
    r = best.readings
    curve = next(c for c in curves(r.past, r.depth_knots, MIMIC_KNOTS) if c.name == "FactorCurve(depth)")
    noiseless = replace(r, worn=exact)
    again = fit(noiseless, [*others, curve])
    return float(np.sum((root @ (exact - r.past.of_rows(again.depth))) ** 2))
