"""Closing the loop: what a survey asks for enters the case, the coupled run is repeated with it, and refitted until both agree.

A run is walked by its own course: depth and shape by service. What the readings say of the coefficient and the effects changes the pace
of that walk, and with it the shape that the flow meets. So the run is repeated with what was found, and the readings are fitted along the
new course, until no parameter moves by more than a part of its standard deviation. Readings held out are fitted in no round.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from wearfem.case import LifeCase, load_any_case
from wearfem.case_file import write_case
from wearfem.errors import UserError
from wearfem.exposure import PutIn, exposed_by_run
from wearfem.run import case_of_run, live_to_the_end
from wearfem.survey.candidates import Candidate, Suspect
from wearfem.survey.choose import SURE, Choice
from wearfem.survey.diagnose import Diagnosis, Effect, Score, diagnose, held_out
from wearfem.survey.forecast import posterior
from wearfem.survey.history import History, Model, depths
from wearfem.survey.identify import COEFFICIENT_PRIOR, Fit, Readings, fit, readings
from wearfem.survey.in_service import Service, in_service, service
from wearfem.survey.nuisance import SAMPLING, disturbance
from wearfem.survey.survey import Survey
from wearfem.wear.effect import Effect as CaseEffect
from wearfem.wear.metal import Metal

PART = 0.25  # of a standard deviation: a parameter that changes by less is the same
ROUNDS = 6  # coupled runs at most
ALIKE = 2.0  # standard deviations: runs that had parameters no further apart go through the same shapes, as far as can be told
DRAWS = 500  # from the posterior, whose mean is put into a run


@dataclass(frozen=True)
class Told:
    """What readings say along the course of a run: a factor on the wear law, and effects.

    Parameters
    ----------
    factor
        [-] coefficient over that of the case.
    effects
        In the units of the survey.
    place, deviation
        (1 + d,) the logarithm of the factor and the coordinates of the effects, and their standard deviations.
    fitted
        The fit behind it; None for the coefficient alone.
    """

    factor: float
    effects: tuple[Suspect, ...]
    place: np.ndarray
    deviation: np.ndarray
    fitted: Fit | None = None

    def change(self, before: "Told") -> float:
        """The largest change of a parameter [its standard deviations]"""
        free = self.deviation > 0.0
        return float(np.max(np.abs(self.place - before.place)[free] / self.deviation[free]))


@dataclass(frozen=True)
class Round:
    """One coupled run: with what, where it lies, and what the readings say along it.

    Parameters
    ----------
    case, run
        Folders.
    put_in
        What the run had.
    told
        What the readings held in say along its course.
    change
        [standard deviations] largest, from `put_in` to `told`.
    """

    case: Path
    run: Path
    put_in: Told
    told: Told
    change: float


@dataclass(frozen=True)
class Improvement:
    """A case with what the readings asked for, before and after.

    Parameters
    ----------
    plain
        The case as it was.
    diagnosis
        Along the run that was given.
    held
        (n,) readings that no round saw, of those that were not doubted.
    rounds
        Coupled runs with the coefficient and the effects; with the coefficient alone where none was found.
    as_given, coefficient_alone, improved
        Errors against the readings as they were read, no zero errors or the like taken off: of the run as it was given, of its course
        walked at another pace, which is what a run with another coefficient does, and of the last coupled run.
    no_better
        Whether the effects were found, but in the coupled run do not predict readings held out; then `rounds` are without them.
    own_sampling
        [measured unit] by how much the last run's depths at the readings held out err by its own sampling, root mean square: no model of
        it can be better than that and the gauge.
    again
        The diagnosis along the last run, where that was asked.
    """

    plain: LifeCase
    diagnosis: Diagnosis
    held: np.ndarray
    rounds: tuple[Round, ...]
    as_given: Score
    coefficient_alone: Score
    improved: Score
    no_better: bool
    own_sampling: float
    again: Diagnosis | None

    def write(self, folder: Path, story: str) -> Path:
        """Write the improved case: the last round's, without its stop at the last reading."""
        case = load_any_case(self.last.case)
        assert isinstance(case, LifeCase) and self.plain.folder is not None
        return write_case(
            folder, self.plain.folder, self.plain.settings, self.last.put_in.factor,
            case.effects[len(self.plain.effects) :], story,
        )  # fmt: skip

    @property
    def last(self) -> Round:
        """The coupled run that the improved case repeats"""
        return self.rounds[-1]

    @property
    def effects(self) -> tuple[Effect, ...]:
        """What the improved case has beside another coefficient"""
        fitted = self.last.put_in.fitted
        names = [] if fitted is None else [suspect.name for suspect in fitted.suspects]
        return tuple(effect for effect in self.diagnosis.effects if effect.name in names)

    @property
    def agreed(self) -> bool:
        """Whether run and readings came to agree within the rounds allowed"""
        return self.rounds[-1].change < PART


