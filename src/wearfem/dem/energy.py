"""The energy ledger: what particles hold, what contacts hold, and where the rest went. It must close."""

from dataclasses import dataclass, fields

import numpy as np

from wearfem.dem.contact import Pair
from wearfem.dem.flow import Flow, Model
from wearfem.dem.motion import point_into_body
from wearfem.dem.pairs import STIFFNESS
from wearfem.dem.sample import Stepper
from wearfem.dem.steps import DAMPING_LOSS, EXTERNAL_WORK, ROLLING_LOSS, SLIP_LOSS, STIFFNESS_LOSS, WALL_WORK
from wearfem.dem.wall_list import MEMORY, POINT, SHARE
from wearfem.dem.walls import wall_touch


@dataclass(frozen=True)
class Energy:
    """Energies of a flow and the work and losses since its start [J]."""

    kinetic: float
    elastic: float
    external_work: float  # by gravity and applied forces
    wall_work: float  # by moving walls
    slip_loss: float  # Coulomb friction
    stiffness_loss: float  # tangential springs whose stiffness changes under load
    damping_loss: float  # dashpots
    rolling_loss: float  # rolling and twisting

    @property
    def dissipated(self) -> float:
        """All losses [J]"""
        return self.slip_loss + self.stiffness_loss + self.damping_loss + self.rolling_loss

    def gap_since(self, start: "Energy") -> float:
        """What does not add up [J]: (kinetic + elastic + losses - work), now less at `start`."""

        def balance(e: Energy) -> float:
            return e.kinetic + e.elastic + e.dissipated - e.external_work - e.wall_work

        return balance(self) - balance(start)

    def lines(self) -> list[str]:
        """One line for each entry."""
        return [
            f"{field.name.replace('_', ' '):16s} {getattr(self, field.name):14.6e} J"
            for field in fields(self)
        ]


def energy(flow: Flow, model: Model) -> Energy:
    """The ledger of a flow at its time. A plain loop over contacts: for proofs and reports, not for every step."""
    return Energy(
        kinetic=flow.kinetic_energy,
        elastic=elastic_energy(flow, model),
        external_work=float(flow.ledger[EXTERNAL_WORK]),
        wall_work=float(flow.ledger[WALL_WORK]),
        slip_loss=float(flow.ledger[SLIP_LOSS]),
        stiffness_loss=float(flow.ledger[STIFFNESS_LOSS]),
        damping_loss=float(flow.ledger[DAMPING_LOSS]),
        rolling_loss=float(flow.ledger[ROLLING_LOSS]),
    )


def touching_pairs(flow: Flow) -> np.ndarray:
    """(k, 3) int: particle, partner and place in the list of every pair that touched at the last step."""
    pairs = flow.pairs
    if pairs is None:
        return np.zeros((0, 3), np.int64)
    chunks = zip(pairs.pair_start, pairs.pair_end, strict=True)
    place = np.concatenate([np.arange(start, end) for start, end in chunks] or [np.zeros(0, np.int64)])
    place = place[pairs.memory[place, STIFFNESS] > 0.0]
    return np.stack(
        [pairs.first[place].astype(np.int64), pairs.second[place].astype(np.int64), place], axis=1
    )


def elastic_energy(flow: Flow, model: Model) -> float:
    """Energy held by the springs of all contacts [J]."""
    if flow.pairs is None or flow.walls is None or flow.packed is None:
        return 0.0
    law, dt, packed = model.contact, model.time_step, flow.packed
    rolling = law.rolling.memory_size()
    total = 0.0
    for i, j, place in touching_pairs(flow):
        a, b = packed[i], packed[j]
        apart = a[:3] - b[:3]
        apart -= model.period * np.round(apart / np.where(model.period > 0, model.period, np.inf))
        distance = float(np.linalg.norm(apart))
        overlap, normal = a[9] + b[9] - distance, apart / distance
        arm, partner_arm = a[9] - overlap * b[9] / (a[9] + b[9]), b[9] - overlap * a[9] / (a[9] + b[9])
        velocity = a[3:6] - b[3:6] - np.cross(arm * a[6:9] + partner_arm * b[6:9], normal)
        pair = _pair(model, 1 / (1 / a[9] + 1 / b[9]), 1 / (1 / a[10] + 1 / b[10]), int(a[11]), int(b[11]))
        held = flow.pairs.memory[place]
        total += _held(law, pair, overlap, normal, velocity, a[6:9] - b[6:9], held, rolling, dt)
    stepper = Stepper(flow, model)
    pose = stepper.pose()
    found = np.zeros((1, 13))
    for row, i in enumerate(flow.walls.particle):
        x = packed[i, :3]
        for k in range(flow.walls.body.shape[1]):
            body, record = flow.walls.body[row, k], flow.walls.record[row, k]
            if body < 0:
                continue
            here = np.array(point_into_body(pose, body, *x))
            distance = float(np.linalg.norm(here - record[POINT : POINT + 3]))
            normal = (here - record[POINT : POINT + 3]) / distance
            found[0, 0], found[0, 7:10], found[0, 10:13] = (
                packed[i, 9] - distance,
                record[POINT : POINT + 3],
                normal,
            )
            touch, _ = wall_touch(packed, i, stepper.geometry, pose, body, found, 0)
            wall = model.materials.index(model.walls[body].shape.material)
            pair = _pair(model, packed[i, 9], packed[i, 10], int(packed[i, 11]), wall)
            held = np.concatenate([record[MEMORY : MEMORY + 4 + rolling], record[MEMORY + 7 : MEMORY + 8]])
            velocity, turning = np.array(touch[4:7]), np.array(touch[7:10])
            total += record[SHARE] * _held(
                law, pair, touch.overlap, normal, velocity, turning, held, rolling, dt
            )
    return total


def _pair(model: Model, radius: float, mass: float, one: int, other: int) -> Pair:
    return Pair(radius, mass, *(float(array[one, other]) for array in model.table))


def _held(law, pair, overlap, normal, velocity, turning, memory, rolling, dt) -> float:
    """Energy of the springs of one contact [J]; displacements are taken back by the half step that they are stored ahead."""
    across = velocity - velocity @ normal * normal
    along = turning @ normal
    stiffness = law.force.tangential_stiffness(overlap, pair)
    total = law.force.elastic_energy(overlap, pair)
    total += 0.5 * stiffness * float(((memory[:3] - 0.5 * dt * across) ** 2).sum())
    if rolling:
        spring = law.rolling.rolling_stiffness(law.force.elastic_force(overlap, pair) / overlap, pair)
        total += 0.5 * spring * float(((memory[4:7] - 0.5 * dt * (turning - along * normal)) ** 2).sum())
    if law.twisting.memory_size():
        spring = law.twisting.twisting_stiffness(stiffness, overlap, pair)
        total += 0.5 * spring * float((memory[4 + rolling] - 0.5 * dt * along) ** 2)
    return float(total)
