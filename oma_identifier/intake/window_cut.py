"""Cut one window out of the rows of a segment: healthy channels, and the health of all."""

from collections.abc import Container, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel, SensorLayout
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.samples import Samples
from modal_core.window import Window
from modal_core.words.flag_words import flag_words
from modal_core.words.named import named
from oma_identifier.intake.joint_track import JointTrack, pose_of
from oma_identifier.intake.segment import Segment
from oma_identifier.intake.source import Source
from oma_identifier.intake.source_rows import CutRows
from oma_identifier.intake.thresholds import INTAKE
from oma_identifier.quality import (
    ChannelHealth,
    channels_by_flag,
    check_gravity,
    check_sizes,
    COPIED,
    copies,
    DAMPING_UNSURE,
    examine,
    EXCLUDING,
    is_damping_unsure,
)
from oma_identifier.time_axis import FarValue, TIME_AXIS

ADVICE = {
    'clipping': ' (choose a larger range, or shake less)',
    'not_finite': f' (or beyond {TIME_AXIS.largest_value:,.0f}: is the unit right?)',
    'clock_unknown': ' (state the rate of even samples, sample_rate_hz, or record finer times)',
}
"""What may be done about channels that are left out, by flag."""


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
    cuts = [segment.cut(source, rows) for source in sources]
    by_source = [
        _qualities(source, segment, rows, cut) for source, cut in zip(sources, cuts, strict=True)
    ]
    by_source = _without_copies(cuts, by_source)
    values = _side_by_side(cuts, by_source, len(rows))
    channels = [channel for source in sources for channel in source.channels]
    qualities = [quality for each in by_source for quality in each]
    healthy = [place for place, quality in enumerate(qualities) if not quality.excluded]
    channels = [channels[place] for place in healthy]
    mean = np.concatenate([cut.summary.mean for cut in cuts])[healthy]
    suspicions = check_gravity(channels, mean), check_sizes([qualities[p] for p in healthy])
    for place in healthy:
        quality = qualities[place]
        found = [flags_of[quality.name] for flags_of in suspicions if quality.name in flags_of]
        if found:
            qualities[place] = replace(quality, flags=(*quality.flags, *found))
    qualities += _missing(layout, qualities)
    start_ns, end_ns = segment.time_ns(rows.start), segment.time_ns(rows.stop)
    recent = joints.between(start_ns, end_ns)
    for source in sources:
        source.forget(segment.time_ns(rows.start + segment.hop_rows))
    return Window(
        index=index,
        samples=Samples(
            acceleration=values,
            sample_rate_hz=segment.sample_rate_hz,
            channels=tuple(channels),
            start_ns=segment.label_ns(rows.start),
        ),
        quality=_quality(sources, qualities, len(rows), flags),
        pose=pose_of(recent),
        joints=recent,
    )


def _without_copies(
    cuts: Sequence[CutRows], qualities: Sequence[Sequence[ChannelQuality]]
) -> list[list[ChannelQuality]]:
    """Return the health of channels with those left out that have the samples of another."""
    live = [
        (source, place)
        for source, each in enumerate(qualities)
        for place, quality in enumerate(each)
        if not quality.excluded
    ]
    found = [list(each) for each in qualities]
    if len(live) > 1:
        extremes = [cuts[source].summary.extremes[:, place] for source, place in live]
        signals = [cuts[source].values[:, place] for source, place in live]
        for copied in copies(signals, np.transpose(extremes)):
            source, place = live[copied]
            flags = (*found[source][place].flags, COPIED)
            found[source][place] = replace(found[source][place], excluded=True, flags=flags)
    return found


def _side_by_side(
    cuts: Sequence[CutRows], qualities: Sequence[Sequence[ChannelQuality]], n_rows: int
) -> NDArray[np.floating]:
    """Return the healthy columns as one array; those of one source are not copied."""
    healthy = [[not quality.excluded for quality in each] for each in qualities]
    if len(cuts) == 1 and all(healthy[0]):
        return cuts[0].values
    dtype = np.result_type(*(cut.values for cut in cuts))
    values = np.empty((n_rows, sum(map(sum, healthy))), dtype)
    start = 0
    for cut, chosen in zip(cuts, healthy, strict=True):
        stop = start + sum(chosen)
        values[:, start:stop] = cut.values if all(chosen) else cut.values[:, chosen]
        start = stop
    return values


