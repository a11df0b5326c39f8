"""What bends the arm at rest is not taken for an encoder or a gain once it is known."""

import dataclasses

import numpy as np
import pytest

from model_gap.campaign.campaign import Campaign, GapRecord
from model_gap.cell.tolerances import Tolerances
from model_gap.effects.gravity_compensator import GravityCompensator
from model_gap.gravity import Fault, Kind, rest_of, same_put_right, weigh, weighed_again
from model_gap.search.search import Search
from test.model_gap.conftest import ROBOT
from test.support.hidden_campaign import poses, SENSORS
from test.support.independent_arm import Chain, read_arm

JOINT, G = 1, 9.81
# Of the spring: it turns joint 2 by up to 5 degrees.
SHARE, PHASE = 0.09, 0.2


def standing(robot, layout, seed, offset_rad=0.0):
    """Means of the independent arm, whose joint 2 a hidden counterbalance turns in its spring."""
    rng, arm, records = np.random.default_rng([91, seed]), read_arm(ROBOT), []
    for number, pose in enumerate(poses(rng, 6)):
        true = pose.copy()
        true[JOINT] += offset_rad
        turn = -SHARE * np.sin(true[JOINT] - PHASE)
        true[[JOINT, JOINT + 1]] += turn, -turn  # the rod keeps the upper arm's inclination
        chain = Chain(arm, true)
        axes = [chain.on_link(link, place)[2] for _, link, place in SENSORS]
        mean = np.concatenate([own.T @ (0.0, 0.0, G) for own in axes])
        still = np.zeros((100, 6))
        shaken = mean + 0.01 * rng.standard_normal((100, len(mean)))
        records.append(GapRecord(f'p{number}', pose, '1', 100.0, shaken, still, still, still))
    return Campaign(tuple(records), layout, robot.joint_names)


@pytest.fixture(scope='module')
def found(robot, layout):
    """The counterbalance as vibration would tell it."""
    begun = Search.begin(robot, standing(robot, layout, 0))
    strength = SHARE * robot.spec.joints[JOINT].drive.spring.stiffness
    values = strength * np.cos(PHASE), strength * np.sin(PHASE)
    return begun.nominal.with_effect(GravityCompensator('joint_2'), values)


@pytest.mark.parametrize('seed', range(3))
def test_a_counterbalance_explains_what_seemed_to_be_wrong(robot, layout, found, seed):
    made = standing(robot, layout, seed)
    faults = weigh(rest_of(robot, made), Tolerances())
    assert faults, f'seed {seed}: too weak to be seen at rest'
    assert weighed_again(faults, found, robot, made, Tolerances()) == (), f'seed {seed}'


@pytest.mark.parametrize('seed', range(3))
def test_an_encoder_that_is_wrong_beside_it_stays(robot, layout, found, seed):
    offset = np.radians(2.5)
    made = standing(robot, layout, seed, offset)
    faults = weigh(rest_of(robot, made), Tolerances())
    again = weighed_again(faults, found, robot, made, Tolerances())
    (fault,) = again
    told = [it for it in (fault, fault.rival) if it is not None and it.place == 'joint_2']
    assert [it.kind for it in told] == [Kind.ENCODER], f'seed {seed}: {fault.words()}'
    if not same_put_right(faults, again):
        assert abs(told[0].values[0] - offset) < 4.0 * told[0].sigma, f'seed {seed}'


def test_rivals_are_the_same_and_sensors_are_not_put_right():
    second = Fault(Kind.ENCODER, 'joint_2', (1,), (0.04,))
    third = Fault(Kind.ENCODER, 'joint_3', (2,), (0.04,))
    open_ = dataclasses.replace(third, rival=second)
    assert same_put_right([open_], [second])
    assert not same_put_right([third], [second])
    assert not same_put_right([second], [])
    assert same_put_right([Fault(Kind.GAIN, 'tool', (0, 1, 2), (1.1,))], [])
