"""The arrows of the architecture, held as data: who may import whom, and what a file may be."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "src" / "wearfem"

# From the top to the ground. A part imports from its own line and from the lines below it.
LAYERS = (
    {"cli"},
    {"verify", "bench", "check", "measured"},
    {"proofs"},
    {"benchmarks"},
    {"report_page", "diagnosis_page"},
    {"foretell"},
    {"forecast"},
    {"report_facts", "report_drawings", "diagnosis_drawings"},
    {"report", "report_particles", "study", "study_results", "verification"},
    {"improve_words"},
    {"improve"},
    {"exposure"},
    {"run"},
    {"case_file"},
    {"pictures", "record_mesh"},
    {"render"},
    {"life"},
    {"sharpness"},
    {"history", "record", "cycle", "formula", "values", "progress"},
    {"known"},
    {"case"},
    {"plan"},
    {"settings"},
    {"dem", "liner", "wear", "survey"},
    {"surface_file"},
    {"surface", "loads", "material", "slope"},
    {"vector", "units", "jit", "errors", "proof", "edges", "convergence", "costs", "page"},
)
SIBLINGS = {"dem", "liner", "wear", "survey"}  # never import one another ...
SIBLING_ARROWS = {("survey", "wear")}  # ... except here

ALONE = {"verification"}  # what the engine is measured against owes nothing to it

# Who may import these packages; a folder ends with a slash.
ONLY_IN = {
    "numba": ("jit.py", "dem/gpu.py"),
    "skfem": ("liner/", "wear/smooth.py"),
    "matplotlib": ("report.py", "report_particles.py", "pictures.py", "render.py", "report_drawings.py"),
    "jinja2": ("page/",),
    "pyvista": ("report.py", "render.py"),
    "click": ("cli.py",),
    "distributed": ("study.py",),
    "rich": ("progress.py", "report.py", "run.py", "check.py", "verify.py", "bench.py"),
}
ONLY_INSIDE_FUNCTIONS = {"matplotlib", "pyvista", "gmsh", "distributed", "jinja2"}
FORBIDDEN_NAMES = {"utils.py", "util.py", "helpers.py", "base.py", "common.py", "misc.py"}
LONGEST_FILE = 500  # lines

FILES = sorted(PACKAGE.rglob("*.py"))


def where(file: Path) -> str:
    return file.relative_to(PACKAGE).as_posix()


def part(file: Path) -> str:
    """The name in LAYERS that a file belongs to; empty for the package itself."""
    first = Path(where(file)).parts[0].removesuffix(".py")
    return "" if first == "__init__" else first


def layer(name: str) -> int:
    places = [number for number, names in enumerate(LAYERS) if name in names]
    assert places, f"{name} has no place in LAYERS: put it there, or better into a part that exists"
    return places[0]


def is_type_checking(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")


def imports(node: ast.AST, file: Path, inside_function: bool = False) -> list[tuple[str, bool]]:
    """All imported modules by full name, and whether inside a function; not those for the type checker."""
    if is_type_checking(node):
        return []
    found = []
    if isinstance(node, ast.Import):
        found = [(alias.name, inside_function) for alias in node.names]
    elif isinstance(node, ast.ImportFrom):
        found = [(name, inside_function) for name in imported_from(node, file)]
    inside_function |= isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
    for child in ast.iter_child_nodes(node):
        found += imports(child, file, inside_function)
    return found


def imported_from(node: ast.ImportFrom, file: Path) -> list[str]:
    """The modules that a `from ... import ...` names; `from wearfem import units` names `wearfem.units`."""
    base = node.module or ""
    if node.level:
        package = ["wearfem", *Path(where(file)).parts][: -node.level]
        base = ".".join([*package, base]).rstrip(".")
    if base == "wearfem":
        return [f"wearfem.{alias.name}" for alias in node.names]
    return [base]


def parts_imported(file: Path) -> set[str]:
    """The parts of wearfem that a file imports, other than its own."""
    names = [name.split(".") for name, _ in imports(ast.parse(file.read_text()), file)]
    found = {words[1] for words in names if words[0] == "wearfem" and len(words) > 1}
    return {name for name in found if not name.startswith("__")} - {part(file)}


def test_there_is_something_to_hold():
    assert len(FILES) > 5


@pytest.mark.parametrize("file", FILES, ids=where)
def test_imports_run_one_way(file):
    own = part(file)
    imported = parts_imported(file)
    if not own:
        assert not imported, "wearfem/__init__.py holds the version and imports nothing"
        return
    assert own not in ALONE or not imported, f"{where(file)} imports {sorted(imported)}"
    for name in imported:
        assert layer(name) >= layer(own), f"{where(file)} imports {name}, which lies above it"
        if {own, name} <= SIBLINGS:
            assert (own, name) in SIBLING_ARROWS, f"{where(file)} imports its sibling {name}"


def test_no_circle():
    arrows = {part(file): set() for file in FILES}
    for file in FILES:
        arrows[part(file)] |= parts_imported(file)
    while leaves := {name for name, targets in arrows.items() if not targets & arrows.keys()}:
        arrows = {name: targets for name, targets in arrows.items() if name not in leaves}
    assert not arrows, f"these import one another in a circle: {sorted(arrows)}"


@pytest.mark.parametrize("file", FILES, ids=where)
def test_packages_stay_in_their_place(file):
    for name, inside_function in imports(ast.parse(file.read_text()), file):
        package = name.split(".")[0]
        places = ONLY_IN.get(package)
        allowed = places is None or any(
            where(file).startswith(place) if place.endswith("/") else where(file) == place for place in places
        )
        assert allowed, f"{where(file)} imports {package}, which belongs in {places}"
        if package in ONLY_INSIDE_FUNCTIONS:
            assert inside_function, f"{where(file)} imports {package} at its top; import it in the function"


@pytest.mark.parametrize("file", FILES, ids=where)
def test_a_file_is_short_and_says_what_it_is(file):
    assert file.name not in FORBIDDEN_NAMES, f"{where(file)}: name it after what it holds"
    assert len(file.read_text().splitlines()) <= LONGEST_FILE
    assert ast.get_docstring(ast.parse(file.read_text())), f"{where(file)} has no docstring"


def mutable(value: ast.expr | None) -> bool:
    if isinstance(value, ast.Call):
        return ast.unparse(value.func) in {
            "list",
            "dict",
            "set",
            "bytearray",
            "defaultdict",
            "deque",
            "Counter",
        }
    return isinstance(value, ast.List | ast.Dict | ast.Set | ast.ListComp | ast.DictComp | ast.SetComp)


@pytest.mark.parametrize("file", FILES, ids=where)
def test_no_state_at_module_level(file):
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and mutable(node.value):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            for name in (ast.unparse(target) for target in targets):
                assert name.isupper() or name == "__all__", f"{where(file)}: {name} is state at module level"
    for node in ast.walk(ast.parse(file.read_text())):
        assert not isinstance(node, ast.Global), (
            f"{where(file)} changes {getattr(node, 'names', '')} of the module"
        )


def test_the_rules_see_what_they_forbid():
    source = (
        "import numba\nfrom wearfem.run import x\nfrom . import jit\ndef f():\n    import pyvista as pv\n"
    )
    found = imports(ast.parse(source), PACKAGE / "dem" / "forces.py")
    assert found == [
        ("numba", False),
        ("wearfem.run", False),
        ("wearfem.dem", False),
        ("pyvista", True),
    ]
    assert mutable(ast.parse("a = {}").body[0].value)
    assert layer("run") < layer("dem")
