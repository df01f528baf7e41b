"""Fit a model to a survey: wear integrated along each plate's life, nuisances integrated out, and how probable the model is.

For a model the most probable parameters are found by nonlinear least squares on whitened readings (MINPACK), in turn with the standard
deviations of the nuisances. Its evidence is Laplace's: the density at the best parameters times the volume of their posterior over that
of their prior. So a parameter costs what the data had to fix, and a shape that is found by looking everywhere pays for the looking.

**Source** MacKay, Neural Computation 4 (1992) 415-447, equation 2.6 (Occam factor).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares, nnls
from scipy.special import logsumexp

from wearfem.errors import UserError
from wearfem.survey.candidates import Candidate
from wearfem.survey.history import FEWEST_PLACES, History, Model, depths, history
from wearfem.survey.nuisance import (
    Disturbance,
    Spread,
    covariance,
    disturbance,
    fit_spread,
    log_likelihood,
    log_prior,
    nuisances,
)
from wearfem.survey.survey import Survey
from wearfem.wear.effects import Corrosion

ROUNDS = 3  # of parameters and standard deviations in turn
KEPT = 2  # starts that are followed to their end
SEARCHED = 4  # starts that are searched; more are screened first
ENOUGH = 6  # lines that tell the scatter of readings
LEAST_SHARE = 1e-3  # of probability: entries of a list that are less probable are left out of a mean
COEFFICIENT_PRIOR = 1.5  # standard deviation of the logarithm of the coefficient about its first guess


@dataclass(frozen=True)
class Readings:
    """A survey made ready: wear (n,) [SI] that each reading tells, its history, and the size of things.

    Parameters
    ----------
    survey, past
        The survey without doubted readings, and the intervals of service.
    worn
        (n,) wear read: a depth as it is, a thickness taken off the new thickness.
    gauge
        Standard error of a reading, as given; None where it is not.
    reference
        [SI] what counts as a small error: the gauge's, given or guessed from the scatter about smooth lines.
    reference_known
        Whether that is given, or guessed from enough lines.
    thickness_free
        Whether the new thickness is known from readings only.
    offset
        (n,) [SI] by which the plate, when new, was read above the mean of all plates; 0 where the new thickness was told. A single
        reading errs by the gauge, and `worn` with it; so plates are taken to be alike as far as their readings allow.
    coefficient
        First guess of the coefficient.
    ratio
        (e - 1,) first guess of the coefficients of other mechanisms over it.
    """

    survey: Survey
    past: History
    worn: np.ndarray
    gauge: float | None
    reference: float
    reference_known: bool
    thickness_free: bool
    offset: np.ndarray
    coefficient: float
    ratio: tuple[float, ...] = ()

    @property
    def coefficients(self) -> int:
        """How many there are: one for each mechanism; the first coordinates of any fit"""
        return 1 + len(self.ratio)

    @property
    def deepest(self) -> float:
        """Largest wear read"""
        return float(self.worn.max())

    @property
    def depth_knots(self) -> np.ndarray:
        """Depths at which wear was read, for a curve over depth to bend where there are readings"""
        return np.append(0.0, self.worn[self.worn > 0.0])

    def left(self, depth: np.ndarray) -> np.ndarray:
        """What of the readings (n,) is left to nuisances, where a model says that depth (l, m) is worn."""
        return self.worn - self.offset - self.past.of_rows(depth)

    def only(self, keep: np.ndarray) -> "Readings":
        """The readings (n,) of `keep`; history and sizes stay those of the whole."""
        past = replace(
            self.past, row_life=self.past.row_life[keep], row_interval=self.past.row_interval[keep]
        )
        return replace(
            self, survey=self.survey.only(keep), past=past, worn=self.worn[keep], offset=self.offset[keep]
        )


def readings(survey: Survey) -> Readings:
    """Wear from readings, with the first guesses that a search needs."""
    past = history(survey)
    worn, free, offset = _worn(survey)
    if not worn.max(initial=0.0) > 0.0:
        raise UserError(
            f"{survey.source} shows no wear: no reading is beyond that of a new plate; check {survey.measured_name}"
        )
    gauge = float(np.nanmedian(survey.sigma)) if np.isfinite(survey.sigma).any() else None
    steady = past.of_rows(depths(past, Model(1.0)))
    used = steady > 0.0
    guess = float(np.median(worn[used]) / np.median(steady[used])) if used.any() else 1.0
    coefficient = guess if guess > 0.0 else float(np.abs(worn).max() / steady.max())
    ratio: tuple[float, ...] = ()
    if len(past.others):
        coefficient, *rest = _several(past, worn)
        ratio = tuple(r / coefficient for r in rest)
    rough, enough = _roughness(survey, worn)
    known = gauge is not None or enough
    return Readings(survey, past, worn, gauge, gauge or rough, known, free, offset, coefficient, ratio)


def _several(past: History, worn: np.ndarray) -> np.ndarray:
    """(e,) coefficients of mechanisms side by side: least squares, none below a hundredth of what it would be alone"""
    alone = [past.exposure, *past.others]
    steady = np.stack([past.of_rows(np.cumsum(e * (past.end - past.begin), axis=1)) for e in alone], axis=1)
    each = (steady.T @ np.abs(worn)) / np.maximum((steady**2).sum(axis=0), 1e-300)
    return np.maximum(nnls(steady, worn)[0], 1e-2 * each)


def _worn(survey: Survey) -> tuple[np.ndarray, bool, np.ndarray]:
    """Wear (n,) that each reading tells, whether the new thickness comes from readings, and that of the plate over the mean (n,)"""
    nothing = np.zeros(survey.size)
    if survey.sign > 0.0:
        return survey.reading, False, nothing
    if np.isfinite(survey.initial).all():
        return survey.initial - survey.reading, False, nothing
    new = np.full(len(survey.life_point), np.nan)
    for life in range(len(new)):
        fresh = (survey.life == life) & survey.is_new
        if fresh.any():
            new[life] = survey.reading[fresh].mean()
    if np.isnan(new).any():
        new[np.isnan(new)] = np.nanmedian(new) if np.isfinite(new).any() else survey.reading.max()
    return new[survey.life] - survey.reading, True, (new - new.mean())[survey.life]


def _roughness(survey: Survey, worn: np.ndarray) -> tuple[float, bool]:
    """A guess of the gauge's error, scatter about lines through neighbours in progress; and whether there are enough of them"""
    apart = []
    for life in np.unique(survey.life):
        rows = np.flatnonzero(survey.life == life)
        rows = rows[np.argsort(survey.progress[rows], kind="stable")]
        t, d = survey.progress[rows], worn[rows]
        span = np.where(t[2:] > t[:-2], t[2:] - t[:-2], 1.0)
        part = (t[1:-1] - t[:-2]) / span
        line = (1.0 - part) * d[:-2] + part * d[2:]
        apart.extend((d[1:-1] - line) / np.sqrt(1.0 + part**2 + (1.0 - part) ** 2))
    enough = len(apart) >= ENOUGH
    size = 1.4826 * float(np.median(np.abs(apart))) if enough else 0.0
    return max(size, (1e-3 if enough else 1e-2) * float(np.abs(worn).max())), enough


