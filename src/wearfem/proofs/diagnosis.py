"""Diagnosis: virtual plants with a hidden effect, what was named, and the error before and after.

The plants are made by their own equations (`tests/identification/plants.py` and `other_plants.py`, written after the diagnosis was), which
import nothing of the diagnosis; the diagnosis is told nothing of them but the survey and the exposure.
"""

import importlib
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from wearfem.errors import UserError
from wearfem.proof import Claim
from wearfem.survey.candidates import candidates
from wearfem.survey.diagnose import SHAPE, Diagnosis, Parameter, diagnose, parameters_of
from wearfem.survey.identify import fit, readings
from wearfem.survey.survey import read_survey
from wearfem.units import day

TESTS = Path(__file__).parents[3] / "tests"
ISSUE = "what a diagnosis must do, issue 5 of the project"
NOTHING = (
    "none", "zero_error", "plain", "bent_scans", "wrong_map", "elsewhere", "two_mechanisms",
)  # plants with no physical effect  # fmt: skip
SHAPES = ("levelling", "hollow", "hollow_alike")  # plants whose shape wears, and their material is as it is
SMALL = {"noise": 0.1, "points": 24, "occasions": 6}


@dataclass(frozen=True)
class Trial:
    """A plant and what was found in it."""

    plant: str
    seed: int
    truth: tuple[str, ...]
    verdict: str
    named: tuple[str, ...]
    alike: tuple[tuple[str, ...], ...]
    right: bool
    error_over_noise: float  # error on held-out readings after, over the gauge's standard error
    decided_over_noise: (
        float  # the same, without readings that the fitted ones do not tell to within the gauge's error
    )
    covered: tuple[tuple[str, bool], ...]  # whether 90 % intervals hold the truth, by effect and parameter


def plants(name: str = "plants") -> ModuleType:
    """A module of virtual plants, which are part of the tests."""
    if not (TESTS / "identification" / f"{name}.py").is_file():
        raise UserError(f"{TESTS} has no plants; the proof of diagnosis needs the tests beside the package")
    if str(TESTS) not in sys.path:
        sys.path.append(str(TESTS))
    return importlib.import_module(f"identification.{name}")


def trial(name: str, seed: int, **design: float) -> Trial:
    """Make a plant, write its survey, diagnose that."""
    module = plants() if name in plants().NAMES else plants("other_plants")
    plant = module.plant(name, seed, **design)
    with tempfile.TemporaryDirectory() as folder:
        survey, exposure = plant.write(Path(folder))
        found = diagnose(read_survey(survey, exposure=exposure), name_without=False)
    names = tuple(effect.name.partition("(")[0] for effect in found.effects)
    after = found.improved.heldout_rmse
    return Trial(
        name, seed, plant.truth, found.verdict, names, tuple(e.indistinguishable_from for e in found.effects),
        is_right(name, plant.truth, found), (after or np.nan) / plant.sigma, (found.heldout.decided_rmse or np.nan) / plant.sigma,
        covered(plant, {effect.name: effect.parameters for effect in found.effects}),
    )  # fmt: skip


def is_right(name: str, truth: tuple[str, ...], found: Diagnosis) -> bool:
    """Whether the verdict is the one that the plant deserves; a set of two that are declared alike counts."""
    names = [effect.name.partition("(")[0] for effect in found.effects]
    if name in NOTHING:
        return not names
    if name in SHAPES:  # no material named, unless the shape is said to do as well
        return all(SHAPE in effect.indistinguishable_from for effect in found.effects)
    if name == "same_exposure":
        return found.verdict == "cannot_tell"
    if name == "outside_library":
        return found.verdict == "unexplained" and [e.quantity for e in found.effects] == ["depth"]
    if len(names) != len(truth):
        return False
    sets = [{n, *e.indistinguishable_from} for n, e in zip(names, found.effects, strict=True)]
    return all(
        any(t == n or (t in s and len(s) <= 2) for n, s in zip(names, sets, strict=True)) for t in truth
    )


