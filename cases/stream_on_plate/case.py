"""A thin stream of grains that strikes a plate at a slant: what wears is aimed at differently, so wear changes itself.

Grains fly in straight lines, hit the worn face once and leave; they do not meet. All loads are those of a rigid sphere that hits a plane:
at the angle a between stream and face, with m the mass that arrives by area and time,

    approach speed   v_n = U sin a,  tangential speed  v_t = U cos a
    change of speed  D = min(mu (1 + e) v_n, 2/7 v_t)          slides to the end, or sticks
    pressure         p = m (1 + e) v_n
    friction work    w = m D (v_t - 7/4 D)                      what translation and spin lose along the face
    load distance    w / mu

So energy is kept: what arrives is m U^2/2. The scar grows where the stream is dense; its far side turns towards the stream and wears
faster, its near side turns away. At 20 degrees one degree of slope changes the rate by some 7 %.

**Source** rigid spheres with friction: Maw, Barber and Fawcett, Wear 38 (1976) 101-114, in the limit of stiff bodies; Archard's law.
**Valid for** streams so thin that grains do not shield the plate.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wearfem.case import Figure, LifeCase, Stop, Window
from wearfem.cycle import worn_to
from wearfem.formula import FormulaFlow, Sliding
from wearfem.history import History
from wearfem.liner.block import Tetrahedra, block
from wearfem.liner.liner import Liner, wear_surface
from wearfem.loads import FacetLoads
from wearfem.material import Material
from wearfem.surface import Surface
from wearfem.units import day, degree, mm
from wearfem.wear.laws import Archard

LENGTH, WIDTH, THICKNESS = 400 * mm, 160 * mm, 25 * mm
STEEL = Material("steel", 7850.0, 80e9, 0.3)


def case(
    *,
    angle: float = 20 * degree,
    speed: float = 6.0,
    mass_rate: float = 4.0,
    specific_wear_rate: float = 2.0e-13,
    limit: float = 8 * mm,
    cells: int = 20,
    smoothing_length: float = 25 * mm,
    tolerance: float = 0.02,
    noise: float = 0.1,
    memory: float = 0.5,
    delay: float = 0.5,
    seed: int = 1,
    frozen: bool = False,
    stop: float = 1e12,
) -> LifeCase:
    """The life of the plate.

    Parameters
    ----------
    angle
        Of the stream to the new plate [rad].
    speed
        Of the grains [m/s].
    mass_rate
        In the stream [kg/s].
    specific_wear_rate
        k of Archard's law [m2/N].
    limit
        Thickness [m] at which the plate of 25 mm is worn out.
    cells
        Of the mesh along the plate of 400 mm.
    smoothing_length
        Over the rate [m].
    tolerance
        Within which the life is to be known, 90 times out of 100.
    noise, memory, delay
        Of the loads, block by block [-], from block to block [-], after the geometry has changed [s].
    seed
        Of the noise.
    frozen
        Keep the geometry as it is new.
    stop
        Service time [s] at which to stop, where it comes before the end of life.
    """
    mesh = block((0, 0, -THICKNESS), (LENGTH, WIDTH, 0), (cells, 2 * cells // 5, 2), Tetrahedra, name="plate")
    liner = Liner(mesh, STEEL)
    seen = Sliding(1.0, 1.0, noise=noise, memory=memory, delay=delay, seed=seed)
    stream = Stream(seen, angle, speed, mass_rate)
    return LifeCase(
        name="stream_on_plate",
        flow=FormulaFlow(),
        sampler=stream,
        liner=liner,
        wear_law=Archard(specific_wear_rate),
        goal=worn_to(liner, limit, tolerance=tolerance),
        window=Window(10.0, 40),
        warm_up=3.0 * delay,
        throughput_rate=mass_rate,
        smoothing_length=smoothing_length,
        frozen=frozen,
        stop=Stop(service_time=stop),
        measure=lambda history: figures(history, stream),
    )


@dataclass(frozen=True)
class Stream:
    """Grains that fly in parallel; across the middle line of the stream their mass is spread normally."""

    seen: Sliding  # what tells the noise and the delay with which a sampled flow shows the mass that arrives
    angle: float  # [rad] to the plane z = 0
    speed: float  # [m/s] U
    mass_rate: float  # [kg/s]
    friction: float = 0.3  # [-] mu
    restitution: float = 0.3  # [-] e
    middle: tuple[float, float] = (0.45 * LENGTH, 0.5 * WIDTH)  # [m] where the middle line meets z = 0
    thick: float = 28 * mm  # standard deviation of the mass across the stream, in the plane of x and z
    wide: float = 60 * mm  # the same along y

    def sample(
        self, flow: FormulaFlow, surface: Surface, window: Window, tell: Any = None
    ) -> tuple[FormulaFlow, FacetLoads]:
        """The flow after the window, and its loads by block."""
        normal, centre = facets_of(surface)
        arriving = self.arriving(normal, centre)
        flow, shown = replace(self.seen, intensity=lambda _: arriving).sample(flow, surface, window, tell)
        return flow, self.loads(shown, normal)

    @property
    def flight(self) -> np.ndarray:
        """(3,) direction"""
        return np.array([np.cos(self.angle), 0.0, -np.sin(self.angle)])

    def arriving(self, normal: np.ndarray, centre: np.ndarray) -> np.ndarray:
        """(f,) [kg/(m2 s)] mass by area of the face and time, m"""
        sine, cosine = np.sin(self.angle), np.cos(self.angle)
        off = (centre[:, 0] - self.middle[0]) * sine + centre[:, 2] * cosine  # of the middle line
        across = centre[:, 1] - self.middle[1]
        density = np.exp(-0.5 * ((off / self.thick) ** 2 + (across / self.wide) ** 2))
        density *= self.mass_rate / (2.0 * np.pi * self.thick * self.wide)
        return density * np.maximum(-normal @ self.flight, 0.0)

    def loads(self, shown: FacetLoads, normal: np.ndarray) -> FacetLoads:
        """What rigid spheres do; `shown.normal_impulse` (b, f) is the mass [kg] that arrives in each block."""
        mass = shown.normal_impulse
        sine = np.clip(-normal @ self.flight, 0.0, 1.0)
        approach, along = self.speed * sine, self.speed * np.sqrt(1.0 - sine**2)
        push = (1.0 + self.restitution) * approach
        pull = np.minimum(self.friction * push, 2.0 / 7.0 * along)
        work = pull * (along - 1.75 * pull)
        tangent = self.flight + sine[:, None] * normal
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        tangent = np.divide(tangent, length, out=np.zeros_like(tangent), where=length > 0.0)
        energy = 0.5 * self.speed**2 * mass
        angle, log = np.arcsin(sine), np.log(self.speed) * np.ones_like(sine)
        moment = np.stack([angle, angle**2, log, log**2, angle * log], axis=-1)
        return replace(
            shown,
            normal_impulse=push * mass,
            tangential_impulse=(pull * mass)[..., None] * tangent,
            friction_work=work * mass,
            load_distance=work / self.friction * mass,
            impact_energy=energy[..., None, None],
            impact_moment=(energy[..., None] * moment)[..., None, None, :],
            angle_edge=np.array([0.0, 90.0]),
            speed_edge=np.array([0.5, 2.0]) * self.speed,
        )


def facets_of(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals (f, 3) and middles (f, 3) [m] of the facets"""

    def summed(by_triangle: np.ndarray) -> np.ndarray:
        parts = (surface.area[:, None] * by_triangle).T
        return np.stack([np.bincount(surface.facet, part, surface.facet_count) for part in parts], axis=1)

    normal = summed(surface.normal)
    centre = summed(surface.corner.mean(axis=1)) / surface.facet_area[:, None]
    return normal / np.linalg.norm(normal, axis=1, keepdims=True), centre


def figures(history: History, stream: Stream) -> tuple[Figure, ...]:
    told = history.life[-1]
    deepest = int(np.argmax(history.depth[-1]))
    angle = np.degrees(np.arcsin(-facets_of(wear_surface(history.state.now.liner))[0] @ stream.flight))
    return (
        Figure("end of life, at the last rate", told.time / day, "d"),
        Figure("half of its 90 % interval", history.reports[-1].end_error(1.645) / day, "d"),
        Figure("deepest wear", 1e3 * history.depth[-1].max(), "mm"),
        Figure("rate there over that of the new plate", history.rate[-1, deepest] / history.rate[0, deepest], "-"),
        Figure("steepest angle of impact", float(angle.max()), "degree"),
        Figure("flattest angle of impact", float(angle.min()), "degree"),
        Figure("cycles", len(history.reports), "-"),
    )  # fmt: skip
