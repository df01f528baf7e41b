"""Move a flow through time, and sample what it does to the facets."""

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from wearfem.dem.flow import Flow, Model
from wearfem.dem.geometry import geometry
from wearfem.dem.motion import POSE, bodies, pose_at
from wearfem.dem.neighbours import chunk_bounds, empty_pairs, list_pairs, sort_into_cells
from wearfem.dem.pairs import PACKED, PairList, memory_rows
from wearfem.dem.particles import Particles, chosen, joined, spheres
from wearfem.dem.start import check_start
from wearfem.dem.steps import (
    DONE,
    LIST_PAIRS,
    LIST_WALLS,
    NOT_A_NUMBER,
    Constants,
    ManyChunks,
    OneChunk,
    largest_shift,
    middle_velocity,
    step_on,
    time_at,
    wrap,
)
from wearfem.dem.tally import (
    ANGLE,
    ANGLE_CLASSES,
    CONTACTS,
    CUSTOM,
    ENERGY,
    FRICTION_WORK,
    LOAD_DISTANCE,
    NORMAL,
    SLIP,
    TANGENTIAL,
    TIME,
    Tally,
    empty_tally,
    force_edges,
    speed_edges,
    with_room,
)
from wearfem.dem.wall_list import ITEM, WallList, empty_walls, list_walls
from wearfem.errors import UserError
from wearfem.loads import FacetLoads

STALE = 0.9  # part of a margin beyond which lists are made anew rather than kept a little longer

# The margin of the pair list follows the flow by counting steps, never time, so that results stay the same to the bit: lists that
# last less than OFTEN steps get a wider margin, more than SELDOM steps a narrower one, within bounds (parts of the mean radius).
OFTEN, SELDOM = 25, 100
NARROWEST, WIDEST, FACTOR = 0.2, 0.5, 1.25


def continued(body: np.ndarray, old: tuple[str, ...], new: tuple[str, ...]) -> np.ndarray:
    """Wall numbers of contacts, when the walls change from `old` to `new` marks; -1 for contacts whose wall is gone.

    A wall goes on as the one of the same mark, else as the one of the same name (a surface that has worn).
    """

    def name(mark: str) -> str:
        return mark.rpartition(" ")[0]

    def heir(mark: str) -> int:
        if mark in new:
            return new.index(mark)
        names = [name(other) for other in new]
        return names.index(name(mark)) if names.count(name(mark)) == 1 else -1

    heirs = np.array([*(heir(mark) for mark in old), -1], np.int32)
    return heirs[body]


