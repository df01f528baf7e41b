"""The coupled cycle on a plate whose life is known: closed forms, the order in time, and a restart to the bit."""

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from wearfem.case import LifeCase, load_any_case, parts_of
from wearfem.cycle import CycleReport, State, cycle, first_state
from wearfem.formula import Sliding
from wearfem.history import History, history_of, read_cycle, write_cycle
from wearfem.liner.liner import wear_surface
from wearfem.liner.recede import volume
from wearfem.proof import Claim
from wearfem.surface import Surface
from wearfem.wear.effect import FactorEffect, all_factors

CASE = Path(__file__).parents[3] / "cases" / "wearing_plate"
LAWS = ("constant", "hardness_gradient", "running_in")
RATE, ALLOWED = 1e-9, 10e-3  # [m/s], [m] of the case
QUIET = {"noise": 0.0, "delay": 0.0, "cells": 4}


def claims() -> Iterator[Claim]:
    """Lives and depths by formula, on a real mesh that recedes; order of equal jumps; written and read; geometry kept."""
    for law in LAWS:
        yield from closed_form(law)
    for law in LAWS[1:]:
        yield from closed_form(law, told=False)
    yield from order("hardness_gradient", (40, 80))
    yield restart()
    yield from promise()


def untold(case: LifeCase) -> LifeCase:
    """The same life where the flow does by the shape of the plate what the metal did by depth: nothing of it is known beforehand."""
    top = wear_surface(case.liner).point[:, 2].max()
    effects = [effect for effect in case.effects if isinstance(effect, FactorEffect)]
    assert isinstance(case.sampler, Sliding)

    def intensity(surface: Surface) -> np.ndarray:
        height = surface.corner.mean(axis=1)[:, 2]
        depth = top - np.bincount(surface.facet, height) / np.bincount(surface.facet)
        return all_factors(effects, {"depth": depth}) * np.ones_like(depth)

    return replace(case, effects=(), sampler=replace(case.sampler, intensity=intensity))


def closed_form(law: str, told: bool = True) -> Iterator[Claim]:
    """The whole cycle without noise: loads by formula, tetrahedra that recede, jumps by the controller at 0.1 %.

    The law is one of the metal that the case is told of, or of a flow that must be sampled.
    """
    case, formula = plate(law=law, tolerance=1e-3, **QUIET)
    history = lived(case if told else untold(case))
    life = formula.life(law, ALLOWED, RATE)
    name = law if told else f"{law} of the flow"
    yield Claim(
        f"end of life, {name}, {len(history.service_time)} cycles", "integral of 1/r over depth", life, history.life[-1].time, "s", 1e-3,
        True, "0.1 % is asked, and given to the controller as its tolerance",
    )  # fmt: skip
    inside = history.service_time < life
    true = formula.depth_at(law, history.service_time[inside], RATE)
    apart = float(np.abs(history.depth[inside] - true[:, None]).max())
    yield Claim(
        f"largest error of depth, any cycle and facet, {name}", "closed form d(t)", 0.0, apart, "m", 1e-3 * ALLOWED * 2.0, False,
        "an error of 0.1 % in time is one of 0.2 % in depth where the rate has doubled",
    )  # fmt: skip
    lost = volume(case.liner.mesh) - volume(history.state.now.liner.mesh)
    area = float(history.area.sum())
    yield Claim(
        f"volume that the mesh lost, {name}", "area x depth moved", float(history.area @ history.state.now.receded), lost, "m3", 1e-9, True,
        f"plate of {1e4 * area:.4g} cm2 that stays plane; rounding of some tens of recessions",
    )  # fmt: skip


def order(law: str, counts: tuple[int, int]) -> Iterator[Claim]:
    """Error of life over number of equal jumps: by the trapezoid rule, and less its bias. Of a flow: a metal is integrated exactly."""
    error, cycles = [], []
    for count in counts:
        case, formula = plate(law=law, tolerance=0.1 / count, jumps=count, **QUIET)
        history = lived(untold(case))
        life, told = formula.life(law, ALLOWED, RATE), history.life[-1]
        error.append(np.abs(np.array([told.time + told.bias, told.time]) / life - 1.0))
        cycles.append(len(history.service_time))
    plain, without = np.log(error[0] / error[1]) / np.log(cycles[1] / cycles[0])
    yield Claim(
        f"order in time through the whole cycle, {law}, {cycles[0]} and {cycles[1]} samples", "trapezoid rule: second order", 2.0,
        float(plain), "-", 0.25, False, "the number of samples is off by one or two",
    )  # fmt: skip
    yield Claim(
        f"the same less its bias, {law}", "third order where the bends are resolved", 3.0, float(without), "-", np.inf, False,
    )  # fmt: skip