# The truth of a plant's parameter in SI, by effect and parameter. What wearfem refers to another place or another friction than the plant
# does is the same curve up to the coefficient, so its parameter follows.
TOLD: dict[tuple[str, str], Callable[[Any], float]] = {
    ("HardnessGradient", "loss"): lambda plant: 1e3 * plant.parameter["loss_per_mm"],
    ("Overlay", "thickness"): lambda plant: 1e-3 * plant.parameter["thickness_mm"],
    ("Overlay", "ratio"): lambda plant: plant.parameter["ratio"],
    ("RunningIn", "excess"): lambda plant: plant.parameter["excess"],
    ("RunningIn", "depth"): lambda plant: 1e-3 * plant.parameter["depth_mm"],
    ("OreChange", "throughput"): lambda plant: plant.parameter["at_kt"],
    ("OreChange", "ratio"): lambda plant: plant.parameter["ratio"],
    ("OreHardness", "exponent"): lambda plant: plant.parameter["exponent"],
    ("Temperature", "softening"): lambda plant: plant.parameter["softening"],
    ("Corrosion", "depth_rate"): lambda plant: 1e-6 / day * plant.parameter["um_per_day"],
    ("PressureExponent", "exponent"): lambda plant: plant.parameter["exponent"],
    ("SpeedExponent", "exponent"): lambda plant: plant.parameter["exponent"],
    ("SlipShare", "rolling_ratio"): lambda plant: _rolling_ratio(plant),
    ("LateralBias", "slope"): lambda plant: _slope(plant),
    ("BuildUp", "ratio"): lambda plant: plant.parameter["ratio"],
}


def _rolling_ratio(plant: Any) -> float:
    """Plants roll where nothing is mobilised of 0.46, wearfem where nothing is of the most that occurs: r + (1 - r) m / 0.46 over r"""
    ratio, most = plant.parameter["rolling_ratio"], float(plant.point_column["mobilised_friction"].max())
    odds = ratio / (1.0 - ratio) * 0.46 / most
    return odds / (1.0 + odds)


def _slope(plant: Any) -> float:
    """1 + slope y over its value midway between the outermost points"""
    across = plant.point[:, 1]
    middle = 0.5 * float(across.min() + across.max())
    return plant.parameter["slope"] / (1.0 + plant.parameter["slope"] * middle)


def covered(plant: Any, found: Mapping[str, Mapping[str, Parameter]]) -> tuple[tuple[str, bool], ...]:
    """Whether each 90 % interval holds the truth, by effect and parameter, where the plant has the same parameter.

    `found` are parameters by name, by effect.
    """
    return tuple(
        (f"{effect} {name}", parameter.interval[0] <= TOLD[effect, name](plant) <= parameter.interval[1])
        for effect, parameters in found.items() if effect in plant.truth
        for name, parameter in parameters.items()
        if parameter.interval and (effect, name) in TOLD
    )  # fmt: skip


def intervals(name: str, seed: int, **design: float) -> tuple[tuple[str, bool], ...]:
    """The same where the right effects are fitted and none is looked for, which takes a tenth of a second."""
    plant = plants().plant(name, seed, **design)
    with tempfile.TemporaryDirectory() as folder:
        survey, exposure = plant.write(Path(folder))
        data = readings(read_survey(survey, exposure=exposure))
    known = {candidate.name: candidate for candidate in candidates(data.past, data.deepest)}
    fitted = fit(data)
    for count in range(len(plant.truth)):
        fitted = fit(data, [known[effect] for effect in plant.truth[: count + 1]], fitted)
    found, at = {}, data.coefficients
    for place, suspect in enumerate(fitted.suspects):
        found[suspect.name] = parameters_of(fitted, place, at)
        at += len(suspect.free)
    return covered(plant, found)


def confusion(trials: Sequence[Trial]) -> list[tuple[str, str, str]]:
    """The confusion matrix, a plant a line: its name, how often it was told rightly, and what was said how often."""
    lines = []
    for name in dict.fromkeys(t.plant for t in trials):
        own = [t for t in trials if t.plant == name]
        labels = [
            (" + ".join(t.named) or "nothing")
            + ("" if t.verdict in ("effect_found", "adequate") else f" ({t.verdict})")
            for t in own
        ]
        said = ", ".join(f"{label} {count}" for label, count in Counter(labels).most_common())
        lines.append((name, f"{sum(t.right for t in own)} of {len(own)}", said))
    return lines


