"""A case written as a file: another case, with its wear law scaled and effects added. What `wearfem run` and `wearfem check` take."""

import inspect
import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from wearfem.case import LifeCase, case_keywords
from wearfem.errors import UserError
from wearfem.record import whole_file
from wearfem.wear.effect import Effect
from wearfem.wear.laws import Scaled


def with_effects(
    plain: LifeCase, factor: float, effects: Sequence[Effect], stop: float = math.inf
) -> LifeCase:
    """A case with its wear law scaled and effects added to those that it has.

    Parameters
    ----------
    plain
        The case as it is. What it expects of its figures was meant for it alone, and is left out.
    factor
        [-] coefficient of wear over that of the case.
    effects
        What is added, after the case's own.
    stop
        Service time [s] at which to stop, where it comes before the case's own.
    """
    return replace(
        plain,
        name=f"{plain.name}_improved",
        wear_law=Scaled(plain.wear_law, factor),
        effects=(*plain.effects, *effects),
        stop=replace(plain.stop, service_time=min(stop, plain.stop.service_time)),
        measure=lambda history: tuple(
            replace(figure, expected=None, source="", tolerance=None) for figure in plain.measure(history)
        ),
        files=(*plain.files, *([plain.folder / "case.py"] if plain.folder else [])),
    )


def write_case(
    folder: Path,
    original: Path,
    settings: Mapping[str, Any],
    factor: float,
    effects: Sequence[Effect],
    story: str,
    stop: float = math.inf,
) -> Path:
    """Write `case.py` into a folder: the original case with other keywords as its defaults, its law scaled, effects added.

    Parameters
    ----------
    folder
        Made if it is not there.
    original
        Folder of the case that is loaded.
    settings
        Keywords [SI] that become the defaults.
    factor, effects, stop
        See `with_effects`.
    story
        Where all this comes from: the docstring of the file.

    Returns
    -------
    Path
        Of the file.

    Raises
    ------
    UserError
        where the folder holds another case: nothing is written over.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"{folder} cannot be made ({error.strerror}); give --out another folder") from error
    text = _text(folder.resolve(), original.resolve(), settings, factor, effects, story, stop)
    file = folder / "case.py"
    if file.exists() and file.read_text(encoding="utf-8") != text:
        raise UserError(
            f"{file} is another case than the one that would be written now (another survey, run or version, or a change by hand); give "
            "--out a new folder, nothing was changed"
        )
    with whole_file(file) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return file


def _text(
    folder: Path,
    original: Path,
    settings: Mapping[str, Any],
    factor: float,
    effects: Sequence[Effect],
    story: str,
    stop: float,
) -> str:
    keywords = case_keywords(original).parameters
    value = {name: settings.get(name, parameter.default) for name, parameter in keywords.items()}
    shown = [f"{name}{_annotation(p)} = {_python(value[name])}," for name, p in keywords.items()]
    classes = {type(effect).__name__ for effect in effects}
    logged = any(getattr(effect, "log", None) is not None for effect in effects)
    imports = [
        *(["from math import inf"] if any(v in (math.inf, -math.inf) for v in value.values()) else []),
        "from pathlib import Path",
        *(["from typing import Literal"] if any(": Literal" in line for line in shown) else []),
        "",
        "from wearfem.case import LifeCase, load_any_case",
        "from wearfem.case_file import with_effects",
        *(["from wearfem.wear.effect import Log"] if logged else []),
        *([f"from wearfem.wear.effects import {', '.join(sorted(classes))}"] if classes else []),
    ]
    listed = "".join(f"\n    {_python(effect)}," for effect in effects)
    return "\n".join(
        [
            '"""' + story.replace("\\", "/").replace('"""', "'''").strip(),
            '"""',
            "",
            *imports,
            "",
            f"ORIGINAL = Path(__file__).parent / {_python(os.path.relpath(original, folder))}",
            f"FACTOR = {factor!r}  # [-] coefficient of wear over that of the original",
            f"EFFECTS = ({listed}\n)  # in SI" if effects else "EFFECTS = ()",
            *([] if stop == math.inf else [f"STOP = {_python(stop)}  # [s] of service"]),
            "",
            "",
            "def case(",
            *(["    *,"] if shown else []),
            *(f"    {line}" for line in shown),
            ") -> LifeCase:",
            '    """The original with what the survey asked for; its keywords, with those of the run as defaults."""',
            "    plain = load_any_case(ORIGINAL, locals())  # all keywords go to the original",
            f"    return with_effects(plain, FACTOR, EFFECTS{'' if stop == math.inf else ', STOP'})",
            "",
        ]
    )


def _annotation(parameter: inspect.Parameter) -> str:
    """As it is written, where that needs no import but of Literal."""
    told = parameter.annotation
    if get_origin(told) is Literal:
        return f": Literal[{', '.join(map(_python, get_args(told)))}]"
    return f": {told.__name__}" if told in (bool, int, float, str, tuple) else ""


def _python(value: Any) -> str:
    """A value as an expression: numbers, texts, tuples, and dataclasses of them by their fields that are not the default."""
    match value:
        case str():
            return json.dumps(value, ensure_ascii=False)
        case bool() | None:
            return repr(value)
        case int() | float():
            return repr(float(value) if isinstance(value, float) else int(value))
        case tuple() | list():
            inner = ", ".join(map(_python, value))
            return f"({inner},)" if len(value) == 1 else f"({inner})"
        case _ if is_dataclass(value) and not isinstance(value, type):
            told = {f.name: getattr(value, f.name) for f in fields(value) if f.init}
            default = {f.name: f.default for f in fields(value)}
            given = [f"{n}={_python(v)}" for n, v in told.items() if v is not default[n] and v != default[n]]
            return f"{type(value).__name__}({', '.join(given)})"
    raise UserError(f"{value!r} is a {type(value).__name__}, which cannot be written as a line of a case")
