"""What a case is, and how one is read from `cases/<name>/case.py`.

A case is Python: one function `case(*, keyword=default, ...) -> Case` whose keyword arguments are in SI. It
says what flows, on what, for how long, by which law the liner wears, and which figures come out.
"""

import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from wearfem.errors import UserError, in_words
from wearfem.settings import Value, check_settings, did_you_mean

if TYPE_CHECKING:
    from wearfem.dem.flow import Flow, Model
    from wearfem.loads import FacetLoads
    from wearfem.wear.laws import WearLaw

Result = TypeVar("Result")


@dataclass(frozen=True)
class Window:
    """A stretch of simulated time.

    Parameters
    ----------
    duration
        How long [s].
    block_count
        In how many equal time blocks the facet loads are summed; they give the standard error of the mean.
    snapshots
        How many states of the flow to keep, equally spaced, the last one at the end.
    """

    duration: float
    block_count: int = 1
    snapshots: int = 0

    def __post_init__(self) -> None:
        """Refuse a window in which nothing can happen."""
        if not self.duration > 0:
            raise UserError(f"a window was given a duration of {self.duration} s: it must be above 0 s")
        if self.block_count < 1 or self.snapshots < 0:
            raise UserError(
                f"a window was given {self.block_count} blocks and {self.snapshots} snapshots: "
                "it needs at least 1 block and 0 snapshots"
            )


@dataclass(frozen=True)
class Stage:
    """One part of a case: the same flow goes from stage to stage, under each stage's own model.

    Parameters
    ----------
    name
        A word that the report and the record use, unique in its case.
    model
        What acts on the flow: contact laws, surfaces and their motion, gravity, inlets.
    window
        The time to simulate, at most.
    until
        Ends the stage as soon as it holds for the flow, for instance when everything has settled.
    """

    name: str
    model: "Model"
    window: Window
    until: "Callable[[Flow], bool] | None" = None


@dataclass(frozen=True)
class StageOutcome:
    """What one stage left: the flow at its end, the loads on the surface, and the flows kept on the way."""

    stage: Stage
    flow: "Flow"
    loads: "FacetLoads"
    snapshots: "tuple[Flow, ...]" = ()


@dataclass(frozen=True)
class Outcome:
    """What a run left, stage by stage: `outcome["slide"].loads`, `outcome.flow` at the end."""

    stages: tuple[StageOutcome, ...]

    def __getitem__(self, name: str) -> StageOutcome:
        """The outcome of the stage of this name."""
        return {outcome.stage.name: outcome for outcome in self.stages}[name]

    @property
    def flow(self) -> "Flow":
        """The flow at the end of the last stage."""
        return self.stages[-1].flow


@dataclass(frozen=True)
class Figure:
    """A number that a case reports, beside what was expected.

    Parameters
    ----------
    name
        What it is, in words.
    value
        What was computed [unit].
    unit
        The unit of value, expected and tolerance; "-" for a pure number.
    expected
        What it ought to be [unit], where that is known.
    source
        Where the expectation comes from: paper and table, or formula.
    tolerance
        The largest difference from the expectation that still agrees [unit].
    """

    name: str
    value: float
    unit: str
    expected: float | None = None
    source: str = ""
    tolerance: float | None = None

    @property
    def verdict(self) -> str:
        """`agrees`, `differs`, or `reported` where nothing was promised."""
        if self.expected is None or self.tolerance is None:
            return "reported"
        return "agrees" if abs(self.value - self.expected) <= self.tolerance else "differs"


