"""What an identification found, as JSON and CSV files that other programs read."""

from collections.abc import Mapping
import csv
from dataclasses import asdict, dataclass, field, is_dataclass
from datetime import datetime, UTC
from enum import Enum
import io
import json
import math
from pathlib import Path

import numpy as np

from autonomous_modal_analysis.identified.joint_sliding import JointSliding
from autonomous_modal_analysis.identified.mode_tracks import mode_tracks
from modal_core.channel import Channel
from modal_core.files.atomic_file import write_text
from modal_core.files.version import software
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode, MODE_FIELDS, ModeSet
from modal_core.quality import DataQuality
from modal_core.window import Pose
from modal_reports import pooled, Spectrum
from oma_identifier.covariance import AnalysedBand

MODE_COLUMNS = tuple(item.name for item in MODE_FIELDS if item.single)
"""What a table says of a mode; shapes and what is made of them are no single numbers."""
CSV_COLUMNS = ('window', 'start_time_s', 'end_time_s', *MODE_COLUMNS)
NONE = ModeSet((), ())
MOST_KEPT_LINES = 1000
FORMAT_VERSION = 1
"""Of the JSON file: counts up when a program that reads it must be changed."""


@dataclass(frozen=True, slots=True)
class IdentifiedWindow:
    """Modes of one window.

    Parameters
    ----------
    index : int
        Counts windows from 0.
    start_ns, end_ns : int [ns]
        Time of the first sample and just after the last, on the clock of the stamps.
    modes : ModeSet
        With ids tracked over windows.
    quality : DataQuality
        Health of the window's data.
    harmonics : ModeSet
        Lines of machines and drives, kept out of the modes.
    pose : Pose or None
        Where the robot was; None without joint states.
    """

    index: int
    start_ns: int
    end_ns: int
    modes: ModeSet
    quality: DataQuality = field(default_factory=DataQuality)
    harmonics: ModeSet = NONE
    pose: Pose | None = None


@dataclass(frozen=True, slots=True)
class SetUps:
    """Of which set-ups modes were merged.

    Parameters
    ----------
    names : tuple of str
        Of the recordings.
    references : tuple of str
        Channels that all have.
    seen_in : tuple of tuple of str
        Per mode, the set-ups that saw it.
    read_in : tuple of tuple of str
        Per mode, the others it was read out of, pole and references known; it is NaN at points
        that neither have.
    frequency_scatter, damping_scatter : float
        Between set-ups beyond chance, as shares; the standard deviations contain it.
    """

    names: tuple[str, ...]
    references: tuple[str, ...]
    seen_in: tuple[tuple[str, ...], ...]
    read_in: tuple[tuple[str, ...], ...]
    frequency_scatter: float
    damping_scatter: float

    def words(self, mode: int) -> str:
        """Say how many saw a mode."""
        read = len(self.read_in[mode])
        seen = f'{len(self.seen_in[mode])} of {len(self.names)} set-ups'
        return f'{seen}, read out of {read}' if read else seen


@dataclass(frozen=True, slots=True)
class Identification:
    """Everything found in one recording.

    Parameters
    ----------
    modes : ModeSet
        Of the whole recording, with the ids of the windows' tracks where they agree.
    windows : tuple of IdentifiedWindow
        In order of time.
    channels : tuple of Channel
        Entries of the mode shapes.
    quality : DataQuality
        Health of the whole recording.
    settings : dataclass or mapping
        What the identifier was told and what it chose.
    harmonics : ModeSet
        Lines of machines and drives in the whole recording, kept out of the modes.
    band : AnalysedBand or None
        Where modes were looked for in the whole recording; single windows reach down to thirty
        periods at most.
    damage : tuple of str
        What of the recording could not be read or was not used, one statement each.
    remarks : tuple of str
        What should be known of it, each with a remedy; empty when settings and data fit.
    set_ups : SetUps or None
        Where several were merged.
    sliding : JointSliding or None
        What part of the time the axes slid, where joint states and the robot are known.
    """

    modes: ModeSet
    windows: tuple[IdentifiedWindow, ...] = ()
    channels: tuple[Channel, ...] = ()
    quality: DataQuality = field(default_factory=DataQuality)
    settings: object = None
    harmonics: ModeSet = NONE
    band: AnalysedBand | None = None
    damage: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    set_ups: SetUps | None = None
    sliding: JointSliding | None = None


