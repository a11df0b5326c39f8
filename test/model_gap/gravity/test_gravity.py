"""What gravity tells of sensors and encoders, against the independent arm's poses."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from modal_core.channel import Sensor, SensorLayout
from modal_core.files.share import share_path
from model_gap.campaign.campaign import Campaign, GapRecord
from model_gap.cell.tolerances import Tolerances
from model_gap.gravity import as_it_stands, encoders_told, Kind, put_right, rest_of, weigh
from test.support.hidden_campaign import poses, SENSORS
from test.support.independent_arm import Chain, read_arm

ROBOT = share_path('config', 'robots', 'irb6660_205_190')
G = 9.81


def campaign(
    robot, layout, rng, offset=(), turned=None, sensors=SENSORS, count=6, off_level=(0.0, 0.0)
):
    """Means of sensors on the independent arm, which hangs in stiff springs of its own.

    Mounts are turned by 0.5 deg rms, gains 0.7 % off, zeros 0.1 m/s² off, the robot 0.1 deg off
    level: all of it healthy.
    """
    arm, records = read_arm(ROBOT), []
    mounts = {name: Rotation.from_rotvec(rng.normal(0.0, 0.009, 3)) for name, _, _ in sensors}
    gains = 1.0 + 0.007 * rng.standard_normal(3 * len(sensors))
    zeros = 0.1 * rng.standard_normal(3 * len(sensors))
    set_up = rng.normal(0.0, 0.002, 2) + off_level
    up = Rotation.from_rotvec([*set_up, 0.0]).inv().apply([0.0, 0.0, G])
    for number, pose in enumerate(poses(rng, count)):
        true = pose + np.array([*offset, *[0.0] * (6 - len(offset))])
        chain = Chain(arm, true)
        readings = []
        for name, link, place in sensors:
            _, _, axes = chain.on_link(link, place)
            mount = (turned or {}).get(name, np.eye(3)) @ mounts[name].as_matrix()
            readings.append(mount @ axes.T @ up)
        mean = gains * np.concatenate(readings) + zeros
        shaken = mean + rng.standard_normal((400, 3 * len(sensors)))
        still = np.zeros((400, 6))
        records.append(
            GapRecord(f'p{number}', pose, '1', 100.0, shaken - shaken.mean(0) + mean, *[still] * 3)
        )
    return Campaign(tuple(records), layout, robot.joint_names)


def found(robot, made):
    return weigh(rest_of(robot, made), Tolerances())


@pytest.mark.parametrize('seed', range(6))
def test_a_healthy_campaign_has_nothing_wrong(robot, layout, seed):
    rng = np.random.default_rng(seed)
    assert found(robot, campaign(robot, layout, rng)) == (), f'seed {seed}'


@pytest.mark.parametrize('seed', range(8))
def test_no_other_encoder_is_named_for_sure(robot, seed):
    """Random joint, offset, sensors and number of poses: right, open, or nothing at all."""
    rng = np.random.default_rng([77, seed])
    few = sorted(rng.choice(len(SENSORS), rng.integers(1, 5), replace=False))
    sensors = [SENSORS[number] for number in few]
    own = SensorLayout(tuple(Sensor(name, link, place) for name, link, place in sensors))
    offset = np.zeros(6)
    joint = int(rng.integers(1, 5))
    offset[joint] = np.radians(rng.choice([-1.0, 1.0]) * rng.uniform(1.5, 4.0))
    count = int(rng.integers(4, 9))
    for fault in found(robot, campaign(robot, own, rng, offset, sensors=sensors, count=count)):
        named = {item.place for item in (fault, fault.rival) if item is not None}
        assert f'joint_{joint + 1}' in named, f'seed {seed}: {fault.words()}'
        assert fault.rival is None or fault.telling.startswith('stand still at'), f'seed {seed}'


@pytest.mark.parametrize(('joint', 'degrees'), [(1, 2.0), (2, -2.0), (3, 2.0), (4, -3.0)])
def test_an_encoder_that_is_wrong_is_named_with_its_offset(robot, layout, joint, degrees):
    offset = np.zeros(6)
    offset[joint] = np.radians(degrees)
    made = campaign(robot, layout, np.random.default_rng(joint), offset)
    (fault,) = found(robot, made)
    assert (fault.kind, fault.place) == (Kind.ENCODER, f'joint_{joint + 1}'), fault.words()
    assert abs(fault.values[0] - offset[joint]) < 4.0 * fault.sigma, fault.words()
    assert fault.sigma < np.radians(0.6)
    stands = [item.offset_rad for item in as_it_stands(robot, [fault]).spec.joints]
    np.testing.assert_allclose(stands, offset, atol=4.0 * fault.sigma)
    told = encoders_told(rest_of(robot, made), Tolerances())
    assert told['joint_1'] == np.inf, 'it turns about the vertical'
    assert told[fault.place] == pytest.approx(np.degrees(fault.sigma), rel=0.2)


def scaled(made, scale):
    return dataclasses.replace(
        made,
        records=tuple(
            dataclasses.replace(item, acceleration=item.acceleration * scale)
            for item in made.records
        ),
    )


def test_a_sensor_in_g_is_named_and_put_right(robot, layout):
    made = campaign(robot, layout, np.random.default_rng(11))
    wrong = scaled(made, np.repeat([1.0, 1.0, 1.0 / 9.80665, 1.0], 3))
    (fault,) = found(robot, wrong)
    assert (fault.kind, fault.place) == (Kind.UNIT, 'elbow')
    right = put_right(wrong, [fault])
    np.testing.assert_allclose(right.records[0].acceleration, made.records[0].acceleration)


@pytest.mark.parametrize(
    ('kind', 'matrix'),
    [
        (Kind.AXES, np.eye(3)[[1, 0, 2]]),
        (Kind.AXES, np.diag([1.0, -1.0, 1.0])),
        (Kind.AXES, np.diag([-1.0, -1.0, 1.0])),
        (Kind.TURNED, Rotation.from_rotvec([0.1, -0.2, 0.15]).as_matrix()),
    ],
)
def test_swapped_reversed_and_turned_sensors_are_named(robot, layout, kind, matrix):
    made = campaign(robot, layout, np.random.default_rng(12), turned={'spindle': matrix})
    (fault,) = found(robot, made)
    assert (fault.kind, fault.place) == (kind, 'spindle'), fault.words()
    np.testing.assert_allclose(fault.matrix, matrix, atol=0.06)


@pytest.mark.parametrize('seed', range(8))
def test_a_wrong_gain_is_named_and_no_encoder_is_blamed(robot, layout, seed):
    """Of the tool's sensor, or of one of its axes, by up to two thirds, in few poses."""
    rng = np.random.default_rng([78, seed])
    gain = np.exp(rng.choice([-1.0, 1.0]) * rng.uniform(0.15, 0.5))
    scale = np.ones(12)
    own = [slice(9, 12), slice(10, 11)][seed % 2]
    scale[own] = gain
    made = scaled(campaign(robot, layout, rng, count=4), scale)
    (fault,) = found(robot, made)
    place = 'spindle' if seed % 2 == 0 else layout.channels[10].name
    assert (fault.kind, fault.place) == (Kind.GAIN, place), f'seed {seed}: {fault.words()}'
    assert abs(fault.values[0] - gain) < 4.0 * fault.sigma, f'seed {seed}: {fault.words()}'
    assert as_it_stands(robot, [fault]) is robot, 'the arm stands where it was'


