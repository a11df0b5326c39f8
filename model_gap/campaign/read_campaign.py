"""Read a campaign folder: recordings on one grid, known motion, poses, levels."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import SensorLayout
from modal_core.errors import RecordingError, SettingsError
from modal_core.layouts.layout_file import layout_from_file
from modal_core.measurements import Measurement
from modal_core.words.named import named
from modal_core.work.progress import Progress
from modal_core.work.side_by_side import side_by_side
from modal_recordings import open_recording
from modal_recordings.joint_table import is_table
from modal_recordings.messages import attached_layout
from model_gap.campaign.campaign import Campaign, GapRecord
from model_gap.campaign.campaign_file import CampaignEntry, read_campaign_file
from model_gap.campaign.columns import in_order_of, joints_beside, read_columns
from model_gap.campaign.copies import refuse_copies
from model_gap.campaign.motion import motion_on_grid, RecordedMotion
from model_gap.campaign.position_units import check_position_units
from model_gap.campaign.resample import at_times, thinned
from model_gap.campaign.series import beginning, gather, joint_columns, RawRecording, Series
from model_gap.campaign.set_ups import SetUps
from model_gap.campaign.spectra import Band, quiet_rate_hz
from model_gap.campaign.thresholds import CAMPAIGN
from structural_model import FlexibleJointModel, load_layout

Array = NDArray[np.float64]


def read_campaign(
    folder: str | Path,
    model: FlexibleJointModel,
    layout: SensorLayout | None = None,
    progress: Progress = lambda _: None,
    most: int | None = None,
    seconds: float = np.inf,
) -> Campaign:
    """Read all recordings of a campaign.

    Parameters
    ----------
    folder : path
        With ``campaign.yaml``, or recordings only.
    model : FlexibleJointModel
        Whose joints move.
    layout : SensorLayout or None
        Overrides the campaign's own.
    progress : callable
        Takes the fraction done.
    most : int or None
        Read the first so many recordings only; None: all.
    seconds : float [s]
        Of each recording read hardly more than its beginning, where that saves reading.

    Raises
    ------
    SettingsError, RecordingError, LayoutError
        What is missing, and what to record.
    """
    folder = Path(folder)
    file = read_campaign_file(folder)
    entries = file.entries[:most]
    layouts = SetUps.of(entries, lambda: _layout(file.layout, layout, folder))
    model.check_layout(layouts.whole)
    notes: list[str] = []
    said: dict[str, list[str]] = {}
    raws: list[tuple[CampaignEntry, RawRecording]] = []
    useless: list[RecordingError] = []
    gathered = side_by_side(
        lambda entry: _gathered(entry, layouts, model, seconds), entries, progress
    )
    for entry, found in zip(entries, gathered, strict=True):
        with _left_out(useless, notes):
            if isinstance(found, RecordingError):
                raise found
            raws.append((entry, found.raw))
            notes += found.notes
            for note in found.said:
                said.setdefault(note, []).append(entry.name)
    if not raws:
        raise useless[0]
    notes += [f'{named(names, 1)}: {note}' for note, names in said.items()]
    refuse_copies(((entry.name, _samples(raw)) for entry, raw in raws), folder)
    read: list[tuple[RawRecording, GapRecord, RecordedMotion]] = []
    for entry, raw in raws:
        with _left_out(useless, notes):
            own = layouts.whole.only(_channels(raw))
            read.append((raw, *_record(entry, raw, own, model, notes)))
    if not read:
        raise useless[0]
    records, kept = _on_one_layout(
        [(raw, record) for raw, record, _ in read], layouts.whole, notes
    )
    sources = sorted({motion.source for _, _, motion in read})
    positions = [raw.position for raw, _, _ in read if raw.position is not None]
    return Campaign(
        records=tuple(_from_the_first(_with_levels(records))),
        layout=kept,
        joint_names=model.joint_names,
        excitation=' and '.join(sources),
        effort_recorded=all(raw.effort is not None for raw, _, _ in read),
        motion_rate_hz=min(position.rate_hz for position in positions),
        motion_band_hz=min(motion.highest_hz for _, _, motion in read),
        notes=tuple(dict.fromkeys(notes)),
        remarks=file.remarks,
        given_layout=layouts.whole,
        effects=file.effects,
        tolerances=file.tolerances,
    )


@contextmanager
def _left_out(useless: list[RecordingError], notes: list[str]) -> Iterator[None]:
    """Note a recording that cannot be used instead of ending at it.

    The others may be enough; how little they are shows in the verdict.
    """
    try:
        yield
    except RecordingError as error:
        useless.append(error)
        notes.append(f'left out: {error}')


@dataclass(frozen=True)
class _Gathered:
    """A recording as read, what is told of it, and what is told of all recordings alike."""

    raw: RawRecording
    notes: tuple[str, ...]
    said: tuple[str, ...]


def _gathered(
    entry: CampaignEntry, layouts: SetUps, model: FlexibleJointModel, seconds: float
) -> _Gathered | RecordingError:
    """Read one recording; fast accelerations are thinned out at once, to need little memory."""
    sensors = layouts.own(entry)
    try:
        measurements, assumed = _measured(entry, sensors, model)
        begun = beginning(measurements, seconds)
        raw = gather(begun, sensors, str(entry.path), model.joint_names)
        if raw.position is None:
            raise RecordingError(
                'no joint states: the motion is not known',
                where=str(entry.path),
                advice='record sensor_msgs/JointState beside the accelerations',
            )
    except RecordingError as error:
        return error
    notes = [
        f'channel {name} is not in the sensor layout and was left out' for name in raw.unknown
    ]
    said = tuple(dict.fromkeys((*raw.notes, *assumed())))
    series = [layouts.in_whole(entry, _thinned(item)) for item in raw.accelerations]
    return _Gathered(replace(raw, accelerations=tuple(series)), tuple(notes), said)


def _measured(
    entry: CampaignEntry, sensors: SensorLayout, model: FlexibleJointModel
) -> tuple[Iterable[Measurement], Callable[[], Iterable[str]]]:
    """Return the measurements of an entry, and what is to be said of them once they are read."""
    beside = () if entry.joints is None else joints_beside(entry.joints, model.joint_names)
    if is_table(entry.path):
        found = read_columns(entry, model.joint_names)
        measurements, assumed = in_order_of(sensors, found)
        return chain(measurements, beside), lambda: (*assumed, *found.notes)
    if entry.stated:
        raise SettingsError(
            'rate, unit and channels are stated by the recording itself',
            where=entry.path,
            found=', '.join(entry.stated),
            expected='these of a file of columns (.csv, .npz, .mat, ...) only',
        )
    recording = open_recording(entry.path)
    return chain(recording.measurements(), beside), recording.damage


def _samples(raw: RawRecording) -> Iterator[Array]:
    series = (*raw.accelerations, raw.position)
    return (item.values for item in series if item is not None)


def _thinned(item: Series) -> Series:
    every = max(1, int(item.rate_hz // CAMPAIGN.highest_rate_hz))
    values = thinned(item.values, item.rate_hz, every)
    return replace(item, rate_hz=item.rate_hz / every, values=values)


def _layout(own: object, given: SensorLayout | None, folder: Path) -> SensorLayout:
    if given is not None:
        return given
    if isinstance(own, Path):
        return layout_from_file(own)
    if isinstance(own, Mapping):
        return SensorLayout.from_mapping(own, str(folder / 'campaign.yaml'))
    raise SettingsError(
        'no sensor layout', where=folder, advice='name one with --layout or put sensors.yaml here'
    )


def _channels(raw: RawRecording) -> set[str]:
    return {name for series in raw.accelerations for name in series.names}


def _on_one_layout(
    read: Sequence[tuple[RawRecording, GapRecord]], whole: SensorLayout, notes: list[str]
) -> tuple[list[GapRecord], SensorLayout]:
    """Return the records on all channels any of them has; each counts where it was recorded."""
    owns = [_channels(raw) for raw, _ in read]
    layout = whole.only(set.union(*owns))
    names = [channel.name for channel in layout.channels]
    some = [name for name in names if not all(name in own for own in owns)]
    if some:
        notes.append(f'not in every recording, compared where they are: {named(some)}')
    records = []
    for (_, record), own in zip(read, owns, strict=True):
        missing = tuple(n for n, name in enumerate(names) if name not in own)
        if missing:
            values = np.zeros((len(record.acceleration), len(names)))
            values[:, np.delete(np.arange(len(names)), missing)] = record.acceleration
            record = replace(record, acceleration=values, missing=missing)
        records.append(record)
    return records, layout


def _record(
    entry: CampaignEntry,
    raw: RawRecording,
    layout: SensorLayout,
    model: FlexibleJointModel,
    notes: list[str],
) -> tuple[GapRecord, RecordedMotion]:
    where = str(entry.path)
    assert raw.position is not None  # noqa: S101 - recordings without are left out
    order = _joint_order(raw.position.names, model, where)
    start, end = _stretch([*raw.accelerations, raw.position], where)
    if end - start > CAMPAIGN.longest_s:
        notes.append(f'of each recording at most the first {CAMPAIGN.longest_s:.0f} s were used')
        end = start + CAMPAIGN.longest_s
    # The slowest sensors' own samples are the grid: they need no interpolation.
    slowest = min(raw.accelerations, key=lambda item: item.rate_hz)
    rate = slowest.rate_hz
    start = slowest.start_s + np.ceil((start - slowest.start_s) * rate - 1e-6) / rate
    grid = start + np.arange(int((end - start) * rate)) / rate
    acceleration = np.zeros((len(grid), len(layout.channels)))
    names = [channel.name for channel in layout.channels]
    for item in raw.accelerations:
        columns = [names.index(name) for name in item.names]
        acceleration[:, columns] = _on_grid(item, grid, rate)
    motion = motion_on_grid(raw, raw.position, order, grid, rate)
    _check_units(motion.pose, acceleration, layout, model, where, notes)
    notes += _caveats(entry, motion, rate)
    record = GapRecord(
        name=entry.name,
        pose=motion.pose,
        level=entry.level,
        sample_rate_hz=rate,
        acceleration=acceleration,
        motor_acceleration=motion.acceleration,
        motor_velocity=motion.velocity,
        motor_shift=motion.shift,
        motion_noise=motion.noise,
        heldout=entry.heldout,
        start_s=float(start),
    )
    return record, motion


def _stretch(series: Sequence[Series], where: str) -> tuple[float, float]:
    """Return when all series are there."""
    start = max(item.start_s for item in series)
    end = min(item.end_s for item in series)
    if end - start >= CAMPAIGN.shortest_s:
        return start, end
    apart = end < start
    spans = ', '.join(f'{item.names[0]} {item.start_s:.2f}..{item.end_s:.2f} s' for item in series)
    raise RecordingError(
        'sensors and joint states were not recorded at the same time'
        if apart
        else 'too short a stretch with all sensors and joint states',
        where=where,
        found=spans if apart else f'{end - start:.2f} s',
        expected=f'>= {CAMPAIGN.shortest_s} s together',
        advice='stamp both with one clock' if apart else 'record half a minute in each pose',
    )


def _check_units(
    pose: Array,
    acceleration: Array,
    layout: SensorLayout,
    model: FlexibleJointModel,
    where: str,
    notes: list[str],
) -> None:
    """Refuse angles in degrees; note accelerations that look like multiples of g."""
    check_position_units(pose, model, where)
    first = 0
    for sensor in layout:
        mean = acceleration[:, first : first + len(sensor.axes)].mean(axis=0)
        first += len(sensor.axes)
        if len(sensor.axes) == 3 and abs(np.linalg.norm(mean) - 1.0) < CAMPAIGN.g_band:
            notes.append(f'{sensor.name} reads 1 at rest: its unit may be g instead of m/s²')


def _caveats(entry: CampaignEntry, motion: RecordedMotion, rate_hz: float) -> list[str]:
    """Return what of a recording limits the comparison."""
    found = [motion.note] if motion.note else []
    band = Band()
    high_hz = band.within(rate_hz, str(entry.path)).high_hz
    if high_hz < band.high_hz:
        found.append(
            f'compared up to {high_hz:.3g} Hz, {CAMPAIGN.usable_share:g} times the rate of the'
            ' sensors'
        )
    if rate_hz < quiet_rate_hz(band):
        found.append(
            f'sensors at {rate_hz:.4g} Hz show little above what is compared: their noise is read'
            ' among the response, and a small gap may be overlooked'
        )
    if motion.highest_hz < min(CAMPAIGN.least_band_hz, high_hz):
        found.append(f'joint states limit the comparison to {motion.highest_hz:.0f} Hz')
    begin = motion.velocity[: max(2, round(0.05 * rate_hz))]
    if np.sqrt(np.mean(begin**2)) > CAMPAIGN.at_rest * np.sqrt(np.mean(motion.velocity**2)):
        found.append('recordings begin in motion: their first seconds count as gap')
    said = entry.pose
    if said is not None and len(said) == len(motion.pose):
        away = float(np.abs(np.array(said) - motion.pose).max())
        if away > CAMPAIGN.pose_said_rad:
            found.append(
                f'{entry.name}: the joint states stand {np.degrees(away):.0f} deg away from'
                ' the pose in campaign.yaml; the joint states count'
            )
    return found


def _on_grid(item: Series, grid: Array, rate: float) -> Array:
    offset = (grid[0] - item.start_s) * item.rate_hz
    if abs(item.rate_hz / rate - 1.0) < 1e-9 and abs(offset - round(offset)) < 1e-3:
        first = round(offset)
        return item.values[first : first + len(grid)]
    return at_times(
        item.values, item.rate_hz, grid - item.start_s, highest_hz=CAMPAIGN.usable_share * rate
    )


def _joint_order(names: tuple[str, ...], model: FlexibleJointModel, where: str) -> list[int]:
    columns = joint_columns(names, model.joint_names)
    if columns is None:
        raise RecordingError(
            'joint states of another robot',
            where=where,
            found=named(names),
            expected=', '.join(model.joint_names),
        )
    return columns


def _from_the_first(records: list[GapRecord]) -> list[GapRecord]:
    """Return records whose time counts from the beginning of the first."""
    first_s = min(record.start_s for record in records)
    return [replace(record, start_s=record.start_s - first_s) for record in records]


def _with_levels(records: list[GapRecord]) -> list[GapRecord]:
    """Name levels by the size of the motion where the campaign does not."""
    if all(record.level for record in records):
        return records
    size = np.array([np.sqrt(np.mean(record.motor_acceleration**2)) for record in records])
    rank = np.round(np.log2(np.maximum(size, 1e-12) / max(float(size.max()), 1e-12)))
    return [
        replace(record, level=record.level or f'{int(value)} oct')
        for record, value in zip(records, rank, strict=True)
    ]


def campaign_layout(folder: str | Path, model: str | None) -> SensorLayout | None:
    """Return the sensor layout of a campaign that states none; None where it does.

    That which its recordings carry, else the robot's own.

    Raises
    ------
    SettingsError, LayoutError, ModelError
        It is malformed, or the robot has none.
    """
    file = read_campaign_file(folder)
    if file.layout is not None:
        return None
    for entry in (it for it in file.entries if not is_table(it.path)):
        # One that cannot be read is told when all are.
        with suppress(RecordingError):
            attachments = open_recording(entry.path).attachments()
            carried = attached_layout(attachments, str(entry.path))
            if carried is not None:
                return carried
    return None if model is None else load_layout(model)
