"""A flat wear plate with bolt holes: `python meshes/flat_plate.py` writes flat_plate.msh."""

from pathlib import Path

from gmsh_model import NEAR, Where, either, empty_model, flat, mesh_of

from wearfem.errors import in_a_sentence
from wearfem.liner.mesh import LinerMesh
from wearfem.liner.mesh_file import write_mesh
from wearfem.units import mm

BOLTS = tuple((x, y) for x in (0.1, 0.5, 0.9) for y in (0.1, 0.5))


def flat_plate(
    *,
    length: float = 1.0,
    width: float = 0.6,
    thickness: float = 20 * mm,
    hole: float = 26 * mm,
    bolts: tuple[tuple[float, float], ...] = BOLTS,
    size: float = 45 * mm,
) -> LinerMesh:
    """Tetrahedra of a plate 0 <= x <= length, 0 <= y <= width, 0 <= z <= thickness [m], with holes of diameter `hole` at `bolts`.

    Groups: `wear` (top), `support` (underside), `rim` (the four sides), `bolt_1` ... (walls of the holes).
    """
    with empty_model("flat_plate", size) as gmsh:
        occ = gmsh.model.occ
        plate = occ.addBox(0, 0, 0, length, width, thickness)
        holes = [(3, occ.addCylinder(x, y, 0, 0, 0, thickness, hole / 2)) for x, y in bolts]
        if holes:
            occ.cut([(3, plate)], holes)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)  # chords a hole
        gmsh.option.setNumber("Mesh.MeshSizeMin", 0.0)
        faces: dict[str, Where] = {"wear": flat(2, thickness), "support": flat(2, 0.0)}
        faces["rim"] = either(flat(0, 0.0), flat(0, length), flat(1, 0.0), flat(1, width))
        for number, bolt in enumerate(bolts, start=1):
            faces[f"bolt_{number}"] = _around(bolt, hole, thickness)
        return mesh_of(gmsh, faces)


def _around(bolt: tuple[float, float], hole: float, thickness: float) -> Where:
    """The wall of one hole: around its axis, from the underside to the top."""
    return lambda low, high, centre: (
        abs(centre[0] - bolt[0]) + abs(centre[1] - bolt[1]) < NEAR
        and high[0] - low[0] < hole + NEAR
        and high[2] - low[2] > thickness - NEAR
    )


if __name__ == "__main__":
    with in_a_sentence(__file__):
        write_mesh(Path(__file__).with_name("flat_plate.msh"), flat_plate())
