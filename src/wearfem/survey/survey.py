"""A survey: readings of wear at points and occasions, as they were taken, in SI."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wearfem.errors import UserError, in_words
from wearfem.survey.columns import column, numbers, read_table
from wearfem.survey.course import Course

PROGRESS = (
    "tonnage",
    "throughput",
    "time",
    "distance",
    "cycles",
)  # what service is counted by; the first found
MEASURED = {"thickness": -1.0, "depth": 1.0, "wear": 1.0, "mass_loss": 1.0, "volume_loss": 1.0}
KNOWN_AS = {  # other names of features
    "speed": "slip_speed",
    "hardness": "ore_hardness",
    "angle": "impact_angle",
    "contact_pressure": "pressure",
}

LISTED = 6  # files that a refusal names


@dataclass(frozen=True)
class Survey:
    """Readings, one a row; a life is one plate (specimen) at one point.

    Parameters
    ----------
    point, occasion, life
        (n,) index of the place, of the campaign in the order of progress, and of the plate that was read.
    point_names, occasion_names
        What the survey calls them.
    progress
        (n,) amount of service at the reading, in `progress_unit` (as the column has it: kt, h, ...).
    progress_name, progress_unit
        Of the column; the unit is empty where the name tells none.
    reading
        (n,) [SI unit of the measured column] as measured.
    sign
        +1 where the reading grows with wear, -1 for a thickness.
    measured_name, measured_unit, measured_factor
        Of the column; a reading in the column's unit times the factor is in SI.
    sigma
        (n,) [SI] standard error of the gauge; not-a-number where none is given.
    initial
        (n,) [SI] what the plate measured when new; not-a-number where it is not told.
    life_point, life_start
        (l,) the point of each life, and the progress at which its plate was put in.
    exposure
        (n,) baseline wear by unit of coefficient and of progress, between the reading before and this one; (n, e) where several
        mechanisms wear, each with a coefficient of its own.
    exposure_known
        Whether it was given; it is 1 everywhere if not.
    feature
        (n,) or (n, 3) [SI] by name: covariates and features of the state, each over the time since the reading before.
    source
        Where the rows come from.
    taken_as_replaced
        Points whose plate was taken to be replaced because the wear vanished, where no specimens are told.
    zone
        What the survey calls the zone of each point, where it has a column of that name; empty if not.
    mechanisms
        Names of the exposures where there are several: `sliding` of a column `exposure_sliding`.
    course
        What a run of the model tells of each life; then `exposure` is 1 everywhere and the coefficient is a factor on the run's wear.
    """

    point: np.ndarray
    occasion: np.ndarray
    life: np.ndarray
    point_names: tuple[str, ...]
    occasion_names: tuple[str, ...]
    progress: np.ndarray
    progress_name: str
    progress_unit: str
    reading: np.ndarray
    sign: float
    measured_name: str
    measured_unit: str
    measured_factor: float
    sigma: np.ndarray
    initial: np.ndarray
    life_point: np.ndarray
    life_start: np.ndarray
    exposure: np.ndarray
    exposure_known: bool
    feature: Mapping[str, np.ndarray]
    source: str
    taken_as_replaced: tuple[str, ...] = ()
    zone: tuple[str, ...] = ()
    mechanisms: tuple[str, ...] = ()
    course: Course | None = None

    @property
    def size(self) -> int:
        """Number of readings"""
        return len(self.reading)

    @property
    def is_new(self) -> np.ndarray:
        """(n,) whether the reading was taken before the plate served"""
        return self.progress <= self.life_start[self.life]

    def only(self, keep: np.ndarray) -> "Survey":
        """The survey with the rows (n,) of `keep` only; points, occasions and lives keep their numbers."""
        rows = ("point", "occasion", "life", "progress", "reading", "sigma", "initial", "exposure")
        kept = {name: getattr(self, name)[keep] for name in rows}
        feature = {name: value[keep] for name, value in self.feature.items()}
        return Survey(**(self.__dict__ | kept | {"feature": feature}))


def read_survey(path: Path, *, progress: str = "", exposure: Path | None = None) -> Survey:
    """Read a survey from a CSV file, one row a reading.

    Parameters
    ----------
    path
        Columns `point`, `occasion`, one of progress, one measured (`thickness_`, `depth_`, `mass_loss_`, `volume_loss_` with a
        unit); optional `sigma_<unit>`, `initial_<unit>` (new thickness), `specimen`, `x_m, y_m, z_m`, `exposure` and covariates.
    progress
        The column that counts service, where its name does not tell.
    exposure
        A CSV file with `point`, optionally `occasion`, `exposure`, and features of the state by point.

    Raises
    ------
    UserError
        for what cannot be read, in one sentence.
    """
    if path.is_dir():
        raise UserError(_folder_instead(path))
    table = read_table(path)
    if "point" not in table:
        raise UserError(
            f"{path} has no column point; it has {in_words(list(table))}. A survey needs point, occasion, "
            "a progress (tonnage_kt, time_h, ...) and a measured column (thickness_mm, depth_mm, ...)"
        )
    for name in sorted({"point", "occasion"} & set(table)):
        if "" in table[name]:
            raise UserError(
                f"{path} has no {name} in data row {table[name].index('') + 1}; each reading belongs to one: name it, or drop the row"
            )
    clock = _progress_column(path, table, progress.strip().lower())
    at = numbers(path, clock, table[clock])
    if (at < 0.0).any():
        raise UserError(f"{path} has {clock} below 0; count service from when the first plate was put in")
    measured = _measured_column(path, table)
    told = column(measured)
    point_names = tuple(dict.fromkeys(table["point"]))
    point = np.array([point_names.index(name) for name in table["point"]])
    occasion, occasion_names = _occasions(table, at)
    reading = told.si(numbers(path, measured, table[measured]))
    replaced: tuple[str, ...] = ()
    if "specimen" not in table:
        plate = _plates(point, at, MEASURED[told.quantity] * reading)
        table["specimen"] = [str(number) for number in plate]
        replaced = tuple(point_names[p] for p in np.unique(point[plate > 0]))
    life, life_point, life_start = _lives(path, table, point, at, clock)
    feature, exposed, mechanisms = _features(
        path, table, {"point", "occasion", "specimen", "zone", clock, measured}
    )
    known = exposed is not None
    if exposure is not None:
        if known:
            raise UserError(f"{path} has a column exposure, and {exposure} was given too; give one of them")
        exposed, more, mechanisms = _read_exposure(exposure, table["point"], table.get("occasion"))
        feature, known = {**feature, **more}, True
    sigma = _beside(path, table, "sigma", told.factor)
    if (sigma <= 0.0).any():
        raise UserError(
            f"{path} has a sigma of 0 or less; a standard error is above 0 (leave the cell empty)"
        )
    return Survey(
        point, occasion, life, point_names, occasion_names, at, clock, column(clock).unit,
        reading, MEASURED[told.quantity],
        measured, told.unit, told.factor, sigma, _beside(path, table, "initial", told.factor),
        life_point, life_start, np.ones(len(at)) if exposed is None else exposed, known, feature, str(path), replaced,
        _zones(path, table, point_names), mechanisms,
    )  # fmt: skip


def _folder_instead(folder: Path) -> str:
    """What to do where a folder was given for a survey"""
    tables = sorted(
        str(file.relative_to(folder))
        for file in [*folder.glob("*.csv"), *folder.glob("*/*.csv"), *folder.glob("*/*/*.csv")]
    )
    more = [f"{len(tables) - LISTED} more"] if len(tables) > LISTED else []
    lies = f"in it: {in_words(tables[:LISTED] + more)}" if tables else "no CSV file lies in it"
    return (
        f"{folder} is a folder, and a survey is a CSV file, one row a reading: point, occasion, service (tonnage_kt, time_h, ...) and what "
        f"was read (thickness_mm, depth_mm, ...); {lies}. Give a survey, and the folder of a run "
        "with --run beside it"
    )


def _progress_column(path: Path, table: Mapping[str, list[str]], asked: str) -> str:
    if asked:
        if asked not in table:
            raise UserError(f"{path} has no column {asked}; it has {in_words(list(table))}")
        return asked
    for quantity in PROGRESS:
        found = [name for name in table if column(name).quantity == quantity]
        if len(found) > 1:
            raise UserError(f"{path} has {in_words(found)}; keep one, or say which with --progress")
        if found:
            return found[0]
    raise UserError(
        f"{path} has no column that counts service (tonnage_kt, time_h, distance_m or cycles); it has "
        f"{in_words(list(table))}. Name one of them with --progress"
    )


def _measured_column(path: Path, table: Mapping[str, list[str]]) -> str:
    found = [name for name in table if column(name).quantity in MEASURED]
    if len(found) != 1:
        raise UserError(
            f"{path} has {in_words(found)} as measured columns; expected exactly one of thickness_mm, depth_mm, "
            f"mass_loss_g and volume_loss_mm3, and it has {in_words(list(table))}"
        )
    if not column(found[0]).unit:
        raise UserError(f"{path} has a column {found[0]} without unit; write it like {found[0]}_mm")
    return found[0]


def _zones(path: Path, table: Mapping[str, list[str]], points: tuple[str, ...]) -> tuple[str, ...]:
    """The zone of each point; nothing where there is no such column."""
    if "zone" not in table:
        return ()
    named = {
        point: {z for p, z in zip(table["point"], table["zone"], strict=True) if p == point}
        for point in points
    }
    if doubled := [point for point, zones in named.items() if len(zones) > 1]:
        raise UserError(
            f"{path} has point {doubled[0]} in the zones {in_words(sorted(named[doubled[0]]))}; a point belongs to one zone"
        )
    return tuple(next(iter(zones)) or "no zone" for zones in named.values())


def _occasions(table: Mapping[str, list[str]], at: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Index of the occasion of each row in the order of progress, and the names."""
    label = table.get("occasion") or [f"{value:g}" for value in at]
    names = sorted(dict.fromkeys(label), key=lambda name: float(np.median(at[[i == name for i in label]])))
    return np.array([names.index(name) for name in label]), tuple(names)


