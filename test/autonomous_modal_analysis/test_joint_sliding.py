"""What part of the time joints slid, from their recorded angles."""

import json

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.identified.joint_sliding import ROWS, slid_in, SlidingWatch
from excitation_planner.motion.sliding import sliding_share
from excitation_planner.request import PlanRequest
from modal_core.measurements import JointSamples
from structural_model import load_robot

ROBOT = 'irb6660_205_190'
PERIOD_S, PRESLIDING_RAD = 0.004, PlanRequest().presliding_rad


@pytest.fixture(scope='module')
def robot():
    return load_robot(ROBOT)


def sweeps(robot, n_rows):
    """Return serial joints that sweep at rates of their own; the last one stands."""
    time_s = np.arange(n_rows) * PERIOD_S
    axes = 0.01 * np.sin(2.0 * np.pi * np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.0]) * time_s[:, None])
    return robot.to_serial(robot.to_controller(robot.pose('P1')) + axes)


def samples(robot, position, first_s=0.0, names=None):
    stamps = np.round(1e9 * (first_s + np.arange(len(position)) * PERIOD_S)).astype(np.int64)
    names = tuple(names or robot.joint_names)
    return JointSamples(stamps, names, position, np.full_like(position, np.nan))


def test_however_a_recording_is_cut_into_messages_the_share_is_that_of_the_path(robot):
    position = sweeps(robot, 3 * ROWS)
    expected = sliding_share(robot.to_controller(position), PERIOD_S, PRESLIDING_RAD)
    rng = np.random.default_rng(12)
    for most in (1, 40, 20_000):
        watch, first = SlidingWatch(robot), 0
        while first < len(position):
            count = int(rng.integers(1, most + 1))
            part = position[first : first + count]
            watch.add(samples(robot, part, first * PERIOD_S))
            first += count
        found = watch.found()
        assert found.axis_names == robot.axis_names
        assert found.share == pytest.approx(expected, abs=0.01), 'seed 12'
    assert found.share[-1] == 0.0 and min(found.share[:5]) > 0.5
    assert 'axis_6 0 %' in found.words()


def test_a_gap_other_joints_and_a_standing_arm(robot):
    position = sweeps(robot, 5000)
    watch = SlidingWatch(robot)
    watch.add(samples(robot, position[:2500]))
    watch.add(samples(robot, position[2500:], 1000.0))
    watch.add(samples(robot, position, 2000.0, [f'other_{n}' for n in range(6)]))
    expected = sliding_share(robot.to_controller(position), PERIOD_S, PRESLIDING_RAD)
    assert watch.found().share == pytest.approx(expected, abs=0.03)
    still = SlidingWatch(robot)
    still.add(samples(robot, np.tile(position[:1], (1000, 1))))
    assert 'standing state' in still.found().words()
    assert SlidingWatch(robot).found() is None
    assert SlidingWatch(None).found() is None


@pytest.fixture(scope='module')
def played(tmp_path_factory):
    """Return a plan and the recording of it on the emulated arm."""
    motion = ama.plan(ROBOT, duration_s=8)
    file = tmp_path_factory.mktemp('played') / 'sliding.mcap'
    return motion, motion.emulate(file, {'rest_s': 0.5})


@pytest.mark.slow
def test_results_of_a_played_plan_say_what_its_preview_said(played):
    motion, recording = played
    found = recording.identify(robot=ROBOT)
    stated = np.array(motion.plan.prediction.sliding_share) * 8.0 / 9.0
    assert found.sliding.share == pytest.approx(stated, abs=0.08)
    assert found.to_dict()['sliding']['share'] == list(found.sliding.share)
    assert 'axes slid this part of the time: axis_1' in found.headline()
    assert recording.identify().sliding is None


@pytest.mark.node
def test_a_replay_says_what_identify_says(played, ama):
    pytest.importorskip('rclpy')
    recording = played[1]
    file = recording.info.path
    run = ama('replay', file, '--robot', ROBOT, '--rate', '4', '--json')
    assert run.returncode == 0, run.stderr
    said = json.loads(run.stdout)
    assert said['windows']
    assert said['sliding'] == recording.identify(robot=ROBOT).to_dict()['sliding']
    # Of the second half alone: what was told before does not count.
    late = slid_in(
        recording.source.measurements(), load_robot(ROBOT), recording.info.start_ns + 4 * 10**9
    )
    assert late.share != tuple(said['sliding']['share'])