def promise(told: bool = True, seeds: int = 60) -> Iterator[Claim]:
    """Noisy lives through the whole cycle: the error told beside the true one, and how often the interval holds the truth"""
    promised, true, way = [], [], "metal" if told else "flow"
    for seed in range(100, 100 + seeds):
        case, formula = plate(law="hardness_gradient", seed=seed, cells=4)
        life = lived(case if told else untold(case)).life[-1]
        truth = formula.life("hardness_gradient", ALLOWED, RATE)
        promised.append(life.error() / truth)
        true.append(life.time / truth - 1.0)
    deviations = case.goal.deviations
    told_rms, true_rms = (float(np.sqrt(np.mean(np.square(one)))) for one in (promised, true))
    yield Claim(
        f"error told over the true one, rms of {seeds} noisy lives, gradient of the {way}", "within a factor 2 is asked", 1.0,
        told_rms / true_rms, "-", 1.0, False,
        f"true error {true_rms:.2%} rms, {np.mean(true):+.2%} in the mean; the ratio is known to 1/sqrt(2 x {seeds}) = 16 %",
    )  # fmt: skip
    error = float(np.quantile(np.abs(true), 0.9))
    yield Claim(
        f"error that 90 % of {seeds} noisy lives stay within, gradient of the {way}", "2 % asked", 0.02, error, "-", 0.4, True,
        "the 90 % quantile of 60 lives is itself known to 12 % (one deviation)",
    )  # fmt: skip
    inside = float(np.mean(np.abs(true) <= deviations * np.array(promised)))
    yield Claim(
        f"share of {seeds} noisy lives within the 90 % interval told, gradient of the {way}", "90 %", 0.9, inside, "-", np.inf, False,
        "decision 0006: the error told is that of the mean",
    )  # fmt: skip


def restart() -> Claim:
    """A life that is written down and read again before every cycle, beside one that is not"""
    case, _ = plate(cells=4)
    through, _ = whole_life(case)
    state = first_state(case)
    with tempfile.TemporaryDirectory() as folder:
        while not state.ended:
            new, report = cycle(case, state)
            write_cycle(Path(folder), new, report, worn=state.now)
            state, _ = read_cycle(Path(folder), new.cycle)
    return Claim(
        f"numbers that differ after {state.cycle} restarts", "a life never interrupted", 0.0, float(differences(through, state)), "-", 0.0,
        False, "every array and number of the state, to the bit",
    )  # fmt: skip


def plate(**settings: Any) -> tuple[LifeCase, ModuleType]:
    """The case with its keywords, and its module with the closed forms."""
    case = load_any_case(CASE, settings)
    assert isinstance(case, LifeCase)
    return case, parts_of(CASE)


def whole_life(case: LifeCase) -> tuple[State, tuple[CycleReport, ...]]:
    """All cycles of a case, in memory."""
    state, reports = first_state(case), []
    while not state.ended:
        state, report = cycle(case, state)
        reports.append(report)
    return state, tuple(reports)


def lived(case: LifeCase) -> History:
    """The history of a whole life."""
    return history_of(*whole_life(case))


def differences(one: Any, other: Any) -> int:
    """How many arrays and numbers of two values are not the same to the bit."""
    if isinstance(one, np.ndarray):
        same = isinstance(other, np.ndarray) and (one.dtype, one.shape) == (other.dtype, other.shape)
        return int(not (same and one.tobytes() == other.tobytes()))
    if type(one) is not type(other):
        return 1
    if isinstance(one, dict):
        return differences(tuple(one.items()), tuple(other.items()))
    if isinstance(one, tuple | list):
        return int(len(one) != len(other)) + sum(map(differences, one, other))
    names = getattr(one, "__dataclass_fields__", None)
    if names is not None:
        return sum(differences(getattr(one, name), getattr(other, name)) for name in names)
    return int(not (one == other or (one != one and other != other)))
