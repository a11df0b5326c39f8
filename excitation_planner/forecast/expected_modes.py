"""Modes that a map of the workspace expects where a plan starts, beside those of the model."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from excitation_planner.forecast.participation import ModeParticipation
from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac

Array = NDArray[np.float64]
WIDEST = 0.2
"""Distance of log f that costs as much as shapes at right angles: about that from mode to mode."""
GATE, FORBIDDEN = 1.5, 1e6
"""Largest cost of a pair: what is farther from every mode of the model is none of them."""


@dataclass(frozen=True, slots=True)
class ExpectedModes:
    """Modes expected at one pose.

    Parameters
    ----------
    joints : (n_joints,) array [rad]
        The pose, serial joints.
    frequency_hz, frequency_std_hz, damping_ratio : (n_modes,) array [Hz], [Hz], [-]
        With the deviation of the frequency.
    shapes : (n_channels, n_modes) array
        At the sensors.
    channel_names : tuple of str
        Rows of the shapes.
    """

    joints: Array
    frequency_hz: Array
    frequency_std_hz: Array
    damping_ratio: Array
    shapes: Array
    channel_names: tuple[str, ...]


def with_expected(modes: ModeParticipation, expected: ExpectedModes) -> ModeParticipation:
    """Return the model's modes with the frequencies and damping ratios that are expected.

    How joints drive a mode and sensors show it stays the model's; modes that nobody expects stay
    as they are.
    """
    frequency, damping = modes.frequency_hz.copy(), modes.damping_ratio.copy()
    for row, column in pairs(modes, expected):
        frequency[row] = expected.frequency_hz[column]
        damping[row] = expected.damping_ratio[column]
    return replace(modes, frequency_hz=frequency, damping_ratio=damping)


def pairs(modes: ModeParticipation, expected: ExpectedModes) -> list[tuple[int, int]]:
    """Return which mode of the model is which of those expected, by shape and frequency."""
    shared = [name for name in modes.channel_names if name in expected.channel_names]
    if not shared or not len(modes.frequency_hz) or not len(expected.frequency_hz):
        return []
    own = modes.response[[modes.channel_names.index(name) for name in shared]]
    told = expected.shapes[[expected.channel_names.index(name) for name in shared]]
    step = np.log(modes.frequency_hz[:, None] / expected.frequency_hz)
    cost = (step / WIDEST) ** 2 + 1.0 - mac(own, told)
    rows, columns = cheapest_pairs(np.where(cost <= GATE, cost, FORBIDDEN))
    return [
        (int(row), int(column))
        for row, column in zip(rows, columns, strict=True)
        if cost[row, column] <= GATE
    ]