class Stepper:
    """A flow on its way through a window: working copies of its arrays, and the model packed for the kernels."""

    def __init__(self, flow: Flow, model: Model) -> None:
        self.model = model
        self.flow = flow
        particles = flow.particles
        radius = particles.radius
        few = particles.count < 10
        self.mean_radius = float(radius.mean() if len(radius) else 4e-3)
        self.pair_skin = model.pair_skin or flow.pair_skin or 0.25 * self.mean_radius
        self.listed_step = flow.listed_step
        self.wall_skin = model.wall_skin or float(
            (1.0 if few else 0.5) * radius.mean() if len(radius) else 1e-3
        )
        largest = max([*radius, *(inlet.sizes.largest for inlet in model.inlets), 1e-6])
        number = {material: k for k, material in enumerate(model.materials)}
        walls = [(wall.shape, wall.motion) for wall in model.walls]
        low = np.asarray(model.domain.low, float)
        self.geometry = geometry(walls, number, 2.0 * (largest + self.wall_skin), model.period, low)
        self.bodies = bodies([motion for _, motion in walls])
        same_step = flow.time_step in (0.0, model.time_step)
        origin = (flow.origin, flow.origin_step) if same_step else (flow.time, flow.step)
        self.constants = Constants(
            np.asarray(model.gravity, float),
            model.time_step,
            self.pair_skin,
            self.wall_skin,
            low,
            model.period,
            *origin,
        )
        self.tally = empty_tally(model.facet_count)
        self.clock = np.array([flow.step, 0])
        self.next_ident = max(flow.next_ident, int(particles.ident.max(initial=-1)) + 1)
        self.travel, self.drift, self.ledger = flow.travel.copy(), flow.drift.copy(), flow.ledger.copy()
        self.particles = Particles(*(array.copy() for array in particles))
        self.rows = memory_rows(model.contact)
        self.pair_reference, self.wall_reference = flow.pair_reference, flow.wall_reference
        self.packed = np.zeros((particles.count, PACKED)) if flow.packed is None else flow.packed.copy()
        if flow.pairs is not None and flow.walls is not None:
            self.pairs = PairList(*(array.copy() for array in flow.pairs))
            self.walls = WallList(*(array.copy() for array in flow.walls))
            if flow.marks != model.marks:
                self.walls = self.walls._replace(body=continued(self.walls.body, flow.marks, model.marks))
                self.walls.record[..., ITEM] = -1.0  # triangles may be numbered anew
                self.list_walls_again()
        else:
            chunks = len(chunk_bounds(particles.count)) - 1
            self.pairs = empty_pairs(particles.count, chunks, 0, self.rows)
            self.walls = empty_walls(particles.count)
            if particles.count:
                self.list_again()
        self.tally = with_room(self.tally, self.walls.chunk_start)

    def result(self) -> Flow:
        """The flow as it is now."""
        step = int(self.clock[0])
        return replace(
            self.flow,
            particles=self.particles,
            step=step,
            time=self.time,
            time_step=self.model.time_step,
            origin=self.constants.origin,
            origin_step=self.constants.origin_step,
            next_ident=self.next_ident,
            ledger=self.ledger,
            pairs=self.pairs,
            walls=self.walls,
            marks=self.model.marks,
            packed=self.packed,
            pair_reference=self.pair_reference,
            wall_reference=self.wall_reference,
            travel=self.travel,
            drift=self.drift,
            pair_skin=self.pair_skin,
            listed_step=self.listed_step,
        )

    @property
    def time(self) -> float:
        """[s]"""
        return float(time_at(self.constants, self.clock[0]))

    def stride(self, most: int) -> int:
        """Steps between looks at inlets and outlets: a largest particle entering moves about its radius."""
        strides = [most]
        for inlet in self.model.inlets:
            radius = inlet.sizes.largest
            speed = max(float(np.linalg.norm(inlet.velocity)), np.sqrt(9.81 * radius))
            strides.append(max(1, int(radius / speed / self.model.time_step)))
        if self.model.domain.outlet:
            strides.append(max(1, int(5e-3 / self.model.time_step)))
        return min(strides + [max(1, int(2e5 / max(self.particles.count, 1)) * 100)])

    def pose(self) -> np.ndarray:
        """(bodies, POSE) where the bodies are now"""
        pose = np.zeros((max(len(self.model.walls), 1), POSE))
        for body in range(len(self.model.walls)):
            pose_at(self.bodies, body, self.time, pose[body])
        return pose

    def adapt_margin(self) -> None:
        """Widen or narrow the margin of the pair list after the number of steps that the last list was good for."""
        lasted = int(self.clock[0]) - self.listed_step
        if self.model.pair_skin or OFTEN <= lasted <= SELDOM:
            return
        wanted = self.pair_skin * (FACTOR if lasted < OFTEN else 1.0 / FACTOR)
        self.pair_skin = min(max(wanted, NARROWEST * self.mean_radius), WIDEST * self.mean_radius)
        self.constants = self.constants._replace(pair_skin=self.pair_skin)

    def list_again(self, was: np.ndarray | None = None) -> None:
        """List pairs and walls anew; `was` says where the particles, as they stand now, were in the arrays of the old lists."""
        p = self.particles
        row_of = self.walls.row_of if was is None else self.walls.row_of[was]
        wrap(p, self.packed, row_of, self.walls, self.constants.low, self.constants.period)
        bounds = chunk_bounds(p.count)
        grid, order = sort_into_cells(
            p.position, p.radius, self.constants.low, self.constants.period, self.pair_skin
        )
        self.particles = chosen(p, order)
        self.packed = self.packed[order]
        was = order if was is None else was[order]
        p = self.particles
        self.pairs = list_pairs(
            self.model.contact,
            p.position,
            p.radius,
            grid,
            bounds,
            was,
            self.pairs,
            self.pair_skin,
            self.constants.period,
        )
        self.pair_reference = p.position.copy()
        self.listed_step = int(self.clock[0])
        middle_velocity(p.velocity, self.drift)
        self.travel[0] = 0.0
        self.list_walls_again(was)

    def list_walls_again(self, was: np.ndarray | None = None) -> None:
        """List anew which particles are near which triangles."""
        p = self.particles
        was = np.arange(p.count) if was is None else was
        bounds = chunk_bounds(p.count)
        self.walls = list_walls(
            self.geometry, self.pose(), p.position, p.radius, bounds, self.wall_skin, was, self.walls
        )
        self.wall_reference = p.position.copy()
        self.travel[1:] = 0.0
        self.tally = with_room(self.tally, self.walls.chunk_start)

    def advance(self, steps: int) -> None:
        """Take `steps` time steps."""
        if not self.particles.count:
            self.clock[0] += steps
            return
        chunks = len(chunk_bounds(self.particles.count)) - 1
        drive = OneChunk() if chunks == 1 else ManyChunks(chunks)
        listing = False
        while True:
            begun, status = step_on(
                drive, self.model.contact, self.model.tally, self.model.table, self.geometry, self.bodies, self.particles, self.packed,
                self.pairs, self.walls, self.drift, self.tally, self.constants, self.clock, self.travel, self.ledger, steps,
                listing,
            )  # fmt: skip
            steps -= begun
            if status == DONE:
                return
            if status not in (LIST_PAIRS, LIST_WALLS):
                raise self._failure(status)
            p = self.particles
            self.travel[0] = largest_shift(p.position, self.pair_reference, True)
            self.travel[1] = largest_shift(p.position, self.wall_reference, False)
            if self.travel[0] > STALE * 0.5 * self.pair_skin:
                self.adapt_margin()
                self.list_again()
            elif self.travel[1] + self.travel[2] > STALE * self.wall_skin:
                self.list_walls_again()
            listing = True

    def _failure(self, status: int) -> UserError:
        p = self.particles
        time = self.time
        if status == NOT_A_NUMBER:
            bad = ~np.isfinite(p.velocity).all(axis=1) | ~np.isfinite(p.position).all(axis=1)
            i = int(np.argmax(bad))
            return UserError(
                f"Particle {p.ident[i]} has a velocity or position that is not a number at {time:.6g} s, near "
                f"{np.round(p.position[i], 4).tolist()} m; the time step {self.model.time_step:g} s is probably too long for "
                "its contacts (`wearfem check` says which is safe), or particles overlapped at the start."
            )
        return UserError(
            f"More wall contacts than there is room for at {time:.6g} s; are triangles much smaller than particles?"
        )

    def replace_particles(self, particles: Particles, was: np.ndarray) -> None:
        """Go on with other particles; `was` (n,) is their place among the old ones, counting on from the last for new ones."""
        new = int(max(0, was.max(initial=-1) + 1 - len(self.pairs.row_start)))
        self.pairs = self.pairs._replace(
            row_start=np.concatenate([self.pairs.row_start, np.zeros(new, np.int64)]),
            row_count=np.concatenate([self.pairs.row_count, np.zeros(new, np.int32)]),
        )
        self.walls = self.walls._replace(
            row_of=np.concatenate([self.walls.row_of, np.full(new, -1, np.int32)])
        )
        self.packed = np.concatenate([self.packed, np.zeros((new, PACKED))])[was]
        self.particles = particles
        if particles.count:
            self.list_again(was)

    def take_out(self) -> None:
        """Take particles that left the domain out of the flow, or say which one left."""
        p, domain = self.particles, self.model.domain
        fixed = ~np.asarray(domain.periodic)
        out = (((p.position < domain.low) | (p.position > domain.high)) & fixed).any(axis=1)
        if not out.any():
            return
        if not domain.outlet:
            i = int(np.argmax(out))
            raise UserError(
                f"Particle {p.ident[i]} left the domain at {self.time:.6g} s, at {np.round(p.position[i], 4).tolist()} m; the domain "
                f"runs from {domain.low} to {domain.high} m. Close the gap, widen the domain, or let particles go with `outlet=True`."
            )
        self.flow = replace(self.flow, left_mass=self.flow.left_mass + float(p.mass[out].sum()))
        keep = np.flatnonzero(~out)
        self.replace_particles(chosen(p, keep), keep)

    def feed(self) -> None:
        """Let in what is due at the inlets, where there is room."""
        flow, time = self.flow, self.time
        fed = list(flow.fed or (0.0,) * len(self.model.inlets))
        for k, inlet in enumerate(self.model.inlets):
            random = np.random.default_rng([inlet.seed, k, int(self.clock[0])])
            density = self.model.materials[inlet.material].density
            radius, position = inlet.place(
                inlet.due(time) - fed[k], density, self.particles, self.constants.period, random
            )
            if len(radius):
                new = spheres(
                    position,
                    radius,
                    density,
                    velocity=inlet.velocity,
                    material=inlet.material,
                    first_ident=self.next_ident,
                )
                self.next_ident += len(radius)
                fed[k] += float(new.mass.sum())
                self.replace_particles(
                    joined(self.particles, new), np.arange(self.particles.count + new.count)
                )
        self.flow = replace(flow, fed=tuple(fed))