@dataclass(frozen=True)
class Fit:
    """A model fitted to readings.

    Parameters
    ----------
    suspects
        The candidates in it; none for the coefficient alone.
    coordinate
        (e + d,) logarithm of the coefficient over its first guess, in prior widths, and of the ratios of other mechanisms; then those
        of the candidates.
    deviation
        (e + d, e + d) posterior covariance of the coordinates.
    spread
        Standard deviations of the nuisances.
    log_evidence
        [nats] with the penalties of the candidates taken off.
    readings
        What it was fitted to.
    depth
        (l, m) wear at the ends of intervals.
    expected, undecided
        (l, m) the same, as a mean over what was looked for on a list (which points a patch covers), by its probability; and the standard
        deviation over that list.
    """

    suspects: tuple[Candidate, ...]
    coordinate: np.ndarray
    deviation: np.ndarray
    spread: Spread
    log_evidence: float
    readings: Readings
    depth: np.ndarray
    expected: np.ndarray
    undecided: np.ndarray

    @property
    def name(self) -> str:
        """Names of the suspects, joined by a plus"""
        return " + ".join(suspect.name for suspect in self.suspects) or "coefficient alone"

    @property
    def model(self) -> Model:
        """The model at the most probable parameters"""
        return model_at(self.readings, self.suspects, self.coordinate)

    @property
    def disturbance(self) -> Disturbance:
        """Columns of the nuisances"""
        r = self.readings
        return disturbance(r.survey, r.past, self.depth, r.reference, r.thickness_free)

    def predict(self, asked: Readings) -> np.ndarray:
        """Wear (n,) that other readings of the survey should show: the model, and nuisances as far as the fitted ones tell them."""
        fitted = self.readings
        residual = fitted.left(self.expected)
        known = disturbance(
            fitted.survey, fitted.past, self.expected, fitted.reference, fitted.thickness_free
        )
        value, _ = nuisances(known, self.spread, residual)
        there = disturbance(asked.survey, asked.past, self.expected, asked.reference, asked.thickness_free)
        told = {(int(g), int(k)): v for g, k, v in zip(known.group, known.label, value, strict=True)}
        new = np.array(
            [told.get((int(g), int(k)), 0.0) for g, k in zip(there.group, there.label, strict=True)]
        )
        return asked.past.of_rows(self.expected) + asked.offset + there.column @ new

    def doubt(self, asked: Readings) -> np.ndarray:
        """Standard deviation (n,) [SI] of what the model predicts of other readings, from its parameters and from lists alone.

        Linear in the parameters, about the most probable ones.
        """
        slopes = np.zeros((asked.survey.size, len(self.coordinate)))
        for i in np.flatnonzero(np.diag(self.deviation) > 0.0):
            step = np.zeros(len(self.coordinate))
            step[i] = 1e-2
            ends = [
                asked.past.of_rows(
                    depths(asked.past, model_at(self.readings, self.suspects, self.coordinate + side * step))
                )
                for side in (-1.0, 1.0)
            ]
            slopes[:, i] = (ends[1] - ends[0]) / 2e-2
        variance = np.einsum("ni,ij,nj->n", slopes, self.deviation, slopes)
        return np.sqrt(variance + asked.past.of_rows(self.undecided) ** 2)


