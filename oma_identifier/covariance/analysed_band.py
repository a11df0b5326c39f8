"""The band that modes are looked for in, and what chose its upper edge.

Where an excitation that fills a band ends, the response drops: the corner looks like a mode of a
few per cent damping just below the edge.
"""

from dataclasses import dataclass, replace
import math

from oma_identifier.covariance.bands import plan_bands
from oma_identifier.covariance.thresholds import COVARIANCE
from oma_identifier.settings import IdentificationSettings

SHARP_SIGNALS = ('band_limited_noise', 'sliding_noise')
"""The one whose spectrum ends at an edge; that of random pulses falls gently."""


@dataclass(frozen=True, slots=True)
class AnalysedBand:
    """Band of one identification.

    Parameters
    ----------
    low_hz, high_hz : float [Hz]
        Its edges.
    low_from, high_from : str
        What chose them: ``data`` (rate and length), ``settings`` or ``plan`` (of the excitation).
    """

    low_hz: float
    high_hz: float
    low_from: str = 'data'
    high_from: str = 'data'


def sharp_edge_hz(signal: str, band_high_hz: float) -> float | None:
    """Return where the excitation of a plan ends; None where it does not end at an edge."""
    known = signal in SHARP_SIGNALS and math.isfinite(band_high_hz) and band_high_hz > 0.0
    return band_high_hz if known else None


def below_edge(settings: IdentificationSettings, edge_hz: float | None) -> IdentificationSettings:
    """Return settings whose band ends below the edge of the excitation, unless they state one."""
    if edge_hz is None or settings.max_frequency_hz is not None:
        return settings
    high_hz = COVARIANCE.below_edge * edge_hz
    if high_hz <= (settings.min_frequency_hz or 0.0):
        return settings
    return replace(settings, max_frequency_hz=high_hz)


def analysed_band(
    sample_rate_hz: float,
    duration_s: float,
    asked: IdentificationSettings,
    used: IdentificationSettings,
) -> AnalysedBand:
    """Return the band of a stretch.

    Parameters
    ----------
    sample_rate_hz, duration_s : float [Hz], [s]
        Of the stretch.
    asked, used : IdentificationSettings
        Before and after :func:`below_edge`.

    Raises
    ------
    IdentificationError
        The stretch is too short.
    """
    bands = plan_bands(sample_rate_hz, duration_s, used)
    low_hz, high_hz = bands[-1].low_hz, bands[0].high_hz
    stated = 'settings' if asked == used else 'plan'
    return AnalysedBand(
        low_hz=low_hz,
        high_hz=high_hz,
        low_from='settings' if low_hz == used.min_frequency_hz else 'data',
        high_from=stated if high_hz == used.max_frequency_hz else 'data',
    )
