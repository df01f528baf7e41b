"""The deck of a vibratory feeder as a shell: `python meshes/feeder_plates.py` writes it with edges of 75 mm and of 45 mm.

Printed are the size of the feeder, 5.3 m x 1.8 m, two wear plates, and shells of 30 to 75 mm; its drawings are not public. Chosen
here: a flat deck of two plates side by side that meet on the centre line, 20 mm thick, held at its two short edges.
"""

from pathlib import Path

from gmsh_model import Where, either, empty_model, everything, flat, mesh_of

from wearfem.errors import in_a_sentence
from wearfem.liner.mesh import LinerMesh
from wearfem.liner.mesh_file import write_mesh
from wearfem.units import mm


def feeder_plates(
    *,
    length: float = 5.3,
    width: float = 1.8,
    plates: int = 2,
    thickness: float = 20 * mm,
    size: float = 75 * mm,
) -> LinerMesh:
    """Triangles of a deck 0 <= x <= length, |y| <= width / 2, worn face z = 0 [m], the plate below it (offset -thickness / 2).

    Groups: `wear` (everything), `plate_1` ... (triangles of each plate, from -y), and edges: `support` (x = 0 and x = length),
    `rim` (all four sides), `joint` (where plates meet).
    """
    each = width / plates
    with empty_model(f"feeder_plates_{1e3 * size:.0f}", size) as gmsh:
        occ = gmsh.model.occ
        deck = [(2, occ.addRectangle(0, k * each - 0.5 * width, 0, length, each)) for k in range(plates)]
        if plates > 1:
            occ.fragment(deck[:1], deck[1:])
        ends = either(flat(0, 0.0), flat(0, length))
        sides = either(flat(1, -0.5 * width), flat(1, 0.5 * width))
        faces: dict[str, Where] = {"wear": everything}
        for k in range(plates):
            faces[f"plate_{k + 1}"] = _between(k * each - 0.5 * width, (k + 1) * each - 0.5 * width)
        curves: dict[str, Where] = {"support": ends, "rim": either(ends, sides)}
        if plates > 1:
            curves["joint"] = lambda *box: not ends(*box) and not sides(*box)
        return mesh_of(gmsh, faces, curves, thickness=thickness, offset=-0.5 * thickness)


def _between(low_y: float, high_y: float) -> Where:
    return lambda low, high, centre: low_y < centre[1] < high_y


if __name__ == "__main__":
    with in_a_sentence(__file__):
        for edge in (75 * mm, 45 * mm):
            write_mesh(
                Path(__file__).with_name(f"feeder_plates_{1e3 * edge:.0f}.msh"), feeder_plates(size=edge)
            )
