"""The loop closed on a coupled virtual plant: a hidden effect is named, put into the case, and the coupled run predicts unseen readings.

The plants are coupled runs themselves (`tests/identification/coupled_plants.py`): a stream that strikes a plate at a slant and aims at its
own scar, or ore on a chute, with something in them that the case does not have, another seed and shorter jumps. The loop is told readings
and nothing else. The chute takes hours (`cases/transfer_chute/hidden.py`); the claims are those of the plate.
"""

import contextlib
import importlib.util
import io
import math
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from wearfem.case import LifeCase, load_any_case
from wearfem.errors import UserError
from wearfem.exposure import exposed_by_run
from wearfem.improve import PART, Improvement, improve
from wearfem.proof import Claim
from wearfem.run import live_to_the_end
from wearfem.survey.diagnose import SHAPE, Diagnosis, diagnose
from wearfem.survey.survey import Survey, read_survey
from wearfem.units import day, kt, mm
from wearfem.wear.effects import HardnessGradient, OreChange, Overlay, SpeedExponent

HERE = Path(__file__).parents[3]
PLANTS = HERE / "tests" / "identification" / "coupled_plants.py"
SMALL: dict[str, Any] = {"points": 24, "occasions": 6}
LOSS_PRIOR = 0.8  # of the logarithm of the loss, by unit of its coordinate
FACTOR = 0.8  # [-] the plant's coefficient over the case's
ISSUE = "what closing the loop must do, issue 5 of the project"


@dataclass(frozen=True)
class Site:
    """A case with keywords under which it is cheap, how long it is followed, and how it is read."""

    case: Path
    keywords: Mapping[str, Any]
    hidden: Mapping[str, tuple[Any, ...]]  # by name, what a plant may have
    served: float  # [s]
    sigma: float  # [mm] of the gauge
    within: tuple[tuple[float, float], tuple[float, float]] | None = None  # [m] x and y of the places read
    truth: Mapping[str, Any] = field(default_factory=dict)  # keywords of the plant that are not the case's


PLATE = Site(
    HERE / "cases" / "stream_on_plate",
    {"noise": 0.05, "tolerance": 0.005},  # sampling errors below the gauge's
    {
        "hardness_gradient": (HardnessGradient(0.05 / mm, 0.4),),
        "ore_change": (OreChange((80 * kt,), (1.5,)),),
        "speed_exponent": (SpeedExponent(1.5, 5.0),),
        "nothing": (),
    },
    500 * day,
    0.1,
    ((60 * mm, 340 * mm), (20 * mm, 140 * mm)),
)
HIDDEN = PLATE.hidden
CHUTE = Site(
    HERE / "cases" / "transfer_chute",
    {"tolerance": 0.02},
    {
        "hardness_gradient": (HardnessGradient(0.05 / mm, 0.4),),
        "case_hardened": (Overlay(4 * mm, 1.6),),
        "ore_change": (OreChange((72 * kt,), (1.4,)),),
        "nothing": (),
    },
    60 * day,  # when 11 mm of 12 are gone
    0.1,
    truth={"tolerance": 0.01},  # sampled longer: a real plant averages over months
)


@dataclass(frozen=True)
class Plant:
    """A survey of a coupled plant, and the run of the case that it is held against."""

    survey: Survey
    run: Path
    sigma: float  # [mm]


def plants() -> ModuleType:
    """The module of coupled virtual plants, which is part of the tests."""
    if not PLANTS.is_file():
        raise UserError(f"{PLANTS} is missing; the proof of the loop needs the tests beside the package")
    spec = importlib.util.spec_from_file_location("wearfem_coupled_plants", PLANTS)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def plant(
    folder: Path, hidden: str, seed: int, frozen: bool = False, site: Site = PLATE, **design: Any
) -> Plant:
    """Make a plant, write its survey, and run the case as it is known; what is in the folder is gone on with."""
    if not (folder / "survey.csv").exists():
        plants().coupled_plant(
            site.case, {**site.keywords, **site.truth}, seed, effects=site.hidden[hidden], factor=FACTOR, served=site.served,
            sigma=site.sigma, within=site.within, **design,
        ).write(folder)  # fmt: skip
    keywords = {**site.keywords, "seed": seed, "frozen": frozen, "stop": site.served}
    case = load_any_case(site.case, keywords)
    assert isinstance(case, LifeCase)
    with contextlib.redirect_stdout(io.StringIO()):
        live_to_the_end(case, folder / "run", quiet=True)
    return Plant(read_survey(folder / "survey.csv"), folder / "run", site.sigma)