def _lives(
    path: Path, table: Mapping[str, list[str]], point: np.ndarray, at: np.ndarray, clock: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Life of each row, and the point and the beginning of each life.

    Specimens that follow one another at a point are plates that were replaced: the later begins at the last reading of the earlier,
    unless a column `installed_<unit>` says when. Specimens side by side are repeats, and begin at 0.
    """
    specimen = table.get("specimen") or [""] * len(at)
    label = list(zip(point.tolist(), specimen, strict=True))
    names = list(dict.fromkeys(label))
    life = np.array([names.index(name) for name in label])
    life_point = np.array([name[0] for name in names])
    start = np.zeros(len(names))
    first = np.array([at[life == i].min() for i in range(len(names))])
    last = np.array([at[life == i].max() for i in range(len(names))])
    for i in range(len(names)):
        before = [j for j in range(len(names)) if life_point[j] == life_point[i] and last[j] <= first[i]]
        start[i] = max((last[j] for j in before if first[j] < first[i]), default=0.0)
    if told := [name for name in table if column(name).quantity == "installed"]:
        value = numbers(path, told[0], table[told[0]], empty=True)
        for i in range(len(names)):
            given = value[life == i]
            if np.isfinite(given).any():
                start[i] = float(np.nanmin(given))
        if (start > first).any():
            raise UserError(f"{path} has plates that were read before {told[0]}; compare it with {clock}")
    return life, life_point, start


def _plates(point: np.ndarray, at: np.ndarray, grown: np.ndarray) -> np.ndarray:
    """Number of the plate (n,) at each point: the next one where more than half the wear vanishes and stays away"""
    plate = np.zeros(len(point), int)
    ranges = [float(np.ptp(grown[point == p])) for p in np.unique(point)]
    for p in np.unique(point):
        rows = np.flatnonzero(point == p)
        rows = rows[np.argsort(at[rows], kind="stable")]
        first = 0
        for i in range(1, len(rows) - 1):
            worn = grown[rows[i - 1]] - grown[rows[first]]
            gone = grown[rows[i - 1]] - grown[rows[i : i + 2]]
            if worn > 0.3 * max(ranges) and (gone > 0.5 * worn).all() and at[rows[i]] > at[rows[i - 1]]:
                plate[rows[i:]] += 1
                first = i
    return plate


def _beside(path: Path, table: Mapping[str, list[str]], quantity: str, factor: float) -> np.ndarray:
    """A column that belongs to the measured one, in SI; not-a-number where it is empty or missing."""
    found = [name for name in table if column(name).quantity == quantity]
    if not found:
        return np.full(len(table["point"]), np.nan)
    told = column(found[0])
    return numbers(path, found[0], table[found[0]], empty=True) * (told.factor if told.unit else factor)


def _features(
    path: Path, table: Mapping[str, list[str]], taken: set[str]
) -> tuple[dict[str, np.ndarray], np.ndarray | None, tuple[str, ...]]:
    """What else the columns tell, in SI, the exposures among them and their names; columns of text are labels and left out."""
    feature: dict[str, np.ndarray] = {}
    exposed: dict[str, np.ndarray] = {}
    for name, text in table.items():
        told = column(name)
        if name in taken or told.quantity in {"sigma", "initial", "installed"} or not _numeric(text):
            continue
        if name == "exposure" or name.startswith("exposure_"):
            wear = numbers(path, name, text)
            if (wear < 0.0).any() or not (wear > 0.0).any():
                raise UserError(
                    f"{path} has exposures below 0 or none above in {name}; exposure is wear, 0 or more"
                )
            exposed[name.removeprefix("exposure").removeprefix("_")] = wear
            continue
        feature[KNOWN_AS.get(told.quantity, told.quantity)] = told.si(numbers(path, name, text, empty=True))
    axes = [feature.pop(axis, None) for axis in "xyz"]
    if any(axis is not None for axis in axes):
        rows = len(next(iter(table.values())))
        feature["position"] = np.stack([np.zeros(rows) if axis is None else axis for axis in axes], axis=1)
    if "load" in feature and "pressure" not in feature:
        feature["pressure"] = feature.pop("load")  # in proportion, where the area of contact does not change
    if "" in exposed and len(exposed) > 1:
        raise UserError(
            f"{path} has exposure beside exposure_{list(exposed)[1]}; name all mechanisms, or give the sum alone"
        )
    known = {name: value for name, value in feature.items() if np.isfinite(value).any()}
    if len(exposed) > 1:
        return known, np.stack(list(exposed.values()), axis=1), tuple(exposed)
    return known, next(iter(exposed.values()), None), ()


def _numeric(text: list[str]) -> bool:
    """Whether a column holds numbers: one cell that is one."""
    for cell in text:
        try:
            float(cell)
        except ValueError:
            continue
        return True
    return False


def _read_exposure(
    path: Path, points: list[str], occasions: list[str] | None
) -> tuple[np.ndarray, dict[str, np.ndarray], tuple[str, ...]]:
    """Exposures, features and names of mechanisms of a table by point (and occasion), for rows of a survey."""
    table = read_table(path)
    if "point" not in table or not any(name.partition("_")[0] == "exposure" for name in table):
        raise UserError(
            f"{path} has the columns {in_words(list(table))}; it needs point and exposure (or exposure_sliding, exposure_impact ...)"
        )
    by_occasion = "occasion" in table and occasions is not None
    keys = list(zip(table["point"], table["occasion"], strict=True)) if by_occasion else table["point"]
    if len(set(keys)) < len(keys):
        raise UserError(f"{path} has a point twice; one row for each point (and occasion, if it varies)")
    asked = list(zip(points, occasions, strict=True)) if by_occasion and occasions else points
    row = {key: i for i, key in enumerate(keys)}
    if missing := sorted({str(key) for key in asked if key not in row}):
        raise UserError(
            f"{path} has no row for {in_words(missing[:3])}{' and others' if len(missing) > 3 else ''} of the survey"
        )
    of = np.array([row[key] for key in asked])
    feature, exposed, mechanisms = _features(path, table, {"point", "occasion"})
    if exposed is None:
        raise UserError(f"{path} has no number in column exposure")
    return exposed[of], {name: value[of] for name, value in feature.items()}, mechanisms