def identification_json(identification: Identification) -> dict[str, object]:
    """Return the object of ``ama identify --json``: plain values, None where a number is unknown.

    Parameters
    ----------
    identification : Identification
        What was found.

    Returns
    -------
    dict
        Keys ``modes``, ``harmonics``, ``shape_channels``, ``band``, ``tracks``, ``windows``,
        ``channels``, ``data_quality``, ``remarks``, ``settings``; ``shape_channels`` names the
        entries of the shapes (windows have ``channels`` for that), ``data_quality`` has
        ``damage``, a list of statements, empty for a sound recording; ``set_ups`` where several
        were merged, ``sliding`` where joint states and robot tell it.
    """
    quality = {field: plain(value) for field, value in asdict(identification.quality).items()}
    return {
        'modes': [mode_json(mode) for mode in identification.modes],
        'harmonics': [mode_json(line) for line in identification.harmonics],
        'shape_channels': list(identification.modes.channel_names),
        'band': plain(identification.band),
        'tracks': [plain(track) for track in mode_tracks(identification.windows)],
        'windows': [_window(window) for window in identification.windows],
        'channels': [plain(channel) for channel in identification.channels],
        'data_quality': {**quality, 'damage': list(identification.damage)},
        'remarks': list(identification.remarks),
        'settings': plain(identification.settings) or {},
        **({'sliding': plain(identification.sliding)} if identification.sliding else {}),
        **({'set_ups': plain(identification.set_ups)} if identification.set_ups else {}),
    }


def json_text(value: object) -> str:
    """Return strict JSON (RFC 8259): no NaN, no Infinity."""
    return json.dumps(plain(value), allow_nan=False, ensure_ascii=False, indent=2) + '\n'


def file_header(format_version: int, **of: str) -> dict[str, object]:
    """Return what a file of results says of itself: its format, what it is of, when, by what."""
    return {
        'format_version': format_version,
        **of,
        'written': datetime.now(UTC).isoformat(timespec='seconds'),
        'software': software(),
    }


def write_json(
    path: Path,
    identification: Identification,
    recording: str = '',
    spectrum: Spectrum | None = None,
) -> None:
    """Write the result as JSON, whole or not at all, with where it comes from in ``file``.

    With a spectrum, ``spectrum`` holds the largest singular value [(SI unit)²/Hz] at up to a
    thousand frequencies, so that results are laid over each other without their recordings.
    """
    file = file_header(FORMAT_VERSION, recording=recording)
    found = {'file': file, **identification_json(identification)}
    if spectrum is not None and len(spectrum.frequency_hz):
        shown = pooled(spectrum, MOST_KEPT_LINES)
        found['spectrum'] = {
            'frequency_hz': [float(f'{value:.6g}') for value in shown.frequency_hz.tolist()],
            'singular_value': [float(f'{v:.4g}') for v in shown.singular_value[:, 0].tolist()],
        }
    write_text(path, json_text(found))


def write_csv(path: Path, identification: Identification) -> None:
    """Write one row per mode and window, whole or not at all; an unknown number is left empty."""
    write_text(path, csv_text(identification))


def csv_text(identification: Identification) -> str:
    """Return the modes of all windows as CSV (RFC 4180), shapes in the last columns.

    Lines of machines and drives follow the modes of their window, marked in ``harmonic``.
    """
    names = _channel_names(identification)
    parts = [(part, name) for name in names for part in ('shape_real', 'shape_imag')]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow([*CSV_COLUMNS, *(f'{part}.{name}' for part, name in parts)])
    for window in identification.windows:
        entry = _window(window)
        place = {name: index for index, name in enumerate(window.modes.channel_names)}
        for mode in (*window.modes, *window.harmonics):
            row = {'window': window.index, **entry, **mode_json(mode)}
            shape = [
                _shape_entry(row[part], place[name]) if name in place else None
                for part, name in parts
            ]
            writer.writerow([*(row[column] for column in CSV_COLUMNS), *shape])
    return text.getvalue()


def plain(value: object) -> object:
    """Return a value made of dict, list, str, int, float, bool and None only.

    Parameters
    ----------
    value : object
        Dataclasses, mappings, sequences, arrays and scalars, nested; what is not finite becomes
        None.

    Returns
    -------
    object
        Ready for strict JSON.
    """
    match value:
        case None | bool() | str():
            return value
        case Enum():
            return value.name.lower()
        case int() | np.integer():
            return int(value)
        case float() | np.floating():
            return float(value) if math.isfinite(value) else None
        case np.bool_():
            return bool(value)
        case np.ndarray():
            return plain(value.tolist())
        case Mapping():
            return {str(key): plain(item) for key, item in value.items()}
        case list() | tuple() | set() | frozenset():
            return [plain(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    return str(value)


def _window(window: IdentifiedWindow) -> dict[str, object]:
    return {
        'index': window.index,
        'start_time_s': window.start_ns / NANOSECONDS_PER_SECOND,
        'end_time_s': window.end_ns / NANOSECONDS_PER_SECOND,
        'modes': [mode_json(mode) for mode in window.modes],
        'harmonics': [mode_json(line) for line in window.harmonics],
        'channels': list(window.modes.channel_names),
        'pose': plain(window.pose),
        'data_quality': plain(window.quality),
    }


def mode_json(mode: Mode) -> dict[str, object]:
    """Return a mode or a line as plain values."""
    return {name: plain(value) for name, value in mode.values().items()}


def _shape_entry(shape: object, index: int) -> object:
    return shape[index] if isinstance(shape, list) else None


def _channel_names(identification: Identification) -> tuple[str, ...]:
    """Return every channel any window used, in order of first appearance."""
    names = dict.fromkeys(identification.modes.channel_names)
    for window in identification.windows:
        names.update(dict.fromkeys(window.modes.channel_names))
    return tuple(names)
