"""The coupled cycle: sample the flow, rate the wear, jump ahead, move the surface, check the strength.

Wear changes the geometry, the geometry changes the flow. `cycle` is a pure function from one state to the next; a jump that proves too
bold is taken back without trace. Why it is so: docs/decisions/0008-the-cycle.md.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from wearfem.case import LifeCase, Window
from wearfem.errors import UserError
from wearfem.liner.breakthrough import Breakthrough, open_surface, thickness
from wearfem.liner.curvature import largest_curvature, shortest_edge
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.recede import advance, volume
from wearfem.liner.remesh import carry, remesh, renew
from wearfem.liner.solve import factorise
from wearfem.liner.traction import load_cases
from wearfem.loads import FacetLoads, in_one_block, in_sequence, on_facets, without_classes
from wearfem.surface import Surface
from wearfem.wear.budget import LEAST
from wearfem.wear.effect import smoothed_with_effects
from wearfem.wear.jump import Bounds, Goal, Jump, Life, choose_jump, end_of_life, is_trusted
from wearfem.wear.sampling import Sample, steady_from
from wearfem.wear.smooth import filter_over

Tell = Callable[[float, str], None]

PIECE = 8  # blocks that are sampled at once: their histograms are the largest thing in memory
PATIENCE = 50  # times the window given for the first sample, which it may become for its noise
ROUNDS = 6  # in which a mesh takes a jump, made anew or opened between them
LEAST_TAKEN = 1e-3  # part of a jump: a mesh that takes less does not recede
ROUNDING = 1e-9  # part of a service time that is no time


class Sampler(Protocol):
    """What tells the loads that a flow makes on the worn face as it is."""

    def sample(
        self, flow: Any, surface: Surface, window: Window, tell: Tell | None = None
    ) -> tuple[Any, FacetLoads]:
        """The flow after the window, and what it did to the facets of `surface` by block; `flow` is not changed."""
        ...


@dataclass(frozen=True)
class Particles:
    """Particles sample themselves: they flow over the worn face, in the model that is built around it."""

    model: Callable[[Surface], Any]  # the worn face as it is -> Model, with that surface among its walls

    def sample(
        self, flow: Any, surface: Surface, window: Window, tell: Tell | None = None
    ) -> tuple[Any, FacetLoads]:
        """The flow after the window, and what it did to the facets of `surface` by block."""
        from wearfem.dem.sample import sample  # here, since it loads numba

        model = self.model(surface)
        marks = [other.mark for other in model.surfaces]
        if surface.mark not in marks:
            raise UserError(
                f"the model has the surfaces {[other.name for other in model.surfaces]}, but not the worn face {surface.name} that it was "
                "given: put it among the walls as it is"
            )
        place = marks.index(surface.mark)
        first = sum(other.facet_count for other in model.surfaces[:place])
        flow, loads, _ = sample(flow, model, window, tell=tell)
        return flow, on_facets(loads, first, surface.facet_count)


@dataclass(frozen=True)
class Worn:
    """The liner and all that is told facet by facet, in the order of its present mesh."""

    liner: Liner
    receded: np.ndarray  # (f,) [m] by which the surface has been moved since the first sample
    allowed_depth: np.ndarray  # (f,) [m] since then, at which a facet is worn out
    samples: tuple[Sample, ...] = ()  # of all cycles that were kept


@dataclass(frozen=True)
class State:
    """Everything that a restart needs, nothing else."""

    flow: Any
    now: Worn  # where the next sample is taken
    kept: Worn | None = None  # where the last one was taken that is trusted: a jump too bold goes back to it
    jump: Jump | None = None  # from there to here
    cycle: int = 0  # done so far
    ended: str = ""  # why; empty while the life goes on


@dataclass(frozen=True)
class Strain:
    """How near the liner was to failing under what the cycle sampled, in the block that pressed at the 95th percentile."""

    von_mises: np.ndarray  # (f,) [Pa] at the worn facets
    largest_von_mises: float  # [Pa] anywhere
    least_reserve: float  # [-] yield stress over von Mises stress
    largest_deflection: float  # [m]


@dataclass(frozen=True)
class CycleReport:
    """What one cycle found. Fields by facet are in the order of the mesh that was sampled."""

    cycle: int  # from 1
    service_time: float  # [s] of the liner that was sampled
    throughput: float  # [kg]
    kept: bool  # whether the sample was trusted; if not, the liner went back to the one before
    rate: np.ndarray  # (f,) [m/s] mean
    error: np.ndarray  # (f,) [m/s] its standard error
    depth: np.ndarray  # (f,) [m] worn off since the liner was new
    thickness: np.ndarray  # (f,) [m] left
    worn_volume: float  # [m3] taken off the mesh since the first cycle of the run, by the areas that wore
    loads: FacetLoads  # of the steady flow, in one block
    window: float  # [s] of steady flow
    warm_up: float  # [s] thrown away before it
    jump: Jump
    taken: float  # [-] share of the jump that the mesh took
    life: Life  # as told by all samples kept
    strain: Strain | None
    event: str  # what happened to the mesh, in words

    def end_error(self, deviations: float) -> float:
        """[s] that the end of life may be off by if the rate stays: bias of jumps, noise so far, and of this rate over what is left."""
        left, place = max(self.life.time - self.service_time, 0.0), self.life.facet
        unsure = self.error[place] / self.rate[place] if self.kept and self.rate[place] > 0.0 else 0.0
        return abs(self.life.bias) + deviations * float(np.hypot(self.life.noise, left * unsure))


def first_state(case: LifeCase) -> State:
    """Before the first cycle."""
    depth = np.zeros(len(case.liner.mesh.wear))
    return State(case.flow, Worn(case.liner, depth, np.asarray(case.goal.allowed_depth, float)))


def cycle(case: LifeCase, state: State, tell: Tell | None = None) -> tuple[State, CycleReport]:
    """Sample the flow, rate the wear, jump ahead, move the surface, check the strength. Pure: `state` is never changed.

    Parameters
    ----------
    case, state
        Where the life stands.
    tell
        Called now and then with the seconds sampled and a word on them.
    """
    here = state.now
    surface = wear_surface(here.liner)
    goal, bounds = goal_of(case, here, surface), bounds_of(case, here.liner, surface)
    flow, measured = sample_rate(case, state, surface, goal, bounds, tell)
    strain = strain_of(case, here.liner, measured.by_block)

    sampled = replace(here, samples=(*here.samples, measured.sample))
    trusted = state.kept is None or is_trusted(sampled.samples, goal)
    if state.kept is None or trusted:
        kept, at_most = sampled, case.longest_jump
    else:
        kept, at_most = state.kept, 0.5 * (here.liner.service_time - state.kept.liner.service_time)
        surface = wear_surface(kept.liner)
        goal, bounds = goal_of(case, kept, surface), bounds_of(case, kept.liner, surface)
    jump = next_jump(case, kept, goal, bounds, at_most)
    moved, taken, event = move(case, kept, jump)
    ended = why_ended(case, kept, jump, event)

    report = CycleReport(
        cycle=state.cycle + 1,
        service_time=here.liner.service_time,
        throughput=here.liner.throughput,
        kept=trusted,
        rate=measured.sample.mean,
        error=measured.sample.error,
        depth=here.liner.depth,
        thickness=thickness(here.liner.mesh) - (here.receded if case.frozen else 0.0),
        worn_volume=volume(case.liner.mesh) - volume(here.liner.mesh),
        loads=measured.loads,
        window=measured.sample.window,
        warm_up=measured.sample.warm_up,
        jump=jump,
        taken=taken,
        life=end_of_life(kept.samples, goal),
        strain=strain,
        event=event,
    )
    return State(flow, moved, kept, jump, state.cycle + 1, ended), report


# Sampling


@dataclass(frozen=True)
class Measured:
    """What one cycle sampled: the rate, and the loads that it comes from."""

    sample: Sample
    loads: FacetLoads  # in one block, with histograms
    by_block: FacetLoads  # without them


def sample_rate(
    case: LifeCase, state: State, surface: Surface, goal: Goal, bounds: Bounds, tell: Tell | None = None
) -> tuple[Any, Measured]:
    """Let the flow run over the worn face until its rate of wear is known as well as was planned, or until the jump here proves too bold.

    The length is fixed beforehand, by the jump before; only the first sample is made longer, for its noise alone (decision 0006).
    Effects see loads without the warm-up that is known beforehand; what more of it is found is left out of the rate.
    """
    block = case.window.duration / case.window.block_count
    earlier, planned = state.now.samples, state.jump if state.now.samples else None
    known = round((planned.warm_up if planned else case.warm_up) / block)
    least = max(LEAST, int(np.ceil((planned.window if planned else case.window.duration) / block - ROUNDING)))
    flow, pieces, asked = state.flow, _Pieces(case, state.now.liner, known), known + LEAST
    while True:
        flow = _sample_pieces(case, flow, surface, pieces, block, asked, tell)
        rate = pieces.rate(surface)
        start = max(steady_from(rate @ surface.facet_area), known)
        steady = len(rate) - start
        if steady >= LEAST:
            time, shape = state.now.liner.service_time, state.now.receded
            sample = Sample(time, rate[start:].copy(), block, start * block, shape)
            if steady >= least and not earlier:
                jump = next_jump(case, replace(state.now, samples=(sample,)), goal, bounds, case.longest_jump)
                if jump.limited_by == "noise":
                    least = int(np.ceil(jump.window / block - ROUNDING))
                    _refuse_beyond_patience(case, surface, goal, jump.window)
            if steady >= least or not is_trusted((*earlier, sample), goal):
                return flow, Measured(sample, pieces.total, pieces.by_block)
        asked = max(least - steady, 1)


def _refuse_beyond_patience(case: LifeCase, surface: Surface, goal: Goal, window: float) -> None:
    """Raise `UserError` where noise asks for a first sample that is far longer than the one given."""
    if window > PATIENCE * case.window.duration:
        raise UserError(
            f"the rate of wear on {surface.name} is so noisy that the first sample would have to be {window:.3g} s long, with a window "
            f"of {case.window.duration:.3g} s given: give the case a longer window, a larger tolerance than {goal.tolerance:g} or a "
            "larger smoothing_length"
        )


def _sample_pieces(
    case: LifeCase,
    flow: Any,
    surface: Surface,
    pieces: "_Pieces",
    block: float,
    asked: int,
    tell: Tell | None,
) -> Any:
    """Sample `asked` more blocks, a few at a time, and never across the end of the warm-up; the flow after them."""
    while asked > 0:
        count = min(asked, PIECE)
        if pieces.count < pieces.known:
            count = min(count, pieces.known - pieces.count)
        window = Window(count * block, count)
        flow, loads = case.sampler.sample(flow, surface, window, _told(tell, pieces.count * block))
        pieces.add(loads)
        asked -= count
    return flow


class _Pieces:
    """Loads as they come: the rate of every block, histograms only in sum."""

    def __init__(self, case: LifeCase, liner: Liner, known: int) -> None:
        self.case, self.liner, self.known = case, liner, known
        self.rows: list[np.ndarray] = []
        self.warm: list[FacetLoads] = []
        self.blocks: list[FacetLoads] = []
        self.sums: FacetLoads | None = None

    @property
    def count(self) -> int:
        """Of blocks so far"""
        return sum(len(row) for row in self.rows)

    def add(self, loads: FacetLoads) -> None:
        """Take the next blocks; those of the warm-up known beforehand give a rate and nothing else."""
        warm = self.count < self.known
        self.rows.append(self.case.wear_law.depth_rate(loads, self.liner))
        if not warm:
            self.blocks.append(without_classes(loads))
            one = in_one_block(loads)
            self.sums = one if self.sums is None else in_one_block(in_sequence([self.sums, one]))

    def rate(self, surface: Surface) -> np.ndarray:
        """(b, f) [m/s] of every block, smoothed, with effects"""
        smooth = filter_over(surface, self.case.smoothing_length)
        return smoothed_with_effects(
            np.concatenate(self.rows), self.case.effects, self.total, self.liner, smooth
        )

    @property
    def total(self) -> FacetLoads:
        """After the warm-up known beforehand, in one block"""
        assert self.sums is not None  # a sample has more blocks than its warm-up
        return self.sums

    @property
    def by_block(self) -> FacetLoads:
        """After the warm-up known beforehand, without histograms"""
        return in_sequence(self.blocks)


def _told(tell: Tell | None, before: float) -> Tell | None:
    return None if tell is None else lambda done, word: tell(before + done, word)


# Choosing


def worn_to(
    liner: Liner, limit: np.ndarray | float = 0.0, *, tolerance: float = 0.02, confidence: float = 0.9
) -> Goal:
    """The goal of wearing down to a thickness.

    Parameters
    ----------
    liner
        As it is at the start.
    limit
        [m] thickness at which a facet is worn out: one for all, or (f,).
    tolerance, confidence
        See `Goal`.

    Raises
    ------
    UserError
        for a limit above the present thickness.
    """
    left = thickness(liner.mesh)
    spare = left - limit
    if not (spare > 0.0).all():
        thin, given = int(np.argmin(spare)), float(np.max(limit))
        hint = f" ({given:g} without a unit is metres: {given:g}*mm is meant?)" if given >= 1.0 else ""
        raise UserError(
            f"{liner.mesh.name} is worn out from the beginning: facet {thin} is {1e3 * left[thin]:.4g} mm thick, the limit is "
            f"{1e3 * np.broadcast_to(limit, left.shape)[thin]:.4g} mm; give a limit below the present thickness{hint}"
        )
    return Goal(spare, wear_surface(liner).facet_area, tolerance, confidence)


def goal_of(case: LifeCase, worn: Worn, surface: Surface) -> Goal:
    """The case's goal on the present facets."""
    return replace(case.goal, allowed_depth=worn.allowed_depth, area=surface.facet_area)


