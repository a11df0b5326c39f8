"""Memory of offline identification: what a window needs, however long the record is."""

import io
from pathlib import Path
import subprocess
import sys

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer
from scipy.signal import lfilter

from modal_core.measurements import SampleBlock
from modal_recordings.containers import RecordingWriter
from modal_recordings.messages import definition, encode
from oma_identifier.record import whole_record

RATE_HZ, N_CHANNELS = 1000, 20
SHORT_S, LONG_S = 120, 480
KEPT = 4 * 2**20
"""Samples kept, instead of eight times that: both records have more."""
MOST_MORE_MB = 15.0
"""The longer record has 29 MB of samples more in single, 58 MB in double precision."""
MANY_S, MANY_HZ, MANY_CHANNELS = 95, 4000, 100
MOST_MB = 490.0
"""Measured over three minutes: 456 MB, over ten 468 MB.  A window has 92 MB of samples, its
covariances and the record's 72 MB, its samples by band 32 MB; Python and the packages 80 MB."""
# The peak since the program began: getrusage begins with the size of who started it.
CHILD = r"""
import re, sys
sys.argv = ['ama', 'identify', *sys.argv[1:]]
from autonomous_modal_analysis.cli import main
from oma_identifier.record import whole_record
whole_record.MOST_BYTES = int(sys.argv.pop())
try:
    main()
finally:
    peak = re.search(r'VmHWM:\s+(\d+) kB', open('/proc/self/status').read())
    print(peak.group(1), file=sys.stderr)
"""


def samples(duration_s: int, rate_hz: int = RATE_HZ, n_channels: int = N_CHANNELS) -> np.ndarray:
    """Return responses of four modes of 1 % damping."""
    rng = np.random.default_rng(7)
    poles = np.exp(2.0 * np.pi * np.array([20.0, 45.0, 90.0, 160.0]) * (1j - 0.01) / rate_hz)
    force = rng.standard_normal((duration_s * rate_hz, len(poles)))
    motion = [
        lfilter([1.0 - abs(pole)], [1.0, -2.0 * pole.real, abs(pole) ** 2], own)
        for pole, own in zip(poles, force.T, strict=True)
    ]
    shapes = rng.standard_normal((len(poles), n_channels)).astype(np.float32)
    responses = np.transpose(motion).astype(np.float32) @ shapes
    for part in responses:
        part += 0.02 * rng.standard_normal(n_channels, dtype=np.float32)
    return responses


def messages(values, rate_hz=RATE_HZ):
    names = tuple(f'c{index}' for index in range(values.shape[1]))
    for first in range(0, len(values), 100):
        stamp_ns = 10**18 + first * (10**9 // rate_hz)
        part = values[first : first + 100]
        block = SampleBlock('/blocks', stamp_ns, first, float(rate_hz), names, part)
        yield from encode(block, '/blocks')


def write_mcap(path, values, rate_hz=RATE_HZ):
    with RecordingWriter(path) as writer:
        for message in messages(values, rate_hz):
            writer.write('/blocks', message.message_type, message.log_time_ns, message.data)


def write_npy(path, values):
    np.save(path, values)


def write_csv(path, values):
    # What takes long is to write numbers: the same minutes again and again.
    names = ','.join(f'c{index}' for index in range(N_CHANNELS))
    part = io.StringIO()
    np.savetxt(part, values[: SHORT_S * RATE_HZ], fmt='%.4e', delimiter=',')
    with path.open('w') as file:
        file.write(f'{names}\n')
        for _ in range(0, len(values), SHORT_S * RATE_HZ):
            file.write(part.getvalue())


def write_db3(path, values):
    folder, connection = path.with_suffix(''), None
    with Rosbag2Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        for message in messages(values):
            connection = connection or writer.add_connection(
                '/blocks',
                message.message_type,
                msgdef=definition(message.message_type),
                rihs01=f'RIHS01_{0:064}',
            )
            writer.write(connection, message.log_time_ns, message.data)
    next(folder.glob('*.db3')).rename(path)


WRITERS = {'.mcap': write_mcap, '.db3': write_db3, '.npy': write_npy, '.csv': write_csv}


@pytest.mark.slow
@pytest.mark.skipif(not Path('/proc/self/status').exists(), reason='needs /proc')
@pytest.mark.parametrize('suffix', WRITERS)
def test_memory_does_not_grow_with_the_record(tmp_path, suffix):
    peaks_mb = []
    for duration_s in (SHORT_S, LONG_S):
        path = tmp_path / f'{duration_s}{suffix}'
        WRITERS[suffix](path, samples(duration_s))
        rate = [] if suffix in ('.mcap', '.db3') else ['--sample-rate-hz', str(RATE_HZ)]
        peaks_mb.append(peak_mb(path, *rate, most_bytes=KEPT))
    assert peaks_mb[1] - peaks_mb[0] < MOST_MORE_MB, peaks_mb


def peak_mb(path, *options, most_bytes=whole_record.MOST_BYTES):
    """Return the most memory that identifying a recording took at any time."""
    done = subprocess.run(
        [sys.executable, '-c', CHILD, str(path), *options, str(most_bytes)],
        capture_output=True,
        text=True,
        check=True,
    )
    return int(done.stderr.split()[-1]) / 1024.0


@pytest.mark.slow
@pytest.mark.skipif(not Path('/proc/self/status').exists(), reason='needs /proc')
def test_a_hundred_channels_at_4_khz_need_less_than_half_a_gigabyte(tmp_path):
    path = tmp_path / 'many.mcap'
    write_mcap(path, samples(MANY_S, MANY_HZ, MANY_CHANNELS), MANY_HZ)
    assert peak_mb(path) < MOST_MB
