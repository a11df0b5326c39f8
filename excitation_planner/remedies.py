"""What would let a plan reach a mode that it is forecast to miss."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from excitation_planner.forecast import (
    analysed_hz,
    forecast,
    mode_participation,
    ModeForecast,
    ModeParticipation,
    PART_OF_BAND,
    VISIBLE_DB,
)
from excitation_planner.motion import flat_spectrum
from excitation_planner.setting import Setting
from excitation_planner.signals import BAND_LIMITED_NOISE, HIGHEST_PATH_HZ, RANDOM_PULSES
from modal_core.channel import Channel

Array = NDArray[np.float64]
# Where on a link a sensor is tried: off its joint's axis [m].
TRIED_AT_M = (0.15, 0.15, 0.15)
# Amplitudes an arm may have at most, over those of its noise: peak over rms of Gaussian noise.
CREST = 4.5


def with_cures(
    modes: tuple[ModeForecast, ...], setting: Setting, duration_s: float
) -> tuple[ModeForecast, ...]:
    """Return the forecast with what would reach each missed mode.

    In this order: a sensor where there is none that moves with the mode, another signal, more
    amplitude of the axis that drives it most, and quieter sensors; each only where the forecast
    with it is above the threshold.

    Parameters
    ----------
    modes : tuple of ModeForecast
        Of a plan.
    setting : Setting
        Its request and robot.
    duration_s : float [s]
        Its length.
    """
    if not any(mode.missed for mode in modes):
        return modes
    more = _with_noise(setting, duration_s)
    placed = _with_sensors(setting)
    return tuple(
        replace(mode, cure=_cure(mode, place, setting, more, placed)) if mode.missed else mode
        for place, mode in enumerate(modes)
    )


def _cure(
    mode: ModeForecast,
    place: int,
    setting: Setting,
    more: tuple[ModeForecast, ...],
    placed: ModeParticipation,
) -> str:
    request = setting.request
    if mode.signal_to_noise_db >= VISIBLE_DB:
        return _cure_of_edge(mode)
    seen = np.abs(placed.response[:, place])
    best = int(np.argmax(seen))
    gain_db = _seen_db(mode, float(seen[best]), request.noise_density) - VISIBLE_DB
    if gain_db >= 0.0:
        return f'a sensor on {placed.channel_names[best].split(".")[0]} would see it'
    if request.signal == RANDOM_PULSES and not more[place].missed:
        return 'band_limited_noise would reach it'
    gap_db = VISIBLE_DB - mode.signal_to_noise_db
    axis = int(np.argmax(np.abs(placed.drive[place])))
    factor = 10.0 ** (gap_db / 20.0)
    if request.signal != RANDOM_PULSES:
        rms = request.acceleration_rms * setting.weights[axis]
        wanted = factor * max(rms, 1e-9)
        name = setting.model.axis_names[axis]
        if rms > 0.0 and CREST * wanted <= setting.model.limits.acceleration[axis]:
            return f'{name} at {wanted:.2g} rad/s² would reach it'
    quiet = request.noise_density / factor
    return f'sensors of {quiet:.1g} m/s²/sqrt(Hz) would see it'


def _cure_of_edge(mode: ModeForecast) -> str:
    """Return what reaches a mode that is strong enough but too near the end of the excitation."""
    wanted_hz = np.ceil(mode.frequency_hz / PART_OF_BAND)
    if wanted_hz <= HIGHEST_PATH_HZ:
        return f'band_high_hz of {wanted_hz:g} Hz would reach it'
    return 'with max_frequency_hz stated it is looked for, beside the corner of the excitation'


def _seen_db(mode: ModeForecast, response: float, noise_density: float) -> float:
    resonance = mode.modal_force_density / (4.0 * mode.damping_ratio**2)
    return float(10.0 * np.log10(max(response**2 * resonance / noise_density**2, 1e-30)))


def _with_noise(setting: Setting, duration_s: float) -> tuple[ModeForecast, ...]:
    """Return the forecast of band-limited noise in place of the signal."""
    request = replace(setting.request, signal=BAND_LIMITED_NOISE)
    modes = mode_participation(
        setting.model, setting.start, setting.channels, request.band_high_hz
    )
    spectrum = flat_spectrum(
        request.acceleration_rms * setting.weights, (request.band_low_hz, request.band_high_hz)
    )
    edge_hz = analysed_hz(request.signal, request.band_high_hz)
    return forecast(modes, spectrum, request.noise_density**2, duration_s, edge_hz)


def _with_sensors(setting: Setting) -> ModeParticipation:
    """Return the modes as sensors on every link would see them."""
    channels = tuple(
        Channel(f'{link}.{axis}', link, TRIED_AT_M, direction)
        for link in setting.model.link_names
        for axis, direction in zip('xyz', ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0)), strict=True)
    )
    return mode_participation(setting.model, setting.start, channels, setting.request.band_high_hz)
