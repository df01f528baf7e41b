"""The loop closed: what a survey asks for enters the case, the coupled run with it predicts readings that no round saw."""

import ast
import importlib.util
import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from identification import coupled_plants

from wearfem.case import load_any_case
from wearfem.cli import wearfem
from wearfem.errors import UserError
from wearfem.exposure import exposed_by_run
from wearfem.improve import improve
from wearfem.proofs.closed_loop import (
    CHUTE,
    FACTOR,
    HIDDEN,
    PLATE,
    SMALL,
    closed,
    plant,
    shape_claims,
    shape_only,
)
from wearfem.survey.candidates import candidates
from wearfem.survey.identify import readings
from wearfem.survey.survey import read_survey
from wearfem.wear.effects import HardnessGradient


def command(*arguments):
    wearfem.main([str(one) for one in arguments], standalone_mode=False)


def told_beforehand(made):
    """A diagnosis at hand: a hardness gradient. Choosing it takes ten times as long as what is tested with it"""
    data = readings(exposed_by_run(made.survey, made.run))
    suspect = next(c for c in candidates(data.past, data.deepest) if c.name == "HardnessGradient")
    choice = SimpleNamespace(best=SimpleNamespace(suspects=(suspect,)), tried=(), odds=0.0)
    return SimpleNamespace(doubts=(), choice=choice)


