"""Read a plate, hold it, load it, wear it, and draw it: python docs/examples/liner.py FOLDER."""

import sys
from pathlib import Path

import numpy as np

from wearfem.liner.breakthrough import thickness
from wearfem.liner.corners import facet_area
from wearfem.liner.flexure import Ore, flexure
from wearfem.liner.liner import Liner
from wearfem.liner.mesh_file import read_mesh
from wearfem.liner.recede import recede, volume
from wearfem.liner.solve import Load, Structure, factorise
from wearfem.liner.support import Bed, Fixed
from wearfem.liner.vibration import lowest_frequencies
from wearfem.material import Material
from wearfem.pictures import draw_liner
from wearfem.record_mesh import write_liner
from wearfem.units import GPa, MPa, day, kPa, mm

MESHES = Path(__file__).parents[2] / "meshes"


def main(folder: Path, time_limit: float = 120.0) -> None:
    # Read: the file's groups are wear, support (underside) and rim (the four sides).
    steel = Material("Hardox 450", density=7850.0, shear_modulus=80 * GPa, poisson_ratio=0.3)
    new = Liner(read_mesh(MESHES / "bucket_bottom.msh"), steel)
    print(f"new plate: {1e3 * thickness(new.mesh).min():.2f} mm thick, {1e3 * volume(new.mesh):.1f} litres")

    # Hold: welded along its rim, on a bed of old liner; bolts would be ElasticBolt("bolt_1", axial, transverse).
    supports = [Fixed("rim"), Bed("support", normal=5e7)]
    structure = Structure(supports, yield_stress=1200 * MPa, gravity=(0.0, 0.0, -9.81))

    # Wear: a pocket where the ore lands, 20 mm deep after 200 days. (Runs get this rate from the particles.)
    centre = new.mesh.node[new.mesh.wear].mean(axis=1)
    far = np.hypot(centre[:, 0] - 1.2, centre[:, 1])
    rate = 20 * mm / (200 * day) * np.exp(-((far / 0.6) ** 2))
    worn = recede(new, 200 * day * rate, service_time=200 * day)
    gone = volume(new.mesh) - volume(worn.mesh)
    print(f"worn plate: {1e3 * thickness(worn.mesh).min():.2f} mm left, {1e3 * gone:.2f} litres gone")

    # Load: 150 kPa where the ore lands, as a force on each facet of the group wear.
    area = facet_area(worn.mesh.node, worn.mesh.wear)
    force = np.where(far < 0.6, 150 * kPa * area, 0.0)[:, None] * [0.0, 0.0, -1.0]
    held = factorise(worn, structure)
    strength = held.solve(Load({"wear": force}))
    print(
        f"deflection {1e3 * strength.deflection.max():.3f} mm, stress {1e-6 * strength.von_mises.max():.1f} MPa"
    )
    print(
        f"reserve {strength.reserve_factor.min():.1f}, rim carries {1e-3 * strength.reaction['rim'].force[2]:.1f} kN"
    )

    # Does the bending matter to the flow?
    rock = Material("rock", density=3700.0, shear_modulus=17.3 * GPa, poisson_ratio=0.3)
    ore = Ore(rock, radius=100 * mm, speed=4.0, friction=0.53, loading_frequency=1.0)
    print(flexure(worn, strength.displacement, ore, float(lowest_frequencies(held)[0])).verdict)

    # Draw, and write for ParaView.
    drawn = draw_liner(folder, worn, rate=rate, strength=strength, time_limit=time_limit)
    files = [*drawn.files, *write_liner(folder, worn, rate=rate, strength=strength)]
    print("files: " + " ".join(file.name for file in files))
    if drawn.message:
        print(drawn.message, file=sys.stderr)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "liner"))
