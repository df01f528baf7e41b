"""Columns of a table: a name that ends in its unit, values in SI."""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from wearfem import units
from wearfem.errors import UserError, in_words

VICKERS = 9.80665e6
"""A Vickers hardness number, kgf/mm2, in pascal."""

UNITS: Mapping[str, tuple[float, float, str]] = {  # how a name ends: factor, what is added, unit in SI
    "um": (units.um, 0.0, "m"),
    "mm": (units.mm, 0.0, "m"),
    "cm": (units.cm, 0.0, "m"),
    "m": (1.0, 0.0, "m"),
    "km": (units.km, 0.0, "m"),
    "mm3": (1e-9, 0.0, "m3"),
    "cm3": (1e-6, 0.0, "m3"),
    "mg": (1e-6, 0.0, "kg"),
    "g": (units.gram, 0.0, "kg"),
    "kg": (1.0, 0.0, "kg"),
    "t": (units.tonne, 0.0, "kg"),
    "kt": (units.kt, 0.0, "kg"),
    "mt": (1e3 * units.kt, 0.0, "kg"),
    "s": (1.0, 0.0, "s"),
    "min": (units.minute, 0.0, "s"),
    "h": (units.hour, 0.0, "s"),
    "d": (units.day, 0.0, "s"),
    "days": (units.day, 0.0, "s"),
    "n": (1.0, 0.0, "N"),
    "kn": (units.kN, 0.0, "N"),
    "pa": (1.0, 0.0, "Pa"),
    "kpa": (units.kPa, 0.0, "Pa"),
    "mpa": (units.MPa, 0.0, "Pa"),
    "gpa": (units.GPa, 0.0, "Pa"),
    "hv": (VICKERS, 0.0, "Pa"),
    "mm_s": (units.mm, 0.0, "m/s"),
    "m_s": (1.0, 0.0, "m/s"),
    "deg": (units.degree, 0.0, "rad"),
    "rad": (1.0, 0.0, "rad"),
    "c": (1.0, 273.15, "K"),
    "k": (1.0, 0.0, "K"),
    "j_m2": (1.0, 0.0, "J/m2"),
    "kj_m2": (1e3, 0.0, "J/m2"),
    "percent": (units.percent, 0.0, "-"),
    "cycles": (1.0, 0.0, "cycles"),
}


@dataclass(frozen=True)
class Column:
    """What the name of a column says.

    Parameters
    ----------
    quantity
        The name without its unit: `temperature` of `temperature_c`.
    unit
        As written at the end of the name: `c`; empty where the name ends in no unit that is known.
    factor, offset
        The value in SI is `factor` times the number plus `offset`.
    """

    quantity: str
    unit: str
    factor: float = 1.0
    offset: float = 0.0

    def si(self, number: np.ndarray) -> np.ndarray:
        """Numbers of the column in SI."""
        return self.factor * number + self.offset


def column(name: str) -> Column:
    """The quantity and the unit that the name of a column tells; the longest ending counts (`speed_m_s` is in m/s)."""
    for ending in sorted(UNITS, key=len, reverse=True):
        factor, offset, _ = UNITS[ending]
        if name == ending:
            return Column(name, ending, factor, offset)
        if name.endswith(f"_{ending}"):
            return Column(name.removesuffix(f"_{ending}"), ending, factor, offset)
    return Column(name, "")


def read_table(path: Path) -> dict[str, list[str]]:
    """The columns of a CSV file as text, by name in small letters; lines that begin with # are comments.

    Raises
    ------
    UserError
        for a file that is missing, empty, no text, not separated by commas, without rows, or with rows longer than its header.
    """
    lines = StringIO(_text(path), newline="")
    rows = [row for row in csv.reader(line for line in lines if not line.startswith("#")) if any(row)]
    if len(rows) < 2:
        raise UserError(f"{path} has no rows of data; expected a header and one row for each reading")
    names = [name.strip().lower() for name in rows[0]]
    for mark, word in ((";", "semicolons"), ("\t", "tabs")):
        if len(names) == 1 and mark in names[0]:
            raise UserError(
                f"{path} separates its values by {word}; a survey has commas between values and points in decimals: save it as CSV "
                "with commas"
            )
    if doubled := sorted({name for name in names if names.count(name) > 1}):
        raise UserError(f"{path} names the column {in_words(doubled)} twice; each name may stand once")
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(names):
            hint = (
                "; a decimal has a point, and a text with a comma stands in quotes"
                if len(row) > len(names)
                else ""
            )
            raise UserError(
                f"row {number} of {path} has {len(row)} values; the header names {len(names)} columns{hint}"
            )
    return {name: [row[i].strip() for row in rows[1:]] for i, name in enumerate(names)}


def _text(path: Path) -> str:
    """What stands in a file, whole"""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return file.read()
    except FileNotFoundError:
        raise UserError(f"there is no file {path}; give the path of a CSV file with a header") from None
    except IsADirectoryError:
        within = in_words([str(file) for file in sorted(path.glob("*.csv"))[:5]], "or")
        raise UserError(
            f"{path} is a folder; give the path of a CSV file with a header (in it: {within})"
        ) from None
    except UnicodeDecodeError as error:
        raise UserError(
            f"{path} is not text in UTF-8 (byte {error.start + 1} is 0x{error.object[error.start]:02x}); save it as CSV UTF-8, as "
            "spreadsheets call it"
        ) from error
    except OSError as error:
        raise UserError(f"{path} cannot be read ({error.strerror}); make it readable, or copy it") from error


def numbers(path: Path, name: str, text: Sequence[str], *, empty: bool = False) -> np.ndarray:
    """A column of text as numbers; empty cells as not-a-number where `empty` is allowed.

    Raises
    ------
    UserError
        naming the first row whose cell is no finite number.
    """
    values = np.full(len(text), np.nan)
    for row, cell in enumerate(text):
        if not cell or cell.lower() in {"na", "nan"}:
            if not empty:
                raise UserError(
                    f"{path} has no value in column {name}, data row {row + 1}; drop the row if it was not measured"
                )
            continue
        try:
            values[row] = float(cell)
        except ValueError:
            values[row] = math.inf
        if not math.isfinite(values[row]):
            raise UserError(
                f"{path} has {cell!r} in column {name}, data row {row + 1}; expected a number with a decimal point"
            )
    return values