def test_plants_owe_nothing_to_the_diagnosis():
    tree = ast.parse(Path(coupled_plants.__file__).read_text())
    imported = {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
    imported |= {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
    assert not [name for name in imported if name.startswith("wearfem.survey")]


@pytest.fixture(scope="module")
def improved(tmp_path_factory):
    """A hidden hardness gradient, improved by the command"""
    folder = tmp_path_factory.mktemp("loop")
    made = plant(folder, "hardness_gradient", 31, **SMALL)
    command("improve", folder / "survey.csv", "--run", made.run, "--out", folder / "out", "--quiet")
    return folder, made, json.loads((folder / "out" / "improved.json").read_text())


def test_the_command_tells_before_and_after(improved):
    _, made, told = improved
    assert told["verdict"] == "effect_found"
    assert [effect["name"] for effect in told["effects"]] == ["HardnessGradient"]
    assert told["agreed"]
    before, after = told["coefficient_alone"]["heldout_rmse"], told["improved"]["heldout_rmse"]
    assert after < 1.3 * made.sigma  # asked; 56 readings scatter by 10 %
    assert before > 2.0 * after
    assert told["straight_line"]["heldout_rmse"] > 2.0 * after
    assert told["what_is_left"] == {"verdict": "adequate", "effects": []}
    loss = told["effects"][0]["parameters"]["loss"]
    low, high = loss["interval"]
    assert low - 0.5 * (high - low) < 50.0 < high + 0.5 * (high - low)  # put in 50/m; 90 % interval, doubled


def test_held_out_readings_are_fitted_in_no_round(improved, tmp_path):
    """Whatever they say: with 1 mm added to them, ten gauge errors, a round comes to the same to the bit"""
    folder, made, told = improved
    held = told["heldout"]
    rows = (folder / "survey.csv").read_text().splitlines()
    names = rows[0].split(",")
    at = {name: names.index(name) for name in ("point", "occasion", "depth_mm")}
    changed, touched = [rows[0]], 0
    for row in rows[1:]:
        cells = row.split(",")
        if cells[at["point"]] in held["points"] or cells[at["occasion"]] in held["occasions"]:
            cells[at["depth_mm"]] = f"{float(cells[at['depth_mm']]) + 1.0:g}"
            touched += 1
        changed.append(",".join(cells))
    assert touched == held["readings"]
    (tmp_path / "survey.csv").write_text("\n".join(changed) + "\n")
    found = told_beforehand(made)  # the effect itself is named by all readings
    both = ((folder / "out", made.survey), (tmp_path, read_survey(tmp_path / "survey.csv")))
    options = {"found": found, "rounds": 1, "diagnose_again": False, "quiet": True}
    rounds = [
        improve(one, made.run, out, **options).rounds for out, one in both
    ]  # the first has been run before
    for one, two in zip(*rounds, strict=True):
        assert one.told.place.tobytes() == two.told.place.tobytes()


def test_the_improved_case_runs_and_says_where_it_comes_from(improved, capsys):
    folder, _, told = improved
    case = load_any_case(folder / "out" / "improved")
    assert isinstance(case.effects[-1], HardnessGradient)
    text = (folder / "out" / "improved" / "case.py").read_text()
    assert "survey.csv, sha256" in text and "Error on readings never fitted" in text
    command("run", folder / "out" / "improved", "--set", "stop=100*day", "--out", folder / "again", "--quiet")
    figures = {f["name"]: f for f in json.loads((folder / "again" / "figures.json").read_text())}
    assert figures["deepest wear"]["value"] > 1.0


def test_what_is_there_is_gone_on_with(improved, capsys):
    folder, made, told = improved
    found = told_beforehand(made)
    again = improve(made.survey, made.run, folder / "out", found=found, diagnose_again=False, quiet=True)
    assert "cycle " not in capsys.readouterr().out  # no cycle is run twice
    assert again.improved.heldout_rmse == told["improved"]["heldout_rmse"]


def test_a_run_that_kept_its_shape_is_refused(improved, tmp_path):
    folder, *_ = improved
    run, short = tmp_path / "run", f"stop={PLATE.served / 10}"
    command("run", PLATE.case, "--set", "frozen=true", "--set", short, "--out", run, "--quiet")
    with pytest.raises(
        UserError, match="kept the geometry as new, so what it lacks may be the change of shape"
    ):
        improve(read_survey(folder / "survey.csv"), run, tmp_path / "out")


def test_a_survey_by_distance_is_refused(improved, tmp_path):
    folder, made, _ = improved
    text = (folder / "survey.csv").read_text().replace("tonnage_kt", "distance_km")
    (tmp_path / "survey.csv").write_text(text)
    with pytest.raises(UserError, match="a run counts time and throughput"):
        improve(read_survey(tmp_path / "survey.csv"), made.run, tmp_path / "out")


@pytest.mark.slow
@pytest.mark.parametrize("hidden", ["hardness_gradient", "ore_change"])
@pytest.mark.parametrize("seed", [41, 42])
def test_held_out_error_falls_to_the_noise(hidden, seed, tmp_path):
    done, made = closed(tmp_path, hidden, seed)
    assert done.agreed
    assert [effect.name for effect in done.effects] == [type(one).__name__ for one in HIDDEN[hidden]]
    assert done.improved.heldout_rmse < 1.3 * made.sigma  # asked
    assert done.improved.heldout_rmse < done.coefficient_alone.heldout_rmse
    if hidden == "hardness_gradient":  # whose factor is 1 at no depth; 2 % for sampling and mesh
        last = done.last.put_in
        assert abs(np.log(last.factor / FACTOR)) < 0.02 + 3.0 * last.deviation[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [41, 42])
def test_a_speed_exponent_that_these_readings_hardly_show_is_not_taken_for_another_effect(seed, tmp_path):
    """Along the coupled run with the planted exponent itself, readings are 4.3 and 1.6 nats more probable than by the coefficient alone,
    and 6 name an effect (decision 0010): so it may be left unnamed, but then there is little to miss"""
    done, made = closed(tmp_path, "speed_exponent", seed)
    assert {effect.name for effect in done.effects} <= {"SpeedExponent"}
    # 1.3 is asked of what is named; by formula the exponent alone makes 0.11 mm beside the gauge's 0.1 where it is left out: 1.5
    assert done.improved.heldout_rmse < (1.3 if done.effects else 1.5) * made.sigma


def chute_script():
    spec = importlib.util.spec_from_file_location("chute_hidden", CHUTE.case / "hidden.py")
    script = sys.modules["chute_hidden"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script


MISSED = pytest.mark.xfail(
    reason="0.132 and 0.133 mm for the 0.130 asked: runs that hardly differ in what was put in differ by 0.05 mm (decision 0010)",
    strict=True,
)


@pytest.mark.parametrize(
    ("hidden", "seed"),
    [
        pytest.param("hardness_gradient", 1, marks=MISSED),
        ("hardness_gradient", 6),
        ("case_hardened", 2),
        pytest.param("case_hardened", 5, marks=MISSED),
        ("ore_change", 3),
    ],
)
def test_the_loop_closed_on_the_chute(hidden, seed):
    """What the script has written; the next test does one of them anew"""
    rows = json.loads(chute_script().RESULTS.read_text())
    (row,) = [row for row in rows if (row["hidden"], row["seed"]) == (hidden, seed)]
    assert row["put in"] == [type(effect).__name__ for effect in CHUTE.hidden[hidden]]
    assert row["in the loop"] < 0.5 * row["coefficient alone"]
    assert row["in the loop"] < 1.3 * CHUTE.sigma  # asked


@pytest.mark.slow
@pytest.mark.parametrize("seed", [pytest.param(1, marks=MISSED), 6])
def test_the_loop_closes_on_the_chute(seed, tmp_path):
    """A quarter of an hour of one core each"""
    done, made = closed(tmp_path, "hardness_gradient", seed, site=CHUTE)
    assert [effect.name for effect in done.effects] == ["HardnessGradient"]
    assert done.improved.heldout_rmse < 1.3 * made.sigma  # asked


@pytest.mark.slow
def test_the_shipped_survey_is_that_of_the_plant(tmp_path):
    made = plant(tmp_path, "hardness_gradient", 42)
    shipped = read_survey(PLATE.case / "measured" / "survey.csv")
    # one digit of the gauge: last bits of a run may differ from machine to machine
    np.testing.assert_allclose(shipped.reading, made.survey.reading, atol=0.02e-3)
    assert (shipped.point_names, shipped.progress.tolist()) == (
        made.survey.point_names,
        made.survey.progress.tolist(),
    )


def test_what_careful_work_leaves_is_told_where_it_is_more_than_the_gauge(tmp_path):
    """A run that kept its shape errs by several gauge errors, smoothly over place; that must not pass for noise without a word"""
    frozen = shape_only(tmp_path, 22, frozen=True)
    assert frozen.baseline.heldout_rmse > 3.0 * frozen.noise_floor
    (note,) = [note for note in frozen.notes if "the rate is off by" in note]
    share = frozen.choice.best.spread.smooth
    assert f"{100 * share:.1f} %, smoothly from place to place" in note


@pytest.mark.slow
def test_a_shape_that_changes_is_no_material(tmp_path):
    assert [claim.claim for claim in shape_claims(tmp_path) if not claim.holds] == []
