"""A history as one table: a row per mode and window, shapes by channel."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from autonomous_modal_analysis.export.table import Column, Table
from autonomous_modal_analysis.export.table_files import export_table
from modal_core.files.version import software
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import MODE_FIELDS
from modal_history.kept import Circumstances, KeptWindow
from modal_history.reader import HistoryReader
from modal_history.selection import Selection

ROWS_AT_ONCE = 20_000
NUMBERS = tuple(item for item in MODE_FIELDS if item.kind is not complex)
TEXTS = ('robot', 'tool', 'software', 'recording', 'recording_hash', 'settings_hash')
Rows = list[list[Any]]


def export_history(path: Path, reader: HistoryReader, asked: Selection) -> int:
    """Write modes into a file of the kind its ending says, whole or not at all; return how many.

    Raises
    ------
    SettingsError
        No such kind, or one that holds no tables.
    ModalAnalysisError
        A library that it needs is not installed, or the history is damaged.
    """
    channels, joints = reader.names(asked)
    kinds, n_rows = _columns(channels, joints), 0

    def parts() -> Iterator[Sequence[Column]]:
        nonlocal n_rows
        waiting: Rows = []
        for circumstances, window in reader.windows(asked):
            waiting += _rows(circumstances, window, channels, joints)
            if len(waiting) >= ROWS_AT_ONCE:
                n_rows += len(waiting)
                yield list(zip(*waiting, strict=True))
                waiting = []
        n_rows += len(waiting)
        yield list(zip(*waiting, strict=True)) or [()] * len(kinds)

    export_table(path, Table(kinds, parts(), {'software': software()}))
    return n_rows


def _columns(channels: tuple[str, ...], joints: tuple[str, ...]) -> dict[str, type]:
    """Return the columns and their kinds."""
    parts = ('shape_real', 'shape_imag', 'shape_std_real', 'shape_std_imag')
    return {
        **dict.fromkeys(TEXTS, str),
        'window': int,
        'start_time_s': float,
        'end_time_s': float,
        'temperature_c': float,
        'load_kg': float,
        'flags': str,
        **{f'position_rad.{name}': float for name in joints},
        **{item.column: item.kind for item in NUMBERS},
        **{f'{part}.{name}': float for part in parts for name in channels},
    }


def _rows(
    circumstances: Circumstances,
    window: KeptWindow,
    channels: tuple[str, ...],
    joints: tuple[str, ...],
) -> Rows:
    at = {name: index for index, name in enumerate(window.modes.channel_names)}
    places = [at.get(name) for name in channels]
    pose = (
        dict(zip(window.pose.joint_names, window.pose.position, strict=True))
        if window.pose
        else {}
    )
    common = [
        *(getattr(circumstances, name) for name in TEXTS),
        window.index,
        window.start_ns / NANOSECONDS_PER_SECOND,
        window.end_ns / NANOSECONDS_PER_SECOND,
        window.temperature_c,
        window.load_kg,
        ' '.join(window.quality.flags),
        *(float(pose.get(name, float('nan'))) for name in joints),
    ]
    found = []
    for mode in window.modes:
        values = mode.values()
        row = [*common, *(getattr(mode, item.name) for item in NUMBERS)]
        for part in ('shape_real', 'shape_imag', 'shape_std_real', 'shape_std_imag'):
            known = values[part]
            row += [
                float('nan') if place is None or known is None else float(known[place])
                for place in places
            ]
        found.append(row)
    return found
