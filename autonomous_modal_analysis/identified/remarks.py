"""What people should know of an identification and do about it, in plain lines."""

from collections import Counter
from collections.abc import Sequence
import math
from statistics import median
from statistics import mode as most_common

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.identified.results import IdentifiedWindow
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_reports import (
    count,
    far_channels,
    interrupted_channels,
    listed,
    lone_channels,
    poor_channels,
)
from oma_identifier.moving_lines import MOVING
from oma_identifier.quality import heard_to_hz
from oma_identifier.record import needed_window_s, SHORT_WINDOWS, too_slow
from oma_identifier.result import NO_MODE, ONLY_LINES, WindowResult
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import SingularValueSpectrum

ROUGH, FAIR = 1.0, 4.0
"""Damping times frequency times duration where damping scatters by 40 % at best, and where by
20 %: 1 / √(2π ζ f T), Au (2014), doi:10.1016/j.ymssp.2013.12.016."""
FAR_BELOW = 0.05
"""Share of half the sample rate."""
STANDS_OUT = 4.0
"""Power over the median of the upper half of the spectrum, which then is noise: averages of eight
segments exceed it once in 1e6 lines."""
NEAR_END = 0.86
"""Share of half the sample rate above which filters of converters leave nothing: what is largest
there was not filtered."""


def remarks(
    whole: WindowResult,
    windows: Sequence[IdentifiedWindow],
    sample_rate_hz: float,
    settings: IdentificationSettings,
) -> tuple[str, ...]:
    """Return what should be known, one line each with the remedy.

    Parameters
    ----------
    whole : WindowResult
        Of the whole recording.
    windows : sequence of IdentifiedWindow
        Of the same.
    sample_rate_hz : float [Hz]
        Of most windows.
    settings : IdentificationSettings
        That were used.
    """
    found = (
        _conditions(whole),
        _too_short_record(whole),
        _damping_without_deviation(whole),
        _crossed(whole),
        _not_heard(whole),
        _too_short_windows(whole, windows),
        _empty_windows(whole, windows),
        _odd_rate(whole, sample_rate_hz, settings),
    )
    health = [window.quality for window in windows]
    channels = (
        *poor_channels(health),
        *far_channels(health),
        *interrupted_channels(health, whole.start_ns),
        *lone_channels(health),
    )
    return (*channels, *(line for line in found if line))


def _conditions(whole: WindowResult) -> str:
    if not whole.n_conditions:
        return ''
    return f'{whole.n_conditions} loading conditions were told apart, of which two are needed'


def _too_short_record(whole: WindowResult) -> str:
    duration_s = _duration_s(whole)
    rough = [mode for mode in whole.modes if _decays(mode, duration_s) < ROUGH]
    if not rough:
        return ''
    needed_s = max(FAIR / (mode.damping_ratio * mode.frequency_hz) for mode in rough)
    unsure = ' (without σ)' if any(_is_withheld(mode) for mode in rough) else ''
    return (
        f'{_frequencies(rough)}: {duration_s:.3g} s are short for the damping{unsure}, which'
        f' scatters by 40 % or more; record {_rounded_up(needed_s)} s for 20 %'
    )


def _damping_without_deviation(whole: WindowResult) -> str:
    duration_s = _duration_s(whole)
    moving = [m for m in whole.modes if _is_withheld(m) and _decays(m, duration_s) >= ROUGH]
    if not moving:
        return ''
    return (
        f'{_frequencies(moving)}: damping without σ, for the frequency moves too far within a'
        ' window, or too many samples were filled in; shorter windows (--window-s) or a steady'
        ' structure'
    )


def _crossed(whole: WindowResult) -> str:
    """Say why modes near lines that moved have no deviation where others of the method have."""
    lines_hz = np.array([line.frequency_hz for line in whole.harmonics])
    bare = [mode for mode in whole.modes if math.isnan(mode.frequency_std_hz)]
    crossed = [mode for mode in bare if _lie_near(mode, lines_hz).any()]
    if not crossed or len(bare) == len(whole.modes):
        return ''
    near_hz = lines_hz[np.any([_lie_near(mode, lines_hz) for mode in crossed], axis=0)]
    lines = f'{count(len(near_hz), "line")} at {listed([f"{hz:.4g}" for hz in near_hz])} Hz'
    return (
        f'{_frequencies(crossed)}: without σ, for {lines} moved across; another speed of the'
        ' machine, or none, would tell it'
    )


def _not_heard(whole: WindowResult) -> str:
    """Say which sensors are too slow for some modes."""
    names = whole.modes.channel_names
    reach = heard_to_hz(names, whole.quality.channels)
    highest = max((mode.frequency_hz for mode in whole.modes), default=0.0)
    deaf = [name for name, hz in zip(names, reach, strict=True) if hz < highest]
    if not deaf:
        return ''
    return (
        f'{listed(deaf)} {"is" if len(deaf) == 1 else "are"} sampled too slowly for modes above'
        f' {reach.min():.4g} Hz, and 0 in their shapes: raise the rate'
    )


