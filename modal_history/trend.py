"""One mode over time, with what its frequency depends on."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
COLUMNS = (
    'frequency_hz',
    'frequency_std_hz',
    'damping_ratio',
    'damping_ratio_std',
    'temperature_c',
    'load_kg',
)


@dataclass(frozen=True, slots=True)
class Trend:
    """Estimates of one mode by time; what is not known is NaN.

    Parameters
    ----------
    id : int
        Of the mode, robot by robot.
    time_ns : (n,) array of int [ns]
        Ends of the windows.
    frequency_hz, frequency_std_hz : (n,) arrays [Hz]
        Natural frequency and its standard deviation.
    damping_ratio, damping_ratio_std : (n,) arrays
        The same of damping.
    temperature_c, load_kg : (n,) arrays [°C], [kg]
        As they were in the window.
    position : (n, n_joints) array [rad]
        Mean position of the joints; no columns where it is never known.
    start_ns : (n,) array of int [ns]
        Begins of the windows.
    """

    id: int
    time_ns: NDArray[np.int64]
    frequency_hz: Array
    frequency_std_hz: Array
    damping_ratio: Array
    damping_ratio_std: Array
    temperature_c: Array
    load_kg: Array
    position: Array
    start_ns: NDArray[np.int64]

    def __len__(self) -> int:
        """Return the number of estimates."""
        return len(self.time_ns)

    def rows(self, places: NDArray[np.int64]) -> 'Trend':
        """Return some of the estimates."""
        names = (item.name for item in fields(self) if item.name != 'id')
        return replace(self, **{name: getattr(self, name)[places] for name in names})


def trend_of(number: int, rows: Sequence[tuple[object, ...]]) -> Trend:
    """Return a trend from rows of begin, end, position and :data:`COLUMNS`.

    Raises
    ------
    ValueError, TypeError, OverflowError
        No program of the suite has written them.
    """
    starts, ends, places, *columns = zip(*rows, strict=True)
    values = {
        name: np.array([math.nan if v is None else v for v in column], dtype=float)
        for name, column in zip(COLUMNS, columns, strict=True)
    }
    return Trend(
        id=number,
        time_ns=np.array(ends, dtype=np.int64),
        start_ns=np.array(starts, dtype=np.int64),
        position=_positions(places),
        **values,
    )


def nothing(number: int) -> Trend:
    """Return the trend of a mode without estimates."""
    none, times = np.empty(0), np.empty(0, dtype=np.int64)
    values = dict.fromkeys(COLUMNS, none)
    return Trend(id=number, time_ns=times, start_ns=times, position=np.empty((0, 0)), **values)


def _positions(places: Sequence[object]) -> Array:
    """Return joint positions as rows; of robots with another number of joints NaN."""
    sizes = [len(place) // 8 for place in places if isinstance(place, bytes)]
    n_joints = max(set(sizes), key=sizes.count) if sizes else 0
    unknown = np.full(n_joints, math.nan).tobytes()
    return np.frombuffer(
        b''.join(
            place if isinstance(place, bytes) and len(place) == len(unknown) else unknown
            for place in places
        ),
        '<f8',
    ).reshape(len(places), n_joints)
