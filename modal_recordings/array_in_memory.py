"""An array in memory as a recording."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from modal_core.errors import RecordingError
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.tables import (
    Advice,
    array_table,
    ArrayOptions,
    ArrayTable,
    checked_names,
    checked_rate,
)

ADVICE = Advice(
    rate='sample_rate_hz=..., or a column named "time [s]"',
    columns='say what every column is: channel_names=["time [ms]", "index", "a [g]", "-"];'
    ' - leaves it out',
    unit='unit=...',
)


def array_recording(
    array: Any,
    sample_rate_hz: float | None = None,
    channel_names: Sequence[str] | None = None,
    unit: str | None = None,
    name: str = 'array',
) -> ArrayRecording:
    """Return an array as a recording.

    Parameters
    ----------
    array : (n_samples, n_channels) or (n_samples,) array_like
        Accelerations; the columns of a pandas DataFrame name the channels.
    sample_rate_hz : float [Hz] or None
        Rate of the rows; None: from a column that is named a time.
    channel_names : sequence of str or None
        One per column, with or without its unit; ``-`` leaves a column out.
    unit : str or None
        Of the values (m/s^2, g, mg, ...); None: m/s², unless the names say.
    name : str
        Named in errors.

    Raises
    ------
    RecordingError
        Not real numbers, the wrong orientation, no rate, a column that counts up as times do, a
        value that is not finite, an unknown unit.
    """
    where = Path(name)
    options = ArrayOptions(
        sample_rate_hz=None if sample_rate_hz is None else checked_rate(sample_rate_hz, where),
        unit=unit,
        channels=None if channel_names is None else checked_names(_listed(channel_names), where),
        advice=ADVICE,
    )
    return ArrayRecording(where, _table(array, where), options)


def _listed(names: Sequence[str]) -> object:
    """Return any iterable of names, such as the columns of a table, as a list."""
    return list(names) if isinstance(names, Iterable) and not isinstance(names, str) else names


def _table(array: Any, where: Path) -> ArrayTable:
    if isinstance(array, str | Path):
        raise RecordingError(
            'a name, not an array', where=where, found=array, advice='open a file with ama.open'
        )
    if np.ma.is_masked(array):
        raise RecordingError(
            'masked values', where=where, expected='a number for every sample of every channel'
        )
    try:
        values = np.asarray(array)
    except (ValueError, TypeError) as error:
        raise RecordingError('not an array', where=where, found=error) from error
    table = array_table(values, where)
    columns = getattr(array, 'columns', None)
    if columns is None or not all(isinstance(column, str) for column in columns):
        return table
    return ArrayTable(table.values, headings=tuple(columns))
