"""Which measured mode is which of the modes that are expected at a pose."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from modal_core.numbers.indicators import mac
from workspace_map.arm import LocalModes
from workspace_map.measured_pose import MeasuredPose

Array = NDArray[np.float64]
# MAC times likeness of frequency below which two modes are not the same: two modes that share one
# shape half and half have a MAC of 0.5 with either, at 1.5 standard deviations times 0.3.
LEAST_LIKE = 0.15
# What a model misses of log f, even where it is sure: keeps pairs from hanging on a hair.
SMALLEST_STD = 0.01


def pair(
    measured: MeasuredPose, modes: LocalModes, log_frequency_std: Array
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the measured modes that are expected ones, and which.

    Parameters
    ----------
    measured : MeasuredPose
        At the pose.
    modes : LocalModes
        Expected there.
    log_frequency_std : (n_modes,) array
        How sure their frequencies are, relative.

    Returns
    -------
    tuple of two (n_pairs,) int arrays
        Measured, expected.
    """
    like = _of_modes(measured, modes, log_frequency_std)
    rows, columns = linear_sum_assignment(-like)
    same = like[rows, columns] >= LEAST_LIKE
    return rows[same], columns[same]


def alike(measured: MeasuredPose, modes: LocalModes, log_frequency_std: Array) -> float:
    """Return how much the measured modes look like the expected ones: the number of equal ones."""
    like = _of_modes(measured, modes, log_frequency_std)
    return float(like[linear_sum_assignment(-like)].sum())


def likeness(
    measured: MeasuredPose, frequency_hz: Array, shapes: Array, log_frequency_std: Array
) -> Array:
    """Return MAC times exp(-z²/2) of each measured mode with each expected, z in log f."""
    own = measured.frequency_std_hz / measured.frequency_hz
    apart = np.log(measured.frequency_hz[:, None] / frequency_hz)
    variance = own[:, None] ** 2 + log_frequency_std**2 + SMALLEST_STD**2
    return mac(measured.shapes, shapes) * np.exp(-0.5 * apart**2 / variance)


def _of_modes(measured: MeasuredPose, modes: LocalModes, log_frequency_std: Array) -> Array:
    return likeness(measured, modes.frequency_hz, modes.channel_shapes, log_frequency_std)
