"""The curved transfer chute with convexes on its face: they take the wear off the chute, until they are worn away themselves.

**Source** Chen, Schott and Lodewijks, Numerical prediction on abrasive wear reduction of bulk solids handling equipment using bionic
design, sections 5 and 6: Figures 4 to 10, Table 4. Ore, feed, arc and coefficient of wear are those of the case transfer_chute.

Printed: the radii a0 and b0, the spacings c0 and d0, which levels they have, the wear that is saved. Not printed in the text and read
from its words here: a0 lies along the flow; b0 is the height and the radius across (a0 = b0 is called a hemisphere); c0 and d0 are called
the long and the short diagonal, so the convexes stand at the corners of rhombi. Chosen: how fine the mesh is. See README.md.

Only the arc is in the model, from 27 degrees to the middle of zone 2, or with `end` to its end: what lies below does not act back, and the
upper half costs a sixth of the whole.
"""

from dataclasses import dataclass, replace
from math import ceil, degrees, radians
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.sparse import csr_array

from wearfem.case import Figure, LifeCase, Stop, Window, find_case, parts_of
from wearfem.cycle import Particles
from wearfem.history import History
from wearfem.liner.chute import facet_angle, share_between
from wearfem.liner.convexes import (
    Convex,
    EmbossedStrip,
    Fineness,
    Pattern,
    bent_shell,
    embossed_strip,
)
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.mesh import ShellMesh
from wearfem.loads import FacetLoads
from wearfem.units import GPa, hour, mm, second, tonne
from wearfem.wear.jump import Goal
from wearfem.wear.laws import Archard

CHUTE_FOLDER = Path(__file__).parents[1] / "transfer_chute"
chute = parts_of(CHUTE_FOLDER)

BEGIN = radians(27.0)  # of the strip; ore comes on from 28.36 degrees
MIDDLE = 0.5 * sum(chute.ZONE_2)  # [rad] of zone 2
WARM_UP = 0.3 * second  # until the upper half is steady
THICKNESS = 20 * mm  # without convexes
PAIR_SKIN = 3 * mm  # wide margin of the list of pairs: ore that comes on has it made anew all the time anyway
REACH = 11  # rows of tiles over which convexes are taken to wear alike


@dataclass(frozen=True)
class Alike:
    """Convexes close to each other along the flow wear alike, and so do their left and right halves: their rates are averaged.

    One facet of one convex is touched a few times in a second of flow. What all facets of the same place on some ten rows of convexes
    and their mirror images see is known ten times better. Volume is kept but for differences between the areas of these facets.
    Rows before `first` do not wear: they are kept as new.
    """

    needs: ClassVar[tuple[str, ...]] = ()  # no feature of the state

    row: np.ndarray  # (f,) along the flow
    alike: np.ndarray  # (f,)
    first: int = 0  # row
    reach: int = REACH  # rows

    def modify(self, rate: np.ndarray, loads: FacetLoads, liner: Any) -> np.ndarray:
        """The rate (b, f) [m/s], averaged by area over facets alike and `reach` rows; reflected where the wearing rows end."""
        kinds, rows, count = self.alike.max() + 1, self.row.max() + 1, len(self.row)
        place = self.alike * rows + self.row
        gather = csr_array((loads.area, (place, np.arange(count))), shape=(kinds * rows, count))

        def over_rows(values: np.ndarray) -> np.ndarray:
            table = (gather @ values.T).T.reshape(-1, kinds, rows)
            mean = uniform_filter1d(table[..., self.first :], self.reach, axis=2, mode="reflect")
            table[..., self.first :] = mean
            return table.reshape(-1, kinds * rows)

        mean = (over_rows(rate) / np.maximum(over_rows(np.ones((1, count))), 1e-300))[:, place]
        return np.where(self.row >= self.first, mean, 0.0)


