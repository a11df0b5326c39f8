"""When numbers that fit are not believed: at the end of what is plausible, or two for one law."""

import numpy as np
import pytest

from model_gap.decide import at_limits, one_law
from model_gap.effects import Scene
from model_gap.effects.backlash import Backlash
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.payload import Payload
from model_gap.effects.sensor_polarity import SensorPolarity
from model_gap.explicit_damping import explicit_damping
from model_gap.hypothesis import Hypothesis
from model_gap.setup import Setup


@pytest.fixture(scope='module')
def nominal(robot, layout):
    setup = Setup(explicit_damping(robot.spec), layout.channels)
    names = tuple(sensor.name for sensor in layout)
    return Hypothesis(Scene(robot, names, setup), (), (), np.zeros(0), np.zeros(0))


def test_a_number_at_the_end_of_its_range_is_no_explanation(nominal):
    stop = nominal.with_effect(JointStiffness('joint_2'), (5.0,))
    (reason,) = at_limits(stop)
    assert 'factor of joint_stiffness at joint_2' in reason
    assert at_limits(nominal.with_effect(JointStiffness('joint_2'), (4.9,))) == ()
    # Details may be nothing at all, and some effects have no number.
    held = nominal.with_effect(Backlash('joint_2'), (1e-4, 0.0))
    assert at_limits(held) == ()
    assert at_limits(nominal.with_effect(SensorPolarity('sensor:elbow', 'x'), ())) == ()


def test_play_and_another_stiffness_in_one_joint_may_be_one_law(nominal):
    play = nominal.with_effect(Backlash('joint_2'), (1e-4, 0.2))
    assert one_law(play) == ()
    (reason,) = one_law(play.with_effect(JointStiffness('joint_2'), (3.0,)))
    assert 'backlash at joint_2 and joint_stiffness' in reason
    assert one_law(play.with_effect(JointStiffness('joint_3'), (3.0,))) == ()
    softer = nominal.with_effect(JointStiffness('joint_2'), (0.8,))
    link = nominal.scene.model.link_names[-1]
    values = tuple(Payload(link).starts(nominal.scene)[0])
    assert one_law(softer.with_effect(Payload(link), values)) == ()
