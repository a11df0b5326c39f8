"""A history as one table: a row per mode and window, shapes by channel."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import csv
from pathlib import Path
from typing import Any

from autonomous_modal_analysis.api.optional import optional
from autonomous_modal_analysis.results import plain
from modal_core.atomic_file import atomic_path
from modal_core.errors import SettingsError
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
        No such kind.
    ModalAnalysisError
        A library that it needs is not installed, or the history is damaged.
    """
    writers = {'.csv': _csv, '.parquet': _parquet}
    if path.suffix.lower() not in writers:
        raise SettingsError(
            'unknown kind of file',
            where=path,
            found=path.suffix or 'no ending',
            expected=', '.join(writers),
        )
    channels, joints = reader.names(asked)
    columns = _columns(channels, joints)
    n_rows, waiting = 0, []
    with atomic_path(path) as temporary, writers[path.suffix.lower()](temporary, columns) as put:
        for circumstances, window in reader.windows(asked):
            waiting += _rows(circumstances, window, channels, joints)
            if len(waiting) >= ROWS_AT_ONCE:
                put(waiting)
                n_rows, waiting = n_rows + len(waiting), []
        put(waiting)
    return n_rows + len(waiting)


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


@contextmanager
def _csv(path: Path, columns: dict[str, type]) -> Iterator[Callable[[Rows], None]]:
    """Yield what writes rows as CSV (RFC 4180); an unknown number is left empty."""
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(columns)
        yield lambda rows: writer.writerows([map(plain, row) for row in rows])


@contextmanager
def _parquet(path: Path, columns: dict[str, type]) -> Iterator[Callable[[Rows], None]]:
    """Yield what writes rows as Parquet, a group of rows at a time."""
    arrow, parquet = optional('pyarrow'), optional('pyarrow.parquet')
    kinds = {str: arrow.string(), int: arrow.int64(), float: arrow.float64(), bool: arrow.bool_()}
    schema = arrow.schema([(name, kinds[kind]) for name, kind in columns.items()])
    with parquet.ParquetWriter(path, schema, compression='zstd') as writer:

        def put(rows: Rows) -> None:
            arrays = [list(column) for column in zip(*rows, strict=True)] or [[] for _ in columns]
            writer.write_table(arrow.table(dict(zip(columns, arrays, strict=True)), schema=schema))

        yield put
