"""Lives told from a survey along a run, and with several exposures: against closed forms, and what is refused."""

import json
import re

import numpy as np
import pytest
from identification.test_run_exposure import CASE, GROWTH, RATE, exact, survey_of

from wearfem.cli import wearfem
from wearfem.errors import UserError
from wearfem.run import run_case

READ = 4  # of six occasions: up to 2e6 s, 200 kt
LIMIT = 6e-3  # [m]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ahead")
    (folder / "case.py").write_text(CASE)
    run_case(folder, {}, folder / "run", quiet=True)
    return folder / "run"


def told(arguments, tmp_path):
    """What the command writes"""
    file = tmp_path / "told.json"
    wearfem.main(["forecast", *map(str, arguments), "--json", str(file)], standalone_mode=False)
    return json.loads(file.read_text())


def beginning(folder, pace=1.0):
    """The first four occasions of a plate that wears as the run does, at a pace of its own"""
    survey_of(folder, lambda x, seconds: exact(x, seconds, pace), noise=0.02)
    head, *rows = (folder / "survey.csv").read_text().splitlines()
    kept = [row for row in rows if int(row.split(",")[1]) < READ]
    (folder / "survey.csv").write_text("\n".join([head, *kept]) + "\n")
    return folder / "survey.csv"


def test_a_life_along_a_run_is_that_of_the_shape_and_not_of_a_line(run, tmp_path):
    pace = 0.9
    found = told(
        [beginning(tmp_path, pace), "--run", run, "--limit", "6*mm", "--next-stop", "270*kt"], tmp_path
    )
    ahead = found["forecast"]
    line, alone = (model["zones"][0] for model in ahead["models"])
    fastest = 1.0 + 0.188 / 0.2  # the outermost point of the survey
    seconds = np.log1p(GROWTH * LIMIT) / (GROWTH * pace * RATE * fastest)  # from d = (exp(c q r t) - 1) / c
    truth = 100.0 * seconds / 1e6  # kt
    low, high = alone["interval"]
    # the run's own jumps err by 1.2e-3 (see test_run_exposure), and 96 readings of 0.02 mm in 3 mm know the coefficient to 1e-3
    assert alone["worn_out_at"] == pytest.approx(truth, rel=4e-3)
    assert low - 2e-3 * truth <= truth <= high + 2e-3 * truth
    assert line["worn_out_at"] > 1.03 * truth  # a line does not know that a deeper plate wears faster
    assert ahead["recommended"]["name"] == "coefficient alone" and ahead["recommended"]["tested"]
    assert ahead["recommended"]["zones"][0]["remaining"] == pytest.approx(
        alone["worn_out_at"] - 200.0, abs=1.0
    )
    assert alone["reaches_next_stop"] > 0.99 > 0.0  # worn out at 294 kt


def two_mechanisms(folder, k=(0.7, 1.6), noise=0.02, plates=12):
    """Plates that slide and are hit, d = (k1 e1 + k2 e2) t; rates (p,) [mm/kt]"""
    random = np.random.default_rng(8)
    sliding, impact = random.uniform(0.005, 0.02, plates), random.uniform(0.0, 0.01, plates)
    rate = k[0] * sliding + k[1] * impact
    rows = ["point,occasion,tonnage_kt,depth_mm,sigma_mm"]
    for j in range(1, 6):
        for i in range(plates):
            rows.append(f"P{i},{j},{100 * j},{100 * j * rate[i] + noise * random.normal():.5f},{noise}")
    (folder / "survey.csv").write_text("\n".join(rows) + "\n")
    table = [f"P{i},{a:.8f},{b:.8f}" for i, (a, b) in enumerate(zip(sliding, impact, strict=True))]
    (folder / "exposure.csv").write_text("\n".join(["point,exposure_sliding,exposure_impact", *table]) + "\n")
    return folder / "survey.csv", folder / "exposure.csv", rate


def test_lives_with_several_exposures_end_where_their_sum_does(tmp_path):
    survey, exposure, rate = two_mechanisms(tmp_path)
    found = told([survey, "--exposure", exposure, "--limit", "16*mm"], tmp_path)["forecast"]
    alone = next(model for model in found["models"] if model["name"] == "coefficient alone")
    assert alone["zones"][0]["worn_out_at"] == pytest.approx(16.0 / rate.max(), rel=5e-3)  # see below
    for point in alone["points"]:
        truth = 16.0 / rate[int(point["place"][1:])]
        if truth > found["reach"]:
            assert point["worn_out_at"] is None
            continue
        # 60 readings of 0.02 mm in 5 mm know two coefficients to 1e-3; plates may differ by what careful work lets them, 0.5 %
        assert point["worn_out_at"] == pytest.approx(truth, rel=1e-2)
        low, high = point["interval"]
        assert low <= (1.0 + 5e-3) * truth and (high is None or truth <= (1.0 + 5e-3) * high)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            lambda text: text.replace("exposure_sliding", "exposure"),
            "name all mechanisms, or give the sum alone",
        ),
        (lambda text: "\n".join(text.splitlines()[:-1]) + "\n", "has no row for P11 of the survey"),
        (lambda text: text + text.splitlines()[1] + "\n", "has a point twice"),
        (lambda text: text.replace("P3,", "P3,-", 1), "exposures below 0"),
        (
            lambda text: text.replace("point,exposure_sliding,exposure_impact", "point,a,b"),
            "it needs point and exposure",
        ),
        (lambda text: re.sub(r"(P3,[^,]*),.*", r"\1,much", text), "much"),
    ],
)
def test_exposures_that_cannot_be_meant_are_refused(tmp_path, change, sentence):
    survey, exposure, _ = two_mechanisms(tmp_path)
    exposure.write_text(change(exposure.read_text()))
    with pytest.raises(UserError, match=sentence):
        told([survey, "--exposure", exposure, "--limit", "16*mm"], tmp_path)


def test_a_run_that_cannot_be_meant_is_refused(run, tmp_path):
    survey = beginning(tmp_path)
    inside = tmp_path / "inside.csv"
    inside.write_text(
        "\n".join(
            f"{row},{'exposure' if i == 0 else 1.0}" for i, row in enumerate(survey.read_text().splitlines())
        )
        + "\n"
    )
    bare = tmp_path / "bare.csv"
    bare.write_text("point,occasion,tonnage_kt,depth_mm\nA,1,10,1\nA,2,20,2\n")
    for arguments, sentence in (
        ([survey, "--run", run, "--exposure", survey], "both tell the exposure"),
        ([inside, "--run", run], "has a column exposure, and --run"),
        ([survey, "--run", tmp_path], "is no run folder"),
        ([bare, "--run", run], "no x_m, y_m, z_m"),
        ([survey, "--run", run, "--frozen", run], "--frozen is for runs"),
        ([run, "--exposure", survey], "--exposure is for surveys"),
        ([run, "--run", run, "--progress", "tonnage_kt"], "--progress and --run is for surveys"),
    ):
        with pytest.raises(UserError, match=sentence):
            told([*arguments, "--limit", "6*mm"], tmp_path)
    assert not (tmp_path / "told.json").exists()
