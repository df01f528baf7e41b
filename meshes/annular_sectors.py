"""Discs that turn under a sample: `python meshes/annular_sectors.py` writes pin_on_disc.msh and annular_sectors.msh."""

from math import atan2, pi
from pathlib import Path

from gmsh_model import Where, empty_model, flat, mesh_of, upright

from wearfem.errors import in_a_sentence
from wearfem.liner.mesh import LinerMesh
from wearfem.liner.mesh_file import write_mesh
from wearfem.units import mm


def annular_sectors(
    *,
    inner_diameter: float = 180 * mm,
    outer_diameter: float = 260 * mm,
    thickness: float = 10 * mm,
    count: int = 6,
    size: float = 6 * mm,
    name: str = "annular_sectors",
) -> LinerMesh:
    """Tetrahedra of a ring around the z axis, 0 <= z <= thickness [m], of `count` equal sectors; a full disc for an inner diameter of 0.

    The diameters are those of the scraper test on the ML-100; its plate's thickness is not printed. Sectors share their nodes.

    Groups: `wear` (top), `sector_1` ... (top of each, counted from the x axis), `support` (underside), `rim` (inner and outer wall).
    """
    angle = 2.0 * pi / count
    with empty_model(name, size) as gmsh:
        occ = gmsh.model.occ
        ring = []
        for number in range(count):
            whole = occ.addCylinder(0, 0, 0, 0, 0, thickness, outer_diameter / 2, angle=angle)
            if inner_diameter:
                hole = occ.addCylinder(0, 0, 0, 0, 0, thickness, inner_diameter / 2, angle=angle)
                occ.cut([(3, whole)], [(3, hole)])
            occ.rotate([(3, whole)], 0, 0, 0, 0, 0, 1, number * angle)
            ring.append((3, whole))
        if count > 1:
            occ.fragment(ring[:1], ring[1:])
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", pi * outer_diameter / size)
        top = flat(2, thickness)
        faces: dict[str, Where] = {"wear": top, "support": flat(2, 0.0)}
        for number in range(count if count > 1 else 0):
            faces[f"sector_{number + 1}"] = _sector(top, (number + 0.5) * angle)
        faces["rim"] = upright  # between sectors such faces lie inside the ring, off its boundary
        return mesh_of(gmsh, faces)


def _sector(top: Where, middle: float) -> Where:
    """The part of the top whose centre lies at the angle `middle` [rad]."""
    return lambda low, high, centre: (
        top(low, high, centre) and abs((atan2(centre[1], centre[0]) - middle + pi) % (2 * pi) - pi) < 1e-3
    )


if __name__ == "__main__":
    with in_a_sentence(__file__):
        here = Path(__file__)
        write_mesh(here.with_name("annular_sectors.msh"), annular_sectors())
        disc = annular_sectors(
            inner_diameter=0.0,
            outer_diameter=53 * mm,
            thickness=6 * mm,
            count=1,
            size=2.2 * mm,
            name="pin_on_disc",
        )
        write_mesh(here.with_name("pin_on_disc.msh"), disc)
