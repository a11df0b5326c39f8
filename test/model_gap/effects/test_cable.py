"""A cable is sought by direction and nearness, one optimum; told are points, in metres."""

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.cell.cell_model import CellModel
from model_gap.effects import Scene
from model_gap.effects.cable import Cable
from model_gap.hypothesis import Hypothesis, known_effects

STIFFNESS, WAY = 5e4, (0.3, -0.4)
POSE = np.array([0.4, 0.3, -0.2, 0.5, -0.7, 0.1])


@pytest.fixture(scope='module')
def scene(robot, layout):
    cell = CellModel(explicit_damping(robot.spec), layout.channels)
    return Scene(robot, tuple(sensor.name for sensor in layout), cell)


def modes_hz(scene, robot, nearness):
    cell = Cable('link_4').apply(scene.cell, (STIFFNESS, *WAY, nearness), scene)
    return robot.replace(cell.spec).modes(POSE).frequency_hz


def test_it_passes_through_infinity_to_the_other_side_without_a_step(scene, robot):
    """Where an anchor is a point, both sides are as far apart as can be."""
    left, far, right = (modes_hz(scene, robot, near) for near in (-1e-3, 0.0, 1e-3))
    bare = robot.replace(scene.cell.spec).modes(POSE).frequency_hz
    size = np.abs(far - bare).max()
    assert size > 0.0
    assert np.abs(right - left).max() < 5e-3 * size
    assert np.abs(right - 2.0 * far + left).max() < 1e-4 * size


def test_both_ends_are_told_in_metres_with_deviations(scene):
    cable = Cable('link_4')
    values = (STIFFNESS, *WAY, 0.5)
    start = Hypothesis(scene, (), (), np.zeros(0), np.zeros(0)).with_effect(cable, values)
    (known,) = known_effects(start, np.diag([1e6, 1e-4, 1e-4, 1e-4]))
    told = {item.name: item for item in known.parameters}
    assert list(told) == ['stiffness', 'from_x', 'from_y', 'from_z']
    assert told['stiffness'].value == STIFFNESS
    assert told['stiffness'].sigma == pytest.approx(1e3, rel=1e-3)
    ends = [told[f'from_{axis}'] for axis in 'xyz']
    assert [item.value for item in ends] == pytest.approx(cable.anchor(values, scene))
    # 2 m away: 0.01/m of nearness are 4 cm along, 0.01 rad of turn about 2 cm across.
    whole = np.sqrt(sum(item.sigma**2 for item in ends))
    assert 0.04 < whole < 0.06


def test_no_prior_pulls_at_a_plausible_cable(scene):
    """What it costs to be there is less than what earns a place."""
    cable = Cable('link_4', details=True)
    most = 0.5 * max(joint.drive.spring.stiffness for joint in scene.model.spec.joints)
    values = {'stiffness': most, 'pull': 600.0}
    for item in cable.parameters(scene):
        if item.name in values:
            assert 0.5 * (item.inner(values[item.name]) / item.scale) ** 2 < 4.0
