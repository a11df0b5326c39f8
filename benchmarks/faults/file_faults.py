"""Faults on the way: damaged messages, damaged recordings, text files in many dialects."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
import tempfile

import numpy as np

from benchmarks.faults.scene import measurements, Scene, START_NS
from modal_core.measurements import Measurement, SampleBlock
from modal_recordings.containers import RecordingWriter
from modal_recordings.messages import encode
from modal_recordings.open_recording import open_recording
from oma_identifier.intake import TopicIntake

Way = Callable[[np.random.Generator, Scene, 'Notes'], Iterator[Measurement]]


class Notes(set[str]):
    """What a reader says beside the measurements."""


def damaged_messages(
    rng: np.random.Generator, scene: Scene, notes: Notes
) -> Iterator[Measurement]:
    """Some messages have a byte changed, are cut off, or are something else altogether."""
    intake = TopicIntake()
    share = 10 ** rng.uniform(-3.0, -1.0)
    for measurement in measurements(scene):
        topic = getattr(measurement, 'source', '/joint_states')
        messages = encode(measurement, topic)
        raws = [
            _damaged(rng, each.data) if rng.random() < share else each.data for each in messages
        ]
        yield from intake.decode(raws, messages[0].message_type, topic)
    if intake.n_refused:
        notes.add('message_refused')


def _damaged(rng: np.random.Generator, data: bytes) -> bytes:
    kind = rng.integers(4)
    if kind == 0:
        return data[: int(rng.integers(len(data)))]
    if kind == 1:
        return rng.bytes(int(rng.integers(0, 200)))
    # Of a byte in the head, which holds stamp, counter, rate and names, or anywhere.
    changed = bytearray(data)
    place = int(rng.integers(4, min(len(data), 90) if kind == 2 else len(data)))
    changed[place] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def damaged_recording(
    rng: np.random.Generator, scene: Scene, notes: Notes
) -> Iterator[Measurement]:
    """An MCAP file is cut off or has bytes changed."""
    with tempfile.TemporaryDirectory() as folder:
        path = _recording(rng, Path(folder) / 'record.mcap', scene)
        data = bytearray(path.read_bytes())
        if rng.random() < 0.4:
            data = data[: int(rng.integers(len(data)))]
        else:
            for place in rng.integers(0, len(data), int(rng.integers(1, 20))):
                data[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(data)
        recording = open_recording(path)
        yield from recording.measurements()
        if recording.damage():
            notes.add('recording_damaged')


def _recording(rng: np.random.Generator, path: Path, scene: Scene) -> Path:
    writer = RecordingWriter(path, str(rng.choice(['none', 'zstd'])))
    for measurement in measurements(scene):
        for message in encode(measurement, getattr(measurement, 'source', '/joint_states')):
            writer.write(message.topic, message.message_type, message.log_time_ns, message.data)
    return writer.close()


@dataclass(frozen=True)
class Dialect:
    """How a program writes a table.

    Parameters
    ----------
    separator, decimal : str
        Between columns, and in numbers.
    header : str
        ``none``, ``names`` or ``units``.
    time : str
        Header of the time column; empty: there is none.
    time_unit_s : float [s]
        Of the time column.
    unit : str
        Of the values; empty: not stated.
    scale : float [m/s²]
        Of the unit.
    """

    separator: str
    decimal: str
    header: str
    time: str
    time_unit_s: float
    unit: str
    scale: float


TIMES = (
    ('', 1.0),
    ('time', 1.0),
    ('t [s]', 1.0),
    ('Time (ms)', 1e-3),
    ('time_ms', 1e-3),
    ('time ms', 1e-3),
    ('Time [msec]', 1e-3),
    ('t [min]', 60.0),
    ('Zeit', 1.0),
    ('Zeit [s]', 1.0),
    ('timestamp_us', 1e-6),
    ('elapsed', 1.0),
)
UNITS = (('', 1.0), ('m/s^2', 1.0), ('g', 9.80665), ('mg', 9.80665e-3), ('mm/s^2', 1e-3))


def text_file(rng: np.random.Generator, scene: Scene, notes: Notes) -> Iterator[Measurement]:
    """The first track as a text file of another program; shapes do not mind its unit."""
    separator, decimal = [
        (',', '.'),
        (';', ','),
        (',', ','),
        ('\t', '.'),
        ('\t', ','),
        (' ', '.'),
    ][rng.integers(6)]
    time, unit_s = TIMES[rng.integers(len(TIMES))]
    unit, scale = UNITS[rng.integers(len(UNITS))]
    header = str(rng.choice(['none', 'names', 'units']))
    dialect = Dialect(separator, decimal, header, time, unit_s, unit, scale)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'record.csv'
        _write_text(rng, path, scene, dialect)
        rate = scene.rate_hz if rng.random() < 0.5 or not time else None
        recording = open_recording(path, sample_rate_hz=rate)
        names = scene.tracks[0].channel_names
        for measurement in recording.measurements():
            notes.update(recording.info().notes if not notes else ())
            yield _renamed(measurement, names)


def _renamed(measurement: Measurement, names: tuple[str, ...]) -> Measurement:
    """Give columns that have no names of their own those of the truth, where they agree."""
    given = getattr(measurement, 'channel_names', ())
    if len(given) == len(names) and isinstance(measurement, SampleBlock):
        return replace(measurement, channel_names=names)
    return measurement


def _write_text(rng: np.random.Generator, path: Path, scene: Scene, dialect: Dialect) -> None:
    track = scene.tracks[0]
    names = [*track.channel_names]
    columns = [track.values / dialect.scale]
    if dialect.time:
        columns.insert(0, ((track.stamp_ns - START_NS) * 1e-9 / dialect.time_unit_s)[:, None])
    unit = f' [{dialect.unit}]' if dialect.unit and dialect.header == 'units' else ''
    head = [*([dialect.time] if dialect.time else []), *(name + unit for name in names)]
    lines = [] if dialect.header == 'none' else [dialect.separator.join(head)]
    for row in np.hstack(columns):
        cells = [f'{value:.9g}'.replace('.', dialect.decimal) for value in row]
        lines.append(dialect.separator.join(cells))
    if rng.random() < 0.15:
        place = int(rng.integers(1, len(lines)))
        lines[place] += dialect.separator + '1'
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')


WAYS: tuple[Way, ...] = (damaged_messages, damaged_recording, text_file)
