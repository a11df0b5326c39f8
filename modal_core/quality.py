"""What is known about the health of a window of data."""

from dataclasses import dataclass
import math

from modal_core.units import ACCELERATION


@dataclass(frozen=True, slots=True)
class ChannelQuality:
    """Health of one channel in one window.

    Parameters
    ----------
    name : str
        Channel.
    n_interpolated, n_lost, n_duplicates, n_reordered : int
        Samples filled in across short gaps; never received; dropped as repeats; put back in order.
    measured_rate_hz : float [Hz]
        From the stamps.
    jitter_std_s : float [s]
        Scatter of the stamps about a uniform grid.
    rms : float [unit]
        Of the signal without its mean.
    kurtosis : float
        Of the signal: 3 for Gaussian vibration, 1.5 for a single tone, far more for knocks; NaN
        when not known.
    noise_rms : float [unit]
        White noise in the samples, an upper bound: what vibration near half the sample rate leaves
        in second differences counts as noise.  NaN when not known.
    lag_s, lag_std_s : float [s]
        How much later than the joint states its stamps are, or else than those of the other
        sensors; NaN where nothing tells.
    since_ns : int [ns]
        Time since when it is what it is, where it changed within the record; 0: always.
    interrupted_ns : tuple of (int, int) [ns]
        From when to when it was not heard.
    far_values : tuple of (int, float, int)
        Values far outside of all others, taken as lost: since when [ns], in about a second, which
        value [unit], how often.
    unit : str
        SI unit of its samples.
    excluded : bool
        Took no part in the identification.
    flags : tuple of str
        What was found: ``flatline``, ``clipping``, ``not_finite``, ``gap``, ...
    """

    name: str
    n_interpolated: int = 0
    n_lost: int = 0
    n_duplicates: int = 0
    n_reordered: int = 0
    measured_rate_hz: float = 0.0
    jitter_std_s: float = 0.0
    rms: float = 0.0
    kurtosis: float = math.nan
    noise_rms: float = math.nan
    lag_s: float = math.nan
    lag_std_s: float = math.nan
    since_ns: int = 0
    interrupted_ns: tuple[tuple[int, int], ...] = ()
    far_values: tuple[tuple[int, float, int], ...] = ()
    unit: str = ACCELERATION
    excluded: bool = False
    flags: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class DataQuality:
    """Health of one window.

    Parameters
    ----------
    identifiable : bool
        False: no mode may be published from it.
    reason : str
        Why not; empty when identifiable.
    flags : tuple of str
        Of the window as a whole: ``degraded``, ``partial``, ``rate_change``, ``clock_jump``, ...
    channels : tuple of ChannelQuality
        One per channel that was expected.
    """

    identifiable: bool = True
    reason: str = ''
    flags: tuple[str, ...] = ()
    channels: tuple[ChannelQuality, ...] = ()
