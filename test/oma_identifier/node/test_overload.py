"""Ten times more windows than can be identified: they are skipped and counted, memory stays."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from modal_core.measurements import SampleBlock
from modal_recordings.messages import encode
from test.support.node_driver import NodeDriver

pytestmark = pytest.mark.node
START = 1_700_000_000_000_000_000
RATE_HZ, N_CHANNELS, ROWS = 256.0, 12, 64
WINDOW_BLOCKS, N_BLOCKS = 120, 1200
"""A window of 30 s every 0.25 s: 1080 of them, 0.8 GB if they were all kept."""
WINDOW_BYTES = WINDOW_BLOCKS * ROWS * N_CHANNELS * 8
NAMES = tuple(f'c{index}' for index in range(N_CHANNELS))
SEED = 5


def resident_bytes():
    return 4096 * int(Path('/proc/self/statm').read_text().split()[1])


def block(number, rng):
    rows = rng.standard_normal((ROWS, N_CHANNELS)).astype(np.float32)
    stamp_ns = START + round(number * ROWS * 1e9 / RATE_HZ)
    whole = SampleBlock('/acceleration_block', stamp_ns, number * ROWS, RATE_HZ, NAMES, rows)
    return encode(whole, '/acceleration_block')


def test_overload_skips_and_counts_windows_and_keeps_no_more_of_them(ros_context):
    """The feed waits for the node to take blocks, never for it to identify them.

    Whatever the machine's speed, a window costs many times what its 64 rows of new samples do.
    """
    driver = NodeDriver(ros_context, window_s=30.0, hop_s=0.25, refine='never')
    try:
        rng = np.random.default_rng(SEED)
        resident = []
        for number in range(N_BLOCKS):
            driver.send(block(number, rng), in_step=False)
            driver.wait_received(number - 100, 300.0)
            # Until all threads have worked for a while their heaps grow.
            if number >= N_BLOCKS // 2 and number % WINDOW_BLOCKS == 0:
                resident.append(resident_bytes())
        driver.wait_received(N_BLOCKS, 300.0)
        worker = driver.node.worker
        driver.finish()
        skipped = worker.n_skipped
        n_windows = worker.n_done + worker.n_skipped
        print(f'{worker.n_done} windows identified, {skipped} skipped, {resident} bytes resident')
        # What the end of the record adds is one partial window.
        assert 0 <= n_windows - (N_BLOCKS - WINDOW_BLOCKS + 1) <= 2
        assert skipped > 3 * worker.n_done, 'the feed was no overload'
        while not driver.results:
            driver.collect()
        assert not any(c.n_lost for m in driver.results for c in m.data_quality.channels)
        assert max(m.data_quality.n_windows_skipped for m in driver.results) > 0
        assert dict(driver.node.findings())['WINDOW_SKIPPED'] == f'{skipped} windows skipped'
        # Between the first and the last look 480 windows came, 350 MB.
        assert max(resident) - resident[0] < 40 * WINDOW_BYTES, resident
    finally:
        driver.close()
