"""The spindle's speed reaches the pipeline of a live identifier, on the clock of its samples."""

import time

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from std_msgs.msg import Float64

from modal_core.measurements import SampleBlock
from modal_recordings.messages import encode
from test.support.node_driver import NodeDriver

pytestmark = pytest.mark.node
START = 1_700_000_000_000_000_000
RATE_HZ, SEED, LONGEST_S = 200.0, 7, 60.0


def until(is_so, what):
    deadline = time.monotonic() + LONGEST_S
    while not is_so():
        assert time.monotonic() < deadline, what
        time.sleep(0.02)


def test_the_speed_counts_from_the_newest_sample(ros_context):
    driver = NodeDriver(ros_context, window_s=40.0)
    try:
        rows = np.random.default_rng(SEED).standard_normal((800, 2)).astype(np.float32)
        blocks = [
            SampleBlock(
                '', START + first * 5_000_000, first, RATE_HZ, ('a', 'b'), rows[first:][:40]
            )
            for first in range(0, 800, 40)
        ]
        driver.send([m for block in blocks for m in encode(block, '/acceleration_block')])
        driver.wait_received(len(blocks))
        publisher = driver.peer.create_publisher(Float64, '/spindle_speed_rpm', 10)
        until(lambda: publisher.get_subscription_count() > 0, 'nobody listens to the speed')
        publisher.publish(Float64(data=1500.0))
        until(lambda: driver.node.pipeline.speed is not None, 'the speed does not arrive')
        speed = driver.node.pipeline.speed
        np.testing.assert_allclose(speed.speed_hz, 25.0)
        assert START + 3 * 10**9 < speed.stamp_ns[0] <= START + 4 * 10**9
    finally:
        driver.close()
