"""`wearfem improve`: what is given wrong ends in a sentence, before anything is run or written."""

from pathlib import Path

import pytest

from wearfem.cli import wearfem
from wearfem.errors import UserError

SURVEY = "point,occasion,time_h,depth_mm\n" + "".join(f"a,{i},{i * 100},{i}\n" for i in range(1, 9))


def command(tmp_path, *more, survey=SURVEY, run="run"):
    (tmp_path / "survey.csv").write_text(survey)
    words = ["improve", tmp_path / "survey.csv", "--run", tmp_path / run, "--out", tmp_path / "out", *more]
    wearfem.main([str(word) for word in words], standalone_mode=False)


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (("--rounds", "0"), "one coupled run is the least"),
        ((), "has no manifest.json: give the folder that wearfem run wrote to"),
        (("--progress", "tonnage"), "has no column tonnage; it has"),
    ],
)
def test_a_sentence(tmp_path, more, sentence):
    with pytest.raises(UserError, match=sentence):
        command(tmp_path, *more)
    assert not list(Path(tmp_path).glob("out/rounds*"))


def test_a_survey_with_an_exposure_of_its_own(tmp_path):
    rows = SURVEY.splitlines()
    text = "\n".join([rows[0] + ",exposure", *(f"{row},1" for row in rows[1:])]) + "\n"
    with pytest.raises(UserError, match="has a column exposure, and --run"):
        command(tmp_path, survey=text)


def test_the_report_of_a_run_is_not_written_over(tmp_path):
    """The folder of a run has a report.html of its own."""
    (tmp_path / "survey.csv").write_text(SURVEY)
    (tmp_path / "life").mkdir()
    (tmp_path / "life" / "manifest.json").write_text("{}")
    words = ["diagnose", str(tmp_path / "survey.csv"), "--out", str(tmp_path / "life")]
    with pytest.raises(UserError, match="life is the folder of a run, whose report would be written over"):
        wearfem.main(words, standalone_mode=False)
    assert [path.name for path in (tmp_path / "life").iterdir()] == ["manifest.json"]


def test_an_output_folder_that_cannot_be(tmp_path):
    (tmp_path / "out").write_text("")
    with pytest.raises(UserError, match="give --out another folder"):
        command(tmp_path)
