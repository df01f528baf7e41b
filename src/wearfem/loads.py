"""What the particles did to each facet, in blocks of time: the second noun that particles, liner and wear share."""

from dataclasses import MISSING, dataclass, field
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
