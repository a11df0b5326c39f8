"""Uniform series out of the measurements of one recording."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
import itertools

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from modal_core.channel import Channel, SensorLayout
from modal_core.errors import RecordingError
from modal_core.layouts.channel_match import match_channel, plain_name
from modal_core.measurements import (
    JointSamples,
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
    StampedSamples,
)
from modal_core.units import ACCELERATION
from modal_core.words.named import named
from model_gap.campaign.thresholds import CAMPAIGN

Array = NDArray[np.float64]
Columns = NDArray[np.intp]


@dataclass(frozen=True)
class Series:
    """Samples on a uniform grid.

    Parameters
    ----------
    names : tuple of str
        Columns.
    start_s : float [s]
        Time of the first row.
    rate_hz : float [Hz]
        Of the rows.
    values : (n_samples, n_columns) array
        Without gaps.
    """

    names: tuple[str, ...]
    start_s: float
    rate_hz: float
    values: Array

    @property
    def end_s(self) -> float:
        """Time of the last row [s]."""
        return self.start_s + (len(self.values) - 1) / self.rate_hz


@dataclass(frozen=True)
class RawRecording:
    """What one recording holds, as uniform series.

    Parameters
    ----------
    accelerations : tuple of Series
        One per recorder or sensor; columns named as channels.
    position, velocity, effort : Series or None
        Of the joints; velocity and effort None where not recorded.
    unknown : tuple of str
        Channels the layout does not have.
    notes : tuple of str
        What was left out, and why.
    """

    accelerations: tuple[Series, ...]
    position: Series | None
    velocity: Series | None
    effort: Series | None
    unknown: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def gather(
    measurements: Iterable[Measurement],
    layout: SensorLayout,
    where: str,
    joint_names: tuple[str, ...] = (),
) -> RawRecording:
    """Collect a recording's measurements.

    Parameters
    ----------
    measurements : iterable of Measurement
        In any order.
    layout : SensorLayout
        Channels that count.
    where : str
        For errors.
    joint_names : tuple of str
        Joints that count, where several sets of joints are recorded.

    Raises
    ------
    RecordingError
        It holds no acceleration of the layout.
    """
    blocks: dict[str, list[SampleBlock]] = {}
    stamped: dict[str, list[StampedSamples]] = {}
    joints: list[JointSamples] = []
    for item in measurements:
        if isinstance(item, SampleBlock):
            blocks.setdefault(item.source, []).append(item)
        elif isinstance(item, StampedSamples):
            stamped.setdefault(item.source, []).append(item)
        else:
            joints.append(item)
    unknown: list[str] = []
    notes: list[str] = []
    found = [_from_blocks(items, layout, unknown) for items in blocks.values()]
    found += [_from_stamped(items, layout, unknown) for items in stamped.values()]
    whole = [_without_holes(part, notes) for part in found if part is not None]
    series = tuple(part for part in whole if part is not None)
    if not series:
        raise RecordingError(
            'no acceleration of the sensor layout',
            where=where,
            found=named(unknown) or '; '.join(notes) or 'none',
            expected=named([channel.name for channel in layout.channels]),
        )
    position, velocity, effort = _joints(joints, joint_names, notes)
    return RawRecording(series, position, velocity, effort, tuple(unknown), tuple(notes))


def beginning(measurements: Iterable[Measurement], seconds: float) -> Iterator[Measurement]:
    """Yield what was measured in the first seconds, and what comes in one piece with it.

    A topic may be stamped later than others: ``CAMPAIGN.reserve_s`` more are read.
    """
    last_ns: float | None = None
    for item in measurements:
        first_ns = int(np.min(item.stamp_ns)) if np.size(item.stamp_ns) else None
        if first_ns is not None:
            if last_ns is None:
                last_ns = first_ns + (seconds + CAMPAIGN.reserve_s) * NANOSECONDS_PER_SECOND
            if first_ns > last_ns:
                return
        yield item


def joint_columns(names: tuple[str, ...], wanted: tuple[str, ...]) -> list[int] | None:
    """Return the column of every wanted joint; a robot's prefix before the names does not matter.

    Parameters
    ----------
    names : tuple of str
        As recorded.
    wanted : tuple of str
        As the model calls them.

    Returns
    -------
    list of int or None
        None when one is missing or not unique.
    """
    columns = []
    for joint in wanted:
        same = [number for number, name in enumerate(names) if name == joint] or [
            number
            for number, name in enumerate(names)
            if name.endswith(joint) and name[-len(joint) - 1] in '/_-.'
        ]
        if len(same) != 1:
            return None
        columns.append(same[0])
    return columns


def _names(item: SampleBlock | StampedSamples) -> tuple[str, ...]:
    """Return the names of channels, each with the unit that the recording states."""
    if not item.units:
        return item.channel_names
    return tuple(
        f'{name} [{unit}]' for name, unit in zip(item.channel_names, item.units, strict=True)
    )


def _from_blocks(
    items: list[SampleBlock], layout: SensorLayout, unknown: list[str]
) -> Series | None:
    names = items[0].channel_names
    matched = [match_channel(name, layout) for name in _names(items[0])]
    unknown += [name for name, channel in zip(names, matched, strict=True) if channel is None]
    columns = [number for number, channel in enumerate(matched) if channel is not None]
    if not columns:
        return None
    items = [item for item in items if item.channel_names == names]
    runs: list[list[SampleBlock]] = [[items[0]]]
    for before, item in itertools.pairwise(items):
        if item.first_index == before.first_index + len(before.acceleration):
            runs[-1].append(item)
        else:
            runs.append([item])
    run = max(runs, key=lambda blocks: sum(len(item.acceleration) for item in blocks))
    values = np.concatenate([item.acceleration for item in run]).astype(float)[:, columns]
    index = np.array([item.first_index - run[0].first_index for item in run], dtype=float)
    stamps = np.array([item.stamp_ns for item in run], dtype=np.int64)
    start, rate = _line(index, stamps, run[0].sample_rate_hz)
    kept = [channel for channel in matched if channel is not None]
    scale = [channel.scale for channel in kept]
    return Series(tuple(channel.name for channel in kept), start, rate, values * scale)


def _line(index: Array, stamps: NDArray[np.int64], nominal_hz: float) -> tuple[float, float]:
    """Return start and rate of stamps over sample numbers; the nominal rate when it fits."""
    seconds = (stamps - stamps[0]) * 1e-9
    rate = nominal_hz
    if len(index) >= 8 and seconds[-1] > 0.0:
        slope = float(np.polyfit(index, seconds, 1)[0])
        if slope > 0.0 and abs(slope * nominal_hz - 1.0) > 2e-5:
            rate = 1.0 / slope
    offset = float(np.median(seconds - index / rate))
    return stamps[0] * 1e-9 + offset, rate


def _from_stamped(
    items: list[StampedSamples], layout: SensorLayout, unknown: list[str]
) -> Series | None:
    first = items[0]
    channels = _stamped_channels(first, layout)
    if channels is None:
        unknown.append(first.source)
        return None
    stamps = np.concatenate([item.stamp_ns for item in items])
    values = np.concatenate([item.acceleration for item in items])[:, : len(channels)]
    uniform = _uniform(stamps, values * [channel.scale for channel in channels])
    names = tuple(channel.name for channel in channels)
    return None if uniform is None else Series(names, *uniform)


def _stamped_channels(item: StampedSamples, layout: SensorLayout) -> tuple[Channel, ...] | None:
    if item.channel_names:
        matched = [match_channel(name, layout) for name in _names(item)]
        known = tuple(channel for channel in matched if channel is not None)
        if len(known) == len(matched):
            return known
    topic = item.source.strip('/')
    for test in (
        lambda sensor: sensor.topic.strip('/') == topic,
        lambda sensor: plain_name(sensor.name) == plain_name(topic),
        lambda sensor: plain_name(sensor.name) in plain_name(topic).split('.'),
        lambda sensor: plain_name(topic).endswith(plain_name(sensor.name)),
        lambda sensor: sensor.frame_id == item.frame_id,
    ):
        fitting = [sensor for sensor in layout if test(sensor)]
        if len(fitting) == 1 and fitting[0].axes == ('x', 'y', 'z'):
            channels = fitting[0].channels()
            return channels if channels[0].unit == ACCELERATION else None
    return None


def _uniform(stamps: NDArray[np.int64], values: Array) -> tuple[float, float, Array] | None:
    """Put stamped rows on a uniform grid; the longest stretch without gaps counts."""
    order = np.argsort(stamps, kind='stable')
    stamps, values = stamps[order], values[order]
    keep = np.r_[True, np.diff(stamps) > 0]
    stamps, values = stamps[keep], values[keep]
    if len(stamps) < CAMPAIGN.fewest_samples:
        return None
    step = float(np.median(np.diff(stamps)))
    cuts = np.flatnonzero(np.diff(stamps) > CAMPAIGN.largest_gap_steps * 2.0 * step) + 1
    edges = [0, *cuts.tolist(), len(stamps)]
    spans = list(itertools.pairwise(edges))
    low, high = max(spans, key=lambda span: span[1] - span[0])
    stamps, values = stamps[low:high], values[low:high]
    seconds = (stamps - stamps[0]) * 1e-9
    # Samples keep their place in the row when their stamps jitter; lost ones leave a hole in it.
    steps = np.maximum(np.rint(np.diff(stamps) / step), 1.0).astype(int)
    index = np.concatenate([[0], np.cumsum(steps)])
    slope = float(np.polyfit(index, seconds, 1)[0])
    offset = float(np.median(seconds - index * slope))
    if np.abs(seconds - index * slope - offset).max() < slope:
        if len(index) < index[-1] + 1:
            values = CubicSpline(index, values, axis=0)(np.arange(index[-1] + 1))
        return stamps[0] * 1e-9 + offset, 1.0 / slope, values
    count = int(seconds[-1] / (step * 1e-9)) + 1
    even = CubicSpline(seconds, values, axis=0)(np.arange(count) * step * 1e-9)
    return stamps[0] * 1e-9, 1e9 / step, np.asarray(even)


def _without_holes(series: Series, notes: list[str]) -> Series | None:
    """Leave out channels that hold no signal, then keep the longest stretch without a hole."""
    good = np.isfinite(series.values)
    columns = np.flatnonzero(good.mean(axis=0) >= CAMPAIGN.least_finite)
    _note_missing(notes, 'mostly not a number', series.names, np.arange(good.shape[1]), columns)
    if not len(columns):
        return None
    whole = np.asarray(good[:, columns].all(axis=1))
    first, end = 0, len(whole)
    if not whole.all():
        edges = [-1, *np.flatnonzero(~whole).tolist(), len(whole)]
        low, high = max(itertools.pairwise(edges), key=lambda span: span[1] - span[0])
        first, end = low + 1, high
        notes.append(f'{int((~whole).sum())} samples are not numbers; the longest rest was used')
    if end - first < CAMPAIGN.fewest_samples:
        return None
    values = series.values[first:end]
    moving = np.ptp(values, axis=0) > CAMPAIGN.least_change * np.abs(values).max(axis=0)
    alive = columns[moving[columns]]
    _note_missing(notes, 'always the same number', series.names, columns, alive)
    if not len(alive):
        return None
    start = series.start_s + first / series.rate_hz
    names = tuple(series.names[number] for number in alive)
    return Series(names, start, series.rate_hz, values[:, alive])


def _note_missing(
    notes: list[str], why: str, names: tuple[str, ...], before: Columns, after: Columns
) -> None:
    dead = [names[number] for number in before if number not in after]
    if dead:
        notes.append(f'left out, {why}: {", ".join(dead)}')


def _joints(
    items: list[JointSamples], wanted: tuple[str, ...], notes: list[str]
) -> tuple[Series | None, Series | None, Series | None]:
    groups: dict[frozenset[str], list[JointSamples]] = {}
    for item in items:
        groups.setdefault(frozenset(item.joint_names), []).append(item)
    if not groups:
        return None, None, None
    fitting = [
        group
        for group in groups.values()
        if joint_columns(group[0].joint_names, wanted) is not None
    ]
    items = max(fitting or groups.values(), key=lambda group: sum(len(i.stamp_ns) for i in group))
    names = items[0].joint_names
    order = [[item.joint_names.index(name) for name in names] for item in items]
    stamps = np.concatenate([item.stamp_ns for item in items])

    def series(field: str) -> Series | None:
        parts = [getattr(item, field) for item in items]
        if any(len(part) != len(item.stamp_ns) for part, item in zip(parts, items, strict=True)):
            return None
        values = np.concatenate([part[:, o] for part, o in zip(parts, order, strict=True)])
        kept = np.isfinite(values).all(axis=1)
        if kept.sum() < CAMPAIGN.fewest_samples:
            return None
        if field == 'position' and not kept.all():
            notes.append(f'{int((~kept).sum())} joint states are not numbers and were left out')
        uniform = _uniform(stamps[kept], values[kept])
        return None if uniform is None else Series(names, *uniform)

    return series('position'), series('velocity'), series('effort')