@dataclass(frozen=True)
class Degraded:
    """What a set of plants with one effect each comes to, as shares [-].

    Parameters
    ----------
    named
        Whose effect was named, or in a set of two.
    refused
        Called adequate, unexplained or cannot_tell without the right name.
    wrong
        In which another effect was called found.
    """

    named: float
    refused: float
    wrong: float


def degraded(trials: Sequence[Trial]) -> Degraded:
    """What was named, what refused, and what named wrongly."""
    named = float(np.mean([t.right for t in trials]))
    wrong = float(np.mean([not t.right and t.verdict == "effect_found" for t in trials]))
    return Degraded(named, 1.0 - named - wrong, wrong)


def claims() -> Iterator[Claim]:
    """One plant of each kind, 24 points and 6 occasions at 0.1 mm: the confusion matrix, then what it comes to.

    `python docs/make_diagnosis.py` does the same for 40 points and 8 occasions, 200 draws of each noise, and harder designs, in hours.
    """
    module = plants()
    trials = []
    for name in module.NAMES:
        trials.append(trial(name, 1, **SMALL))
        print("  {:<18} {}  {}".format(*confusion(trials[-1:])[0]), flush=True)
    yield from summary(trials, module.SEPARABLE)
    inside = [
        held
        for name in module.SEPARABLE
        for seed in range(6, 11)
        for _, held in intervals(name, seed, **SMALL)
    ]
    noise = float(np.sqrt(0.09 / len(inside)))
    yield Claim(
        "share of 90 % intervals that hold the truth, right effects given", ISSUE, 0.90, float(np.mean(inside)), "-", 0.05 + 2.0 * noise,
        False, f"{len(inside)} intervals; 0.05 as asked, and 2 standard errors of so many",
    )  # fmt: skip


def summary(trials: Sequence[Trial], separable: Sequence[str]) -> Iterator[Claim]:
    """What a set of trials comes to, beside what is asked."""
    apart = [t for t in trials if t.plant in separable]
    if apart:
        yield Claim(
            "share of separable plants whose effect was named", ISSUE, 1.0, float(np.mean([t.right for t in apart])), "-", 0.05, False,
            f"{len(apart)} plants; at least 95 % is asked",
        )  # fmt: skip
        ratio = [t.error_over_noise for t in apart if t.right]
        yield Claim(
            "median of error on held-out readings after, over the gauge's", ISSUE, 1.0, float(np.median(ratio)), "-", 0.15, False,
            f"1.15 is asked; the largest of {len(ratio)} is {max(ratio):.2f}",
        )  # fmt: skip
        decided = [t.decided_over_noise for t in apart if t.right]
        yield Claim(
            "largest of the same on those held-out readings that the others tell", ISSUE, 1.0, max(decided), "-", np.inf, False,
            f"of {len(decided)} plants; the others do not tell readings deeper than any that was fitted, or at the border of a patch",
        )  # fmt: skip
        inside = [c for t in apart if t.right for _, c in t.covered]
        if len(inside) >= 50:
            yield Claim(
                "share of 90 % intervals that hold the truth", ISSUE, 0.90, float(np.mean(inside)), "-", 0.05, False,
                f"{len(inside)} intervals; 85 to 95 % is asked",
            )  # fmt: skip
    quiet = [t for t in trials if t.plant in NOTHING]
    if quiet:
        yield Claim(
            "share of plants without effect in which one was named", ISSUE, 0.0, float(np.mean([not t.right for t in quiet])),
            "-", 0.05, False, f"{len(quiet)} plants; under 5 % is asked",
        )  # fmt: skip
    for name, words in (
        ("same_exposure", "share of plants exposed alike in which the tool says that it cannot tell"),
        (
            "outside_library",
            "share of plants with a strange effect traced to its quantity and called unexplained",
        ),
    ):
        own = [t.right for t in trials if t.plant == name]
        if own:
            yield Claim(words, ISSUE, 1.0, float(np.mean(own)), "-", 0.05, False, f"{len(own)} plants")
