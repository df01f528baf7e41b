"""A curved transfer chute, solid and shell: `python meshes/curved_chute.py` writes both .msh files.

Printed are the radius 2.0 m, the width 0.2 m, the slope 45 degrees of the sides, and a list of lengths whose place in the drawing is not
(Chen, Schott and Lodewijks, bionic design of a transfer chute, table 1). Chosen here: a straight entry of 0.3 m, an exit of 0.5 m, sides
0.2 m wide, plates of 20 mm. A cut-off angle of 30 degrees would end the arc after 60 degrees of turn, but the paper's zone 2
reaches to 64.15 degrees: the arc here ends at 65.
"""

from dataclasses import replace
from math import cos, sin, tan
from pathlib import Path
from typing import Any

import numpy as np
from gmsh_model import NEAR, Where, either, empty_model, everything, flat, mesh_of

from wearfem.errors import in_a_sentence
from wearfem.liner.block import mapped
from wearfem.liner.mesh import LinerMesh, ShellMesh
from wearfem.liner.mesh_file import write_mesh
from wearfem.units import degree, mm

Profile = list[
    tuple[float, float]
]  # (y, z) [m] of the cross-section, z = 0 at the worn bottom, towards the flow


def curved_chute(
    *,
    radius: float = 2.0,
    width: float = 0.2,
    side: float = 0.2,
    slope: float = 45 * degree,
    turn: float = 65 * degree,
    entry: float = 0.3,
    end: float = 0.5,
    thickness: float = 20 * mm,
    size: float = 40 * mm,
    shell: bool = False,
) -> LinerMesh:
    """A trough that turns a stream from straight down towards +x; its worn bottom has `radius` around the y axis.

    The arc begins at (-radius, 0, 0) and ends `turn` [rad] later, with straight parts `entry` before and `end` after it [m]. The bottom is
    `width` wide, the sides are `side` wide and rise from it by `slope`. It is meshed straight and then bent. `shell`: triangles of the
    worn face with the plate behind it (offset -thickness / 2); else tetrahedra.

    Groups: `wear` (inside), `zone_arc` (the bottom of the arc), `entry` and `end` (the cut faces, or edges), `rim` (these and the
    borders of the sides), and of the solid `support` (outside).
    """
    inner, outer = profile(width, side, slope, thickness)
    part = (entry, radius * turn, end)
    with empty_model("curved_chute", size) as gmsh:
        section = _section(gmsh, inner) if shell else _section(gmsh, inner + outer[::-1], closed=True)
        for length in part:
            made = gmsh.model.occ.extrude(section, length, 0, 0)
            section = [made[k - 1] for k, (dimension, _) in enumerate(made) if dimension == 2 + (not shell)]
        gmsh.model.occ.removeAllDuplicates()
        first, last = flat(0, 0.0), flat(0, sum(part))
        inside = either(*(_swept(a, b) for a, b in zip(inner, inner[1:], strict=False)))
        faces: dict[str, Where] = {
            "wear": inside,
            "zone_arc": lambda low, high, centre: (
                flat(2, 0.0)(low, high, centre) and abs(centre[0] - part[0] - 0.5 * part[1]) < NEAR
            ),
        }
        if shell:
            border = either(_swept(inner[0], inner[0]), _swept(inner[-1], inner[-1]))
            curves = {"entry": first, "end": last, "rim": either(first, last, border)}
            straight = mesh_of(
                gmsh, faces | {"wear": everything}, curves, thickness=thickness, offset=-0.5 * thickness
            )
        else:
            border = either(_swept(inner[0], outer[0]), _swept(inner[-1], outer[-1]))
            outside = either(*(_swept(a, b) for a, b in zip(outer, outer[1:], strict=False)))
            straight = mesh_of(
                gmsh,
                faces | {"support": outside, "entry": first, "end": last, "rim": either(first, last, border)},
            )
    if isinstance(straight, ShellMesh) and not _faces_flow(straight):
        straight = replace(straight.turned, offset=straight.offset)
    return mapped(straight, lambda x: bent(x, radius, turn, entry))


def profile(width: float, side: float, slope: float, thickness: float) -> tuple[Profile, Profile]:
    """The worn side and the back of the trough's plates in (y, z), from border to border; plates meet in a mitre."""
    half, miter = 0.5 * width, thickness * tan(0.5 * slope)
    reach = (half + side * cos(slope), side * sin(slope))
    inner = [(half, 0.0), reach]
    outer = [
        (half + miter, -thickness),
        (reach[0] + thickness * sin(slope), reach[1] - thickness * cos(slope)),
    ]
    return _mirrored(inner), _mirrored(outer)


def _mirrored(line: Profile) -> Profile:
    """From the border at the other side to this one"""
    return [(-y, z) for y, z in line[::-1]] + line


def bent(straight: np.ndarray, radius: float, turn: float, entry: float) -> np.ndarray:
    """Positions (n, 3) [m] along, across and above the straight chute's bottom, where they are in the bent one."""
    along, across, above = straight.T
    angle = np.clip((along - entry) / radius, 0.0, turn)
    rest = along - entry - radius * angle  # below zero in the entry, above zero in the exit
    inward = radius - above
    return np.column_stack(
        [
            -inward * np.cos(angle) + rest * np.sin(angle),
            across,
            -inward * np.sin(angle) - rest * np.cos(angle),
        ]
    )


def _section(gmsh: Any, line: Profile, closed: bool = False) -> list[tuple[int, int]]:
    occ = gmsh.model.occ
    point = [occ.addPoint(0, y, z) for y, z in line]
    point += point[:1] if closed else []
    edge = [occ.addLine(a, b) for a, b in zip(point, point[1:], strict=False)]
    return [(2, occ.addPlaneSurface([occ.addCurveLoop(edge)]))] if closed else [(1, one) for one in edge]


def _swept(first: tuple[float, float], second: tuple[float, float]) -> Where:
    """What was swept along x from the line between two points of the profile: its middle lies there."""
    middle = 0.5 * (np.array(first) + np.array(second))
    return lambda low, high, centre: bool(np.abs(centre[1:] - middle).max() < NEAR < high[0] - low[0])


def _faces_flow(mesh: ShellMesh) -> bool:
    a, b, c = np.moveaxis(mesh.node[mesh.element], 1, 0)
    return bool(np.cross(b - a, c - a)[:, 2].sum() > 0.0)


if __name__ == "__main__":
    with in_a_sentence(__file__):
        here = Path(__file__)
        write_mesh(here.with_name("curved_chute.msh"), curved_chute())
        write_mesh(here.with_name("curved_chute_shell.msh"), curved_chute(shell=True))
