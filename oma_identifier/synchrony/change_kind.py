"""What became of a sensor that is not what it was: turned round, turned, exchanged, amplified.

One change of a sensor does the same at all peaks; what a structure does differs from mode to mode.
"""

from collections.abc import Sequence
from itertools import pairwise
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.synchrony.course_misfit import predicted, Sensors
from oma_identifier.synchrony.peak_course import Course
from oma_identifier.synchrony.thresholds import SYNCHRONY

CHANGED = 'sensor_changed'
POLARITY = 'polarity_changed'
GAIN = 'gain_changed'
ROTATED = 'sensor_rotated'
SWAPPED = 'sensor_swapped'
SHAPE = 'shape_changed'
"""What no kind of change explains: the structure may have changed as well."""
CHANGES = frozenset({CHANGED, POLARITY, GAIN, ROTATED, SWAPPED})
"""Flags of channels."""

Complex = NDArray[np.complex128]


def change_kind(
    courses: Sequence[Course], changed: Sensors, others: Sensors, moment: int
) -> str | None:
    """Return the change that, the same at all peaks, explains how sensors went on; else None.

    Parameters
    ----------
    courses : sequence of Course
        Of the peaks.
    changed, others : sequence of int array
        Channels of the sensors that changed, and of those that did not.
    moment : int [ns]
        When.
    """
    own = np.concatenate(changed)
    shown, said = _stacked([predicted(course, own, others, moment) for course in courses])
    widths = [len(columns) for columns in changed]
    kinds = [_amplified(shown, said), _swapped(shown, said, widths), _rotated(shown, said, widths)]
    if len(courses) >= len(own) + SYNCHRONY.peaks_to_spare:
        kinds.append(_mixed(shown, said))
    least = min(left for left, _ in kinds)
    most = min(SYNCHRONY.explained * _size(shown - said), SYNCHRONY.preferred * least)
    return next((kind for left, kind in kinds if left < most), None)


def _stacked(pairs: Sequence[tuple[Complex, Complex]]) -> tuple[Complex, Complex]:
    """Return the rows of all peaks, each peak of the same power."""
    scales = [1.0 / np.sqrt(_size(shown) + _size(said) + 1e-300) for shown, said in pairs]
    shown = [scale * shown for scale, (shown, _) in zip(scales, pairs, strict=True)]
    said = [scale * said for scale, (_, said) in zip(scales, pairs, strict=True)]
    return np.concatenate(shown), np.concatenate(said)


def _amplified(shown: Complex, said: Complex) -> tuple[float, str]:
    """Return what gains leave unexplained, and what to call them."""
    gain = np.sum((said.conj() * shown).real, axis=0)
    gain /= np.sum(np.abs(said) ** 2, axis=0) + 1e-300
    return _size(shown - gain * said), POLARITY if (gain < 0.0).any() else GAIN


def _swapped(shown: Complex, said: Complex, widths: Sequence[int]) -> tuple[float, str]:
    """Return the same of an exchange of two sensors."""
    if len(widths) != 2 or widths[0] != widths[1]:
        return math.inf, SWAPPED
    return _size(shown - np.roll(said, widths[0], axis=1)), SWAPPED


def _rotated(shown: Complex, said: Complex, widths: Sequence[int]) -> tuple[float, str]:
    """Return the same of a rotation of each sensor (orthogonal Procrustes)."""
    rest = 0.0
    for first, end in pairwise(np.cumsum([0, *widths]).tolist()):
        own, other = shown[:, first:end], said[:, first:end]
        left, _, right = np.linalg.svd((other.conj().T @ own).real)
        rest += _size(own - other @ (left @ right))
    return rest, ROTATED


def _mixed(shown: Complex, said: Complex) -> tuple[float, str]:
    """Return the same of any mixture of the channels."""
    known, wanted = (np.concatenate([each.real, each.imag]) for each in (said, shown))
    return _size(shown - said @ np.linalg.lstsq(known, wanted, rcond=None)[0]), CHANGED


def _size(values: Complex) -> float:
    return float(np.sum(np.abs(values) ** 2))