def closed(
    folder: Path, hidden: str, seed: int, again: bool = False, site: Site = PLATE, **design: Any
) -> tuple[Improvement, Plant]:
    """The loop on one plant."""
    made = plant(folder, hidden, seed, site=site, **design)
    found = diagnose(exposed_by_run(made.survey, made.run), name_without=False)
    with contextlib.redirect_stdout(io.StringIO()):
        done = improve(made.survey, made.run, folder / "out", found=found, diagnose_again=again, quiet=True)
    return done, made


def claims() -> Iterator[Claim]:
    """A hidden hardness gradient put in and refitted; nothing named where only the shape changes; a frozen run that says so."""
    with tempfile.TemporaryDirectory() as folder:
        done, made = closed(Path(folder) / "gradient", "hardness_gradient", 21, again=True, **SMALL)
        yield from gradient_claims(done, made)
        yield from shape_claims(Path(folder))


def gradient_claims(done: Improvement, made: Plant) -> Iterator[Claim]:
    """Before and after, on readings that no round saw."""
    last = done.last.put_in
    effect = last.effects[0]
    assert isinstance(effect, HardnessGradient)
    unseen = f"error on {done.diagnosis.heldout.readings} readings never fitted"
    before = {
        "straight line per point": done.diagnosis.straight_line,
        "coefficient alone": done.coefficient_alone,
        "diagnosed along the run as given, not repeated": done.diagnosis.improved,
    }
    for name, score in before.items():
        yield Claim(
            f"{unseen}: {name}", "gauge of the plant", made.sigma, score.heldout_rmse or 0.0, "mm", math.inf, True
        )  # fmt: skip
    yield Claim(
        f"{unseen}: {type(effect).__name__} in the loop", ISSUE, made.sigma, done.improved.heldout_rmse or 0.0, "mm", 0.3, True,
        "within 1.3 times the gauge's error is asked",
    )  # fmt: skip
    factor, loss = (float(last.deviation[0]), float(last.deviation[1] * LOSS_PRIOR))
    yield Claim(
        "factor on the wear law", "put into the plant", FACTOR, last.factor, "-", 3.0 * factor, True, "three of its standard deviations"
    )  # fmt: skip
    yield Claim(
        "hardness lost with depth", "put into it", 0.05 / mm, effect.loss, "1/m", 3.0 * loss, True, "three of its standard deviations"
    )  # fmt: skip
    yield Claim(
        f"largest change of a parameter in the last of {len(done.rounds)} coupled runs", "less than a quarter", 0.0, done.last.change,
        "standard deviations", PART, False,
    )  # fmt: skip
    assert done.again is not None
    yield Claim(
        "effects named along the improved run", "what is left is noise", 0.0, float(len(done.again.effects)), "-", 0.0, False,
        done.again.verdict,
    )  # fmt: skip


def shape_claims(folder: Path) -> Iterator[Claim]:
    """Only the shape changes, and the run follows it or not"""
    moving = shape_only(folder / "moving", 22, frozen=False)
    yield Claim(
        "effects named where only the shape changes, run moving", "nothing is hidden", 0.0, float(len(moving.effects)), "-", 0.0, False,
        moving.verdict,
    )  # fmt: skip
    frozen = shape_only(folder / "frozen", 22, frozen=True)
    silent = [effect for effect in frozen.effects if SHAPE not in effect.indistinguishable_from]
    yield Claim(
        "effects named without saying that they may be the shape, run frozen", ISSUE, 0.0, float(len(silent)), "-", 0.0, False,
        f"{frozen.verdict}; named: {len(frozen.effects)}",
    )  # fmt: skip


def shape_only(folder: Path, seed: int, frozen: bool) -> Diagnosis:
    """The diagnosis of a plant with nothing hidden but another coefficient"""
    made = plant(folder, "nothing", seed, frozen, points=16, occasions=5)
    return diagnose(exposed_by_run(made.survey, made.run), name_without=False)
