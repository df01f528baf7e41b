"""Rigid motions: where a body is and how fast, before, while and after it turns."""

import math

import numpy as np
import pytest

from wearfem.case import Window
from wearfem.dem.flow import Domain, Flow, Model
from wearfem.dem.motion import ORIGIN, POSE, ROTATION, TURNING, bodies, pose_at, rotation
from wearfem.dem.particles import spheres
from wearfem.dem.sample import sample
from wearfem.errors import UserError
from wearfem.material import Material


def pose(motion, time):
    found = np.zeros(POSE)
    pose_at(bodies([motion]), 0, time, found)
    return found


@pytest.mark.parametrize(
    ("time", "turn", "rate"),
    [(0.5, 0.0, 0.0), (1.0, 0.0, 2.0), (1.25, 0.5, 2.0), (1.5, 1.0, 0.0), (9.0, 1.0, 0.0)],
)
def test_a_rotation_starts_and_stops(time, turn, rate):
    found = pose(rotation(2.0, axis=(0.0, 3.0, 0.0), centre=(1.0, 0.0, 0.0), start=1.0, stop=1.5), time)
    matrix = found[ROTATION : ROTATION + 9].reshape(3, 3)
    expected = [[math.cos(turn), 0, math.sin(turn)], [0, 1, 0], [-math.sin(turn), 0, math.cos(turn)]]
    assert matrix == pytest.approx(np.array(expected), abs=1e-15)  # rounding of numbers near 1
    assert found[TURNING : TURNING + 3] == pytest.approx([0.0, rate, 0.0], abs=0.0)
    centre = np.array([1.0, 0.0, 0.0])
    assert found[ORIGIN : ORIGIN + 3] + matrix @ centre == pytest.approx(centre, abs=1e-15)  # as above


def test_a_rotation_without_an_end_turns_from_the_beginning():
    found = pose(rotation(2.0), 100.0)
    assert found[ROTATION] == pytest.approx(math.cos(200.0), abs=1e-15)  # rounding of a number near 1


def test_a_rotation_that_stops_before_it_starts_is_refused():
    with pytest.raises(UserError, match="must stop after its start"):
        rotation(1.0, start=2.0, stop=1.0)


def test_snapshots_keep_their_moment():
    """A falling sphere's height in each snapshot is that of the free fall at its time."""
    steel = Material("steel", 7800.0, 1e8, 0.3)
    model = Model(materials=(steel,), time_step=1e-5, domain=Domain((-1, -1, -9), (1, 1, 9)))
    flow = Flow(spheres(np.array([[0.0, 0.0, 5.0]]), 0.01, steel.density))
    _, _, snapshots = sample(flow, model, Window(0.1, snapshots=4))
    for snapshot in snapshots:
        fall = 0.5 * 9.81 * snapshot.time**2
        assert snapshot.particles.position[0, 2] == pytest.approx(
            5.0 - fall, abs=1e-12
        )  # rounding of 1e4 steps