def test_a_robot_off_level_is_told_and_no_encoder_is_blamed(robot, layout):
    tilt = np.radians([1.0, -1.5])
    made = campaign(robot, layout, np.random.default_rng(17), off_level=tilt)
    (fault,) = found(robot, made)
    assert fault.kind is Kind.TILT, fault.words()
    np.testing.assert_allclose(fault.values, tilt, atol=np.radians(0.4))


def test_a_zero_offset_is_named(robot, layout):
    made = campaign(robot, layout, np.random.default_rng(13))
    zero = np.zeros(12)
    zero[4] = 3.0
    wrong = dataclasses.replace(
        made,
        records=tuple(
            dataclasses.replace(item, acceleration=item.acceleration + zero)
            for item in made.records
        ),
    )
    (fault,) = found(robot, wrong)
    assert (fault.kind, fault.place) == (Kind.ZERO, 'lower_arm.y')
    assert fault.values[0] == pytest.approx(3.0, abs=0.5)


def test_two_faults_are_both_named(robot, layout):
    offset = np.zeros(6)
    offset[1] = np.radians(2.0)
    swapped = {'frame': np.eye(3)[[0, 2, 1]]}
    made = campaign(robot, layout, np.random.default_rng(14), offset, swapped)
    faults = found(robot, made)
    assert {(it.kind, it.place) for it in faults} == {
        (Kind.ENCODER, 'joint_2'),
        (Kind.AXES, 'frame'),
    }


