"""Which runs a study makes: every combination of values, values side by side, or points spread over ranges."""

import ast
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import isfinite
from typing import Any

import numpy as np

from wearfem.errors import UserError, in_words
from wearfem.settings import UNITS, Value, parse_value

Rows = tuple[Mapping[str, Value], ...]
UNIT = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*([*/].*)")  # what follows a number: *mm
EXAMPLE = '"mesh=8,6,4*mm"'


@dataclass(frozen=True)
class Range:
    """From `low` to `high` [SI], both included."""

    low: float
    high: float

    def __post_init__(self) -> None:
        """Refuse a range without room."""
        if not (isfinite(self.low) and isfinite(self.high) and self.low < self.high):
            raise UserError(
                f"a range was given from {self.low!r} to {self.high!r}: the second must be the larger"
            )


def grid(values: Mapping[str, Sequence[Value]]) -> Rows:
    """Every combination of the values [SI] of each keyword; the last keyword changes fastest."""
    _some(values)
    return tuple(dict(zip(values, row, strict=True)) for row in product(*values.values()))


def listed(values: Mapping[str, Sequence[Value]]) -> Rows:
    """The first values [SI] of all keywords, then the second, and so on; a single value holds for all."""
    _some(values)
    count = max(len(given) for given in values.values())
    odd = [name for name, given in values.items() if len(given) not in (1, count)]
    if odd:
        raise UserError(
            f"a list was given {count} values of one keyword and another number of {in_words(odd)}: give as many, or one for all"
        )
    return tuple(
        {name: given[number % len(given)] for name, given in values.items()} for number in range(count)
    )


def sobol(
    ranges: Mapping[str, Range | Sequence[Value]], count: int, seed: int = 0, whole: Iterable[str] = ()
) -> Rows:
    """`count` points of a scrambled Sobol sequence, spread evenly over all ranges together.

    Parameters
    ----------
    ranges
        By keyword: a range [SI], or values of which each comes as often.
    count
        A power of 2, or the points would lose their balance.
    seed
        Of the scrambling: the same seed gives the same points, whatever the count.
    whole
        Keywords that take whole numbers.

    **Source** `scipy.stats.qmc.Sobol`; A. B. Owen, J. Complexity 14 (1998) 466-489 (scrambling).
    """
    from scipy.stats import qmc

    if count < 1 or count & (count - 1):
        raise UserError(f"a Sobol sequence of {count} points was asked: give a power of 2, like 16, 32 or 64")
    _some(ranges)
    unit = qmc.Sobol(len(ranges), scramble=True, rng=np.random.default_rng(seed)).random_base2(
        count.bit_length() - 1
    )
    return _spread(unit, ranges, set(whole))


def latin(
    ranges: Mapping[str, Range | Sequence[Value]], count: int, seed: int = 0, whole: Iterable[str] = ()
) -> Rows:
    """`count` points of a Latin hypercube: each range is cut into `count` equal parts, each part is met once. Parameters as in `sobol`.

    **Source** `scipy.stats.qmc.LatinHypercube`; M. D. McKay et al., Technometrics 21 (1979) 239-245.
    """
    from scipy.stats import qmc

    if count < 1:
        raise UserError(f"a Latin hypercube of {count} points was asked: give 1 or more")
    _some(ranges)
    unit = qmc.LatinHypercube(len(ranges), rng=np.random.default_rng(seed)).random(count)
    return _spread(unit, ranges, set(whole))


def _spread(unit: np.ndarray, ranges: Mapping[str, Range | Sequence[Value]], whole: set[str]) -> Rows:
    """Rows from points (n, keywords) of the unit cube."""

    def at(name: str, given: Range | Sequence[Value], u: float) -> Value:
        if not isinstance(given, Range):
            return given[int(u * len(given))]
        if name in whole:
            return int(given.low) + int(u * (int(given.high) - int(given.low) + 1))
        return float(given.low + u * (given.high - given.low))

    return tuple(
        {name: at(name, given, u) for (name, given), u in zip(ranges.items(), row, strict=True)}
        for row in unit
    )


def _some(values: Mapping[str, Any]) -> None:
    if not values:
        raise UserError(f"a study was given no keyword to vary: give one with its values, like {EXAMPLE}")


def parse_values(texts: Iterable[str]) -> dict[str, tuple[Value, ...]]:
    """Values [SI] by keyword from texts like `mesh=8,6,4*mm`: a unit after the last number holds for all that have none."""
    return {name: _values(name, text) for name, text in _by_keyword(texts).items()}


def parse_ranges(texts: Iterable[str]) -> dict[str, Range | tuple[Value, ...]]:
    """Ranges [SI] by keyword from texts like `mesh=4..8*mm`, or values as in `parse_values`."""
    found: dict[str, Range | tuple[Value, ...]] = {}
    for name, text in _by_keyword(texts).items():
        low, dots, high = text.partition("..")
        if not dots:
            found[name] = _values(name, text)
            continue
        ends = _values(name, f"{low.strip() or '?'},{high.strip() or '?'}")
        if len(ends) != 2 or not all(
            isinstance(end, int | float) and not isinstance(end, bool) for end in ends
        ):
            raise UserError(f'{name} was given "{text}", but a range needs two numbers, like {name}=4..8*mm')
        found[name] = Range(*ends)  # type: ignore[arg-type]
    return found


def _by_keyword(texts: Iterable[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for text in texts:
        keyword, equals, values = (part.strip() for part in text.partition("="))
        if not (equals and keyword.isidentifier() and values):
            raise UserError(
                f'a study was given "{text}", but it needs KEYWORD=VALUES, like {EXAMPLE} or "mesh=4..8*mm"'
            )
        if keyword in found:
            raise UserError(
                f"a study was given {keyword} twice: put all its values into one text, like {EXAMPLE}"
            )
        found[keyword] = values
    return found


def _values(keyword: str, text: str) -> tuple[Value, ...]:
    """The values of a comma list."""
    line = f"[{text}]"  # so that (1, 2) is one value and 1, 2 are two
    try:
        tree = ast.parse(line, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return (parse_value(keyword, text),)  # which tells what is wrong
    if not isinstance(tree, ast.List) or len(tree.elts) < 2:
        return (parse_value(keyword, text),)
    parts = [ast.get_source_segment(line, element) or "" for element in tree.elts]
    unit = UNIT.fullmatch(parts[-1])
    tail = unit[1] if unit and set(re.findall(r"[A-Za-z_]\w*", unit[1])) & UNITS.keys() else ""
    return tuple(parse_value(keyword, part + tail if _bare(part) else part) for part in parts)


def _bare(text: str) -> bool:
    """Whether a text is a number and nothing else."""
    try:
        float(text)
    except ValueError:
        return False
    return True
