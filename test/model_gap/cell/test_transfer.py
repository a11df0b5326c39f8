"""What sensors read per force on every degree of freedom at once."""

import dataclasses

import numpy as np
import pytest

from model_gap.cell import pose_system
from structural_model.description.spec import Spring

POSE = np.array([0.3, 0.2, 0.1, 0.4, -0.6, 0.2])
OMEGA = 2.0 * np.pi * np.linspace(3.0, 60.0, 50)


def overdamped(model):
    """Return an arm one drive of which creeps back: its poles are real."""
    first, *others = model.spec.joints
    spring = first.drive.spring
    creeping = Spring(spring.stiffness, 0.5 * spring.stiffness)
    first = dataclasses.replace(first, drive=dataclasses.replace(first.drive, spring=creeping))
    spec = dataclasses.replace(model.spec, joints=(first, *others))
    return dataclasses.replace(model, spec=spec)


@pytest.mark.parametrize('made', [lambda model: model, overdamped])
def test_it_is_the_response_to_one_force_after_the_other(robot, layout, made):
    """To single precision of the largest response of a channel."""
    system = pose_system(made(robot), POSE, layout.channels)
    alone = [system.response(OMEGA, force) for force in np.eye(len(system.dof_names))]
    exact = np.array(alone).transpose(1, 0, 2)
    size = np.abs(exact).max(axis=2, keepdims=True)
    assert np.abs(system.transfer(OMEGA) - exact).max() < 1e-4 * size.max()
    np.testing.assert_allclose(system.transfer(OMEGA) / size, exact / size, atol=1e-5)
