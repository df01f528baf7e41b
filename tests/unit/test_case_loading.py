"""Cases are found, imported and built, or refused in a sentence that lists what exists."""

from pathlib import Path

import pytest

from wearfem.case import Case, Figure, Stage, Window, load_case
from wearfem.errors import UserError

GOOD = """
from wearfem.case import Case, Figure, Stage, Window

def case(*, force: float = 5.0, seed: int = 1) -> Case:
    stages = (Stage("slide", None, Window(1.0)),)
    return Case("good", None, stages, None, lambda outcome: (Figure("force", force, "N"),))
"""


@pytest.fixture
def cases(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path / "cases"


def write(folder: Path, text: str) -> Path:
    folder.mkdir(parents=True)
    (folder / "case.py").write_text(text)
    return folder


def test_a_case_is_built_with_its_settings(cases):
    folder = write(cases / "good", GOOD)
    case = load_case(folder, {"force": 6})
    assert case.settings == {"force": 6.0, "seed": 1}
    assert case.folder == folder
    assert case.measure(None)[0].value == 6.0
    assert load_case(folder / "case.py").settings["force"] == 5.0


def test_two_cases_of_one_name_do_not_mix(cases, tmp_path):
    first = write(cases / "good", GOOD)
    second = write(tmp_path / "other" / "good", GOOD.replace("5.0", "7.0"))
    assert [load_case(folder).settings["force"] for folder in (first, second, first)] == [5.0, 7.0, 5.0]


@pytest.mark.parametrize("given", ["cases/goood", "good", "elsewhere/good"])
def test_a_missing_case_lists_those_that_exist(cases, given):
    write(cases / "good", GOOD)
    with pytest.raises(UserError, match=f"there is no case {given}.*the cases here are cases/good"):
        load_case(Path(given))


def test_a_folder_without_a_case_file_is_refused(cases):
    (cases / "empty").mkdir(parents=True)
    with pytest.raises(UserError, match=r"cases/empty has no file case.py; give the path of a folder"):
        load_case(Path("cases/empty"))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x = 1", "has no function case"),
        ("case = 3", "has no function case"),
        ("def case(force=5.0): ...", "force of case.. .* must be keyword-only with a default"),
        ("def case(*, force): ...", "force of case.. .* must be keyword-only with a default"),
        ("def case(**anything): ...", "anything of case.. .* must be keyword-only"),
        ("def case(*, force=5.0): return 3", "returned int, but it must return a wearfem.case.Case"),
        ("def case(:\n", "case.py line 1 is not Python"),
        ("\nimport no_such_module", "case.py line 2 fails: ModuleNotFoundError: No module named"),
        ("def case():\n    return 1 / 0", "case.py line 2 fails: ZeroDivisionError"),
        (GOOD.replace("Window(1.0)", "Window(0.0)"), "duration of 0.0 s: it must be above 0 s"),
        (
            GOOD.replace("(Stage", "2 * (Stage"),
            "stages slide and slide: it needs some, each with its own name",
        ),
    ],
)
def test_a_faulty_case_file_is_told_in_a_sentence(cases, text, expected):
    folder = write(cases / "faulty", text)
    with pytest.raises(UserError, match=expected):
        load_case(folder)


def test_an_unknown_keyword_lists_the_keywords(cases):
    folder = write(cases / "good", GOOD)
    with pytest.raises(UserError, match="good has no keyword forse.*force=5, seed=1"):
        load_case(folder, {"forse": 6.0})


@pytest.mark.parametrize(
    ("value", "expected", "tolerance", "verdict"),
    [
        (5.0, 5.1, 0.2, "agrees"),
        (5.0, 5.1, 0.05, "differs"),
        (float("nan"), 5.1, 0.2, "differs"),
        (5.0, None, None, "reported"),
        (5.0, 5.1, None, "reported"),
    ],
)
def test_a_figure_knows_its_verdict(value, expected, tolerance, verdict):
    assert Figure("f", value, "N", expected, "hand", tolerance).verdict == verdict


def test_a_case_needs_a_stage():
    with pytest.raises(UserError, match="stages none"):
        Case("c", None, (), None, lambda outcome: ())
    assert Case("c", None, (Stage("s", None, Window(1.0)),), None, lambda outcome: ()).notes == ()
