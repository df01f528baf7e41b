"""What smoothing took off the deepest rate: a wave and a band beside closed forms, and noise that is not taken for it."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.case import Stop, Window
from wearfem.cycle import worn_to
from wearfem.formula import FormulaFlow, Sliding
from wearfem.liner.block import Hexahedra, block
from wearfem.liner.liner import Liner
from wearfem.proofs.cycle import QUIET, lived, plate
from wearfem.sharpness import deepest, of_whole_face, rates
from wearfem.units import day, mm

LENGTH = 1.0  # [m] of a strip that is one facet of 10 mm wide
FACET = 10 * mm


def strip(intensity, smoothing, noise=0.0, seed=1, stop=40 * day):
    """The life so far of a strip under a load by place x [m], with its smoothing; the shape stays."""
    case, _ = plate(law="constant", **QUIET)
    mesh = block((0, 0, -20 * mm), (LENGTH, FACET, 0), (round(LENGTH / FACET), 1, 1), Hexahedra, name="strip")
    liner = Liner(mesh, case.liner.material)
    x = mesh.node[mesh.wear].mean(axis=1)[:, 0]
    flow = Sliding(
        1e4,
        1.0,
        intensity=lambda surface: intensity(x),
        facet_noise=noise,
        memory=0.5 if noise else 0.0,
        seed=seed,
    )
    case = replace(
        case, liner=liner, goal=worn_to(liner, 10 * mm), sampler=flow, flow=FormulaFlow(), smoothing_length=smoothing,
        frozen=True, window=Window(10.0, 40), longest_jump=4 * day, stop=Stop(stop),
    )  # fmt: skip
    return lived(case), case


@pytest.mark.parametrize("smoothing", [60 * mm, 30 * mm])
def test_a_wave_is_flattened_as_the_filter_says(smoothing):
    """1 + a cos(k x) becomes 1 + a / (1 + l^2 k^2) cos(k x): second order in l where the wear is smooth."""
    k, a = 2.0 * np.pi / LENGTH, 0.5
    history, case = strip(lambda x: 1.0 + a * np.cos(k * x), smoothing)
    told = of_whole_face(history, case)
    flat = (1.0 + a / (1.0 + (smoothing * k) ** 2)) / (1.0 + a)
    assert told.over[-1] == 0.0 and told.error == pytest.approx(0.0, abs=1e-9)  # without noise
    assert told.kept[-1] == pytest.approx(
        flat, rel=2e-3
    )  # facets of 10 mm and their sharing: (k h)^2 / 6 of a


def test_what_is_told_of_smooth_wear_falls_with_the_square_of_the_length():
    runs = [strip(lambda x: 1.0 + 0.5 * np.cos(2.0 * np.pi * x), length) for length in (60 * mm, 30 * mm)]
    told = [1.0 - of_whole_face(*run).kept[-1] for run in runs]
    assert np.log2(told[0] / told[1]) == pytest.approx(
        2.0, abs=0.25
    )  # 1 / (1 + l^2 k^2) itself is of order 1.9 here


def test_a_band_is_flattened_as_the_filter_says():
    """A band of width b over nothing: 1 - exp(-b / 2l) in its middle."""
    width, smoothing = 50 * mm, 30 * mm
    history, case = strip(lambda x: 0.01 + (np.abs(x - 0.505) < 0.5 * width), smoothing)
    told = of_whole_face(history, case)
    flat = (0.01 + 1.0 - np.exp(-0.5 * width / smoothing)) / 1.01
    # facets of a third of the length share their values with their neighbours
    assert told.kept[-1] == pytest.approx(flat, rel=0.03)
    half = 1.0 - np.exp(-width / smoothing)
    assert told.kept[0] == pytest.approx((flat - 0.01 / 1.01) / half, rel=0.03)  # over half of the length


def test_noise_is_not_taken_for_sharpness():
    """Even wear, each facet with noise of its own: the largest of a hundred noisy rates is no sharpness."""
    told = [of_whole_face(*strip(np.ones_like, 30 * mm, noise=0.3, seed=seed)) for seed in range(1, 13)]
    lost = np.array([1.0 - one.kept for one in told])  # (12 lives, 3 lengths)
    error = np.array([one.error for one in told])
    # the mean of twelve is known to a standard error over sqrt(12): three of these
    assert (np.abs(lost.mean(axis=0)) < 3.0 * error.mean(axis=0) / np.sqrt(12.0)).all()
    assert np.sqrt(np.mean(np.square(lost / error))) == pytest.approx(
        1.0, abs=0.5
    )  # the doubt told is the one there is
    history, case = strip(np.ones_like, 30 * mm, noise=0.3)
    naive = rates(history, case, np.asarray).mean(axis=0)
    assert (
        naive.max() / naive.mean() > 1.0 + 3.0 * error[:, -1].mean()
    )  # the largest of all would be taken for a place that wears deeper


def test_place_and_rate_come_from_different_halves():
    rate = np.array([[1.0, 5.0, 1.0], [2.0, 1.0, 2.0], [1.0, 5.0, 1.0], [2.0, 1.0, 3.0]])
    # one half has its largest at place 1, where the other has 1; the other at place 2, where the first has 1
    assert np.array_equal(deepest(rate, np.ones(4)), [1.0, 1.0, 1.0, 1.0])


def test_nothing_is_told_without_smoothing_or_of_few_samples():
    history, case = strip(np.ones_like, 30 * mm, stop=8 * day)
    assert len(history.samples) < 6 and of_whole_face(history, case) is None
    history, case = strip(np.ones_like, 30 * mm)
    assert (
        of_whole_face(history, replace(case, smoothing_length=0.0)) is None
        and of_whole_face(history, None) is None
    )
    words = of_whole_face(history, case).words(50 * day)
    assert words.endswith("had the same loads been smoothed over 15, 7.5 and 0 mm instead of 30 mm")
    assert "0.0 +- 0.0, " in words