def _qualities(
    source: Source, segment: Segment, rows: range, cut: CutRows
) -> list[ChannelQuality]:
    base = _source_quality(source, segment, rows, cut.lost, cut.filled)
    within = segment.time_ns(rows.start), segment.time_ns(rows.stop)
    far = source.far_values.told(*within)
    repeated = source.repeats.flags(*within)
    converted = source.converter.flags(*within)
    bad = cut.bad | (cut.n_mended > INTAKE.most_mended * len(rows))
    n_mended = np.rint(cut.n_mended * _samples_per_row(source, segment)).astype(int)
    return [
        _channel_quality(_with_lost(base, mended, told), channel, health, is_bad, found)
        for channel, health, is_bad, mended, told, *found in zip(
            source.channels,
            examine(cut.values, cut.summary),
            bad.tolist(),
            n_mended.tolist(),
            far,
            repeated,
            converted,
            strict=True,
        )
    ]


def _samples_per_row(source: Source, segment: Segment) -> float:
    return segment.step_ns / source.period_ns if source.period_ns else 1.0


def _with_lost(base: ChannelQuality, n_mended: int, far: tuple[FarValue, ...]) -> ChannelQuality:
    """Return the quality of a channel some of whose values are no measurements: as if not sent."""
    if far:
        base = replace(base, far_values=far)
    if not n_mended or 'missing' in base.flags:
        return base
    return replace(
        base,
        n_interpolated=base.n_interpolated + n_mended,
        n_lost=base.n_lost + n_mended,
        flags=tuple(dict.fromkeys((*base.flags, 'gap'))),
    )


def _source_quality(
    source: Source,
    segment: Segment,
    rows: range,
    lost: NDArray[np.bool_],
    filled: NDArray[np.bool_],
) -> ChannelQuality:
    start_ns, end_ns = segment.time_ns(rows.start), segment.time_ns(rows.stop)
    share = _samples_per_row(source, segment)
    flags = sorted(source.flags)
    if any(start_ns <= stretch < end_ns for stretch in source.unclear_ns):
        flags.append('clock_unknown')
    if any(start_ns <= stretch < end_ns for stretch in source.changed_ns):
        flags.append('rate_change')
    if source.clock is not None and source.clock.is_wrong:
        # Its samples were not taken when it says, so it says nothing beside others.
        flags.append('rate_mismatch')
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
    health: ChannelHealth,
    bad: bool,
    as_sent: Sequence[Sequence[str]],
) -> ChannelQuality:
    flags = list(base.flags)
    if bad:
        flags.append('not_finite')
    if 'missing' not in flags:
        # What stands in for samples that were lost is no limit of a sensor.
        seen = () if 'lost' in flags else health.flags
        found = dict.fromkeys((*seen, *chain.from_iterable(as_sent)))
        flags += [flag for flag in found if flag not in flags and not _is_told(flag, found)]
    return ChannelQuality(
        name=channel.name,
        n_interpolated=base.n_interpolated,
        n_lost=base.n_lost,
        n_duplicates=base.n_duplicates,
        n_reordered=base.n_reordered,
        measured_rate_hz=base.measured_rate_hz,
        jitter_std_s=base.jitter_std_s,
        far_values=base.far_values,
        rms=health.rms,
        kurtosis=health.kurtosis,
        noise_rms=health.noise_rms,
        unit=channel.unit,
        excluded=any(flag in EXCLUDING for flag in flags),
        flags=tuple(flags),
    )


def _is_told(flag: str, found: Container[str]) -> bool:
    """Tell whether another flag says it: at a limit values stand still and repeat."""
    return 'clipping' in found and flag in {'sample_and_hold', 'flatline'}


def _why_excluded(channels: Sequence[ChannelQuality]) -> str:
    """Name channels by what is wrong with them."""
    by_flag = channels_by_flag(channels)
    unreal = set(by_flag.get('not_finite', ()))
    return '; '.join(
        f'{flag_words(flag)} in {named(names, INTAKE.most_named)}{ADVICE.get(flag, "")}'
        for flag, names in by_flag.items()
        # What is left of a channel without values is flat.
        if flag in EXCLUDING and not (flag == 'flatline' and unreal.issuperset(names))
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
    if any(quality.n_interpolated > INTAKE.degraded_share * n_rows for quality in channels) or any(
        quality.excluded for quality in channels
    ):
        found.append('degraded')
    if is_damping_unsure(channels, n_rows):
        found.append(DAMPING_UNSURE)
    wrong, reason = _wrong_rate(sources), ''
    if wrong:
        found.append('rate_mismatch')
    if all(quality.excluded for quality in channels):
        reason = wrong or f'every channel is excluded: {_why_excluded(channels)}'
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
        if source.clock.is_wrong:
            return (
                f'{source.name.split()[0]} declares {declared:g} Hz '
                f'but its stamps say {measured:.5g} Hz'
            )
    return ''
