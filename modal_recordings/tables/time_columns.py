"""Times of rows from columns of dates, times of day, whole seconds and their remainders."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_recordings.tables.time_text import DAY_S, HOUR_S


def combined(
    path: Path, first: NDArray[np.float64], second: NDArray[np.float64], advice: str
) -> NDArray[np.float64]:
    """Add a date and a time of day, or whole seconds and what is left of them.

    Raises
    ------
    RecordingError
        Neither refines the other: which of them is meant?
    """
    for whole_s in (DAY_S, 1.0):
        for coarse, fine in ((first, second), (second, first)):
            if not np.any(np.mod(coarse, whole_s)) and fine.min() >= 0.0 and fine.max() < whole_s:
                return coarse + fine
    raise which_time(path, 2, advice)


def which_time(path: Path, n_times: int, advice: str) -> RecordingError:
    """Return the question which of several times is meant."""
    return RecordingError('which of the times?', where=path, found=f'{n_times}', advice=advice)


def past_midnight(time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Let times of day run on over midnight, those of an hour over the full hour."""
    for period_s in (DAY_S, HOUR_S):
        falls = np.diff(time_s) < -0.9 * period_s
        if time_s.min() >= 0.0 and time_s.max() <= period_s and falls.any():
            time_s = time_s + period_s * np.concatenate(([0.0], np.cumsum(falls)))
    return time_s