def test_sensors_that_take_their_mean_away_tell_nothing(robot, layout):
    made = campaign(robot, layout, np.random.default_rng(15))
    for keep in (0, 6):
        quiet = tuple(
            dataclasses.replace(
                item,
                acceleration=np.hstack(
                    [
                        item.acceleration[:, :keep],
                        (item.acceleration - item.acceleration.mean(0))[:, keep:],
                    ]
                ),
            )
            for item in made.records
        )
        rest = rest_of(robot, dataclasses.replace(made, records=quiet))
        assert len(rest.channels) == keep
        assert weigh(rest, Tolerances()) == ()


@pytest.mark.parametrize('seed', range(6))
def test_exchanged_sensors_and_joints_are_named_and_changed_back(robot, layout, seed):
    """One plug for another, or two joints' states: nothing else is wrong."""
    made = campaign(robot, layout, np.random.default_rng(100 + seed))
    tip, elbow = ([n for n, it in enumerate(layout.channels) if it.sensor == name]
                  for name in ('spindle', 'elbow'))  # fmt: skip
    order = np.arange(len(layout.channels))
    order[[*tip, *elbow]] = [*elbow, *tip]
    joints = [0, 2, 1, 3, 4, 5]
    for kind, wrong in (
        (Kind.SENSORS, lambda it: {'acceleration': it.acceleration[:, order]}),
        (Kind.JOINTS, lambda it: {'pose': it.pose[joints]}),
    ):
        records = tuple(dataclasses.replace(it, **wrong(it)) for it in made.records)
        mixed = dataclasses.replace(made, records=records)
        (fault,) = found(robot, mixed)
        assert fault.kind is kind and fault.rival is None, f'seed {100 + seed}: {fault.words()}'
        for record, back in zip(made.records, put_right(mixed, [fault]).records, strict=True):
            assert np.array_equal(back.acceleration, record.acceleration)
            assert np.array_equal(back.pose, record.pose)


@pytest.mark.parametrize('seed', range(6))
def test_what_no_few_faults_explain_is_told_as_such(robot, layout, seed):
    """Every recording with the pose of another: nothing is wrong with sensors or encoders."""
    made = campaign(robot, layout, np.random.default_rng(200 + seed))
    others = (*made.records[1:], made.records[0])
    records = [
        dataclasses.replace(it, pose=other.pose)
        for it, other in zip(made.records, others, strict=True)
    ]
    faults = found(robot, dataclasses.replace(made, records=tuple(records)))
    assert faults[-1].kind is Kind.UNTOLD, f'seed {200 + seed}: {[it.words() for it in faults]}'


def swept(robot, layout, rng, amplitude_rad, count=3, seconds=8.0, rate_hz=50.0):
    """Recordings in which all joints wander about a pose; each sensor's way is differentiated."""
    arm, records = read_arm(ROBOT), []
    time = np.arange(round(seconds * rate_hz)) / rate_hz
    for number, pose in enumerate(poses(rng, count)):
        hertz, phase = rng.uniform(0.1, 0.4, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
        omega = 2.0 * np.pi * hertz
        turn = omega * time[:, None] + phase
        way = amplitude_rad * np.sin(turn)
        chains = [Chain(arm, pose + shift) for shift in way]
        readings = []
        for _, link, place in SENSORS:
            seen = [chain.on_link(link, place) for chain in chains]
            points = np.array([point for _, point, _ in seen])
            rise = np.gradient(np.gradient(points, time, axis=0), time, axis=0)
            axes = np.array([matrix for _, _, matrix in seen])
            readings.append(np.einsum('nij,ni->nj', axes, rise + np.array([0.0, 0.0, G])))
        mean = way.mean(axis=0)
        records.append(
            GapRecord(
                f'p{number}',
                pose + mean,
                '1',
                rate_hz,
                np.concatenate(readings, axis=1),
                -amplitude_rad * omega**2 * np.sin(turn),
                amplitude_rad * omega * np.cos(turn),
                way - mean,
            )
        )
    return Campaign(tuple(records), layout, robot.joint_names)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(2))
def test_a_healthy_arm_that_travels_has_nothing_wrong(robot, layout, seed):
    """Gravity turned to and fro reads less on the mean than in the middle of the way."""
    rng = np.random.default_rng([79, seed])
    made = swept(robot, layout, rng, rng.uniform(0.3, 0.9))
    rest = rest_of(robot, made)
    left = rest.measured - rest.predicted(np.zeros(6))
    assert np.abs(left).max() < 0.06, f'seed {seed}: {np.abs(left).max()}'
    assert found(robot, made) == (), f'seed {seed}'
