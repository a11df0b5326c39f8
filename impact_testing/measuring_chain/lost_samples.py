"""Values in a recording of taps that are no measurement: of a tap nothing can be filled in."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from oma_identifier.time_axis import FarValues, no_measurement

ADVICE = 'leave the channel out with --channels, - in its place, or cut the rows off'


def check_measured(
    path: str | Path, values: NDArray[np.float64], names: Sequence[str], units: Sequence[str]
) -> None:
    """Refuse what is no number, and what stands for samples that were lost.

    Parameters
    ----------
    path : path
        Of the recording.
    values : (n_samples, n_columns) array
        Force and responses together: a pulse is told from a spark by what answers it.
    names, units : sequence of str
        Of the columns.

    Raises
    ------
    RecordingError
        Values that are not finite, larger than anything a sensor tells, or far outside of all
        others of their column (:class:`oma_identifier.time_axis.FarValues`).
    """
    lost = np.argwhere(~np.isfinite(values))
    if len(lost):
        row, column = lost[0]
        raise RecordingError(
            'a value that is no number',
            where=f'{path}: row {row + 1}, {names[column]}',
            found=values[row, column],
            expected='finite numbers: samples of a tap cannot be filled in',
            advice=ADVICE,
        )
    rows = np.arange(len(values))
    far = no_measurement(values)
    far |= FarValues(len(names)).mark(rows, values, 0, len(values))
    columns = np.flatnonzero(far.any(axis=0))
    if len(columns):
        column = columns[0]
        place = np.flatnonzero(far[:, column])
        value, count = _commonest(values[place, column])
        also = f', also in {len(columns) - 1} more' if len(columns) > 1 else ''
        raise RecordingError(
            'values far outside of all else stand for samples that were lost',
            where=f'{path}: {names[column]}, first in row {place[0] + 1}{also}',
            found=f'{len(place)} such values, {count} x {value:.5g} {units[column]}',
            expected='what was measured: samples of a tap cannot be filled in',
            advice=ADVICE,
        )


def _commonest(values: NDArray[np.float64]) -> tuple[float, int]:
    found, counts = np.unique(values, return_counts=True)
    most = int(np.argmax(counts))
    return float(found[most]), int(counts[most])