def improve(
    survey: Survey,
    run: Path,
    out: Path,
    *,
    found: Diagnosis | None = None,
    rounds: int = ROUNDS,
    diagnose_again: bool = True,
    quiet: bool = False,
    say: Callable[[str], None] = print,
) -> Improvement:
    """Diagnose a survey along a run, put into the case what it asks for, and repeat the coupled run until both agree.

    Parameters
    ----------
    survey
        As it was read, without exposure.
    run
        The folder of a life of the case, whose shape changed as it wore.
    out
        Folder for the cases and runs of all rounds; what is there is gone on with.
    found
        The diagnosis along that run, where it is at hand.
    rounds
        Coupled runs at most, for each set of effects.
    diagnose_again
        Ask along the last run whether what is left is noise.
    quiet
        Show no progress within a cycle.
    say
        Takes one line a round.

    Raises
    ------
    UserError
        for a run that is not of the case as it is now, that kept its shape, or whose service is not the survey's.
    """
    plain, _ = case_of_run(run)
    if plain.frozen:
        raise UserError(
            f"{run} kept the geometry as new, so what it lacks may be the change of shape; run the case with its geometry moving "
            "(frozen=false), and improve that"
        )
    unit = service(survey, plain.throughput_rate)
    given = exposed_by_run(survey, run)
    found = found or diagnose(given)
    keep = np.ones(survey.size, bool)
    keep[[doubt.row for doubt in found.doubts]] = False
    data = readings(given.only(keep))
    held = held_out(data)
    last = float((survey.progress - survey.life_start[survey.life]).max()) * unit.seconds
    train = keep.copy()
    train[np.flatnonzero(keep)[held]] = False
    loop = _Loop(survey, plain, given, data.past, keep, held, train, unit, last, out, rounds, quiet, say)

    coefficient = coefficient_alone(readings(given.only(train)), None)
    before = score(given.only(keep), held, 1, coefficient.factor)
    suspects = found.choice.best.suspects
    done = loop.one_by_one(found.choice) if suspects else loop.repeat("coefficient", coefficient_alone)
    no_better = bool(suspects) and (loop.score(done[-1]).heldout_rmse or 0.0) > 1.02 * (
        before.heldout_rmse or np.inf
    )
    if no_better:
        done = loop.repeat("coefficient", coefficient_alone)
    along, (improved, _) = exposed_by_run(survey, done[-1].run), case_of_run(done[-1].run)
    again = diagnose(along, name_without=False) if diagnose_again else None
    return Improvement(
        plain, found, held, done, score(given.only(keep), held, 0), before, loop.score(done[-1]), no_better,
        own_sampling(along.only(keep), held, improved.effects), again,
    )  # fmt: skip


Refit = Callable[[Readings, Told | None], Told]


def _refit(suspects: Sequence[Candidate]) -> Refit:
    return lambda data, before: with_suspects(data, suspects, before)


def needed(last: Round, odds: float) -> tuple[Candidate, ...]:
    """The effects of a run without the one that the readings along it ask for least, if they do not ask for it.

    Along the run that has them all, each must be as probable as a diagnosis asks.

    Parameters
    ----------
    last
        The run.
    odds
        [nats] prior log odds of each effect.
    """
    fitted = last.told.fitted
    assert fitted is not None  # there are effects in the run
    fewer = [tuple(s for s in fitted.suspects if s is not one) for one in fitted.suspects]
    best = max((fit(fitted.readings, rest) for rest in fewer), key=lambda found: found.log_evidence)
    return fitted.suspects if fitted.log_evidence - best.log_evidence + odds > SURE else best.suspects


