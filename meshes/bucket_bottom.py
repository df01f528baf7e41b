"""The bottom plate of a rope shovel's bucket, with and without wear bars: `python meshes/bucket_bottom.py` writes three .msh files.

The bucket's drawing is not public: sizes here are those of a bucket of 43 m3 in round figures. The published bars stand at
90 and 45 degrees to the direction of digging, +x.
"""

from pathlib import Path

from gmsh_model import NEAR, Where, either, empty_model, flat, mesh_of

from wearfem.errors import in_a_sentence
from wearfem.liner.mesh import LinerMesh
from wearfem.liner.mesh_file import write_mesh
from wearfem.units import degree, mm


def bucket_bottom(
    *,
    length: float = 3.0,
    width: float = 3.4,
    thickness: float = 60 * mm,
    bars: int = 0,
    bar_width: float = 120 * mm,
    bar_height: float = 60 * mm,
    angle: float = 90 * degree,
    margin: float = 0.2,
    size: float = 100 * mm,
) -> LinerMesh:
    """Tetrahedra of a plate 0 <= x <= length, |y| <= width / 2, worn face z = 0 [m], with `bars` straight bars on it.

    The bars are spaced evenly, at `angle` [rad] to x (90 degrees: across the flow), and end `margin` before the plate does.

    Groups: `wear` (top and bars), `bars` (the bars' faces), `support` (underside), `rim` (the four sides).
    """
    with empty_model("bucket_bottom", size) as gmsh:
        occ = gmsh.model.occ
        plate = occ.addBox(0, -0.5 * width, -thickness, length, width, thickness)
        if bars:
            reach = length + width  # longer than any; cut off at the margin
            spacing = (length - 2 * margin) / bars
            long = []
            for k in range(bars):
                bar = occ.addBox(-0.5 * reach, -0.5 * bar_width, 0, reach, bar_width, bar_height)
                occ.rotate([(3, bar)], 0, 0, 0, 0, 0, 1, angle)
                occ.translate([(3, bar)], margin + (k + 0.5) * spacing, 0, 0)
                long.append((3, bar))
            inset = occ.addBox(
                margin, margin - 0.5 * width, 0, length - 2 * margin, width - 2 * margin, bar_height
            )
            short, _ = occ.intersect(long, [(3, inset)])
            occ.fuse([(3, plate)], short)
        under = flat(2, -thickness)
        sides = either(flat(0, 0.0), flat(0, length), flat(1, -0.5 * width), flat(1, 0.5 * width))
        faces: dict[str, Where] = {
            "wear": lambda *box: not under(*box) and not sides(*box), "support": under, "rim": sides
        }  # fmt: skip
        if bars:
            faces["bars"] = lambda low, high, centre: high[2] > 2 * NEAR
        return mesh_of(gmsh, faces)


if __name__ == "__main__":
    with in_a_sentence(__file__):
        here = Path(__file__)
        write_mesh(here.with_name("bucket_bottom.msh"), bucket_bottom())
        for degrees in (90, 45):
            made = bucket_bottom(bars=4, angle=degrees * degree)
            write_mesh(here.with_name(f"bucket_bottom_bars_{degrees}.msh"), made)
