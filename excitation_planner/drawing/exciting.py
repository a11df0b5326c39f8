"""Noise that excites the modes that are expected, most where one would drown."""

from dataclasses import replace

import numpy as np

from excitation_planner.forecast import (
    cramer_rao_std,
    ExpectedModes,
    forecast,
    mode_participation,
    pairs,
    with_expected,
)
from excitation_planner.motion import PredictedSpectrum, raised_shape, Stretch
from excitation_planner.setting import Setting
from excitation_planner.signals import RANDOM_PULSES

STRONG = 1e9
"""Force over noise at which a mode's σ is as small as the length of the record lets it be."""
ENOUGH = 1.1
"""σ over that of a mode without noise, up to which more excitation is worth nothing."""


def exciting(setting: Setting, expected: ExpectedModes) -> Setting:
    """Return a setting whose noise is strongest where an expected mode would drown.

    A mode that stands well above the noise is known as well as the length of the record lets it
    be: where all do, nothing is changed.  A request that states a shape, or pulses, which have
    none, keep what they have.
    """
    request = setting.request
    if request.shape_gain or request.signal == RANDOM_PULSES:
        return setting
    low, high = request.band_low_hz, request.band_high_hz
    own = mode_participation(setting.model, setting.start, setting.channels, high)
    columns = dict(pairs(own, expected))
    density = (request.acceleration_rms * setting.weights) ** 2 / (high - low)
    flat = PredictedSpectrum(np.array([0.0, high]), np.tile(density, (2, 1)))
    found = forecast(
        with_expected(own, expected), flat, request.noise_density**2, request.duration_s
    )
    stretches = [
        Stretch(
            mode.frequency_hz,
            mode.damping_ratio,
            mode.frequency_std_hz
            / cramer_rao_std(
                mode.frequency_hz, mode.damping_ratio, STRONG, request.duration_s
            ).frequency_hz,
            float(expected.frequency_std_hz[columns[row]]),
        )
        for row, mode in enumerate(found)
        if row in columns
        and low <= mode.frequency_hz <= high
        and np.isfinite(mode.frequency_std_hz)
    ]
    if not any(each.shortfall > ENOUGH for each in stretches):
        return setting
    shape = raised_shape((low, high), stretches)
    changed = replace(request, shape_frequency_hz=shape.frequency_hz, shape_gain=shape.gain)
    return replace(setting, request=changed)