@dataclass(frozen=True)
class _Loop:
    """What all rounds share."""

    survey: Survey
    plain: LifeCase
    given: Survey  # along the run that was given
    past: History
    keep: np.ndarray  # (n,) readings that are not doubted
    held: np.ndarray  # those of them that no round sees
    train: np.ndarray  # (n,) those that all rounds see
    unit: Service
    last: float  # [s] of service at the last reading
    out: Path
    rounds: int
    quiet: bool
    say: Callable[[str], None]

    def one_by_one(self, choice: Choice) -> tuple[Round, ...]:
        """Coupled runs with the effect that explains most by itself; with another of those that were found where the readings ask for it.

        A diagnosis along a run without effects may take two for one: what the first does to the shape looks like another, and a run that
        is given both keeps them. So the second must be asked for along the run that has the first.
        """
        alone = {
            fitted.suspects[0].name: fitted.log_evidence
            for fitted in choice.tried
            if len(fitted.suspects) == 1
        }
        first, *rest = sorted(choice.best.suspects, key=lambda suspect: -alone.get(suspect.name, -np.inf))
        done = self.repeat("effects", _refit((first,)))
        for more in rest:
            before = done[-1].told.fitted
            assert before is not None  # there are effects in the run
            richer = fit(before.readings, (*before.suspects, more), before)
            if richer.log_evidence - before.log_evidence + choice.odds > SURE:
                done = self.repeat("effects", _refit(richer.suspects), done)
                if (fewer := needed(done[-1], choice.odds)) != richer.suspects:
                    done = self.repeat("effects", _refit(fewer), done)
        return done

    def repeat(self, name: str, refit: Refit, before: tuple[Round, ...] = ()) -> tuple[Round, ...]:
        """Coupled runs until the readings along the last say what was put into it, or the rounds are over; after those `before`."""
        data = readings(self.given.only(self.train))
        if before and before[-1].told.fitted is not None:
            data = before[-1].told.fitted.readings
        told, done = refit(data, None), list(before)
        for _ in range(self.rounds):
            done.append(self.round(self.out / "rounds" / f"{name}-{len(done) + 1}", told, refit))
            told = averaged(done[-1].told, done[len(before) :])
            done[-1] = replace(done[-1], change=told.change(done[-1].put_in))
            self.say(self._line(name, done))
            if done[-1].change < PART:
                break
        return tuple(done)

    def round(self, folder: Path, put_in: Told, refit: Refit) -> Round:
        """One coupled run with what was told, and what the readings say along it."""
        effects = tuple(in_service(effect, self.survey, self.past, self.unit) for effect in put_in.effects)
        assert self.plain.folder is not None  # it was read from a folder
        write_case(
            folder, self.plain.folder, self.plain.settings, put_in.factor, effects,
            f"{self.plain.name} in a round of wearfem improve, up to the last reading of {self.survey.source}.", self.last,
        )  # fmt: skip
        case = load_any_case(folder)
        assert isinstance(case, LifeCase)
        live_to_the_end(case, folder / "run", self.quiet)
        along = exposed_by_run(self.survey, folder / "run", put_in=PutIn(put_in.factor, effects))
        told = refit(readings(along.only(self.train)), put_in)
        return Round(folder, folder / "run", put_in, told, told.change(put_in))

    def score(self, done: Round) -> Score:
        return score(
            exposed_by_run(self.survey, done.run).only(self.keep), self.held, int((done.put_in.deviation > 0.0).sum())
        )  # fmt: skip

    def _line(self, name: str, done: Sequence[Round]) -> str:
        one = done[-1]
        verdict = "they agree" if one.change < PART else "not yet"
        return (
            f"{name}, coupled run {len(done)}: factor {one.put_in.factor:.4g}, by the readings along it "
            f"{one.told.factor:.4g}; largest change {one.change:.2g} standard deviations: {verdict}"
        )


def coefficient_alone(data: Readings, before: Told | None) -> Told:
    """The factor by plain least squares, as people refit a coefficient.

    Its standard deviation is that of the scatter and, as covariance C, what the run itself does not know: j'(s^2 + C)j / (j'j)^2, with j
    the change of the wear with the logarithm of the factor. Two runs cannot agree better than they know themselves.
    """

    def left(log: np.ndarray) -> np.ndarray:
        return data.worn - data.past.of_rows(depths(data.past, Model(float(np.exp(log[0])))))

    start = np.log(before.factor if before is not None else data.coefficient)
    found = least_squares(left, [start], diff_step=1e-4)
    slope = found.jac[:, 0]
    own = slope @ _own_errors(data, float(np.exp(found.x[0])))
    scatter = 2.0 * found.cost / max(1, len(data.worn) - 1)
    variance = (scatter + float(own @ own) / float(slope @ slope)) / float(slope @ slope)
    return Told(float(np.exp(found.x[0])), (), found.x, np.sqrt([variance]))


