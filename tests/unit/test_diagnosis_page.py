"""The page of a diagnosis: every verdict gets one, its figures are those of the diagnosis, and it needs nothing from outside."""

import base64
import re
from dataclasses import replace

import browser
import numpy as np
import pytest
from unit.test_report_page import Page

from wearfem.case import find_case
from wearfem.diagnosis_page import compose, odds_words
from wearfem.errors import UserError
from wearfem.proofs.survey_life import plants
from wearfem.survey.backtest import BackTest, back_test
from wearfem.survey.diagnose import diagnose
from wearfem.survey.forecast import forecast
from wearfem.survey.residual import NoiseTest
from wearfem.survey.survey import read_survey
from wearfem.survey.words import diagnosis_lines, diagnosis_values

SECTIONS = (
    "words", "data", "model", "residual", "suspects", "found", "errors", "nuisances", "forecast", "backtest", "next",
)  # fmt: skip


def page_of(folder, name, ahead=False, tested=None, **design):
    plant = plants().plant(name, 1, **({"points": 12, "occasions": 5} | design))
    survey, exposure = plant.write(folder)
    found = diagnose(read_survey(survey, exposure=exposure), name_without=False)
    limit = (
        1.2e-3 * plant.reading.max() if ahead else None
    )  # some of the plates are worn that far after the next stop
    foretold = forecast(found.choice, limit, plant.tonnage[-1] + 30.0 if ahead else None, draws=200)
    tested = back_test(found.survey) if tested is None else tested
    file = folder / "report.html"
    file.write_text(compose(found, foretold, tested, [survey, exposure]), encoding="utf-8")
    return file, found, foretold, tested


@pytest.fixture(scope="module")
def gradient(tmp_path_factory):
    return page_of(tmp_path_factory.mktemp("gradient"), "hardness_gradient", ahead=True)


def test_the_page_tells_the_story_in_order_with_its_figures(gradient):
    file, found, ahead, tested = gradient
    text = file.read_text()
    page = Page(text)
    assert not page.open and not page.wrong
    places = [text.index(f'id="{name}"') for name in SECTIONS]
    assert places == sorted(places)
    assert found.verdict in page.text.replace(" ", "_")
    for score in (found.baseline, found.straight_line, found.improved):
        assert f"{score.heldout_rmse:.3g} mm" in page.text
    end = ahead.of_zone(ahead.outlooks[-1], "all points")
    assert f"{end.median:.4g} ({end.interval[0]:.4g} to {end.interval[1]:.4g})" in page.text
    assert f"{1e3 * tested.rmse[2]:.3g} mm" in page.text
    assert "SHA-256 of survey.csv" in page.text and "seed" in page.text
    for effect in found.effects:
        assert effect.name in page.text


def test_what_an_effect_leaves_is_told_first(gradient):
    file, found, ahead, tested = gradient
    assert not found.more_than_noise and 'id="more"' not in file.read_text()
    for p, more in ((2e-2, False), (3e-7, True)):  # the level is 0.01
        left = replace(found, tests_after=(NoiseTest("date", 40.0, 4, p), *found.tests_after))
        text = compose(left, ahead, tested, [])
        spoken = " ".join(" ".join(diagnosis_lines(left)).split())
        assert diagnosis_values(left)["left_over"]["noise"] is not more
        assert diagnosis_values(left)["verdict"] == found.verdict  # the four verdicts stay what they are
        for told in (Page(text[: text.index('id="data"')]).text, spoken):
            assert ("more than noise (p < 3e-07, most with date)" in told) is more


def test_the_page_loads_nothing(gradient):
    text = gradient[0].read_text()
    assert all(address.startswith("data:") for address in Page(text).address)
    inline = [base64.b64decode(code).decode() for code in re.findall(r"svg\+xml;base64,([^\"]+)", text)]
    assert len(inline) > 8
    for part in (text, *inline):
        named = set(re.findall(r"\b(?:https?|wss?|ftp):/*[\w./-]+", part))
        # names of XML vocabularies and of the document type, which no browser looks up
        assert all(address.startswith(("http://www.w3.org/", "http://purl.org/")) for address in named), named


def test_in_a_browser_it_shows_all_pictures_and_prints(gradient):
    with browser.open_page(gradient[0]) as tab:
        shown = tab.evaluate("[...document.images].every(i => i.complete && i.naturalWidth > 200)")
        assert shown and tab.evaluate("document.images.length") > 8
        assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")  # nothing sticks out
        assert all(address.startswith(("file:", "data:")) for address in tab.requested)
        assert tab.trouble == []
        pdf = base64.b64decode(tab.call("Page.printToPDF", preferCSSPageSize=True)["data"])
        assert pdf.startswith(b"%PDF") and 2 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 12


@pytest.mark.parametrize(
    ("name", "verdicts", "words"),
    [
        ("none", {"adequate"}, "Nothing needs to be added"),
        ("same_exposure", {"cannot_tell"}, "fit more than one explanation"),
    ],
)
def test_every_verdict_gets_its_page(tmp_path, name, verdicts, words):
    file, found, _, _ = page_of(tmp_path, name, tested=BackTest(()))
    assert found.verdict in verdicts
    page = Page(file.read_text())
    assert not page.open and not page.wrong
    assert words in page.text and "Give --limit" in page.text and "there are fewer" in page.text


def test_odds_are_told_as_people_tell_them():
    assert [odds_words(x) for x in (0.0, np.log(20.0), -np.log(8.0), 60.0 * np.log(10.0))] == [
        "1 to 1", "20 to 1", "1 to 8", "10^60 to 1",
    ]  # fmt: skip


def test_a_survey_is_no_case(tmp_path):
    (tmp_path / "measured").mkdir()
    (tmp_path / "measured" / "survey.csv").write_text("point,occasion,tonnage_kt,depth_mm\n")
    with pytest.raises(
        UserError, match="holds a survey, and nothing to run; give wearfem diagnose .*survey.csv"
    ):
        find_case(tmp_path)
