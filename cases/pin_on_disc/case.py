"""Pin on disc: one iron-ore particle, held and pressed on a turning steel disc, wears a track of known volume.

**Source** Sensitivity analysis of DEM prediction for sliding wear by single iron ore particle, the reference case (Table IX).
"""

from math import pi, sqrt
from pathlib import Path

import numpy as np

from wearfem import report
from wearfem.case import Case, Figure, Outcome, Stage, Window
from wearfem.check import rayleigh_time, static_overlap
from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.motion import rotation
from wearfem.dem.particles import HELD, spheres
from wearfem.errors import UserError, in_words
from wearfem.material import Interaction, Material
from wearfem.surface_file import read_surface
from wearfem.wear.laws import Archard, worn_depth

MESHES = Path(__file__).parent / "meshes"
DISC_RADIUS, DISC_HEIGHT = 26.5e-3, 6e-3  # [m]
GRAVITY = 9.81  # [m/s2]
SETTLE = 2e-3  # [s] after which the force is steady: some 70 periods of the contact
SNAPSHOTS = 4000  # of the normal force while sliding
PUBLISHED = 4.50e-12  # [m3] wear of one revolution of the reference case (section 5.1)


def case(
    *,
    radius: float = 2e-3,
    density: float = 4850.0,
    poisson_ratio: float = 0.24,
    shear_modulus: float = 65e9,
    rotation_speed: float = 6.82,
    mesh_size: float = 1.1e-3,
    restitution: float = 0.4,
    force: float = 5.0,
    time_step: float = 1.5e-6,
    friction: float = 1.0,
    track_radius: float = 22e-3,
    distance: float = 3 * 2 * pi * 22e-3,
    specific_wear_rate: float = 6.51e-12,
) -> Case:
    """The particle [m, kg/m3, -, Pa], the disc [rad/s, m], their contact [-], the load [N], the time step [s], the track [m], the
    distance slid [m], 180 m in the paper, and the coefficient of sliding wear alpha_s [m2/N]."""
    ore = Material("iron ore", density, shear_modulus, poisson_ratio, restitution, friction)
    steel = Material("mild steel", 7932.0, 78e9, 0.3, restitution, friction)
    if not 0.0 < track_radius < DISC_RADIUS:
        raise UserError(
            f"The track radius is {track_radius:g} m; it must lie on the disc, under {DISC_RADIUS} m."
        )
    mesh = mesh_of(mesh_size)
    disc = read_surface(mesh, steel, name="disc")
    particle = spheres(
        [track_radius, 0.0, radius],
        radius,
        density,
        applied_force=(0.0, 0.0, -force),
        held=HELD["x"] | HELD["y"] | HELD["rotation"],
    )
    room = DISC_RADIUS + 2.0 * radius
    model = Model(
        materials=(ore, steel),
        interactions=(Interaction(ore, steel, restitution, friction),),
        time_step=time_step,
        domain=Domain((-room, -room, -2.0 * DISC_HEIGHT), (room, room, 4.0 * radius)),
        walls=(Wall(disc, rotation(rotation_speed)),),
        gravity=(0.0, 0.0, -GRAVITY),
        wall_skin=0.5 * radius,
    )
    speed = abs(rotation_speed) * track_radius
    if speed == 0.0:
        raise UserError("The rotation speed is 0 rad/s; the disc must turn for the particle to slide.")
    slide = Window(distance / speed, block_count=3, snapshots=SNAPSHOTS)
    stages = (Stage("settle", model, Window(SETTLE)), Stage("slide", model, slide))

    law = Archard(specific_wear_rate)
    load = force + particle.mass[0] * GRAVITY
    overlap = static_overlap(load, radius, model.table.effective_modulus[0, 1])
    slowest_wave = rayleigh_time(radius, density, shear_modulus, poisson_ratio)
    reference = (radius, density, force, specific_wear_rate) == (2e-3, 4850.0, 5.0, 6.51e-12)

    def measure(outcome: Outcome) -> tuple[Figure, ...]:
        loads = outcome["slide"].loads
        time = loads.duration.sum()
        slid = speed * time
        volume = law.volume(loads).sum()
        turn = 2.0 * pi * track_radius
        normal, height, sinking = trace(outcome)
        expected = specific_wear_rate * load * slid
        return (
            Figure("sliding distance", slid, "m"),
            Figure("wear volume", volume, "m3", expected, "alpha (F + m g) l", 1e-4 * expected),
            Figure(
                "wear volume of one revolution",
                volume * turn / slid,
                "m3",
                PUBLISHED if reference and track_radius == 22e-3 else specific_wear_rate * load * turn,
                "section 5.1" if reference and track_radius == 22e-3 else "alpha (F + m g) 2 pi r",
                0.005e-12,
            ),
            Figure("mean normal force", loads.normal_impulse.sum() / time, "N", load, "F + m g", 1e-6 * load),
            Figure(
                "largest deviation of the normal force",
                float(np.abs(normal / load - 1.0).max()),
                "-",
                0.0,
                "no joint is felt",
                1e-6,
            ),
            Figure(
                "largest speed across the disc",
                float(np.abs(sinking).max()),
                "m/s",
                0.0,
                "no joint is felt",
                1e-6 * speed,
            ),
            Figure(
                "sliding speed",
                loads.load_distance.sum() / loads.normal_impulse.sum(),
                "m/s",
                speed,
                "omega r",
                1e-6 * speed,
            ),
            Figure("overlap", float(radius - height.mean()), "m", overlap, "Hertz", 1e-6 * overlap),
            Figure("deepest facet", float(worn_depth(law, loads).max()), "m"),
            Figure("time step over Rayleigh time", time_step / slowest_wave, "-"),
            Figure("smallest mesh size advised", 2.0 * sqrt(radius * overlap), "m"),
        )

    def draw(outcome: Outcome, folder: Path) -> None:
        depth = worn_depth(law, outcome["slide"].loads)
        normal, _, _ = trace(outcome)
        length = np.linspace(0.0, distance, len(normal) + 1)[1:]
        with report.picture(folder / "pin_on_disc.png", 2) as (left, right):
            report.draw_surface(left, disc, depth * 1e9, "wear depth [nm]")
            left.set_title(f"Worn by {load:.4g} N over {distance:.4g} m")
            report.draw_lines(
                right, length, {"normal force": normal / load - 1.0}, "distance [m]", "F_n / (F + m g) - 1"
            )
            right.set_title("Normal force across the joints")

    return Case("pin_on_disc", Flow(particle), stages, law, measure, draw=draw, files=(mesh,))


def mesh_of(size: float) -> Path:
    """The shipped mesh of the disc with this mesh size [m]."""
    path = MESHES / f"disc_{size * 1e3:g}_mm.vtu"
    if not path.is_file():
        shipped = sorted(float(file.stem.split("_")[1]) for file in MESHES.glob("disc_*_mm.vtu"))
        raise UserError(
            f"There is no mesh of {size * 1e3:g} mm; the disc is shipped with {in_words([f'{s:g}*mm' for s in shipped], 'or')} "
            "(meshes/make_meshes.py makes others)."
        )
    return path


def trace(outcome: Outcome) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normal force [N], height of the centre [m] and velocity along the axis [m/s] of the particle at each snapshot."""
    particles = [flow.particles for flow in outcome["slide"].snapshots]
    return tuple(
        np.array(row)
        for row in zip(*((p.force[0, 2], p.position[0, 2], p.velocity[0, 2]) for p in particles), strict=True)
    )
