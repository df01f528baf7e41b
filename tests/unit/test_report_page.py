"""The page on a life: its figures are those of the run and of closed forms, it loads nothing, and it works in a browser."""

import base64
import json
import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import browser
import numpy as np
import pytest

from wearfem.case import load_any_case
from wearfem.cycle import cycle, first_state
from wearfem.errors import UserError
from wearfem.history import History, computing_of, history_of, read_history
from wearfem.report_facts import (
    corrected_thickness,
    corrected_volume,
    end_of,
    thickness_at,
    warnings_of,
    wear_by_zone,
    zones_of,
)
from wearfem.report_page import write_report
from wearfem.run import run_case
from wearfem.sharpness import of_whole_face
from wearfem.units import day, mm

CASES = Path(__file__).parents[2] / "cases"
SETTINGS = {"cells": 6, "law": "hardness_gradient", "tolerance": 0.05}

TWO_ZONES = """
import numpy as np
from wearfem.case import LifeCase, Window
from wearfem.cycle import worn_to
from wearfem.formula import FormulaFlow, Sliding
from wearfem.liner.block import Tetrahedra, block
from wearfem.liner.liner import Liner
from wearfem.material import Material
from wearfem.wear.laws import Archard
from dataclasses import replace

def twice_beyond_the_middle(surface):
    x = surface.corner[:, :, 0].mean(axis=1)
    return np.where(np.bincount(surface.facet, x) / np.bincount(surface.facet) < 0.1, 1.0, 2.0)

def case(*, frozen: bool = True) -> LifeCase:
    mesh = block((0, 0, -0.02), (0.2, 0.1, 0), (4, 2, 2), Tetrahedra, name="plate")
    right = mesh.node[mesh.wear].mean(axis=1)[:, 0] > 0.1
    mesh = replace(mesh, group={**mesh.group, "left": mesh.wear[~right], "right": mesh.wear[right]})
    liner = Liner(mesh, Material("steel", 7850.0, 80e9, 0.3))
    flow = Sliding(1e4, 1.0, intensity=twice_beyond_the_middle)
    return LifeCase("zones", FormulaFlow(), flow, liner, Archard(1e-13), worn_to(liner, 0.01), Window(10.0, 40),
                    throughput_rate=100.0, longest_jump=2e6, frozen=frozen, notes=("only <two> zones",))
"""


class Page(HTMLParser):
    """Tags that are not closed, addresses, and the words that a reader sees."""

    def __init__(self, text):
        super().__init__()
        self.open, self.address, self.words, self.wrong = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.address += [value for name, value in attributes if name in ("src", "href", "action", "poster")]
        if tag not in ("meta", "link", "img", "input"):  # these have no end
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data):
        if not {"script", "style"} & set(self.open):
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    run = tmp_path_factory.mktemp("report") / "run"
    run_case(CASES / "wearing_plate", SETTINGS, run, quiet=True)
    figures = write_report(run, json_file=run / "report.json")
    return run, {figure.name: figure.value for figure in figures}


@pytest.fixture
def run(finished, tmp_path):
    """A copy that a test may damage."""
    shutil.copytree(finished[0], tmp_path / "run")
    return tmp_path / "run"


@pytest.fixture(scope="module")
def zones(tmp_path_factory) -> tuple[Path, History]:
    folder = tmp_path_factory.mktemp("zones")
    (folder / "zones").mkdir()
    (folder / "zones" / "case.py").write_text(TWO_ZONES)
    run_case(folder / "zones", {}, folder / "run", quiet=True)
    return folder / "run", read_history(folder / "run")


def test_the_page_tells_the_figures_of_the_run(finished):
    run, figures = finished
    history = read_history(run)
    told = json.loads((run / "figures.json").read_text())
    case_says = {figure["name"]: figure["value"] for figure in told}
    assert figures["end of life"] == case_says["end of life"]
    half = 0.5 * (figures["end of life, to"] - figures["end of life, from"])
    left = max(history.life[-1].time - history.service_time[-1], 0.0) / day
    assert half >= case_says["promised at 90 %"] - 1e-3  # deviations are 1.645 there
    assert left > 0.0 or half == pytest.approx(case_says["promised at 90 %"], rel=1e-4)  # 1.645 for 1.64485
    text = Page((run / "report.html").read_text()).text
    for number in (figures["end of life"], figures["end of life, from"], figures["end of life, to"]):
        assert f"{number:.4g} d" in text
    for words in (
        "hardness_gradient",
        "Where this comes from",
        "jump error",
        "thirds along",
        "strength was not asked",
    ):
        assert words in text
    assert json.loads((run / "manifest.json").read_text())["sha256"].popitem()[1] in text
    assert [f["name"] for f in json.loads((run / "report.json").read_text())] == list(figures)