@dataclass(frozen=True)
class Case:
    """Everything a run needs.

    Parameters
    ----------
    name
        A word; the run folder is named after it.
    flow
        The particles and their contacts at the start.
    stages
        What happens to the flow, one stage after the other.
    wear_law
        Turns facet loads into a rate of depth; None where nothing wears. `surface.vtkhdf` shows the depth of the last stage.
    measure
        Turns what the run left into the figures that the case reports.
    notes
        Sentences that a reader of the figures must know.
    draw
        Draws the case's own pictures into a folder: `draw(outcome, folder)`.
    files
        Files that the case has read (meshes, tables); the manifest keeps their hashes.
    settings
        The resolved keywords [SI]; filled in by `load_case`.
    folder
        Where the case came from; filled in by `load_case`.
    """

    name: str
    flow: "Flow"
    stages: tuple[Stage, ...]
    wear_law: "WearLaw | None"
    measure: Callable[[Outcome], tuple[Figure, ...]]
    notes: tuple[str, ...] = ()
    draw: Callable[[Outcome, Path], None] | None = None
    files: tuple[Path, ...] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)
    folder: Path | None = None

    def __post_init__(self) -> None:
        """Refuse a case without stages, or with two stages of one name."""
        names = [stage.name for stage in self.stages]
        if not names or len(set(names)) < len(names):
            raise UserError(
                f"case {self.name} has the stages {in_words(names)}: it needs some, each with its own name"
            )


def load_case(folder: Path, settings: Mapping[str, Value] | None = None) -> Case:
    """The case of a folder, built with the given keywords [SI].

    Every mistake in the folder, in the case file or in the keywords is a `UserError`.
    """
    file = find_case(folder)
    build, signature = _case_function(file)
    keywords = check_settings(settings or {}, signature, file.parent.name)
    case = _in_users_file(file, lambda: build(**keywords))
    if not isinstance(case, Case):
        raise UserError(
            f"case() in {file} returned {type(case).__name__}, but it must return a wearfem.case.Case"
        )
    return replace(case, settings=keywords, folder=file.parent)


def find_case(folder: Path) -> Path:
    """The `case.py` of a folder (or of the path to the file itself)."""
    file = folder if folder.name == "case.py" else folder / "case.py"
    if file.is_file():
        return file.resolve()
    existing = sorted(
        {str(path) for place in (file.parent.parent, Path("cases")) for path in _cases_in(place)}
    )
    problem = f"{folder} has no file case.py" if folder.is_dir() else f"there is no case {folder}"
    advice = (
        f"the cases here are {in_words(existing)}"
        if existing
        else "give the path of a folder that holds a case.py"
    )
    raise UserError(f"{problem}{did_you_mean(str(folder), existing)}; {advice}")


def _cases_in(place: Path) -> list[Path]:
    try:
        return [path.parent for path in place.glob("*/case.py")]
    except OSError:
        return []


def _case_function(file: Path) -> tuple[Callable[..., Any], inspect.Signature]:
    """The function `case` of a file, and its signature with the annotations evaluated."""
    module = _in_users_file(file, lambda: _import(file))
    build = getattr(module, "case", None)
    if not inspect.isfunction(build):
        raise UserError(f"{file} has no function case: write `def case(*, keyword=value) -> Case` in it")
    signature = _in_users_file(file, lambda: inspect.signature(build, eval_str=True))
    for parameter in signature.parameters.values():
        if parameter.kind is not parameter.KEYWORD_ONLY or parameter.default is parameter.empty:
            raise UserError(
                f"{parameter.name} of case() in {file} must be keyword-only with a default: "
                f"write `def case(*, {parameter.name}=...)`"
            )
    return build, signature


def _import(file: Path) -> ModuleType:
    """The module of a file, under a name of its own."""
    name = f"wearfem_case_{file.parent.name}_{sha256(str(file).encode()).hexdigest()[:8]}"
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None and spec.loader is not None  # it is a .py file
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _in_users_file(file: Path, work: Callable[[], Result]) -> Result:
    """The result of `work`; an error in the user's lines becomes a sentence, one inside wearfem stays."""
    try:
        return work()
    except UserError:
        raise
    except SyntaxError as error:
        raise UserError(
            f"{error.filename} line {error.lineno} is not Python ({error.msg}): correct it"
        ) from error
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        if Path(last.filename) != file:
            raise
        raise UserError(f"{file} line {last.lineno} fails: {type(error).__name__}: {error}") from error