def model_at(data: Readings, suspects: Sequence[Candidate], coordinate: np.ndarray) -> Model:
    """The model at a coordinate."""
    first = data.coefficients
    k = data.coefficient * float(np.exp(COEFFICIENT_PRIOR * coordinate[0]))
    ratio = tuple(
        r * float(np.exp(COEFFICIENT_PRIOR * u)) for r, u in zip(data.ratio, coordinate[1:first], strict=True)
    )
    built = []
    for suspect in suspects:
        built.append(suspect.effect(coordinate[first : first + len(suspect.free)]))
        first += len(suspect.free)
    factors = tuple(effect for effect in built if not isinstance(effect, Corrosion))
    return Model(k, factors, tuple(effect for effect in built if isinstance(effect, Corrosion)), ratio)


def small_spread(data: Readings) -> Spread:
    """Nuisances as a careful campaign has them; where a search begins."""
    half = 0.5 * data.reference
    initial = max(half, float(data.offset.std()))
    return Spread(data.reference, half, initial, 0.02, 0.01, 0.01, 0.01, half, 0.005, 0.02)


def fit(data: Readings, suspects: Sequence[Candidate] = (), start: Fit | None = None) -> Fit:
    """The most probable parameters of a model, its nuisances and its evidence.

    Parameters
    ----------
    data
        The readings.
    suspects
        Effects in the model, beside the coefficient.
    start
        A fit of the first of these suspects, to begin from.
    """
    suspects = tuple(suspects)
    problem = _Problem(data, suspects)
    spread = start.spread if start is not None and not suspects else small_spread(data)
    root = problem.root(problem.first(start), spread)
    known = 0 if start is None else len(start.coordinate)
    begins = problem.screened(problem.starts(start), root)
    tried = sorted(
        (problem.search(begin, root, most=12 + 4 * known) for begin in begins), key=lambda found: found[1]
    )
    return max(
        (_settle(problem, begin, spread) for begin, _ in tried[:KEPT]), key=lambda found: found.log_evidence
    )


def plain_fit(data: Readings) -> Fit:
    """The coefficient alone, with the nuisances that it needs; its `readings` say which.

    Whether the rate of each place changes by its own shape, and whether a campaign's errors are smooth over place: each is in the model of
    all suspects if it makes the coefficient alone more probable.
    """
    best, past = fit(data), data.past
    if len(past.begin) < FEWEST_PLACES:
        return best
    for more in ({"bent": data.deepest}, {"warped": past.smooth} if past.smooth.shape[1] else {}):
        if more:
            richer = fit(replace(data, past=replace(best.readings.past, **more)))
            best = max(best, richer, key=lambda fitted: fitted.log_evidence)
    return best


