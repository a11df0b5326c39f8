"""Hours of data through the sample buffer: nothing lost, memory flat.

``python test/oma_identifier/intake/test_soak.py 24`` runs so many hours and prints the figures.
"""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
import sys

import numpy as np

from modal_core.measurements import JointSamples, SampleBlock, StampedSamples
from oma_identifier.intake.sample_buffer import SampleBuffer
from oma_identifier.settings import IdentificationSettings

START = 1_700_000_000_000_000_000
BLOCK_HZ, IMU_HZ, JOINT_HZ = 100, 50, 20
NAMES = tuple(f'c{index}' for index in range(6))


def resident_bytes():
    pages = int(Path('/proc/self/statm').read_text().split()[1])
    return pages * 4096


def second(number, data, rng):
    """Yield one second of a recorder, a jittering sensor and the joint states."""
    start = START + number * 10**9
    rows = data[: BLOCK_HZ * 6].reshape(BLOCK_HZ, 6)
    yield SampleBlock('/block', start, number * BLOCK_HZ, float(BLOCK_HZ), NAMES, rows)
    jitter = rng.integers(-200_000, 200_000, IMU_HZ)
    stamps = start + np.arange(IMU_HZ, dtype=np.int64) * (10**9 // IMU_HZ) + jitter
    yield StampedSamples(
        '/imu', 'link', stamps, data[: 3 * IMU_HZ].reshape(IMU_HZ, 3).astype(float)
    )
    stamps = start + np.arange(JOINT_HZ, dtype=np.int64) * (10**9 // JOINT_HZ)
    position = np.zeros((JOINT_HZ, 6))
    yield JointSamples(stamps, tuple('abcdef'), position, position)


def soak(hours, report=lambda *_: None):
    """Return (windows, windows with a loss, resident bytes at each tenth)."""
    rng = np.random.default_rng(1)
    data = rng.standard_normal(1000).astype(np.float32)
    buffer = SampleBuffer(IdentificationSettings(window_s=60.0, hop_s=30.0))
    n_seconds = round(hours * 3600)
    n_windows, n_lossy, resident = 0, 0, []
    for number in range(n_seconds):
        data = np.roll(data, 7)
        for measurement in second(number, data, rng):
            buffer.add(measurement)
        for window in buffer.windows():
            n_windows += 1
            n_lossy += any(channel.n_lost for channel in window.quality.channels)
        if number % max(1, n_seconds // 10) == 0:
            resident.append(resident_bytes())
            report(number / 3600, resident[-1] / 1e6, n_windows, n_lossy)
    return n_windows, n_lossy, resident


def test_half_an_hour_leaves_memory_flat():
    # In a process of its own: what other tests left fragmented would be counted with it.
    with ProcessPoolExecutor(1, get_context('spawn')) as process:
        n_windows, n_lossy, resident = process.submit(soak, 0.5).result()
    assert n_windows >= 57 and n_lossy == 0
    # After the first windows are full nothing may grow; a leak of the samples would be 4 MB.
    assert max(resident[3:]) - resident[3] < 1.5e6, resident


if __name__ == '__main__':
    soak(float(sys.argv[1]), print)