def bounds_of(case: LifeCase, liner: Liner, surface: Surface) -> Bounds:
    """Lengths of the present geometry that a jump must stay well below; none where it is frozen."""
    if case.frozen:
        return Bounds()
    return Bounds(
        edge_length=shortest_edge(liner.mesh.node, liner.mesh.wear),
        particle_radius=case.particle_radius,
        curvature=largest_curvature(surface),
    )


def next_jump(case: LifeCase, worn: Worn, goal: Goal, bounds: Bounds, at_most: float) -> Jump:
    """The jump after the last sample that is trusted, no further than the stop."""
    left = case.stop.service_time - worn.liner.service_time
    if left <= ROUNDING * worn.liner.service_time:
        return Jump(0.0, "asked", 0.0, 0.0, 0.0, np.zeros_like(worn.receded))
    return choose_jump(worn.samples, worn.receded, goal, bounds, at_most, left)


def why_ended(case: LifeCase, worn: Worn, jump: Jump, event: str) -> str:
    """Why the life is not followed any further; empty while it goes on."""
    if event.startswith("worn through") and case.stop.breakthrough:
        return event
    if jump.duration > 0.0:
        return ""
    return "end of life" if jump.limited_by == "end of life" else "service time"


# Moving


def move(case: LifeCase, worn: Worn, jump: Jump) -> tuple[Worn, float, str]:
    """The liner after the jump, the share of it that the mesh took, and what happened to the mesh, in words."""
    if jump.duration == 0.0:
        return worn, 1.0, ""
    if case.frozen:
        liner = replace(
            worn.liner,
            depth=worn.liner.depth + jump.recession,
            service_time=worn.liner.service_time + jump.duration,
            throughput=worn.liner.throughput + jump.duration * case.throughput_rate,
        )
        return replace(worn, liner=liner, receded=worn.receded + jump.recession), 1.0, ""
    moved, rest, taken, event = worn, jump.recession, 0.0, ""
    for _ in range(ROUNDS):
        left = 1.0 - taken
        recession = advance(
            moved.liner,
            rest,
            service_time=left * jump.duration,
            throughput=left * jump.duration * case.throughput_rate,
        )
        moved = replace(moved, liner=recession.liner, receded=moved.receded + recession.share * rest)
        taken, rest = taken + recession.share * left, (1.0 - recession.share) * rest
        if recession.breakthrough is not None:
            event = _where(recession.breakthrough)
            if case.stop.breakthrough:
                return moved, taken, event
            opened = _opened(moved)
            if len(opened.receded) < len(moved.receded):
                return opened, taken, f"{event}, opened"
        elif recession.remesh_needed:
            moved, carried, event = _meshed_again(case, moved)
            rest = carried(rest)
        if taken > 1.0 - ROUNDING:
            return moved, 1.0, event
    if taken < LEAST_TAKEN:
        raise UserError(
            f"{worn.liner.mesh.name} cannot recede with the elements that it has: give the case another element_size, or a "
            "smoothing_length of a few facets"
        )
    return moved, taken, event