def _settle(problem: "_Problem", coordinate: np.ndarray, spread: Spread) -> Fit:
    """Parameters and standard deviations in turn, until they agree; then the evidence"""
    data = problem.data
    for _ in range(ROUNDS):
        before = spread
        depth = problem.depth(coordinate)
        found = disturbance(data.survey, data.past, depth, data.reference, data.thickness_free)
        spread = fit_spread(found, data.left(depth), spread, data.gauge, data.reference)
        coordinate, _ = problem.search(coordinate, problem.root(coordinate, spread), most=60)
        if np.allclose(
            [*before.__dict__.values()], [*spread.__dict__.values()], rtol=0.03, atol=1e-2 * data.reference
        ):
            break
    depth = problem.depth(coordinate)
    found = disturbance(data.survey, data.past, depth, data.reference, data.thickness_free)
    residual = data.left(depth)
    jacobian = problem.jacobian(coordinate, problem.root(coordinate, spread))
    moving = problem.moving
    precision = jacobian.T @ jacobian + np.eye(len(moving))
    deviation = np.zeros((len(coordinate), len(coordinate)))
    deviation[np.ix_(moving, moving)] = np.linalg.inv(precision)
    expected, undecided, listed = problem.over_lists(coordinate, spread, depth)
    evidence = (
        log_likelihood(found, spread, residual)
        + log_prior(spread, data.gauge, data.reference)
        - 0.5 * float(coordinate[moving] @ coordinate[moving])
        - 0.5 * float(np.linalg.slogdet(precision)[1])
        - sum(suspect.penalty for suspect in problem.suspects)
        + listed
    )
    return Fit(problem.suspects, coordinate, deviation, spread, evidence, data, depth, expected, undecided)


