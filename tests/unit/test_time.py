"""Time goes on when the time step changes between windows."""

import numpy as np
import pytest

from wearfem.dem.flow import Domain, Flow, Model, Wall
from wearfem.dem.motion import rotation, translation
from wearfem.dem.particles import spheres
from wearfem.dem.sample import Stepper, advance
from wearfem.material import Material
from wearfem.surface import rectangle

STONE = Material("stone", 2500.0, 1e7, 0.3)


def world(time_step: float) -> Model:
    """A sphere in free flight far above a plate that turns and one that slides."""
    plate = rectangle((-0.1, -0.1), (0.1, 0.1), (2, 2), STONE)
    return Model(
        materials=(STONE,),
        time_step=time_step,
        domain=Domain((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)),
        walls=(Wall(plate, rotation(3.0)), Wall(plate, translation((0.2, 0.0, 0.0)))),
    )


def test_walls_go_on_where_they_were_when_the_step_changes():
    flow = advance(Flow(spheres((0.0, 0.0, 0.5), 0.005, 2500.0)), world(1e-5), 0.01)
    flow = advance(flow, world(4e-6), 0.02)
    flow = advance(flow, world(4e-6), 0.03)
    assert flow.time == pytest.approx(0.06, abs=1e-12)  # whole steps of 10 and 4 us
    pose = Stepper(flow, world(4e-6)).pose()
    assert pose[0, 3] == pytest.approx(np.cos(3.0 * 0.06), abs=1e-12)  # rounding
    assert pose[1, 0] == pytest.approx(0.2 * 0.06, abs=1e-12)
    height = 0.5 - 0.5 * 9.81 * 0.06**2
    assert flow.particles.position[0, 2] == pytest.approx(height, abs=1e-12)  # Verlet is exact in free fall
