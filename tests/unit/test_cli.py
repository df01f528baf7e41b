"""The command line: what it imports, what it passes on, and how it ends."""

import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from wearfem import cli
from wearfem.errors import UserError

HEAVY = ("numba", "numpy", "scipy", "skfem", "h5py", "gmsh", "pyvista", "matplotlib", "rich")


def test_help_imports_nothing_heavy():
    script = """
import json, sys
from wearfem.cli import main
try:
    main()
finally:
    print(json.dumps(sorted(sys.modules)), file=sys.stderr)
"""
    done = subprocess.run(
        [sys.executable, "-c", script, "--help"], capture_output=True, text=True, check=True
    )
    assert {"run", "check", "verify", "bench", "study"} <= set(done.stdout.split())
    assert set(HEAVY).isdisjoint(json.loads(done.stderr.splitlines()[-1]))


@pytest.fixture
def wearfem(monkeypatch, capsys):
    """Run the command line in this process: `wearfem("run", "cases/x")` gives code, out and err."""

    def call(*arguments: str) -> SimpleNamespace:
        monkeypatch.setattr(sys, "argv", ["wearfem", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        captured = capsys.readouterr()
        return SimpleNamespace(code=ended.value.code, out=captured.out, err=captured.err)

    return call


@pytest.fixture
def stand_in(monkeypatch):
    """Put a function in the place of `wearfem.<module>.<name>`."""

    def put(module: str, name: str, function) -> None:
        stub = ModuleType(f"wearfem.{module}")
        setattr(stub, name, function)
        monkeypatch.setitem(sys.modules, f"wearfem.{module}", stub)

    return put


def raising(error):
    def function(*_):
        raise error

    return function


def test_run_passes_on_what_it_was_given(wearfem, stand_in):
    calls = []
    stand_in("run", "run_case", lambda *arguments: calls.append(arguments))
    result = wearfem(
        "run", "cases/x", "--set", "force=3*kN", "--set", "seed=2", "--out", "o", "--json", "f", "--quiet"
    )
    assert result.code == 0
    assert calls == [(Path("cases/x"), {"force": 3000.0, "seed": 2}, Path("o"), Path("f"), True)]


@pytest.mark.parametrize(("status", "code"), [("done", 0), ("failed", 1)])
def test_study_passes_on_what_it_was_given(wearfem, stand_in, status, code):
    calls = []

    def study(case, plan, out, **options):
        calls.append((case, plan, out, options))
        return (SimpleNamespace(status=status),)

    stand_in("study", "study", study)
    sys.modules["wearfem.study"].planned = lambda *arguments: arguments
    sys.modules["wearfem.study"].dask_executor = raising(AssertionError("no scheduler was given"))
    words = "study cases/x --grid a=1,2 b=3,4*mm --set seed=2 --size a --size b --out o --workers 2 --retry --json f --quiet"
    assert wearfem(*words.split()).code == code
    options = {
        "executor": None,
        "workers": 2,
        "sizes": ("a", "b"),
        "retry": True,
        "json_file": Path("f"),
        "quiet": True,
    }
    plan = (Path("cases/x"), ("a=1,2", "b=3,4*mm"), {"seed": 2}, False, None, None, 0)
    assert calls == [(Path("cases/x"), plan, Path("o"), options)]


def test_a_users_mistake_is_one_sentence_and_code_2(wearfem, stand_in):
    stand_in("run", "run_case", raising(UserError("there is no case x; the cases here are none")))
    result = wearfem("run", "x")
    assert (result.code, result.err) == (2, "wearfem: there is no case x; the cases here are none.\n")


def test_a_malformed_setting_is_code_2(wearfem, stand_in):
    stand_in("run", "run_case", raising(AssertionError("must not be reached")))
    result = wearfem("run", "x", "--set", "force")
    assert result.code == 2
    assert result.err.startswith('wearfem: --set was given "force"')


@pytest.mark.parametrize("arguments", [("rnu",), ("run",), ("run", "x", "--outt", "y"), ("run", "x", "y")])
def test_a_malformed_command_is_one_sentence_and_code_2(wearfem, arguments):
    result = wearfem(*arguments)
    assert result.code == 2
    assert result.err.startswith("wearfem: ") and result.err.count("\n") == 1


def test_an_interrupt_is_a_sentence_and_code_130(wearfem, stand_in):
    stand_in("run", "run_case", raising(KeyboardInterrupt()))
    result = wearfem("run", "x")
    assert result.code == 130
    assert result.err.strip() == "wearfem: interrupted; what was written so far is whole."


def test_a_bug_keeps_its_traceback(monkeypatch, stand_in):
    stand_in("run", "run_case", raising(ZeroDivisionError()))
    monkeypatch.setattr(sys, "argv", ["wearfem", "run", "x"])
    with pytest.raises(ZeroDivisionError):
        cli.main()


@pytest.mark.parametrize(("passed", "code"), [(True, 0), (False, 1)])
def test_verify_ends_by_its_verdict(wearfem, stand_in, passed, code):
    stand_in("verify", "verify", lambda names, json_file: passed)
    assert wearfem("verify", "impacts").code == code


def test_no_words_show_the_help(wearfem):
    result = wearfem()
    assert result.code == 0
    assert "Usage: wearfem" in result.out
