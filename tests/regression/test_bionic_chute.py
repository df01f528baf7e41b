"""The case bionic_chute, shortened, against its `expected.json`; one coupled cycle; what the shipped results say of the trends."""

import importlib.util
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wearfem.case import Window, load_any_case
from wearfem.cycle import cycle, first_state
from wearfem.liner.liner import wear_surface
from wearfem.liner.recede import volume

CASE = Path(__file__).parents[2] / "cases" / "bionic_chute"
SHORT = json.loads((CASE / "expected.json").read_text())["short"]


@pytest.fixture(scope="module")
def worn():
    """[m3] on the slice, without and with convexes."""
    found = []
    for convexes in (False, True):
        case = load_any_case(CASE, {**SHORT["settings"], "convexes": convexes})
        _, loads = case.sampler.sample(case.flow, wear_surface(case.liner), Window(SHORT["seconds"]))
        found.append(float(case.wear_law.volume(loads).sum()))
    return found


def test_wear_and_what_convexes_save(worn):
    smooth, embossed = worn
    figures = {
        "worn without convexes": smooth,
        "worn with convexes": embossed,
        "wear saved": 1.0 - embossed / smooth,
    }
    for name, value in figures.items():
        expected = SHORT[name]
        assert value == pytest.approx(expected["value"], abs=expected["tolerance"]), name


def test_one_cycle_moves_the_convexes_and_keeps_the_volume():
    case = load_any_case(CASE, {**SHORT["settings"], "tolerance": 0.5})
    case = replace(case, window=Window(0.1, 8), warm_up=0.15)
    state, report = cycle(case, first_state(case))
    before, now = case.liner.mesh, state.now.liner.mesh
    asked = float(report.jump.recession @ wear_surface(case.liner).facet_area)
    # One recession is exact to 1e-10; the walls between the normals of a shell's rim twist a little (test_convexes.py).
    assert volume(before) - volume(now) == pytest.approx(asked, rel=1e-5, abs=0.0)
    assert asked > 0.0
    lost = before.thickness - now.thickness
    height = before.thickness - before.thickness.min()
    start = case.effects[0].first * 20e-3  # [m] along the strip: before it nothing wears
    along = 2.0 * (np.arctan2(-before.node[:, 2], -before.node[:, 0]) - np.radians(27.0))
    assert (lost[along < start - 1e-9] == 0.0).all()
    worn = along > start + 1e-9
    top = worn & (height > 0.999 * height.max())
    assert lost[top].mean() > 3.0 * lost[worn & (height == 0.0)].mean()  # tops bear most; here some ten times
    assert (
        lost.max() <= 0.25 * 1.5e-3 * 2.0
    )  # a quarter of the smallest particle's radius, with ore twice as large
    side = [np.flatnonzero(np.isclose(before.node[:, 1], y, atol=1e-9)) for y in (0.0, 60e-3)]
    left, right = (nodes[np.argsort(along[nodes])] for nodes in side)
    # The strip still fits to itself, but for a step: one side borders on tiles with a convex, the other on tiles without, and each node
    # there sees its own side only. A step of 2 % of what tops lose is 40 um when they are gone, a hundredth of a particle.
    np.testing.assert_allclose(lost[left], lost[right], atol=0.02 * lost.max())


def test_the_shipped_trends_are_those_of_the_paper():
    spec = importlib.util.spec_from_file_location("bionic_trends", CASE / "trends.py")
    trends = sys.modules["bionic_trends"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(trends)
    runs, span = trends.read(), {}
    for name, (letter, levels, _) in trends.LEVELS.items():
        low, high = (
            trends.saved(runs, "upper half", **{name: level * 1e-3}) for level in (levels[0], levels[-1])
        )
        span[letter] = low.mean - high.mean
        if letter != "c0":  # beyond both intervals of 90 %
            assert abs(span[letter]) > np.hypot(low.half, high.half), letter
    assert (
        span["b0"] < 0.0 < min(span["a0"], span["c0"], span["d0"])
    )  # printed: wear rises with a0, c0, d0 and falls with b0
    assert span["c0"] < min(span["a0"], -span["b0"], span["d0"])  # printed: the least sensitive
