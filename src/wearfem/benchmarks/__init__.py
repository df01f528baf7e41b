"""The flows whose speed is measured, for wearfem and, from the same packings, for its peers.

Spheres of radius 4 to 6 mm, uniform by number, 2500 kg/m3, E = 10 MPa, nu = 0.3, e = 0.5, mu = 0.5 (at walls too), no rolling
friction; Hertz-Mindlin with history; a time step of 6.9e-5 s, 20 % of the Rayleigh time of the smallest sphere.

The packings (`*.npz`: position (n, 3) m, radius (n,) m) are our own: spheres dropped from a jittered lattice and left to settle.
The decks (`liggghts_*.in`, `lammps_*.in`) ask the peers for the same physics.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.particles import spheres
from wearfem.material import Material
from wearfem.surface import Plane, Surface, rectangle

FOLDER = Path(__file__).parent
GRAIN = Material("grain", 2500.0, 1.0e7 / 2.6, 0.3, restitution=0.5, friction=0.5)
TIME_STEP = 6.9e-5  # [s]
GRAVITY = 9.81  # [m/s2]
SINE, COSINE = 0.573576436, 0.819152044  # of the plate's slope, 35 degrees
PLATE_SPEED = 1.0  # [m/s] down the slope at the start
PLATE_WIDTH = 0.2  # [m]


@dataclass(frozen=True)
class Benchmark:
    """A flow to be timed: `warm` steps first, then `steps` against the clock."""

    name: str
    text: str
    deck: str  # the peers' decks are named by it
    warm: int
    steps: int
    edge: float  # [m] of the box's base; 0 for the plate
    peer_skins: tuple[float, ...]  # [m] margins of the pair list to try for the peers

    def packing(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, 3) and radii (n,) at the start [m]."""
        with np.load(FOLDER / f"{self.name}.npz") as file:
            return file["position"], file["radius"]

    def start(self) -> tuple[Flow, Model]:
        """The flow at its start, and its world."""
        position, radius = self.packing()
        if self.edge:
            return Flow(spheres(position, radius, GRAIN.density)), _box(self.edge)
        velocity = (PLATE_SPEED, 0.0, 0.0)
        return Flow(spheres(position, radius, GRAIN.density, velocity=velocity)), _plate()

    def write_inputs(self, folder: Path) -> None:
        """Write what the peers read: `<name>.data`, and the plate as `plate.stl`."""
        position, radius = self.packing()
        if self.edge:
            high = (self.edge, self.edge, round(position[:, 2].max() + 0.02, 4))
            box, kinds, speed = ((0.0, 0.0, -1e-3), high), 1, 0.0
        else:
            box, kinds, speed = ((0.0, 0.0, -0.05), (1.5, PLATE_WIDTH, 0.15)), 2, PLATE_SPEED
            _write_stl(folder / "plate.stl", plate())
        lines = ["spheres", "", f"{len(radius)} atoms", f"{kinds} atom types", ""]
        lines += [f"{a:.9g} {b:.9g} {x}lo {x}hi" for a, b, x in zip(*box, "xyz", strict=True)]
        lines += ["", "Atoms", ""]
        for number, (x, r) in enumerate(zip(position, radius, strict=True), 1):
            lines.append(f"{number} 1 {2 * r:.12g} {GRAIN.density} {x[0]:.12g} {x[1]:.12g} {x[2]:.12g}")
        if speed:
            lines += ["", "Velocities", ""]
            lines += [f"{number} {speed} 0 0 0 0 0" for number in range(1, len(radius) + 1)]
        (folder / f"{self.name}.data").write_text("\n".join(lines) + "\n")


BENCHMARKS = (
    Benchmark("bed_5000", "5 000 settled spheres in an open box", "bed", 1000, 2000, 0.165, (1e-3,)),
    Benchmark("bed_20000", "20 000 settled spheres in an open box", "bed", 500, 1000, 0.263, (1e-3,)),
    Benchmark("bed_100000", "100 000 settled spheres in an open box", "bed", 200, 400, 0.449, (1e-3,)),
    Benchmark(
        "plate",
        "10 000 spheres sliding down 4 928 triangles at 35 degrees, with wear",
        "plate",
        500,
        1000,
        0.0,
        (1e-3, 2e-3, 2.5e-3, 3e-3),
    ),
)


def plate() -> Surface:
    """1.0 m x 0.2 m, 112 x 22 squares of two triangles."""
    return rectangle((0.0, 0.0), (1.0, PLATE_WIDTH), (112, 22), GRAIN)


def _box(edge: float) -> Model:
    """Four walls and a floor."""
    sides = (
        ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((edge, 0.0, 0.0), (-1.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, edge, 0.0), (0.0, -1.0, 0.0)),
    )
    walls = tuple(Wall(Plane(point, normal, GRAIN)) for point, normal in sides)
    domain = Domain((-0.1, -0.1, -0.1), (edge + 0.1, edge + 0.1, 2.0 * edge))
    return Model((GRAIN,), TIME_STEP, domain, walls, gravity=(0.0, 0.0, -GRAVITY))


def _plate() -> Model:
    """The plate between two flat side walls; gravity is tilted instead of the plate."""
    walls = (
        Wall(plate()),
        Wall(Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), GRAIN)),
        Wall(Plane((0.0, PLATE_WIDTH, 0.0), (0.0, -1.0, 0.0), GRAIN)),
    )
    domain = Domain((-0.5, -0.1, -0.5), (2.0, 0.3, 1.0))
    gravity = (SINE * GRAVITY, 0.0, -COSINE * GRAVITY)
    return Model((GRAIN,), TIME_STEP, domain, walls, gravity=gravity)


def _write_stl(file: Path, surface: Surface) -> None:
    lines = [f"solid {surface.name}"]
    for normal, corner in zip(surface.normal, surface.corner, strict=True):
        lines += [" facet normal {:g} {:g} {:g}".format(*normal), "  outer loop"]
        lines += ["   vertex {:.9e} {:.9e} {:.9e}".format(*point) for point in corner]
        lines += ["  endloop", " endfacet"]
    file.write_text("\n".join([*lines, f"endsolid {surface.name}"]) + "\n")
