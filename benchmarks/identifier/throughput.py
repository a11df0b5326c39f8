"""Taking in many sensors, and working through a recording: multiples of real time."""

from collections.abc import Iterator
from pathlib import Path
import resource
import struct
import tempfile
import time

import numpy as np

from autonomous_modal_analysis.identified.identification import identify_recording
from benchmarks.identifier.plant import chain_plant, simulate
from benchmarks.table import Line
from modal_core.measurements import NANOSECONDS_PER_SECOND, SampleBlock, StampedSamples
from modal_recordings.containers import RecordingWriter
from modal_recordings.messages import BLOCK, encode, IMU
from modal_recordings.open_recording import open_recording
from oma_identifier.intake import SampleBuffer, TopicIntake
from oma_identifier.settings import IdentificationSettings

START_NS = 1_700_000_000 * NANOSECONDS_PER_SECOND
N_IMUS, IMU_HZ, BLOCK_HZ, N_CHANNELS = 6, 1000, 4096, 42
BATCHES_HZ = 8
"""How often what has arrived is taken in."""


def rows(ingest_s: int, record_s: float) -> Iterator[Line]:
    """Yield the lines."""
    yield from _ingest(ingest_s)
    yield from _offline(record_s)


def _ingest(seconds: int) -> Iterator[Line]:
    """Serialised messages in, windows out; middleware and identification left out."""
    intake = TopicIntake()
    buffer = SampleBuffer(IdentificationSettings(window_s=60.0, hop_s=30.0))
    rng = np.random.default_rng(74000)
    values = rng.standard_normal((BLOCK_HZ, N_CHANNELS)).astype(np.float32)
    imu = [_imu_messages(rng, index) for index in range(N_IMUS)]
    cpu_s, n_windows, n_lost, resident = 0.0, 0, 0, []
    for number in range(seconds * BATCHES_HZ):
        batches = [*_stamped(imu, number), *_blocks(values, number)]
        start = time.process_time()
        for topic, kind, raws in batches:
            for measurement in intake.decode(raws, kind, topic):
                buffer.add(measurement)
        for window in buffer.windows():
            n_windows += 1
            n_lost += sum(channel.n_lost for channel in window.quality.channels)
        cpu_s += time.process_time() - start
        resident.append(_resident_mb())
    share = cpu_s / seconds
    yield Line(
        'intake of 6 IMUs at 1 kHz, singly, and 42 channels at 4,096 Hz: share of a core',
        f'{share:.1%}',
        reach='≤ 10 %',
        met=share <= 0.10,
    )
    refused = sum(intake.n_refused.values()) + buffer.counters.n_rejected
    yield Line(
        f'the same: samples lost, messages refused; {n_windows} windows',
        f'{n_lost}, {refused}',
        reach='0, 0',
        met=n_lost == 0 and refused == 0 and n_windows > 0,
    )
    before, after = (max(quarter) for quarter in _last_quarters(resident))
    yield Line(
        f'the same: peak of resident memory, last quarter of {seconds} s against the third',
        f'{after - before:+.1f} MB of {before:.0f} MB',
        reach='none',
        met=after - before < 0.02 * before,
    )


def _last_quarters(resident: list[float]) -> tuple[list[float], list[float]]:
    """Return the last two quarters, of whole hops each.

    The rows of a window fill memory that is taken anew with every hop: resident memory rises and
    falls with the hops, and only its peaks over whole hops can be compared.
    """
    quarter = len(resident) // 4
    return resident[-2 * quarter : -quarter], resident[-quarter:]


def _imu_messages(rng: np.random.Generator, index: int) -> list[bytes]:
    """Return one batch of messages, to be stamped anew."""
    count = IMU_HZ // BATCHES_HZ
    values = rng.standard_normal((2, count, 3))
    samples = StampedSamples(
        f'/imu_{index}', f'link_{index}', np.zeros(count, dtype=np.int64), values[0], values[1]
    )
    return [message.data for message in encode(samples, samples.source)]


def _stamped(imu: list[list[bytes]], number: int) -> Iterator[tuple[str, str, list[bytes]]]:
    count = IMU_HZ // BATCHES_HZ
    for index, messages in enumerate(imu):
        raws = []
        for row, message in enumerate(messages):
            stamp = START_NS + (number * count + row) * (NANOSECONDS_PER_SECOND // IMU_HZ)
            head = struct.pack('<iI', *divmod(stamp, NANOSECONDS_PER_SECOND))
            raws.append(message[:4] + head + message[12:])
        yield f'/imu_{index}', IMU, raws


def _blocks(values: np.ndarray, number: int) -> Iterator[tuple[str, str, list[bytes]]]:
    count = BLOCK_HZ // BATCHES_HZ
    first = number * count
    stamp = START_NS + number * NANOSECONDS_PER_SECOND // BATCHES_HZ
    part = np.roll(values, number, axis=0)[:count]
    names = tuple(f'c{channel}' for channel in range(N_CHANNELS))
    block = SampleBlock('/block', stamp, first, float(BLOCK_HZ), names, part)
    yield '/block', BLOCK, [message.data for message in encode(block, '/block')]


def _resident_mb() -> float:
    pages = int(Path('/proc/self/statm').read_text(encoding='ascii').split()[1])
    return pages * 4096 / 2**20


def _offline(seconds: float) -> Iterator[Line]:
    """Read an MCAP recording and identify its windows and the whole, all by default.

    Two processes work at the same time, and neither waits much for the other: on an idle machine
    the one with more to do takes its processor time.
    """
    rate_hz = 512
    samples = simulate(chain_plant(42), np.random.default_rng(74001), seconds, float(rate_hz))
    rows = samples.acceleration.astype(np.float32)
    with tempfile.TemporaryDirectory() as folder:
        writer = RecordingWriter(Path(folder) / 'record.mcap')
        for first in range(0, len(rows), 64):
            stamp = START_NS + first * NANOSECONDS_PER_SECOND // rate_hz
            block = SampleBlock(
                '/block',
                stamp,
                first,
                float(rate_hz),
                samples.channel_names,
                rows[first : first + 64],
            )
            for message in encode(block, '/block'):
                writer.write('/block', BLOCK, stamp, message.data)
        path = writer.close()
        del samples, rows
        start, before_s = time.process_time(), _children_s()
        found = identify_recording(open_recording(path), IdentificationSettings())
        own_s, other_s = time.process_time() - start, _children_s() - before_s
    count = len(found.identification.windows)
    what = (
        f'offline, 42 channels at 512 Hz from MCAP, {seconds:.0f} s, {count} windows and the'
        ' whole, all by default: multiple of real time'
    )
    multiple = seconds / max(own_s, other_s)
    yield Line(
        f'{what}, by the busier of two processes',
        f'{multiple:.0f}',
        reach='≥ 200',
        met=multiple >= 200.0,
    )
    yield Line(f'{what}, by both on one processor', f'{seconds / (own_s + other_s):.0f}')


def _children_s() -> float:
    """Return the processor time of processes that were waited for [s]."""
    return sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