def test_the_page_is_whole_and_loads_nothing(finished):
    text = (finished[0] / "report.html").read_text()
    page = Page(text)
    assert not page.open and not page.wrong
    assert page.address and all(address.startswith("data:") for address in page.address)
    inline = [base64.b64decode(code).decode() for code in re.findall(r"svg\+xml;base64,([^\"]+)", text)]
    assert len(inline) == 5  # four curves of the run, one of the chance to last
    for part in (text, *inline):
        named = set(re.findall(r"\b(?:https?|wss?|ftp):/*[\w./-]+", part))
        # names of XML vocabularies and of the document type, which no browser looks up
        assert all(address.startswith(("http://www.w3.org/", "http://purl.org/")) for address in named), named
    for word in ("fetch(", "XMLHttpRequest", "import(", "@import", "url("):
        assert word not in text


def test_what_smoothing_took_stands_beside_the_life(tmp_path):
    """The same days on the page, in its figures and in the line that the run prints."""
    keywords = {"cells": 10, "noise": 0.02, "tolerance": 0.004, "stop": 400 * day}
    run_case(CASES / "stream_on_plate", keywords, tmp_path / "run", quiet=True)
    case, history = load_any_case(CASES / "stream_on_plate", keywords), read_history(tmp_path / "run")
    sharp, figures = of_whole_face(history, case), {f.name: f.value for f in write_report(tmp_path / "run")}
    life = history.life[-1].time / day
    text = Page((tmp_path / "run" / "report.html").read_text()).text
    assert f"evened out over {case.smoothing_length / mm:.4g} mm" in text
    for over, kept, error in zip(sharp.over, sharp.kept, sharp.error, strict=True):
        change = (kept - 1.0) * life
        assert f"{change:+.1f} ± {error * life:.1f} d over {over / mm:.4g} mm" in text
        assert f"{change:+.1f} +- {error * life:.1f}" in sharp.words(history.life[-1].time)
        name = f"change of the end of life, had the rate been smoothed over {over / mm:.3g} mm"
        assert figures[name] == pytest.approx(change)
        assert figures[f"{name}, standard error"] == pytest.approx(error * life)
    assert "followed to the service time that was asked; it goes on" in text
    assert (sharp.kept < 1.0).all()  # a stream with an edge: less smoothing wears deeper


def test_the_page_tells_the_time_outside_the_flow(finished):
    run, _ = finished
    text = Page((run / "report.html").read_text()).text
    assert computing_of(run).words() in text
    assert "The life was followed to its end." in text


def test_the_view_has_the_faces_that_were_sampled(finished):
    text = (finished[0] / "report.html").read_text()
    data = json.loads(re.search(r'id="data">(.*?)</script>', text, re.S)[1])
    history = read_history(finished[0])
    ahead = history.life[-1].time > history.service_time[-1]
    assert len(data["frames"]) == len(history.samples) + ahead
    assert [frame["triangle"] is not None for frame in data["frames"]] == [True] + [False] * (
        len(data["frames"]) - 1
    )
    for number, known in enumerate(corrected_thickness(history)):
        frame = data["frames"][number]
        thickness = np.frombuffer(base64.b64decode(frame["thickness"]), "<f4")
        point = np.frombuffer(base64.b64decode(frame["point"]), "<f4").reshape(-1, 3)
        assert thickness == pytest.approx(1e3 * known, rel=1e-6)  # single precision; a triangle a facet
        height = np.ptp(point[:, 2])
        assert height < 1e-4  # mm: the plate stays flat


def test_thickness_at_end_of_life_is_the_limit():
    case = load_any_case(CASES / "wearing_plate", {"cells": 4, "tolerance": 0.05})
    state, reports = first_state(case), []
    while not state.ended:
        state, report = cycle(case, state)
        reports.append(report)
    for count in (len(reports), len(reports) - 2):  # after the end, and while it is still to come
        history = history_of(*_after(case, count))
        life = history.life[-1]
        left = thickness_at(history, life.time)[life.facet]
        # 20 mm of plate less the 10 mm allowed, and what wears in the bias of the jumps, which is taken off the life alone
        metal, depth = history.metal, history.samples[-1].depth
        flow = (history.rate[-1] / metal.factor(depth))[life.facet]
        worn = metal.depth_of(metal.plain_of(np.full(len(depth), 10 * mm)) - flow * life.bias)
        assert left == pytest.approx(20 * mm - worn[life.facet], abs=1e-12)  # m: rounding