def _where(hole: Breakthrough) -> str:
    x, y, z = hole.place
    return f"worn through at ({x:.4g}, {y:.4g}, {z:.4g}) m"


def _opened(worn: Worn) -> Worn:
    """The liner without what is worn through. A hole of one facet, which the mesh spreads over its neighbours, opens nothing yet."""
    opening = open_surface(worn.liner)
    if not len(opening.facet):
        raise UserError(f"{worn.liner.mesh.name} has no worn face left: all of it is worn through")
    return _on_other_facets(worn, opening.liner, lambda field: field[..., opening.facet])


def _meshed_again(case: LifeCase, worn: Worn) -> tuple[Worn, Callable[[np.ndarray], np.ndarray], str]:
    """New elements where the old ones are worn out, and how fields are carried to them."""
    old = worn.liner
    size = case.element_size or float(np.sqrt(wear_surface(old).facet_area.mean()))
    new = renew(old, size)
    if new is old:  # not badly shaped, and yet they would have turned over
        new = remesh(old, size)

    def carried(field: np.ndarray) -> np.ndarray:
        return carry(field, old, new)

    event = f"meshed again, {len(new.mesh.element)} elements"
    return _on_other_facets(worn, new, carried), carried, event


def _on_other_facets(worn: Worn, liner: Liner, carried: Callable[[np.ndarray], np.ndarray]) -> Worn:
    """All that is told by facet, on the facets of another mesh. Of allowed depths the inverse is carried: 0 where none is judged."""
    return Worn(
        liner=liner,
        receded=carried(worn.receded),
        allowed_depth=_inverse(carried(_inverse(worn.allowed_depth))),
        samples=tuple(_carried(sample, carried) for sample in worn.samples),
    )


def _carried(sample: Sample, carried: Callable[[np.ndarray], np.ndarray]) -> Sample:
    depth = None if sample.depth is None else carried(sample.depth)
    return replace(sample, rate=carried(sample.rate), depth=depth)


def _inverse(length: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore"):
        return 1.0 / length


# Strength


def strain_of(case: LifeCase, liner: Liner, loads: FacetLoads) -> Strain | None:
    """Stress under the peak load of the sample; None where the case has no structure."""
    if case.structure is None:
        return None
    peak = factorise(liner, case.structure).solve(load_cases(loads, liner).peak)
    stress = peak.von_mises
    return Strain(
        von_mises=peak.at_facets(stress, liner.mesh.wear),
        largest_von_mises=float(stress.max()),
        least_reserve=float(peak.reserve_factor.min()),
        largest_deflection=float(peak.deflection.max()),
    )
