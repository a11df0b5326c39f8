"""Joint states on the host's clock, whatever the controller's clock and the network do."""

import numpy as np
import pytest

from robot_bridge.egm.egm_feedback import RobotFeedback
from robot_bridge.node.joint_feed import JointFeed

BEGIN_NS = 1_700_000_000_000_000_000
DELAY_NS = 300_000
CYCLE_US = 4032
SEED = 3


def feedback(number, time_us, joints_deg):
    joints = tuple(np.asarray(joints_deg, float).tolist())
    return RobotFeedback(
        seqno=number, tm_ms=number, joints_deg=joints, planned_deg=joints, time_us=time_us,
        motors_on=True, mci_state=3, rapid_running=True, converged=False,
    )  # fmt: skip


def played(model, clock, true_ns, start_deg, speed_deg_s=2.0):
    """Return the samples of a joint 1 turning at a speed, received late by a random delay."""
    random = np.random.default_rng(SEED)
    feed = JointFeed(model)
    for number, (time_us, at_ns) in enumerate(zip(clock, true_ns, strict=True)):
        late_ns = DELAY_NS + int(random.exponential(2e6))
        joints = start_deg + np.array([1e-9 * speed_deg_s * (at_ns - true_ns[0]), 0, 0, 0, 0, 0])
        feed.add(feedback(number, int(time_us), joints), int(at_ns) + late_ns)
    return list(feed.samples())


@pytest.mark.parametrize('drift', [0.0, 1e-4, -1e-4, 4.032 / 4.0 - 1.0])
def test_stamps_follow_the_measurement_not_the_network(model, start_deg, drift):
    number = np.arange(2000)
    true_ns = BEGIN_NS + number * 4_032_000
    clock = 5_000_000 + np.round(number * CYCLE_US * (1.0 + drift))
    samples = played(model, clock, true_ns, start_deg)
    error = np.array([sample.stamp_ns for sample in samples]) - true_ns
    # Delays of 2 ms on average become the smallest one, and two seconds of drift.
    settled = error[1000:]
    assert np.abs(settled - DELAY_NS).max() < 2e5 + 2.2e9 * abs(drift), f'seed {SEED}'
    speed = np.array(
        [sample.velocity[0] for sample in samples[1000:] if sample.velocity is not None]
    )
    assert abs(np.degrees(np.median(speed)) * (1.0 + drift) - 2.0) < 1e-3


def test_a_controller_clock_that_stands_still_gives_times_of_receipt(model, start_deg):
    true_ns = BEGIN_NS + np.arange(50) * 4_032_000
    samples = played(model, np.zeros(50), true_ns, start_deg)
    late_ns = np.array([sample.stamp_ns for sample in samples]) - true_ns
    assert (late_ns >= DELAY_NS).all() and len(set(late_ns.tolist())) > 40


def test_a_clock_that_is_set_anew_begins_anew(model, start_deg):
    true_ns = BEGIN_NS + np.arange(1000) * 4_032_000
    clock = np.arange(1000) * CYCLE_US
    clock[500:] += 7_000_000_000
    samples = played(model, clock, true_ns, start_deg)
    error = np.array([sample.stamp_ns for sample in samples]) - true_ns
    assert np.abs(error).max() < 4e7, f'seed {SEED}'


def test_angles_are_serial_joints_in_radians_and_the_reference_too(model, start_deg):
    feed = JointFeed(model)
    wanted = start_deg + np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    feed.add(feedback(0, 0, start_deg), BEGIN_NS, wanted)
    (sample,) = feed.samples()
    np.testing.assert_allclose(sample.position, model.pose('P1'), atol=1e-12)
    # The parallel rod: the serial joint 3 is the controller's axis 3 minus its axis 2.
    np.testing.assert_allclose(
        np.degrees(sample.reference - sample.position), [0, 1, -1, 0, 0, 0], atol=1e-9
    )
    assert sample.velocity is None
