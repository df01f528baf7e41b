"""Scripts of cases: a mistake of the user is one sentence, and what they have measured before is not written over."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

CASES = Path(__file__).parents[2] / "cases"
SCRIPTS = sorted(
    path for path in CASES.glob("*/*.py") if path.name != "case.py" and "__main__" in path.read_text()
)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_each_ends_in_a_sentence(script):
    last = ast.unparse(ast.parse(script.read_text()).body[-1])
    assert last == "if __name__ == '__main__':\n    with in_a_sentence(__file__):\n        main()"


@pytest.mark.parametrize(
    ("script", "given", "sentence"),
    [
        ("bionic_chute/where.py", ["{empty}"], "where.py: {empty} holds no life of this chute"),
        ("bionic_chute/decay.py", ["{empty}", "--table"], "decay.py: {empty} holds no life"),
        ("transfer_chute/hidden.py", ["--only", "gradient"], "hidden.py: --only was given gradient: give one of"),
        ("transfer_chute/shortcuts.py", ["--worn", "{empty}"], "shortcuts.py: {empty} has no cycle yet"),
    ],
)  # fmt: skip
def test_what_is_no_run_is_a_sentence_and_results_stay(script, given, sentence, tmp_path):
    place = CASES / script
    results = place.with_suffix(".json")
    before = results.read_bytes()
    words = [word.format(empty=tmp_path) for word in given]
    done = subprocess.run([sys.executable, str(place), *words], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith(sentence.format(empty=tmp_path)) and done.stderr.count("\n") == 1
    assert results.read_bytes() == before