def case(
    *,
    convexes: bool = True,
    major_radius: float = 3 * mm,
    minor_radius: float = 2 * mm,
    spacing_along: float = 40 * mm,
    spacing_across: float = 30 * mm,
    staggered: bool = True,
    across_radius: float = 0.0,
    spacings: int = 1,
    end: float = MIDDLE,
    shear_modulus: float = 0.065 * GPa,
    coarsening: float = 1.0,
    time_step_share: float = 0.25,
    sectors: int = 8,
    rings: int = 2,
    rings_around: int = 1,
    window: float = 0.1 * second,
    tolerance: float = 0.3,
    worn_off: float = 18 * mm,
    stop: float = 100 * hour,
    renewed: bool = True,
    frozen: bool = False,
    seed: int = 1,
) -> LifeCase:
    """The life of the convexes of the base case (group 2 of Table 4).

    Parameters
    ----------
    convexes
        Whether there are any; without them the same mesh is smooth.
    major_radius, minor_radius
        a0 and b0 [m]: radius along the flow, and height.
    spacing_along, spacing_across
        c0 and d0 [m].
    staggered
        Whether c0 and d0 are the diagonals of rhombi; else they are the sides of rectangles, with half as many convexes.
    across_radius
        Of the convexes across the flow [m]; 0: as their height.
    spacings
        How many times `spacing_across` the slice of the chute is wide; it is periodic across.
    end
        Angle [rad] up to which the arc is in the model, at least; the arc ends at 64.16 degrees.
    shear_modulus
        Of the ore [Pa]; published 65 GPa.
    coarsening
        Factor on all diameters of the ore.
    time_step_share
        Time step over the smallest particle's Rayleigh time.
    sectors, rings, rings_around
        Of the mesh: around each convex, from its rim to its top, from its rim to the next tile. Jumps are a quarter of its shortest edge.
    window
        The first sample of steady flow [s]; later ones are as long.
    tolerance
        Within which the end of life is to be known, 90 times out of 100.
    worn_off
        Depth [m] at which a facet counts as worn out, of the 20 mm of the chute.
    stop
        Service time [s] at which to stop, where it comes before the end of life.
    renewed
        Keep the stretch before zone 2 as new, as if a plate there were replaced whenever it needs it: under the falling ore convexes
        are gone several times sooner. Else it wears too.
    frozen
        Keep all convexes as they are new.
    seed
        Of the feed.
    """
    stream = chute.Stream(
        shear_modulus,
        coarsening,
        spacings * spacing_across,
        time_step_share * chute.rayleigh_time(coarsening, shear_modulus),
        seed,
    )
    convex = Convex(major_radius, across_radius or minor_radius, minor_radius)
    pattern = Pattern(convex, spacing_along, spacing_across, staggered)
    strip = arc_strip(pattern, spacings, end, Fineness(sectors, rings, rings_around))
    strip = strip if convexes else replace(strip, height=0.0 * strip.height)
    liner = Liner(bent_shell(strip, chute.RADIUS, BEGIN, THICKNESS, name="chute"), chute.STEEL)
    before = ceil(chute.RADIUS * (chute.ZONE_2[0] - BEGIN) / pattern.tile[0]) if renewed else 0
    surface = wear_surface(liner)
    zone_2 = share_between(surface, *chute.ZONE_2) * (
        facet_angle(surface) < end
    )  # no more than was asked for
    where = Where(zone_2, strip.on_convex.astype(float), strip.height, stream.share)
    return LifeCase(
        name="bionic_chute",
        flow=stream.nothing,
        sampler=Particles(lambda surface: replace(stream.model(surface), pair_skin=PAIR_SKIN * coarsening)),
        liner=liner,
        wear_law=Archard(chute.SPECIFIC_WEAR_RATE),
        effects=(Alike(strip.row, strip.alike, before),),
        goal=Goal(np.full(len(strip.row), worn_off), tolerance=tolerance),
        window=Window(window, 8),
        warm_up=WARM_UP,
        throughput_rate=chute.FEED_RATE,
        particle_radius=stream.radii[0],
        stop=Stop(service_time=stop),
        frozen=frozen,
        measure=Measure(where),
        notes=(
            f"the ore's shear modulus is {shear_modulus:.3g} Pa instead of 65 GPa",
            f"the chute is a slice of {1e3 * stream.slice_width:g} mm, periodic across, and ends at {degrees(end):.4g} degrees; rates are "
            "told for its whole width of 0.2 m",
            *(("the stretch before zone 2 is kept as new",) if renewed else ()),
            f"convexes of {REACH} rows are taken to wear alike: one facet alone is touched too seldom",
        ),
        files=(find_case(CHUTE_FOLDER),),
    )


def arc_strip(pattern: Pattern, spacings: int, end: float, fineness: Fineness) -> EmbossedStrip:
    """The face of the arc up to the angle `end` [rad], rolled out, in whole tiles: the last one reaches over it."""
    length, width = pattern.tile
    rows = ceil(chute.RADIUS * (end - BEGIN) / length)
    return embossed_strip(pattern, rows, round(spacings * pattern.spacing_across / width), fineness)


@dataclass(frozen=True)
class Where:
    """What part of each facet lies in zone 2, and which lie on convexes."""

    zone_2: np.ndarray  # (f,) [-]
    on_convex: np.ndarray  # (f,) [-] 1 or 0
    height: np.ndarray  # (n,) [m] of the nodes above the face, when new
    share: float  # [-] part of the chute's width that is simulated

    def volume_rate(self, loads: FacetLoads, part: np.ndarray | float = 1.0) -> np.ndarray:
        """(b,) [m3/s] that zone 2, or `part` (f,) of it, loses in each block, for the whole width of the chute"""
        distance = loads.load_distance @ (self.zone_2 * part)
        return chute.SPECIFIC_WEAR_RATE * distance / loads.duration / self.share

    def convex_height(self, mesh: ShellMesh) -> float:
        """[m] by which the tops of convexes that wear still stand above the face between: mean over tops less mean over the face"""
        top = self.height > 0.999 * self.height.max()
        worn = mesh.thickness < THICKNESS + self.height
        worn = worn if worn.any() else np.ones(len(worn), bool)
        return float(mesh.thickness[top & worn].mean() - mesh.thickness[(self.height == 0.0) & worn].mean())


@dataclass(frozen=True)
class Measure:
    """The figures of a run."""

    where: Where

    def __call__(self, history: History) -> tuple[Figure, ...]:
        """Wear of zone 2 when new and at the end of the run."""
        first, last = history.reports[0], history.reports[-1]
        new, now = (float(self.where.volume_rate(one.loads).mean()) for one in (first, last))
        left = self.where.convex_height(history.state.now.liner.mesh) if self.where.height.any() else 0.0
        return (
            Figure("wear of zone 2 as far as it is in the model, new", 1e10 * new, "1e-10 m3/s"),
            Figure("the same at the end", 1e10 * now, "1e-10 m3/s"),
            Figure("height of the convexes left", 1e3 * left, "mm"),
            Figure("throughput", last.throughput / tonne, "t"),
            Figure("deepest", 1e3 * float(last.depth.max()), "mm"),
            Figure("cycles", len(history.reports), "-"),
            Figure("flow sampled", history.simulated, "s"),
        )
