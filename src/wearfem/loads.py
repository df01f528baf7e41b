"""What the particles did to each facet, in blocks of time: the second noun that particles, liner and wear share."""

from collections.abc import Callable, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any

import numpy as np


def _array(unit: str, shape: str, text: str, default: Any = MISSING) -> Any:
    """A field whose unit, shape and meaning travel with it into files."""
    return field(default=default, metadata={"unit": unit, "shape": shape, "text": text})


@dataclass(frozen=True)
class FacetLoads:
    """Sufficient statistics by block b and facet f: any wear law can be evaluated on them without running the particles again.

    Vectors are in the frame of the facet's body, forces are those on the surface. An impact is the first touch of a contact: its
    energy is that of the particle's centre as the surface sees it, its angle (0 grazing, 90 degrees normal) and speed are those of the
    point that touches. Mean and spread of angle and speed within a class follow from `impact_moment`; loads without it are looked at as
    if every impact lay in the middle of its class.
    """

    duration: np.ndarray = _array("s", "(b,)", "length of each block")
    area: np.ndarray = _array("m2", "(f,)", "of each facet")
    normal_impulse: np.ndarray = _array("N s", "(b, f)", "sum of normal force over time")
    tangential_impulse: np.ndarray = _array("N s", "(b, f, 3)", "sum of tangential force over time")
    friction_work: np.ndarray = _array("J", "(b, f)", "dissipated by slip")
    load_distance: np.ndarray = _array(
        "N m", "(b, f)", "sum of normal force times tangential speed over time"
    )
    slip_distance: np.ndarray = _array("m", "(b, f)", "slid while friction was at its limit")
    contact_time: np.ndarray = _array("s", "(b, f)", "sum over contacts")
    contact_count: np.ndarray = _array("-", "(b, f)", "first touches")
    custom: np.ndarray = _array("-", "(b, f)", "sum of the model's own tally")
    force_time: np.ndarray = _array("s", "(b, f, c)", "contact time by class of normal force")
    force_slip: np.ndarray = _array("m", "(b, f, c)", "slip by class of normal force")
    impact_energy: np.ndarray = _array(
        "J", "(b, f, a, v)", "kinetic energy at first touch by class of angle and speed"
    )
    force_edge: np.ndarray = _array("N", "(c + 1,)", "borders of the force classes; the end classes are open")
    angle_edge: np.ndarray = _array("degree", "(a + 1,)", "borders of the impact angle classes, 0 grazing")
    speed_edge: np.ndarray = _array(
        "m/s", "(v + 1,)", "borders of the speed classes; the end classes are open"
    )
    impact_moment: np.ndarray | None = _array(
        "J rad, J rad2, J, J, J rad",
        "(b, f, a, v, 5)",
        "impact energy times angle, angle^2, l, l^2 and angle x l, with l = ln(speed in m/s)",
        None,
    )

    @property
    def block_count(self) -> int:
        """Number of time blocks."""
        return len(self.duration)

    @property
    def facet_count(self) -> int:
        """Number of facets."""
        return len(self.area)


def in_sequence(samples: Sequence[FacetLoads]) -> FacetLoads:
    """Samples of the same facets one after the other: all their blocks in order."""
    return _map(lambda arrays: np.concatenate(arrays), samples)


def in_one_block(loads: FacetLoads) -> FacetLoads:
    """The same loads summed over all blocks: one block as long as all of them."""
    return _map(lambda arrays: arrays[0].sum(axis=0, keepdims=True), (loads,))


def without_classes(loads: FacetLoads) -> FacetLoads:
    """The sums by block and facet alone: the histograms, which fill most of the memory, are left out (zero classes)."""
    empty = {name: getattr(loads, name)[..., :0] for name in ("force_time", "force_slip", "impact_energy")}
    return replace(loads, **empty, impact_moment=None)


def on_facets(loads: FacetLoads, first: int, count: int) -> FacetLoads:
    """The loads on `count` facets from the number `first` on."""
    chosen = slice(first, first + count)
    by_block = {name: getattr(loads, name)[:, chosen] for name in _BY_BLOCK if name != "duration"}
    moment = loads.impact_moment
    return replace(
        loads,
        area=loads.area[chosen],
        impact_moment=None if moment is None else moment[:, chosen],
        **by_block,
    )


_BY_BLOCK = tuple(f.name for f in fields(FacetLoads) if f.metadata["shape"].startswith("(b,")
                  and f.name != "impact_moment")  # fmt: skip


def _map(join: Callable[[list[np.ndarray]], np.ndarray], samples: Sequence[FacetLoads]) -> FacetLoads:
    """Loads whose arrays by block are those of the samples joined; area and class borders are those of the last."""
    joined = {name: join([getattr(loads, name) for loads in samples]) for name in _BY_BLOCK}
    moments = [loads.impact_moment for loads in samples if loads.impact_moment is not None]
    moment = join(moments) if len(moments) == len(samples) else None
    return replace(samples[-1], **joined, impact_moment=moment)
