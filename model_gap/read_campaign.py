"""Read a campaign folder: recordings on one grid, known motion, poses, levels."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import SensorLayout
from modal_core.errors import RecordingError, SettingsError
from modal_core.yaml_file import load_yaml
from model_gap.campaign import Campaign, GapRecord
from model_gap.campaign_file import CampaignEntry, read_campaign_file
from model_gap.resample import at_times
from model_gap.series import gather, RawRecording, Series
from recordings import open_recording
from structural_model import FlexibleJointModel, load_layout
from structural_model.robot_files import robot_folder

Array = NDArray[np.float64]
LONGEST_S = 60.0
SHORTEST_S = 4.0
HIGHEST_MOTION_HZ = 110.0
LEAST_VELOCITY_AGREEMENT = 0.98
AT_REST = 0.3


def read_campaign(
    folder: Path,
    model: FlexibleJointModel,
    layout: SensorLayout | None = None,
    progress: Callable[[float], None] = lambda _: None,
) -> Campaign:
    """Read all recordings of a campaign.

    Parameters
    ----------
    folder : Path
        With ``campaign.yaml``, or recordings only.
    model : FlexibleJointModel
        Whose joints move.
    layout : SensorLayout or None
        Overrides the campaign's own.
    progress : callable
        Takes the fraction done.

    Raises
    ------
    SettingsError, RecordingError, LayoutError
        What is missing, and what to record.
    """
    file = read_campaign_file(folder)
    sensors = _layout(file.layout, layout, folder)
    sensors.check_links(model.link_names, model.robot_name)
    notes: list[str] = []
    raws: list[tuple[CampaignEntry, RawRecording]] = []
    for number, entry in enumerate(file.entries):
        recording = open_recording(entry.path)
        raw = gather(recording.measurements(), sensors, str(entry.path))
        raws.append((entry, raw))
        for name in raw.unknown:
            note = f'channel {name} is not in the sensor layout and was left out'
            if note not in notes:
                notes.append(note)
        progress((number + 1) / len(file.entries))
    kept = _common_layout(sensors, [raw for _, raw in raws], notes)
    records = [_record(entry, raw, kept, model, notes) for entry, raw in raws]
    return Campaign(
        records=tuple(_with_levels(records)),
        layout=kept,
        joint_names=model.joint_names,
        excitation=_excitation([raw for _, raw in raws]),
        notes=tuple(dict.fromkeys(notes)),
    )


def _layout(own: object, given: SensorLayout | None, folder: Path) -> SensorLayout:
    if given is not None:
        return given
    if isinstance(own, Path):
        return SensorLayout.from_mapping(load_yaml(own), str(own))
    if isinstance(own, Mapping):
        return SensorLayout.from_mapping(own, str(folder / 'campaign.yaml'))
    raise SettingsError(
        'no sensor layout', where=folder, advice='name one with --layout or put sensors.yaml here'
    )


def _common_layout(
    layout: SensorLayout, raws: list[RawRecording], notes: list[str]
) -> SensorLayout:
    """Keep the channels every recording has."""
    sets = [{name for series in raw.accelerations for name in series.names} for raw in raws]
    common = set.intersection(*sets)
    if not common:
        raise RecordingError(
            'recordings have no sensor in common',
            advice='record all poses and levels with the same sensors',
        )
    lost = sorted(set.union(*sets) - common)
    if lost:
        notes.append(f'left out, not in every recording: {", ".join(lost[:12])}')
    sensors = []
    for sensor in layout:
        axes = tuple(axis for axis in sensor.axes if f'{sensor.name}.{axis}' in common)
        if axes:
            sensors.append(replace(sensor, axes=axes))
    return SensorLayout(tuple(sensors), layout.name)


def _record(
    entry: CampaignEntry,
    raw: RawRecording,
    layout: SensorLayout,
    model: FlexibleJointModel,
    notes: list[str],
) -> GapRecord:
    where = str(entry.path)
    if raw.position is None:
        raise RecordingError(
            'no joint states: the motion is not known',
            where=where,
            advice='record sensor_msgs/JointState beside the accelerations',
        )
    chosen = [item for item in raw.accelerations if _uses(item, layout)]
    start = max(item.start_s for item in (*chosen, raw.position))
    end = min(item.end_s for item in (*chosen, raw.position))
    if end - start < SHORTEST_S:
        raise RecordingError(
            'too short a stretch with all sensors and joint states',
            where=where,
            found=f'{max(end - start, 0.0):.2f} s',
            expected=f'>= {SHORTEST_S} s',
        )
    if end - start > LONGEST_S:
        notes.append(f'of each recording at most the first {LONGEST_S:.0f} s were used')
        end = start + LONGEST_S
    rate = min(item.rate_hz for item in chosen)
    grid = start + np.arange(int((end - start) * rate)) / rate
    acceleration = np.empty((len(grid), len(layout.channels)))
    names = [channel.name for channel in layout.channels]
    for item in chosen:
        columns = [number for number, name in enumerate(item.names) if name in names]
        values = _on_grid(item, item.values[:, columns], grid, rate)
        acceleration[:, [names.index(item.names[column]) for column in columns]] = values
    return _with_motion(entry, raw, model, grid, rate, acceleration, notes)


def _uses(item: Series, layout: SensorLayout) -> bool:
    names = {channel.name for channel in layout.channels}
    return bool(names & set(item.names))


def _on_grid(item: Series, values: Array, grid: Array, rate: float) -> Array:
    offset = (grid[0] - item.start_s) * item.rate_hz
    if abs(item.rate_hz / rate - 1.0) < 1e-9 and abs(offset - round(offset)) < 1e-3:
        first = round(offset)
        return values[first : first + len(grid)]
    return at_times(values, item.rate_hz, grid - item.start_s, highest_hz=0.45 * rate)


def _with_motion(
    entry: CampaignEntry,
    raw: RawRecording,
    model: FlexibleJointModel,
    grid: Array,
    rate: float,
    acceleration: Array,
    notes: list[str],
) -> GapRecord:
    position = raw.position
    assert position is not None  # noqa: S101  checked by the caller
    order = _joint_order(position.names, model, str(entry.path))
    values = position.values[:, order]
    times = grid - position.start_s
    pose = values.mean(axis=0)
    highest = min(HIGHEST_MOTION_HZ, 0.45 * position.rate_hz, 0.45 * rate)
    if highest < 55.0:
        notes.append(
            f'joint states at {position.rate_hz:.0f} Hz limit the band to {highest:.0f} Hz'
        )
    shift = at_times(values - pose, position.rate_hz, times, highest_hz=highest)
    speed = at_times(values - pose, position.rate_hz, times, 1, highest)
    rise = at_times(values - pose, position.rate_hz, times, 2, highest)
    if raw.velocity is not None:
        recorded = raw.velocity.values[:, order]
        told = at_times(recorded, position.rate_hz, times, 0, highest)
        if _agree(told, speed):
            speed, rise = told, at_times(recorded, position.rate_hz, times, 1, highest)
        else:
            notes.append('recorded joint velocities contradict the positions and were not used')
    begin = speed[: max(2, round(0.05 * rate))]
    if np.sqrt(np.mean(begin**2)) > AT_REST * np.sqrt(np.mean(speed**2)):
        notes.append('recordings begin in motion: their first seconds count as gap')
    return GapRecord(
        name=entry.path.name,
        pose=pose,
        level=entry.level,
        sample_rate_hz=rate,
        acceleration=acceleration,
        motor_acceleration=rise,
        motor_velocity=speed,
        motor_shift=shift,
        heldout=entry.heldout,
    )


def _joint_order(names: tuple[str, ...], model: FlexibleJointModel, where: str) -> list[int]:
    if all(name in names for name in model.joint_names):
        return [names.index(name) for name in model.joint_names]
    raise RecordingError(
        'joint states of another robot',
        where=where,
        found=', '.join(names),
        expected=', '.join(model.joint_names),
    )


def _agree(told: Array, derived: Array) -> bool:
    moving = derived.std(axis=0) > 1e-6
    if not moving.any():
        return False
    pairs = [
        np.corrcoef(told[:, number], derived[:, number])[0, 1] for number in np.flatnonzero(moving)
    ]
    ratio = told[:, moving].std(axis=0) / derived[:, moving].std(axis=0)
    return min(pairs) > LEAST_VELOCITY_AGREEMENT and bool(np.all(np.abs(ratio - 1.0) < 0.1))


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


def _excitation(raws: list[RawRecording]) -> str:
    return (
        'joint velocities' if all(raw.velocity is not None for raw in raws) else 'joint positions'
    )


def campaign_layout(folder: Path, model: str) -> SensorLayout | None:
    """Return the robot's own sensor layout when the campaign brings none."""
    if read_campaign_file(folder).layout is not None:
        return None
    path = Path(model)
    home = path.parent if path.is_file() else robot_folder(model)
    return load_layout(home)
