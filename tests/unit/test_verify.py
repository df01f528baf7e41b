"""The verification runner: verdicts, lines, the file it writes, and names it does not know."""

import json
import math
from types import SimpleNamespace

import pytest

from wearfem import verify as runner
from wearfem.errors import UserError
from wearfem.proof import Claim


def claim(computed, *, expected=2.0, tolerance=0.01, relative=True, note=""):
    return Claim("speed", "a formula", expected, computed, "m/s", tolerance, relative, note)


@pytest.mark.parametrize(
    ("one", "verdict"),
    [
        (claim(2.015), "holds"),  # 0.75 % off
        (claim(2.03), "FAILS"),  # 1.5 % off
        (claim(2.015, relative=False), "FAILS"),  # 0.015 m/s off
        (claim(2.005, relative=False), "holds"),
        (claim(math.nan), "FAILS"),
        (claim(math.nan, tolerance=math.inf), "FAILS"),
        (claim(7.0, tolerance=math.inf), "shown"),
        (claim(0.0, expected=0.0, tolerance=0.0), "holds"),
        (claim(1e-20, expected=0.0), "FAILS"),  # nothing is near zero, relatively
    ],
)
def test_a_claim_holds_within_its_tolerance(one, verdict):
    assert one.verdict == verdict
    assert one.holds == (verdict != "FAILS")


def test_every_proof_says_what_it_proves():
    for name in runner.proof_names():
        proof = runner.importlib.import_module(f"wearfem.proofs.{name}")
        assert proof.__doc__ and callable(proof.claims)


@pytest.fixture
def proofs(monkeypatch):
    """Two proofs that stand in for the real ones: `good` holds, `bad` does not."""
    modules = {
        "good": SimpleNamespace(__doc__="It holds.", claims=lambda: iter([claim(2.0, note="exact")])),
        "bad": SimpleNamespace(__doc__="It fails.", claims=lambda: iter([claim(2.0), claim(9.0)])),
    }
    monkeypatch.setattr(runner, "proof_names", lambda: sorted(modules))
    monkeypatch.setattr(
        runner.importlib, "import_module", lambda name: modules[name.removeprefix("wearfem.proofs.")]
    )


def test_all_proofs_run_unless_some_are_named(proofs, capsys):
    assert runner.verify(("good", "good")) is True
    assert "1 claims hold, 0 fail" in capsys.readouterr().out  # named twice, run once
    assert runner.verify() is False
    text = capsys.readouterr().out
    assert "2 claims hold, 1 fail" in text
    assert "expected 2 m/s, computed 9 m/s, off by 3.5 relative, tolerance 0.01 relative" in text


def test_the_claims_are_written_with_versions(proofs, tmp_path, capsys):
    file = tmp_path / "claims.json"
    runner.verify((), file)
    written = json.loads(file.read_text())
    assert {"wearfem", "numba", "numpy"} <= set(written["versions"])
    assert [(row["proof"], row["holds"]) for row in written["claims"]] == [
        ("bad", True),
        ("bad", False),
        ("good", True),
    ]
    assert written["claims"][2]["note"] == "exact"


def test_an_unknown_name_is_told_before_anything_runs(proofs, capsys):
    with pytest.raises(UserError, match="no proof ugly: the proofs are bad and good"):
        runner.verify(("good", "ugly"))
    assert capsys.readouterr().out == ""
