"""One pass over a recording: counts, rates, gaps, jitter."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import (
    JointSamples,
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
    StampedSamples,
)
from modal_recordings.contents.info import Gap, RecordingInfo, TopicSummary
from modal_recordings.contents.stamp_steps import stamp_steps
from modal_recordings.messages import BLOCK, differing_field, JOINT_STATE, TopicEntry, USABLE_TYPES

LISTED_GAPS = 100


class Readable(Protocol):
    """What a summary is made from."""

    def measurements(self) -> Iterator[Measurement]:
        """Yield the measurements."""

    def damage(self) -> tuple[str, ...]:
        """Return what the last pass lost."""


@dataclass
class _Tally:
    """What one topic has shown so far."""

    message_type: str
    n_messages: int = 0
    n_samples: int = 0
    declared_rate_hz: float = 0.0
    channels: tuple[str, ...] = ()
    steps: list[NDArray[np.int64]] = field(default_factory=list)
    starts: list[NDArray[np.int64]] = field(default_factory=list)
    last_ns: int | None = None
    first_ns: int = 0
    start_ns: int = 0
    end_ns: int = 0
    next_index: int | None = None
    index_gaps: list[Gap] = field(default_factory=list)


def summarise(
    recording: Readable,
    *,
    path: str,
    kind: str,
    entries: Sequence[TopicEntry],
    damage: tuple[str, ...] | None,
    notes: tuple[str, ...],
) -> RecordingInfo:
    """Read a recording once and say what it holds.

    Parameters
    ----------
    recording : Readable
        The recording.
    path, kind : str
        As in :class:`RecordingInfo`.
    entries : sequence of TopicEntry
        All topics it names; empty for an array.
    damage : tuple of str or None
        None: ask the recording after the pass.
    notes : tuple of str
        What was assumed.
    """
    tallies: dict[str, _Tally] = {}
    joints = _joint_topic(entries)
    for measurement in recording.measurements():
        _count(tallies, measurement, joints)
    refused = getattr(recording, 'n_refused', {})
    selected = getattr(recording, 'selected', None)
    topics = []
    for entry in entries:
        reason = why_unusable(entry)
        if not reason and selected is not None and entry.name not in selected:
            reason = 'not selected'
        tally = tallies.pop(entry.name, None)
        topics.append(_summary(entry, tally, reason, refused.get(entry.name, 0)))
    types = {entry.name: entry.message_type for entry in entries}
    for source, tally in tallies.items():
        message_type = types.get(source.split()[0], tally.message_type)
        entry = TopicEntry(source, message_type, n_messages=tally.n_samples)
        topics.append(_summary(entry, tally, '', 0))
    timed = [topic for topic in topics if topic.usable and topic.n_samples]
    return RecordingInfo(
        path=path,
        kind=kind,
        topics=tuple(topics),
        n_messages=sum(topic.n_messages for topic in topics),
        start_ns=min((topic.start_ns for topic in timed), default=0),
        end_ns=max((topic.end_ns for topic in timed), default=0),
        damage=recording.damage() if damage is None else damage,
        notes=notes,
    )


def why_unusable(entry: TopicEntry) -> str:
    """Return why the identifier cannot use a topic; empty when it can."""
    if not entry.message_type:
        return 'no message type'
    if entry.encoding not in ('cdr', ''):
        return f'messages in {entry.encoding}, not in CDR'
    if entry.message_type not in USABLE_TYPES:
        return 'type not used'
    if entry.message_type == BLOCK and entry.definition:
        field = differing_field(entry.message_type, entry.definition)
        if field:
            return f'its definition differs from {BLOCK}: {field}'
    return ''


def _joint_topic(entries: Sequence[TopicEntry]) -> str:
    """Return what joint samples, which carry no topic, came from: a cell has one such topic."""
    names = [entry.name for entry in entries if entry.message_type == JOINT_STATE]
    return names[0] if len(names) == 1 else '/joint_states'


def _count(tallies: dict[str, _Tally], measurement: Measurement, joints: str) -> None:
    if isinstance(measurement, JointSamples):
        tally = tallies.setdefault(joints, _Tally(JOINT_STATE))
        tally.channels = measurement.joint_names
        _count_stamps(tally, measurement.stamp_ns)
    elif isinstance(measurement, StampedSamples):
        tally = tallies.setdefault(measurement.source, _Tally('samples'))
        tally.channels = measurement.channel_names or tuple(
            f'{measurement.source.strip("/")}.{axis}' for axis in 'xyz'
        )
        _count_stamps(tally, measurement.stamp_ns)
    else:
        _count_block(_tally_of(tallies, measurement), measurement)


def _tally_of(tallies: dict[str, _Tally], block: SampleBlock) -> _Tally:
    """Return the tally of a recorder: channels tell those of one topic apart."""
    first = tallies.setdefault(block.source, _Tally('block', channels=block.channel_names))
    if set(first.channels) == set(block.channel_names):
        return first
    names = ' '.join(sorted(block.channel_names))
    return tallies.setdefault(f'{block.source} {names}', _Tally('block'))


def _count_stamps(tally: _Tally, stamps: NDArray[np.int64]) -> None:
    tally.n_messages += len(stamps)
    tally.n_samples += len(stamps)
    before = stamps[:1] if tally.last_ns is None else np.array([tally.last_ns])
    if tally.last_ns is None:
        tally.start_ns = tally.end_ns = int(stamps[0])
        before = stamps[:0]
    line = np.concatenate([before, stamps])
    tally.steps.append(np.diff(line))
    tally.starts.append(line[:-1])
    tally.last_ns = int(stamps[-1])
    tally.start_ns = min(tally.start_ns, int(stamps.min()))
    tally.end_ns = max(tally.end_ns, int(stamps.max()))


def _count_block(tally: _Tally, block: SampleBlock) -> None:
    n_samples = len(block.acceleration)
    tally.channels = block.channel_names
    tally.declared_rate_hz = block.sample_rate_hz
    step_ns = NANOSECONDS_PER_SECOND / block.sample_rate_hz
    if tally.next_index is not None and block.first_index > tally.next_index:
        lost = block.first_index - tally.next_index
        start = block.stamp_ns - round((lost + 1) * step_ns)
        tally.index_gaps.append(Gap(start, block.stamp_ns, lost))
    tally.next_index = block.first_index + n_samples
    if tally.last_ns is None:
        tally.start_ns = block.stamp_ns
    else:
        # The mean step inside the block that has just ended.
        tally.steps.append(np.array([block.stamp_ns - tally.last_ns], dtype=np.int64))
        tally.starts.append(np.array([tally.last_ns], dtype=np.int64))
    tally.last_ns = block.stamp_ns
    tally.n_messages += 1
    tally.n_samples += n_samples
    tally.start_ns = min(tally.start_ns, block.stamp_ns)
    tally.end_ns = max(tally.end_ns, block.stamp_ns + round((n_samples - 1) * step_ns))


def _summary(entry: TopicEntry, tally: _Tally | None, reason: str, n_refused: int) -> TopicSummary:
    if tally is None:
        return TopicSummary(
            name=entry.name,
            message_type=entry.message_type,
            n_messages=entry.n_messages or 0,
            usable=not reason and bool(entry.n_messages) and n_refused < (entry.n_messages or 0),
            reason=reason or ('no messages' if not entry.n_messages else 'no good message'),
            n_refused=n_refused,
        )
    steps = np.concatenate(tally.steps) if tally.steps else np.empty(0, np.int64)
    starts = np.concatenate(tally.starts) if tally.starts else np.empty(0, np.int64)
    told = stamp_steps(steps)
    is_block = tally.declared_rate_hz > 0.0
    gaps = (
        tally.index_gaps
        if is_block
        else [
            Gap(int(starts[place]), int(starts[place] + steps[place]), int(told.n_lost[place]))
            for place in np.flatnonzero(told.is_gap)
        ]
    )
    n_equal = 0 if is_block or told.is_coarse else int(np.count_nonzero(steps == 0))
    if not reason and not is_block and tally.n_samples > 1 and tally.start_ns == tally.end_ns:
        reason = f'all stamps are {tally.start_ns * 1e-9:g} s: set header.stamp in the driver'
    return TopicSummary(
        name=entry.name,
        message_type=entry.message_type,
        n_messages=tally.n_messages + n_refused,
        usable=not reason,
        reason=reason,
        channels=tally.channels,
        n_samples=tally.n_samples,
        declared_rate_hz=tally.declared_rate_hz,
        measured_rate_hz=_block_rate_hz(tally) if is_block else told.rate_hz,
        jitter_std_s=0.0 if is_block else told.jitter_std_s,
        gaps=tuple(sorted(gaps, key=lambda gap: -gap.n_lost)[:LISTED_GAPS]),
        n_gaps=len(gaps),
        n_duplicates=n_equal,
        n_backwards=int(np.count_nonzero(steps < 0)),
        n_refused=n_refused,
        start_ns=tally.start_ns,
        end_ns=tally.end_ns,
    )


def _block_rate_hz(tally: _Tally) -> float:
    """Return the rate that counters and stamps of blocks tell [Hz]."""
    span = (tally.end_ns - tally.start_ns) * 1e-9
    lost = sum(gap.n_lost for gap in tally.index_gaps)
    is_known = tally.n_messages > 1 and span > 0.0
    return (tally.n_samples + lost - 1) / span if is_known else tally.declared_rate_hz
