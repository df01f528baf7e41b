"""A small plate under real particles: lives for forecasts, and their end by brute force, which owes nothing to the jump controller."""

from dataclasses import replace

import numpy as np

from wearfem.case import LifeCase, Window
from wearfem.cycle import Particles
from wearfem.liner.block import Tetrahedra, block
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.recede import advance
from wearfem.proofs.cycle import ALLOWED, RATE, plate
from wearfem.units import mm
from wearfem.wear.jump import Goal
from wearfem.wear.laws import Archard
from wearfem.wear.smooth import HelmholtzFilter

LENGTH, WIDTH = 80 * mm, 40 * mm
FEED = 0.8  # [kg/s]: as the case has
SMOOTHING = 20 * mm


def plate_of_balls(seed: int) -> LifeCase:
    """The case `wearing_plate` with particles on two fifths of its length; some 80 balls at a time, a life known within 10 % is enough."""
    whole, formulas = plate(loads="particles", law="constant", seed=seed)
    balls = formulas.Balls(seed, LENGTH, WIDTH, whole.liner.material, feed=FEED)
    mesh = block((0, 0, -20 * mm), (LENGTH, WIDTH, 0), (8, 4, 4), Tetrahedra, name="plate")
    return replace(
        whole,
        flow=balls.nothing(),
        sampler=Particles(balls.model),
        liner=Liner(mesh, whole.liner.material),
        wear_law=Archard(balls.coefficient(RATE)),
        goal=Goal(np.full(len(mesh.wear), ALLOWED), tolerance=0.1),
        window=Window(0.4, 16),
        warm_up=0.2,
        throughput_rate=FEED,
        smoothing_length=SMOOTHING,
    )


def brute_force(seed: int, steps: int, window: float) -> tuple[np.ndarray, np.ndarray]:
    """Service times (n,) [s] and depths (n, f) [m] of the plate in many small equal steps with one long sample each.

    Adams-Bashforth of second order with constant steps of RATE: depth over rate of the plate as a whole, divided by `steps`; 0.3 s of
    each sample are thrown away. It goes on until a facet has lost what it may.
    """
    case = plate_of_balls(seed)
    step = ALLOWED / RATE / steps
    liner, flow, before = case.liner, case.flow, None
    time, depth = [0.0], [np.zeros(len(case.liner.mesh.wear))]
    while depth[-1].max() < ALLOWED:
        surface = wear_surface(liner)
        flow, _ = case.sampler.sample(flow, surface, Window(0.3, 1))
        flow, loads = case.sampler.sample(flow, surface, Window(window, 10))
        rate = HelmholtzFilter(surface, SMOOTHING)(case.wear_law.depth_rate(loads, liner)).mean(axis=0)
        gain = step * (rate if before is None else 1.5 * rate - 0.5 * before)
        moved = advance(liner, gain, service_time=step, throughput=0.0)
        assert moved.share > 0.999  # the mesh takes small steps whole
        liner, before = moved.liner, rate
        time.append(time[-1] + step)
        depth.append(depth[-1] + gain)
    return np.array(time), np.array(depth)


def end_by_brute_force(time: np.ndarray, depth: np.ndarray) -> float:
    """[s] when the first facet has lost what it may, on straight lines between the steps"""
    return float(np.interp(ALLOWED, depth.max(axis=1), time))