def advance(
    flow: Flow, model: Model, duration: float, tell: Callable[[float, str], None] | None = None
) -> Flow:
    """The flow `duration` [s] later; `flow` itself is not changed."""
    window = _Window(duration, 1)
    return sample(flow, model, window, tell=tell)[0]


class _Window(NamedTuple):
    duration: float
    block_count: int
    snapshots: int = 0


def sample(
    flow: Flow,
    model: Model,
    window: Any,
    until: Callable[[Flow], bool] | None = None,
    tell: Callable[[float, str], None] | None = None,
) -> tuple[Flow, FacetLoads, tuple[Flow, ...]]:
    """Run the flow through a window and sum by block what it does to the facets.

    Parameters
    ----------
    flow, model
        where the particles are, and their world; neither is changed.
    window
        with `duration` [s], `block_count` and `snapshots`, the number of flows to keep on the way.
    until
        asked at the end of each block; True ends the window early.
    tell
        called now and then with the seconds done and a word on the particles.
    """
    check_start(flow, model)
    stepper = Stepper(flow, model)
    total = max(1, round(window.duration / model.time_step))
    ends = np.unique(np.linspace(0, total, window.block_count + 1).round().astype(int)[1:])
    keep = (
        set(np.linspace(0, total, window.snapshots + 1).round().astype(int)[1:])
        if window.snapshots
        else set()
    )
    stride = stepper.stride(total)
    blocks, durations, snapshots, done = [], [], [], 0
    for end in ends:
        begun = done
        while done < end:
            stepper.feed()
            stops = [end, done + stride, *(k for k in keep if k > done)]
            steps = int(min(stops)) - done
            stepper.advance(steps)
            done += steps
            stepper.take_out()
            if done in keep:
                snapshots.append(deepcopy(stepper.result()))  # its arrays change in place
            if tell is not None:
                tell(done * model.time_step, f"{stepper.particles.count} particles")
        blocks.append(stepper.tally)
        stepper.tally = with_room(empty_tally(model.facet_count), stepper.walls.chunk_start)
        durations.append((end - begun) * model.time_step)
        if until is not None and until(stepper.result()):
            break
    return stepper.result(), _loads(model, blocks, durations), tuple(snapshots)


def _loads(model: Model, blocks: Sequence[Tally], durations: Sequence[float]) -> FacetLoads:
    """Blocks of sums as facet loads."""
    sums = np.stack([block.sums for block in blocks])
    impact = np.stack([block.impact for block in blocks])
    area = [surface.facet_area for surface in model.surfaces]
    return FacetLoads(
        duration=np.array(durations),
        area=np.concatenate(area) if area else np.zeros(0),
        normal_impulse=sums[..., NORMAL],
        tangential_impulse=sums[..., TANGENTIAL : TANGENTIAL + 3],
        friction_work=sums[..., FRICTION_WORK],
        load_distance=sums[..., LOAD_DISTANCE],
        slip_distance=sums[..., SLIP],
        contact_time=sums[..., TIME],
        contact_count=sums[..., CONTACTS],
        custom=sums[..., CUSTOM],
        force_time=np.stack([block.force_time for block in blocks]),
        force_slip=np.stack([block.force_slip for block in blocks]),
        impact_energy=impact[..., ENERGY].copy(),
        force_edge=force_edges(),
        angle_edge=np.linspace(0.0, 90.0, ANGLE_CLASSES + 1),
        speed_edge=speed_edges(),
        impact_moment=impact[..., ANGLE:].copy(),
    )