def _lie_near(mode: Mode, lines_hz: NDArray[np.float64]) -> NDArray[np.bool_]:
    reach_hz = 0.5 * MOVING.sweep * lines_hz + mode.damping_ratio * mode.frequency_hz
    return np.asarray(np.abs(lines_hz - mode.frequency_hz) < reach_hz)


def _is_withheld(mode: Mode) -> bool:
    return math.isfinite(mode.frequency_std_hz) and math.isnan(mode.damping_ratio_std)


def _too_short_windows(whole: WindowResult, windows: Sequence[IdentifiedWindow]) -> str:
    if len(windows) < 2 or SHORT_WINDOWS not in whole.quality.flags:
        return ''
    window_s = median(window.end_ns - window.start_ns for window in windows)
    window_s /= NANOSECONDS_PER_SECOND
    seen = Counter(mode.id for window in windows for mode in window.modes)
    slow = too_slow(whole.modes, window_s, lambda mode: seen[mode.id] / len(windows))
    if not slow:
        return ''
    needed_s = max(needed_window_s(mode) for mode in slow)
    them = 'it' if len(slow) == 1 else 'them'
    said = (
        f'{_frequencies(slow)}: windows of {window_s:.3g} s are too short, most do not show {them}'
    )
    if needed_s <= _duration_s(whole):
        return f'{said}; --window-s {_rounded_up(needed_s)} or more would'
    return (
        f'{said}, only the record as one does; to follow {them} over time record several times'
        f' {_rounded_up(needed_s)} s'
    )


def _empty_windows(whole: WindowResult, windows: Sequence[IdentifiedWindow]) -> str:
    if whole.n_conditions:
        return ''  # A window sees one condition.
    empty = [window for window in windows if not len(window.modes)]
    if len(windows) < 2 or 2 * len(empty) <= len(windows):
        return ''
    reason = most_common(window.quality.reason or NO_MODE for window in empty)
    remedy = {
        NO_MODE: 'longer windows (--window-s), or more excitation',
        ONLY_LINES: 'an excitation of many frequencies',
    }.get(reason, 'see the data quality in the report')
    return f'{len(empty)} of {len(windows)} windows gave no modes, mostly: {reason}; {remedy}'


def _odd_rate(whole: WindowResult, sample_rate_hz: float, settings: IdentificationSettings) -> str:
    spectrum = whole.spectrum
    if settings.max_frequency_hz is not None or len(spectrum.frequency_hz) < 2:
        return ''
    half_hz = 0.5 * sample_rate_hz
    known = [*whole.modes.frequency_hz, *whole.harmonics.frequency_hz]
    ends_hz = max([_end_of_response_hz(spectrum), *known])
    if 0.0 < ends_hz < FAR_BELOW * half_hz:
        return (
            f'the response ends at {ends_hz:.3g} Hz, far below half the sample rate of'
            f' {sample_rate_hz:.4g} Hz: is that rate right?'
        )
    power = spectrum.singular_value.sum(axis=1)
    largest_hz = spectrum.frequency_hz[int(np.argmax(power))]
    if largest_hz > NEAR_END * half_hz and power.max() > STANDS_OUT * np.median(power):
        return (
            f'the response is largest at {largest_hz:.3g} Hz, near half the sample rate of'
            f' {sample_rate_hz:.4g} Hz, and may be folded there: is that rate right? If so,'
            ' sample faster'
        )
    return ''


def _end_of_response_hz(spectrum: SingularValueSpectrum) -> float:
    """Return above which frequency nothing but noise is left."""
    power = spectrum.singular_value.sum(axis=1)
    above = power > STANDS_OUT * np.median(power[len(power) // 2 :])
    return float(spectrum.frequency_hz[np.flatnonzero(above)[-1]]) if above.any() else 0.0


def _duration_s(whole: WindowResult) -> float:
    return (whole.end_ns - whole.start_ns) / NANOSECONDS_PER_SECOND


def _decays(mode: Mode, duration_s: float) -> float:
    return mode.damping_ratio * mode.frequency_hz * duration_s


def _frequencies(modes: Sequence[Mode]) -> str:
    shown = listed([f'{mode.frequency_hz:.4g}' for mode in modes])
    return f'{count(len(modes), "mode")} at {shown} Hz'


def _rounded_up(seconds: float) -> str:
    """Return seconds with two digits, not fewer than they are."""
    digit = 10.0 ** (np.floor(np.log10(seconds)) - 1.0)
    return f'{np.ceil(seconds / digit - 1e-9) * digit:g}'