def _after(case, count):
    state, reports = first_state(case), []
    for _ in range(count):
        state, report = cycle(case, state)
        reports.append(report)
    return state, reports


def test_volume_and_thickness_agree_with_depth(finished):
    history = read_history(finished[0])
    # a flat plate of 0.2 x 0.1 m: volume is depth times area, thickness is 20 mm less depth; 1e-9 is what the mesh loses exactly
    assert corrected_volume(history) == pytest.approx(history.depth.mean(axis=1) * 0.02, rel=1e-9, abs=1e-15)
    assert corrected_thickness(history) == pytest.approx(20 * mm - history.depth, rel=1e-9)


def test_on_a_changed_mesh_nothing_is_corrected_twice(finished):
    history = read_history(finished[0])
    other = replace(history.reports[0], depth=np.zeros(7))  # the first cycle, as if on a mesh of 7 facets
    changed = replace(history, reports=(other, *history.reports[1:]))
    assert np.array_equal(corrected_thickness(changed), history.thickness)
    assert (
        np.abs(corrected_thickness(history) - history.thickness).max() > 0.01 * mm
    )  # there is something to correct


def test_zones_are_groups_of_the_mesh_and_wear_as_they_must(zones):
    run, history = zones
    left, right = wear_by_zone(history, 0.9)
    assert (left.name, right.name) == ("left", "right")
    rate = 1e-13 * 1e4 * 1.0  # k p v
    served = float(history.service_time[-1])
    # constant rates: depth is rate times time, life 10 mm over rate; nothing but rounding is lost
    assert left.deepest == pytest.approx(rate * served, rel=1e-9)
    assert right.deepest == pytest.approx(2.0 * rate * served, rel=1e-9)
    assert left.end.time == pytest.approx(10 * mm / rate, rel=1e-9)
    assert right.end.time == pytest.approx(10 * mm / (2.0 * rate), rel=1e-9)
    assert right.end.throughput == pytest.approx(100.0 * right.end.time, rel=1e-9)
    assert left.area + right.area == pytest.approx(0.02, rel=1e-12)
    assert end_of(history.life[-1], history, -1, 0.9).time == pytest.approx(right.end.time, rel=1e-12)


def test_no_facet_is_left_out_of_the_zones(zones):
    mesh = zones[1].state.now.liner.mesh
    named = zones_of(replace(mesh, group={"wear": mesh.wear, "left": mesh.group["left"]}))
    assert list(named) == ["left", "rest of the worn face"]
    thirds = zones_of(replace(mesh, group={"wear": mesh.wear}))
    assert len(thirds) == 3
    for zone in (named, thirds):
        assert np.array_equal(np.sort(np.concatenate(list(zone.values()))), np.arange(len(mesh.wear)))


def test_what_is_strange_is_told(zones):
    history = zones[1]
    case = load_any_case(CASES / "wearing_plate")
    end = end_of(history.life[-1], history, -1, 0.9)
    begun = {"finished": "today"}
    assert not any("thinner than" in warning for warning in warnings_of(history, begun, case, end))
    thin = history.thickness.copy()
    thin[-1, :2] -= 5 * mm  # of 20 mm, more than a fifth
    told = warnings_of(replace(history, thickness=thin), begun, case, end)
    assert any(
        warning.startswith(f"2 of {len(history.area)} facets measure thinner than") for warning in told
    )


def test_what_a_case_says_is_told_and_cannot_break_the_page(zones):
    write_report(zones[0])
    text = (zones[0] / "report.html").read_text()
    page = Page(text)
    assert "The case says: only <two> zones." in page.text
    assert "groups of the mesh" in page.text
    assert not page.open and not page.wrong


