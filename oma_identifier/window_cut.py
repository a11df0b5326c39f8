"""Cut one window out of the rows of a segment: healthy channels, and the health of all."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel, SensorLayout
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.samples import Samples
from modal_core.window import Window
from oma_identifier.block_clock import RATE_TOLERANCE
from oma_identifier.health import compare, examine, EXCLUDING
from oma_identifier.joint_track import JointTrack, pose_of
from oma_identifier.segment import Segment
from oma_identifier.setup_check import check_gravity
from oma_identifier.source import Source

DEGRADED_SHARE = 0.01
"""Share of filled samples that makes a window degraded."""

MOST_NAMED = 4
"""Channels named one by one."""


@dataclass(frozen=True, slots=True)
class _Column:
    channel: Channel
    values: NDArray[np.float64]
    quality: ChannelQuality


def cut_window(
    *,
    index: int,
    segment: Segment,
    sources: Sequence[Source],
    rows: range,
    layout: SensorLayout | None,
    joints: JointTrack,
    flags: tuple[str, ...],
) -> Window:
    """Cut a window.

    Parameters
    ----------
    index : int
        Window counter.
    segment : Segment
        The rows.
    sources : sequence of Source
        All that are known.
    rows : range
        Rows of the window.
    layout : SensorLayout or None
        Channels that are expected.
    joints : JointTrack
        For the pose.
    flags : tuple of str
        What is known about the window as a whole.
    """
    columns = [column for source in sources for column in _columns_of(source, segment, rows)]
    healthy = [column for column in columns if not column.quality.excluded]
    values = _side_by_side(healthy, len(rows))
    compared = compare(values, [column.quality for column in healthy])
    suspicions = check_gravity([column.channel for column in healthy], values)
    by_name = {
        quality.name: replace(quality, flags=(*quality.flags, suspicions[quality.name]))
        if quality.name in suspicions
        else quality
        for quality in compared
    }
    qualities = [by_name.get(column.channel.name, column.quality) for column in columns]
    qualities += _missing(layout, qualities)
    start_ns, end_ns = segment.time_ns(rows.start), segment.time_ns(rows.stop)
    recent = joints.between(start_ns, end_ns)
    for source in sources:
        source.stream.events.forget(segment.time_ns(rows.start + segment.hop_rows))
    return Window(
        index=index,
        samples=Samples(
            acceleration=values,
            sample_rate_hz=segment.sample_rate_hz,
            channels=tuple(column.channel for column in healthy),
            start_ns=segment.label_ns(rows.start),
        ),
        quality=_quality(sources, qualities, len(rows), flags),
        pose=pose_of(recent),
        joints=recent,
    )


def _side_by_side(columns: Sequence[_Column], n_rows: int) -> NDArray[np.float64]:
    """Return the columns as one array, without a copy where they are all columns of one."""
    whole = columns[0].values.base if columns else None
    if whole is not None and whole.shape == (n_rows, len(columns)):
        if all(column.values.base is whole for column in columns):
            return whole
    values = np.empty((n_rows, len(columns)))
    for place, column in enumerate(columns):
        values[:, place] = column.values
    return values


def _columns_of(source: Source, segment: Segment, rows: range) -> list[_Column]:
    n_channels = len(source.channels)
    values = np.zeros((len(rows), n_channels))
    lost = np.ones(len(rows), dtype=bool)
    filled = np.zeros(len(rows), dtype=bool)
    bad = np.zeros((len(rows), n_channels), dtype=bool)
    for stretch in segment.stretches:
        part = stretch.rows.get(source.name)
        low = max(rows.start, stretch.first_row)
        high = min(rows.stop, stretch.first_row + stretch.n_rows)
        if part is None or high <= low:
            continue
        here = slice(low - rows.start, high - rows.start)
        there = slice(low - stretch.first_row, high - stretch.first_row)
        values[here] = part.values[there]
        lost[here] = part.lost[there]
        filled[here] = part.filled[there]
        bad[here] = part.bad[there]
    base = _source_quality(source, segment, rows, lost, filled)
    return [
        _Column(channel, values[:, place], _channel_quality(base, channel, values, bad, place))
        for place, channel in enumerate(source.channels)
    ]


def _source_quality(
    source: Source,
    segment: Segment,
    rows: range,
    lost: NDArray[np.bool_],
    filled: NDArray[np.bool_],
) -> ChannelQuality:
    start_ns, end_ns = segment.time_ns(rows.start), segment.time_ns(rows.stop)
    share = segment.step_ns / source.period_ns if source.period_ns else 1.0
    flags = sorted(source.flags)
    if lost.all():
        flags.append('missing')
    elif lost.any():
        flags += ['gap', 'lost']
    elif filled.any():
        flags.append('gap')
    events = source.stream.events

    def count(stamps: list[int]) -> int:
        return sum(start_ns <= stamp < end_ns for stamp in stamps)

    return ChannelQuality(
        name=source.name,
        n_interpolated=round(np.count_nonzero(filled) * share),
        n_lost=round(np.count_nonzero(lost | filled) * share) + count(events.late),
        n_duplicates=count(events.duplicates),
        n_reordered=count(events.reordered),
        measured_rate_hz=source.measured_rate_hz,
        jitter_std_s=source.jitter_std_s,
        flags=tuple(flags),
    )


def _channel_quality(
    base: ChannelQuality,
    channel: Channel,
    values: NDArray[np.float64],
    bad: NDArray[np.bool_],
    place: int,
) -> ChannelQuality:
    flags = list(base.flags)
    if bad[:, place].any():
        flags.append('not_finite')
    health = examine(values[:, place])
    if 'missing' not in flags:
        flags += [flag for flag in health.flags if flag not in flags]
    return ChannelQuality(
        name=channel.name,
        n_interpolated=base.n_interpolated,
        n_lost=base.n_lost,
        n_duplicates=base.n_duplicates,
        n_reordered=base.n_reordered,
        measured_rate_hz=base.measured_rate_hz,
        jitter_std_s=base.jitter_std_s,
        rms=health.rms,
        excluded=any(flag in EXCLUDING for flag in flags),
        flags=tuple(flags),
    )


def _why_excluded(channels: Sequence[ChannelQuality]) -> str:
    """Name channels by what is wrong with them."""
    by_flag: dict[str, list[str]] = {}
    for quality in channels:
        for flag in quality.flags:
            if flag in EXCLUDING:
                by_flag.setdefault(flag, []).append(quality.name)
    return '; '.join(
        f'{flag} in {", ".join(names[:MOST_NAMED])}'
        + (f' and {len(names) - MOST_NAMED} more' if len(names) > MOST_NAMED else '')
        for flag, names in by_flag.items()
    )


def _missing(
    layout: SensorLayout | None, present: Sequence[ChannelQuality]
) -> list[ChannelQuality]:
    names = {quality.name for quality in present}
    expected = layout.channels if layout else ()
    return [
        ChannelQuality(name=channel.name, excluded=True, flags=('missing',))
        for channel in expected
        if channel.name not in names
    ]


def _quality(
    sources: Sequence[Source],
    channels: Sequence[ChannelQuality],
    n_rows: int,
    flags: tuple[str, ...],
) -> DataQuality:
    found = list(flags)
    if any(quality.n_interpolated > DEGRADED_SHARE * n_rows for quality in channels) or any(
        quality.excluded for quality in channels
    ):
        found.append('degraded')
    reason = _wrong_rate(sources)
    if reason:
        found.append('rate_mismatch')
    elif all(quality.excluded for quality in channels):
        reason = f'every channel is excluded: {_why_excluded(channels)}'
    return DataQuality(
        identifiable=not reason,
        reason=reason,
        flags=tuple(dict.fromkeys(found)),
        channels=tuple(channels),
    )


def _wrong_rate(sources: Sequence[Source]) -> str:
    for source in sources:
        if source.clock is None:
            continue
        declared, measured = source.clock.sample_rate_hz, source.measured_rate_hz
        if abs(measured / declared - 1.0) > RATE_TOLERANCE:
            return (
                f'{source.name.split()[0]} declares {declared:g} Hz '
                f'but its stamps say {measured:.4g} Hz'
            )
    return ''
