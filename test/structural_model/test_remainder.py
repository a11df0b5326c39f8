"""What a linearised arm leaves out, against the order it must have and a turning pendulum."""

import numpy as np
import pytest

from modal_core.channel import Sensor, SensorLayout
from structural_model import load_robot
from structural_model.equations import remainder

SEED = 4
SAMPLES = 6


def motion(rng, n):
    return tuple(rng.standard_normal((SAMPLES, n)) * size for size in (1e-2, 0.1, 1.0))


@pytest.mark.parametrize('name', ['irb6660_205_190', 'generic_arm_6'])
def test_nothing_of_first_order_is_left(name):
    """Halving a motion quarters what is left, of force and of readings."""
    model = load_robot(name)
    rng = np.random.default_rng(SEED)
    motors, flexible = motion(rng, model.n_joints), motion(rng, model.n_dof)
    layout = SensorLayout(
        tuple(Sensor(link, link, (0.1, -0.05, 0.2)) for link in model.link_names[-3:])
    )
    pose = model.pose(next(iter(model.poses_controller_rad)))
    rest = model.static_deflection(pose)
    sizes = []
    for scale in (1e-2, 5e-3):
        parts = [tuple(scale * item for item in items) for items in (motors, flexible)]
        found = remainder(model.dynamics, pose, rest, *parts, layout.channels)
        sizes.append([np.abs(item).max() for item in found])
    ratio = np.divide(*sizes)
    np.testing.assert_allclose(ratio, 4.0, rtol=0.02, err_msg=f'{name}, seed {SEED}')


def test_a_steady_turn_shows_its_centripetal_acceleration():
    """The first axis turns alone: a sensor at radius r reads ω²r inwards, and nothing else new."""
    model = load_robot('generic_arm_6')
    pose = model.pose(next(iter(model.poses_controller_rad)))
    omega, still = 0.3, np.zeros((1, model.n_joints))
    turn = still.copy()
    turn[0, 0] = omega
    rigid = np.zeros((1, model.n_dof))
    layout = SensorLayout((Sensor('tip', model.link_names[-1], (0.0, 0.0, 0.0)),))
    none = np.zeros(model.n_dof)
    _, reading = remainder(
        model.dynamics, pose, none, (still, turn, still), (rigid, rigid, rigid), layout.channels
    )
    exact = model.rigid_acceleration(pose, turn[0], still[0], layout.channels)
    at_rest = model.rigid_acceleration(pose, still[0], still[0], layout.channels)
    np.testing.assert_allclose(reading[0], exact - at_rest, atol=1e-12)
    assert np.linalg.norm(reading) > 0.05 * omega**2