def with_suspects(data: Readings, suspects: Sequence[Candidate], before: Told | None) -> Told:
    """The factor and the effects, at their mean over what the readings leave probable, with nuisances integrated out."""
    start = before.fitted if before is not None else None
    return told_by(at_mean(fit(data, suspects, start)))


def told_by(fitted: Fit) -> Told:
    """The factor and the effects of a fit."""
    model = fitted.model
    place, deviation = fitted.coordinate.copy(), np.sqrt(np.diag(fitted.deviation))
    place[0], deviation[0] = np.log(model.coefficient), COEFFICIENT_PRIOR * deviation[0]
    at, effects = 1, []
    for suspect in fitted.suspects:
        effects.append(suspect.effect(fitted.coordinate[at : at + len(suspect.free)]))
        at += len(suspect.free)
    return Told(model.coefficient, tuple(effects), place, deviation, fitted)


def averaged(last: Told, rounds: Sequence[Round]) -> Told:
    """What the readings say along several runs, mean over those that had nearly what the last says: `ALIKE` standard deviations at most.

    Each run errs by its own sampling, and what is told along it with it; a loop that follows the last would chase that noise.

    **Source** stochastic approximation, H. Robbins and S. Monro, Ann. Math. Stat. 22 (1951) 400-407: steps of 1/n.
    """
    alike = [one.told for one in rounds[:-1] if last.change(one.put_in) < ALIKE] + [last]
    if last.fitted is None:
        place = np.mean([told.place for told in alike], axis=0)
        return replace(last, factor=float(np.exp(place[0])), place=place)
    coordinate = np.mean([told.fitted.coordinate for told in alike if told.fitted is not None], axis=0)
    return told_by(replace(last.fitted, coordinate=coordinate))


def at_mean(fitted: Fit) -> Fit:
    """A fit at the mean of its posterior and with its spread, in place of the peak.

    A parameter that readings bound from one side only, like the core of a plate that is not worn to it, has its peak at that bound or
    where its prior is widest. A run goes on beyond the readings, and errs least on average with the mean.
    """
    drawn = posterior(fitted, DRAWS, np.random.default_rng(1))
    return replace(fitted, coordinate=drawn.mean(axis=0), deviation=np.cov(drawn.T))


def own_sampling(along: Survey, held: np.ndarray, effects: Sequence[CaseEffect]) -> float:
    """What a run does not know of its own depths [measured unit], root mean square over the readings held out.

    Parameters
    ----------
    along
        With the course of the run.
    held
        (n,) of its readings.
    effects
        Of the run: with E(d) of its metal and plain depths p = int dd / E, what a sample errs by, e of the growth of p, is E(d) e of d at
        every later depth. A place that has come to softer metal has gone ahead by its error, too.
    """
    data = readings(along)
    past, depth = data.past, depths(data.past, Model(1.0))
    metal = Metal.known_by(effects, np.zeros(1), depth)
    plain, factor = (
        (depth, 1.0) if metal is None else (metal.plain_of(depth), metal.factor(depth)[:, :, None])
    )
    growth = np.diff(plain, axis=1, prepend=0.0)[:, :, None]
    error = (factor * np.cumsum(growth * past.sampled, axis=1))[past.row_life, past.row_interval]
    error = np.where(past.row_interval[:, None] < 0, 0.0, error)
    return (
        float(np.sqrt(np.square(error[held]).sum(axis=1).mean())) / along.measured_factor
        if held.any()
        else 0.0
    )


def _own_errors(data: Readings, factor: float) -> np.ndarray:
    """(n, q) by which the run's own sampling may change each reading, for q independent standard normals"""
    depth = depths(data.past, Model(factor))
    known = disturbance(data.survey, data.past, depth, data.reference, data.thickness_free)
    return known.column[:, known.group == SAMPLING]


def score(along: Survey, held: np.ndarray, parameters: int, factor: float = 1.0) -> Score:
    """Errors of a run's own depths at a pace [measured unit], on readings it was fitted to and on those held out."""
    data = readings(along)
    left = data.worn - data.past.of_rows(depths(data.past, Model(factor)))
    size = along.measured_factor
    return Score(
        float(np.sqrt(np.mean(left[~held] ** 2))) / size,
        float(np.sqrt(np.mean(left[held] ** 2))) / size if held.any() else None,
        float(np.sum(left[~held] ** 2)) / data.reference**2 / max(1, int((~held).sum()) - parameters),
    )
