"""The speed of a spindle out of a recording: a topic, a channel, or a column of a table."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
import math
import re
import struct

import numpy as np

from modal_core.errors import RecordingError
from modal_core.measurements import Measurement
from modal_core.spindle_speed import SpindleSpeed
from modal_core.units import WITH_UNIT
from modal_recordings.mark import cut, mark_pieces, Stretch
from modal_recordings.messages import MessageFile, TopicEntry
from modal_recordings.tables import ArrayTable

SPEED_TOPIC = '/spindle_speed_rpm'
"""Taken where a recording has it and no other is named."""
FLOAT64 = 'std_msgs/msg/Float64'
FORMATS = {FLOAT64: 'd', 'std_msgs/msg/Float32': 'f'}
"""Types of topics that are a speed, with the letter of their one number."""
TO_HZ = {
    'rpm': 1.0 / 60.0, '1/min': 1.0 / 60.0, 'min^-1': 1.0 / 60.0, 'hz': 1.0, '1/s': 1.0,
    'rad/s': 0.5 / math.pi, 'rad_s': 0.5 / math.pi,
}  # fmt: skip
ALWAYS = Stretch(np.iinfo(np.int64).min, np.iinfo(np.int64).max)


def factor_of(name: str, unit: str = '') -> float:
    """Return the factor to turns per second: by the unit, or the end of the name; else of rpm."""
    bracket = re.search(r'[\[(]([^\])]+)[\])]\s*$', name)
    text = (unit or (bracket.group(1) if bracket else '')).strip('[]() ').lower()
    if text in TO_HZ:
        return TO_HZ[text]
    ending = next((word for word in TO_HZ if name.lower().endswith(f'_{word}')), 'rpm')
    return TO_HZ[ending]


def speed_topic(entries: Sequence[TopicEntry], asked: str | None) -> TopicEntry | None:
    """Return the topic of the speed; None where there is none of that name.

    Raises
    ------
    RecordingError
        The topic that is asked for is of another type.
    """
    named = {entry.name: entry for entry in entries}
    wanted = SPEED_TOPIC if asked is None else asked
    entry = named.get(wanted) or named.get(f'/{wanted.lstrip("/")}')
    if entry is None or entry.message_type in FORMATS:
        return entry
    if asked is None:
        return None
    raise RecordingError(
        'no speed of a spindle', where=entry.name, found=entry.message_type,
        expected=' or '.join(FORMATS),
    )  # fmt: skip


def speed_of_topic(file: MessageFile, entry: TopicEntry) -> SpindleSpeed:
    """Return the values of a topic, at the times they were recorded."""
    stamps, values = [], []
    for message in file.messages(frozenset([entry.name])):
        stamps.append(message.log_time_ns)
        values.append(number_of(message.data, entry.message_type, ros1=file.ros1))
    speed_hz = factor_of(entry.name) * np.array(values, dtype=np.float64)
    return SpindleSpeed.of(np.array(stamps, dtype=np.int64), speed_hz)


def number_of(raw: bytes, message_type: str, *, ros1: bool = False) -> float:
    """Return the number of a serialised message; NaN where it is too short to hold it."""
    start, letter = 0 if ros1 else 4, FORMATS[message_type]
    if len(raw) < start + struct.calcsize(letter):
        return math.nan
    return float(struct.unpack_from(f'<{letter}', raw, start)[0])


def speed_of_channel(
    measurements: Callable[[], Iterable[Measurement]], name: str, where: object
) -> SpindleSpeed:
    """Return the values of a channel.

    Raises
    ------
    RecordingError
        There is no such channel.
    """
    pieces = list(mark_pieces(measurements, name)())
    if not pieces:
        raise no_speed(where, name, ())
    stamps, values = (np.concatenate(each) for each in zip(*pieces, strict=True))
    return SpindleSpeed.of(stamps, factor_of(name) * values)


def without_channel(measurements: Iterable[Measurement], name: str) -> Iterator[Measurement]:
    """Yield measurements without the channel of the speed."""
    for item in measurements:
        part = cut(item, ALWAYS, name)
        if part is not None:
            yield part


def no_speed(where: object, name: str, others: Sequence[str]) -> RecordingError:
    """Return that the speed asked for is not there."""
    return RecordingError(
        'no speed of a spindle', where=where, found=name,
        expected=', '.join(others) or 'a topic (Float64) or a channel of this name',
        advice='without it lines that move are found in the responses',
    )  # fmt: skip


def speed_column(
    table: ArrayTable, name: str, where: object, given: Sequence[str] = ()
) -> tuple[ArrayTable, int, float]:
    """Return a table whose speed is no response, the column, and its factor to turns per second.

    Parameters
    ----------
    table : ArrayTable
        Of all columns.
    name : str
        Of the column, without its unit.
    where : object
        Named in errors.
    given : sequence of str
        Names told beside the file, one per column; else they are not looked at.

    Raises
    ------
    RecordingError
        There is no such column.
    """
    n_columns = table.values.shape[1]
    own = table.headings or ('',) * n_columns
    names = next((known for known in (given, own) if _place(known, name, n_columns) >= 0), ())
    if not names:
        known = given if len(given) == n_columns else table.headings
        raise no_speed(where, name, [_plain(each) for each in known] or ('named columns',))
    number = _place(names, name, n_columns)
    factor = factor_of(names[number], table.units[number] if table.units else '')
    headings, units = list(own), list(table.units)
    headings[number] = f'{name} [rpm]'
    if units:
        units[number] = 'rpm'
    found = replace(table, headings=tuple(headings), units=tuple(units), speed=number)
    return found, number, factor


def _place(names: Sequence[str], name: str, n_columns: int) -> int:
    plain = [_plain(each) for each in names]
    return plain.index(name) if len(names) == n_columns and name in plain else -1


def _plain(heading: str) -> str:
    return WITH_UNIT.sub(r'\1', heading).strip()