def test_the_case_may_be_gone(zones, tmp_path):
    run = tmp_path / "run"
    shutil.copytree(zones[0], run)
    manifest = json.loads((run / "manifest.json").read_text())
    manifest["folder"] = manifest["folder"].replace("zones", "gone")
    manifest["sha256"] = {
        name.replace("zones", "gone"): digest for name, digest in manifest["sha256"].items()
    }
    manifest["finished"] = None
    (run / "manifest.json").write_text(json.dumps(manifest))
    write_report(run, out=tmp_path / "page.html")
    text = Page((tmp_path / "page.html").read_text()).text
    assert "The case that was run is gone or has changed" in text
    assert "The run is not finished" in text
    assert not (run / "report.html").exists() or "is gone" not in (run / "report.html").read_text()


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda run: shutil.rmtree(run / "cycles"), "has no cycles: a report is of a life"),
        (lambda run: keep(run, 1), "has one cycle that was kept, and a report needs two"),
        (lambda run: (run / "manifest.json").unlink(), "is no run folder, it has no manifest.json"),
        (lambda run: cut(run / "cycles" / "0002.h5"), "0002.h5 is cut off or damaged"),
        (lambda run: cut(run / "cycles" / "0002.vtkhdf"), "0002.vtkhdf is missing, cut off or damaged"),
        (lambda run: cut(run / "figures.json"), "figures.json is cut off or damaged"),
        (lambda run: cut(run / "manifest.json"), "manifest.json cannot be read"),
        (lambda run: (run / "cycles" / "0002.h5").unlink(), "but not cycle 2: put 0002.h5 back"),
    ],
)
def test_what_is_no_life_is_refused_and_the_old_page_stays(run, damage, sentence):
    before = (run / "report.html").read_bytes()
    damage(run)
    with pytest.raises(UserError, match=sentence):
        write_report(run)
    assert (run / "report.html").read_bytes() == before


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(UserError, match="nowhere"):
        write_report(tmp_path / "nowhere")


def keep(run, count):
    for file in (run / "cycles").iterdir():
        if int(file.stem) > count:
            file.unlink()


def cut(file):
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2])


# In a browser


@pytest.fixture(scope="module")
def tab(finished):
    with browser.open_page(finished[0] / "report.html") as tab:
        tab.wait_for("document.querySelector('.stage').dataset.ready === 'yes'")
        yield tab


PICTURE = "(() => { dispatchEvent(new Event('resize')); return document.querySelector('.stage > canvas').toDataURL(); })()"
MIDDLE = """(() => {
    const b = document.querySelector('.stage > canvas').getBoundingClientRect();
    return [b.x + b.width / 2, b.y + b.height / 2];
})()"""


def test_the_view_turns_with_mouse_and_touch(tab):
    tab.evaluate("document.querySelector('#view').scrollIntoView()")
    pictures = [tab.evaluate(PICTURE)]
    x, y = tab.evaluate(MIDDLE)
    tab.drag(x, y, 80, 30)
    pictures.append(tab.evaluate(PICTURE))
    tab.swipe(x, y, -60, 40)
    pictures.append(tab.evaluate(PICTURE))
    tab.wheel(x, y, -300)
    pictures.append(tab.evaluate(PICTURE))
    tab.evaluate("document.querySelector('.stage button').click()")
    assert len(set(pictures)) == 4
    assert tab.evaluate(PICTURE) == pictures[0]  # the button goes back to the same bits


def test_the_slider_goes_over_the_cycles_and_the_face_tells_its_value(tab, finished):
    history = read_history(finished[0])
    first = "(() => { const s = document.querySelector('.stage input'); s.value = 0; s.dispatchEvent(new Event('input')); })()"
    last = tab.evaluate(PICTURE)
    tab.evaluate(first)
    assert tab.evaluate(PICTURE) != last
    assert tab.evaluate("document.querySelector('.stage output').textContent").startswith(
        "cycle 1: 0 s served"
    )
    tab.move(*tab.evaluate(MIDDLE))
    assert history.depth[0].max() == 0.0
    assert (
        tab.evaluate("document.querySelector('.stage .value').textContent")
        == "20.00 mm left, 0.000 mm worn off"
    )


def test_nothing_is_asked_of_a_network_and_nothing_goes_wrong(tab):
    assert tab.requested and all(address.startswith(("file:", "data:")) for address in tab.requested)
    assert tab.trouble == []


def test_printed_it_shows_the_maps_and_no_empty_canvas(tab, tmp_path):
    tab.call("Emulation.setEmulatedMedia", media="print")
    hidden = "getComputedStyle(document.querySelector('#view')).display"
    wide = "document.querySelector('.maps img').naturalWidth"
    assert tab.evaluate(hidden) == "none"
    assert tab.evaluate(wide) > 500  # pixels: it was decoded and is large enough to read
    tab.call("Emulation.setEmulatedMedia", media="screen")
    pdf = base64.b64decode(tab.call("Page.printToPDF", preferCSSPageSize=True)["data"])
    assert pdf.startswith(b"%PDF") and 1 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 8
