"""Joint values as people write them: turning joints in degrees, sliding ones in metres."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
TURNING, SLIDING = 'deg', 'm'


def shown(values: ArrayLike, sliding: Sequence[bool]) -> Array:
    """Return values in degrees or metres, (..., n_joints), of radians or metres.

    Parameters
    ----------
    values : (..., n_joints) array [rad], [m]
        Of joints or of controller axes.
    sliding : (n_joints,) sequence of bool
        Which of them slide.
    """
    return np.where(sliding, values, np.rad2deg(values))


def read_values(values: ArrayLike, sliding: Sequence[bool]) -> Array:
    """Return values in radians or metres: the reverse of :func:`shown`."""
    return np.where(sliding, values, np.deg2rad(values))


def unit_of(slides: bool) -> str:
    """Return the unit that values of a joint are shown in."""
    return SLIDING if slides else TURNING


def value_words(value: float, slides: bool, digits: int = 1) -> str:
    """Return a value of :func:`shown` without its unit; of metres two digits more are told."""
    return f'{value + 0.0:.{digits + 2 if slides else digits}f}'


def pose_words(values: ArrayLike, sliding: Sequence[bool], digits: int = 2) -> str:
    """Return a pose for people: ``[0.0, 90.0] deg``, or of several units ``[0.1 m, 90.0 deg]``.

    Parameters
    ----------
    values : (n_joints,) array [deg], [m]
        From :func:`shown`; of metres three digits more are told.
    sliding : (n_joints,) sequence of bool
        Which of them slide.
    digits : int
        Behind the point.
    """
    numbers = np.asarray(values, dtype=float)
    if not any(sliding):
        return f'{numbers.round(digits).tolist()} deg'
    rounded = [
        round(float(value), digits + 3 if slides else digits) + 0.0
        for value, slides in zip(numbers, sliding, strict=True)
    ]
    if all(sliding):
        return f'{rounded} m'
    both = zip(rounded, sliding, strict=True)
    return f'[{", ".join(f"{value} {unit_of(slides)}" for value, slides in both)}]'