class _Problem:
    """Least squares of one model on one set of readings."""

    def __init__(self, data: Readings, suspects: tuple[Candidate, ...]) -> None:
        self.data, self.suspects = data, suspects
        size = data.coefficients + sum(len(suspect.free) for suspect in suspects)
        still = [place for place, _ in self.lists]
        self.moving = np.array([i for i in range(size) if i not in still])

    def depth(self, coordinate: np.ndarray) -> np.ndarray:
        return depths(self.data.past, model_at(self.data, self.suspects, coordinate))

    def over_lists(
        self, coordinate: np.ndarray, spread: Spread, depth: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """What is looked for on lists, at the other coordinates: the mean depth (l, m) by the probability of the entries, its standard
        deviation (l, m), and the logarithm of the evidence of all entries, each times its prior probability, over that of the one here."""
        lists = self.lists
        root = self.root(coordinate, spread) if lists else np.zeros((0, 0))
        mean, variance, total = depth, np.zeros_like(depth), 0.0
        for place, suspect in lists:
            others = np.tile(coordinate, (len(suspect.share), 1))
            others[:, place] = np.arange(len(others))
            half = 0.5 * self.squares(others, root)
            belief = np.log(suspect.share) - half
            sum_of_all = float(logsumexp(belief))
            total += sum_of_all + float(half[round(coordinate[place])])
            weight = np.exp(belief - sum_of_all)
            likely = weight > LEAST_SHARE
            told = np.array([self.depth(other) for other in others[likely]])
            middle = np.tensordot(weight[likely] / weight[likely].sum(), told, 1)
            variance = variance + np.tensordot(weight[likely], (told - middle) ** 2, 1)
            mean = mean + middle - depth
        return mean, np.sqrt(variance), total

    @property
    def lists(self) -> list[tuple[int, Candidate]]:
        """Suspects that are looked for on a list, with the coordinate that numbers its entries"""
        ends = self.data.coefficients + np.cumsum([len(suspect.free) for suspect in self.suspects], dtype=int)
        return [(int(end) - 1, s) for end, s in zip(ends, self.suspects, strict=True) if s.frozen]

    def changes(self, coordinates: np.ndarray, root: np.ndarray) -> Iterator[tuple[np.ndarray, ...]]:
        """Whitened residuals of many coordinates (s, d), as b + E c: those of the same b and E together.

        Yields rows (r,) of `coordinates`, b (n,), E (n, l), c (r, l). Where entries of a list cover plates, b is the residual where none
        is covered, E what covering each plate adds, and c which are: no plate's wear depends on another's. Else E has no columns.
        """
        covering = [(place, suspect) for place, suspect in self.lists if len(suspect.covers)]
        if not covering:
            for row, own in enumerate(coordinates):
                yield np.array([row]), self.residual(own, root), np.zeros((len(root), 0)), np.zeros((1, 0))
            return
        place, suspect = covering[0]
        rest, which = np.unique(np.delete(coordinates, place, 1), axis=0, return_inverse=True)
        plate = np.equal.outer(self.data.past.row_life, np.arange(suspect.covers.shape[1]))
        for group, own in enumerate(rest):
            rows = np.flatnonzero(which.ravel() == group)
            ends = [self.depth(np.insert(own, place, len(suspect.share) + i)) for i in (0, 1)]
            everywhere, nowhere = map(self.data.left, ends)
            covered = suspect.covers[coordinates[rows, place].round().astype(int)].astype(float)
            yield rows, root @ nowhere, root @ ((everywhere - nowhere)[:, None] * plate), covered

    def squares(self, coordinates: np.ndarray, root: np.ndarray) -> np.ndarray:
        """(s,) sums of squares of the whitened residuals of many coordinates (s, d)"""
        found = np.empty(len(coordinates))
        for rows, base, change, covered in self.changes(coordinates, root):
            found[rows] = _square(base, change, covered)
        return found

    def first(self, start: Fit | None) -> np.ndarray:
        known = np.zeros(self.data.coefficients) if start is None else start.coordinate
        rest = [s.starts[0] for s in self.suspects[0 if start is None else len(start.suspects) :]]
        return np.concatenate([known, *rest])

    def starts(self, start: Fit | None) -> list[np.ndarray]:
        """Where searches begin: what is known, with each start of what is new"""
        begins = [np.zeros(self.data.coefficients) if start is None else start.coordinate]
        for suspect in self.suspects[0 if start is None else len(start.suspects) :]:
            begins = [np.concatenate([b, s]) for b in begins for s in suspect.starts]
        return begins

    def screened(self, begins: list[np.ndarray], root: np.ndarray) -> list[np.ndarray]:
        """The most promising of many starts: those whose effect, taken as linear, would remove most of what is left"""
        if len(begins) <= SEARCHED:
            return begins
        plain = _Problem(self.data, ())
        at = begins[0][: self.data.coefficients]
        own = plain.residual(at, root)
        steps = 1e-3 * np.eye(len(at))
        tangent = np.linalg.qr(np.stack([plain.residual(at + step, root) - own for step in steps], axis=1))[0]
        own = own - tangent @ (tangent.T @ own)
        gain = np.empty(len(begins))
        for rows, base, change, covered in self.changes(np.array(begins), root):
            base = base - own - tangent @ (tangent.T @ base)
            change = change - tangent @ (tangent.T @ change)
            along = own @ base + covered @ (own @ change)
            gain[rows] = along**2 / np.maximum(_square(base, change, covered), 1e-300)
        return [begins[i] for i in np.argsort(-gain, kind="stable")[:SEARCHED]]

    def root(self, coordinate: np.ndarray, spread: Spread) -> np.ndarray:
        data = self.data
        found = disturbance(
            data.survey, data.past, self.depth(coordinate), data.reference, data.thickness_free
        )
        return covariance(found, spread).root()

    def residual(self, coordinate: np.ndarray, root: np.ndarray) -> np.ndarray:
        return root @ self.data.left(self.depth(coordinate))

    def search(self, begin: np.ndarray, root: np.ndarray, most: int) -> tuple[np.ndarray, float]:
        """The best coordinate from a start, and half the sum of squares there"""
        moving = self.moving

        def leftover(part: np.ndarray) -> np.ndarray:
            full = begin.copy()
            full[moving] = part
            return np.concatenate([self.residual(full, root), part])

        found = least_squares(
            leftover, begin[moving], method="lm", diff_step=1e-4, max_nfev=most * (len(moving) + 1), xtol=1e-5, ftol=1e-6
        )  # fmt: skip
        best = begin.copy()
        best[moving] = found.x
        return best, float(found.cost)

    def jacobian(self, coordinate: np.ndarray, root: np.ndarray) -> np.ndarray:
        columns = []
        for i in self.moving:
            step = np.zeros(len(coordinate))
            step[i] = 1e-3
            columns.append(
                (self.residual(coordinate + step, root) - self.residual(coordinate - step, root)) / 2e-3
            )
        return np.stack(columns, axis=1)


def _square(base: np.ndarray, change: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """(r,) |b + E c|^2 for b (n,), E (n, l) and each c of (r, l)"""
    return (
        base @ base
        + 2.0 * covered @ (change.T @ base)
        + ((covered @ (change.T @ change)) * covered).sum(axis=1)
    )
