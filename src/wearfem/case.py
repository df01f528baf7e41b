"""What a case is, and how one is read from `cases/<name>/case.py`.

A case is Python: one function `case(*, keyword=default, ...)` whose keyword arguments are in SI. It says what flows, on what, by which
law the liner wears, and which figures come out. A `Case` is simulated in stages, over a geometry that stays; a `LifeCase` in cycles, in
which the liner wears away under the flow until it is worn out.
"""

import importlib.util
import inspect
import math
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
    from wearfem.cycle import Sampler
    from wearfem.dem.flow import Flow, Model
    from wearfem.history import History
    from wearfem.liner.liner import Liner
    from wearfem.liner.solve import Structure
    from wearfem.loads import FacetLoads
    from wearfem.wear.effect import Effect
    from wearfem.wear.jump import Goal
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


@dataclass(frozen=True)
class Stop:
    """When a life is not followed any further. It always ends when the goal is met: the first facet is worn out.

    Parameters
    ----------
    service_time
        Stop at this service time [s] of the liner, where it comes first.
    breakthrough
        Stop where the liner wears through; else the hole is opened and the life goes on around it.
    """

    service_time: float = math.inf
    breakthrough: bool = True


@dataclass(frozen=True)
class LifeCase:
    """Everything that the life of a liner needs: it is sampled, worn and sampled again, cycle by cycle.

    Parameters
    ----------
    name
        A word; the run folder is named after it.
    flow
        What moves over the liner, at the start: a `Flow` of particles, or what another sampler takes.
    sampler
        Samples the flow over the worn face as it is: `wearfem.cycle.Particles(model)`, `model` being a function from the worn face to a
        `Model`; or a formula.
    liner
        As it is at the start.
    wear_law, effects
        The rate of depth from facet loads, and what makes it differ from the law's.
    goal
        When the liner is worn out, and how well that time is to be known; see `wearfem.cycle.worn_to`.
    window
        The first sample of steady flow; later ones are as long as they must be, in blocks of the same length.
    warm_up
        What to throw away of the first sample at least [s]; later samples throw away no less. More is found by itself.
    throughput_rate
        Mass that passes in one second of service [kg/s].
    smoothing_length
        Of the Helmholtz filter over the rate of depth [m]; 0 for none.
    particle_radius
        Of the smallest particle [m], which a jump stays well below.
    longest_jump
        In service time [s].
    structure
        What holds the liner; None where its strength does not matter.
    element_size
        Edge length [m] of new elements where worn-out ones are replaced; the mean of the worn facets without it.
    stop
        When to stop before the liner is worn out.
    frozen
        Keep the geometry as it is new, to see what its change does: depth goes on, the surface does not move.
    measure
        Turns the history of the run into the figures that the case reports.
    notes, draw, files, settings, folder
        As in `Case`; `draw(history, folder)`.
    """

    name: str
    flow: Any
    sampler: "Sampler"
    liner: "Liner"
    wear_law: "WearLaw"
    goal: "Goal"
    window: Window
    warm_up: float = 0.0
    throughput_rate: float = 0.0
    effects: "tuple[Effect, ...]" = ()
    smoothing_length: float = 0.0
    particle_radius: float = math.inf
    longest_jump: float = math.inf
    structure: "Structure | None" = None
    element_size: float | None = None
    stop: Stop = field(default_factory=Stop)
    frozen: bool = False
    measure: "Callable[[History], tuple[Figure, ...]]" = lambda history: ()
    notes: tuple[str, ...] = ()
    draw: "Callable[[History, Path], None] | None" = None
    files: tuple[Path, ...] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)
    folder: Path | None = None

    def __post_init__(self) -> None:
        """Refuse numbers with which no cycle can be run."""
        facets = len(self.liner.mesh.wear)
        if self.goal.allowed_depth.shape != (facets,):
            raise UserError(
                f"case {self.name} allows depths of shape {self.goal.allowed_depth.shape}, but its liner wears on {facets} facets: "
                "give one for each, in their order"
            )
        for name, unit in (("warm_up", "s"), ("throughput_rate", "kg/s"), ("smoothing_length", "m")):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise UserError(
                    f"case {self.name} has {name} = {getattr(self, name)!r} {unit}: it must be 0 or more"
                )
        for name, unit in (("particle_radius", "m"), ("longest_jump", "s")):
            if not getattr(self, name) > 0.0:
                raise UserError(
                    f"case {self.name} has {name} = {getattr(self, name)!r} {unit}: it must be above 0"
                )
        for effect in self.effects:
            if not hasattr(effect, "needs"):
                raise UserError(
                    f"case {self.name} has the effect {type(effect).__name__}, which does not say what it needs: give it `needs`, a tuple "
                    "of names of features such as depth or pressure, empty where it needs none; effects of the flow act before smoothing"
                )
        if not self.stop.service_time > self.liner.service_time:
            raise UserError(
                f"case {self.name} stops at {self.stop.service_time:g} s of service, but its liner has served {self.liner.service_time:g} s"
            )


