"""Modes over windows: all frequencies in one chart, and a strip per mode for its small changes."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
import math

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_core.window import ModesOfWindow
from modal_reports.charts.plain_numbers import number
from modal_reports.quantities import DAMPING, FREQUENCY


@dataclass(frozen=True, slots=True)
class Strip:
    """A mode to have a strip of its own, and its true values where they are known.

    Parameters
    ----------
    mode : Mode
        Of the whole recording; the line and band of the strip.
    true_frequency_hz : float [Hz]
        NaN when not known.
    true_damping_ratio : float
        NaN when not known.
    """

    mode: Mode
    true_frequency_hz: float = math.nan
    true_damping_ratio: float = math.nan


def tracks_data(windows: Sequence[ModesOfWindow], strips: Iterable[Strip]) -> dict[str, object]:
    """Return what the charts over windows draw, times from the begin of the first window."""
    origin = windows[0].start_ns if windows else 0
    return {
        'windows': [
            {
                'index': window.index,
                'start_s': number((window.start_ns - origin) / NANOSECONDS_PER_SECOND),
                'end_s': number((window.end_ns - origin) / NANOSECONDS_PER_SECOND),
                'modes': [_mode(mode) for mode in window.modes],
            }
            for window in windows
        ],
        'strips': [
            {
                **_mode(strip.mode),
                'true_frequency_hz': number(strip.true_frequency_hz),
                'true_damping_ratio': number(strip.true_damping_ratio),
            }
            for strip in strips
        ],
    }


def _mode(mode: Mode) -> dict[str, object]:
    return {
        'id': int(mode.id),
        'frequency_hz': number(mode.frequency_hz),
        'frequency_std_hz': number(mode.frequency_std_hz),
        'damping_ratio': number(mode.damping_ratio),
        'damping_ratio_std': number(mode.damping_ratio_std),
        'harmonic': bool(mode.harmonic),
        'frequency': FREQUENCY.text(mode.frequency_hz, mode.frequency_std_hz),
        'damping': DAMPING.text(mode.damping_ratio, mode.damping_ratio_std),
    }
