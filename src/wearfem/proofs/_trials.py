"""Many diagnoses of virtual plants, written to a CSV as they come: what the tables of docs/diagnosis.md are counted from.

`python docs/make_diagnosis.py` makes those that are missing and prints the tables. Seeds are such that nothing was developed on.
"""

import csv
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

import numpy as np

import wearfem.survey
from wearfem.proofs.diagnosis import Trial, intervals, plants, trial

COLUMNS = (
    "design", "plant", "seed", "truth", "verdict", "named", "alike", "right", "error_over_noise", "decided_over_noise",
    "intervals", "seconds", "code",
)  # fmt: skip
CARELESS = {
    "scatter": 0.03,
    "book": 0.02,
    "campaign_zero": 0.1,
}  # what places and what dates share, mm and parts
HARD = {"noise": 0.3, "points": 24, "occasions": 5}
NOISES = (0.1, 0.2, 0.5, 1.0)  # [mm], at 24 points and 6 occasions
READINGS = ((8, 3), (12, 3), (12, 5), (24, 6))  # points and occasions, at 0.1 mm


@dataclass(frozen=True)
class Design:
    """Plants that are read in the same way, one of each kind for each seed; `make` is what `plants.plant` takes.

    Where the right effects are `given`, none is looked for, and only intervals are told.
    """

    name: str
    plants: Sequence[str]
    seeds: Sequence[int]
    make: Mapping[str, float] = field(default_factory=dict)
    given: bool = False


@dataclass(frozen=True)
class Row:
    """A diagnosis as the file has it: its design, the trial, and which code made it in how many seconds."""

    design: str
    trial: Trial
    seconds: float
    code: str


def designs() -> list[Design]:
    """What the tables are made of."""
    every, apart = plants().NAMES, plants().SEPARABLE
    told = [name for name in apart if name != "impact_angle"]  # whose curve has no parameter of the plant
    noise, reading, few = range(1000, 1200), (71,), {"points": 24, "occasions": 6}
    return [
        Design("whole", every, range(63, 65)),
        Design("hard", apart, range(63, 65), HARD),
        Design("noise", ("none",), noise),
        Design("noise of places and dates", ("none",), noise, CARELESS),
        Design("noise of neighbours", ("bent_scans",), noise),
        Design("points elsewhere", ("elsewhere",), noise),
        Design("given", told, range(3100, 3200), few, given=True),
        Design("given again", ("temperature", "ore_change", "build_up"), range(6000, 6200), few, given=True),
        *(Design(f"{at:g} mm", apart, reading, {"noise": at} | few) for at in NOISES),
        *(Design(f"{p} x {o}", apart, reading, {"points": p, "occasions": o}) for p, o in READINGS[:-1]),
    ]


def code() -> str:
    """What was measured: a hash of the sources of the diagnosis and of the effects."""
    own = Path(wearfem.survey.__file__).parent
    sources = sorted([*own.glob("*.py"), *(own.parent / "wear").glob("effect*.py")])
    return sha256(b"".join(file.read_bytes() for file in sources)).hexdigest()[:8]


CODE = code()  # what this process has loaded, whatever is edited meanwhile


def measure(file: Path, asked: Sequence[Design], workers: int = 1) -> Iterator[Row]:
    """Trials that the file does not have yet, added to it as they come; those that it has are left as they are."""
    known = {(row.design, row.trial.plant, row.trial.seed) for row in read(file)}
    jobs = [
        (design, name, seed)
        for design in asked for seed in design.seeds for name in design.plants
        if (design.name, name, seed) not in known
    ]  # fmt: skip
    fresh = not file.exists()
    with file.open("a", newline="", encoding="utf-8") as out, ProcessPoolExecutor(workers) as pool:
        writer = csv.writer(out, lineterminator="\n")
        if fresh:
            writer.writerow(COLUMNS)
        for done in as_completed([pool.submit(_one, *job) for job in jobs]):
            row = done.result()
            writer.writerow(_cells(row))
            out.flush()
            yield row


def _one(design: Design, name: str, seed: int) -> Row:
    begun = time.perf_counter()
    if design.given:
        held = intervals(name, seed, **design.make)
        made = Trial(name, seed, (), "given", (), (), True, np.nan, np.nan, held)
    else:
        made = trial(name, seed, **design.make)
    return Row(design.name, made, time.perf_counter() - begun, CODE)


def _cells(row: Row) -> list[object]:
    t = row.trial
    return [
        row.design, t.plant, t.seed, "+".join(t.truth), t.verdict, "+".join(t.named), "+".join("|".join(a) for a in t.alike), int(t.right),
        f"{t.error_over_noise:.4g}", f"{t.decided_over_noise:.4g}",
        ";".join(f"{name}={int(held)}" for name, held in t.covered), f"{row.seconds:.1f}", row.code,
    ]  # fmt: skip


def read(file: Path) -> list[Row]:
    """The trials of a file; none where it does not exist."""
    if not file.exists():
        return []
    with file.open(newline="", encoding="utf-8") as text:
        return [_row(cells) for cells in csv.DictReader(text)]


def _row(cells: Mapping[str, str]) -> Row:
    held = [pair.split("=") for pair in cells["intervals"].split(";") if pair]
    made = Trial(
        cells["plant"], int(cells["seed"]), _names(cells["truth"]), cells["verdict"], _names(cells["named"]),
        tuple(tuple(filter(None, a.split("|"))) for a in cells["alike"].split("+")) if cells["named"] else (),
        cells["right"] == "1", float(cells["error_over_noise"]), float(cells["decided_over_noise"]),
        tuple((name, value == "1") for name, value in held),
    )  # fmt: skip
    return Row(cells["design"], made, float(cells["seconds"]), cells["code"])


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split("+")) if text else ()