def load_case(folder: Path, settings: Mapping[str, Value] | None = None) -> Case:
    """The case of a folder, built with the given keywords [SI].

    Every mistake in the folder, in the case file or in the keywords is a `UserError`; so is a case that runs in cycles.
    """
    case = load_any_case(folder, settings)
    if isinstance(case, LifeCase):
        raise UserError(
            f"{case.name} is the life of a liner in cycles, and this is only for cases in stages: use wearfem run"
        )
    return case


def load_any_case(folder: Path, settings: Mapping[str, Value] | None = None) -> Case | LifeCase:
    """The case of a folder, in stages or in cycles, built with the given keywords [SI]."""
    file = find_case(folder)
    build, signature = _case_function(file)
    keywords = check_settings(settings or {}, signature, file.parent.name)
    case = _in_users_file(file, lambda: build(**keywords))
    if not isinstance(case, Case | LifeCase):
        raise UserError(
            f"case() in {file} returned {type(case).__name__}, but it must return a wearfem.case.Case or LifeCase"
        )
    return replace(case, settings=keywords, folder=file.parent)


def case_keywords(folder: Path) -> inspect.Signature:
    """The keywords of a case with their defaults [SI]."""
    return _case_function(find_case(folder))[1]


def parts_of(folder: Path) -> ModuleType:
    """What the case file of a folder defines, so that another case can be built from its parts.

    Name that file among the `files` of the case that uses it: the manifest then keeps its hash too.

    Raises
    ------
    UserError
        where the folder has no case, or its file fails.
    """
    file = find_case(folder)
    return _in_users_file(file, lambda: _import(file))


def find_case(folder: Path) -> Path:
    """The `case.py` of a folder (or of the path to the file itself)."""
    file = folder if folder.name == "case.py" else folder / "case.py"
    try:
        if file.is_file():
            return file.resolve()
    except OSError as error:
        raise UserError(f"{file} cannot be read ({error.strerror}): make its folder readable") from error
    existing = sorted(
        {str(path) for place in (file.parent.parent, Path("cases")) for path in _cases_in(place)}
    )
    if surveys := _surveys_in(folder):
        raise UserError(
            f"{folder} has no file case.py: it holds a survey, and nothing to run; give wearfem diagnose {surveys[0]}"
        )
    problem = f"{folder} has no file case.py" if folder.is_dir() else f"there is no case {folder}"
    advice = (
        f"the cases here are {in_words(existing)}"
        if existing
        else "give the path of a folder that holds a case.py"
    )
    raise UserError(f"{problem}{did_you_mean(str(folder), existing)}; {advice}")


def _surveys_in(folder: Path) -> list[Path]:
    """Surveys (CSV) of a folder or of its `measured`"""
    if folder.suffix.lower() == ".csv" and folder.is_file():
        return [folder]
    return sorted([*folder.glob("*.csv"), *folder.glob("measured/*.csv")]) if folder.is_dir() else []


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
