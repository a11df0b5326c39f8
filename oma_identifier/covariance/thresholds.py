"""Where bands begin and end and what they are made of, in one place, with the reasons."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CovarianceLimits:
    """Limits of the analysed band, of its parts, and of the references."""

    # The band that is analysed.
    periods: float = 30.0
    """Least number of periods in the record for a frequency to be identified."""
    upper_undecimated: float = 0.45
    """Accepted poles lie below this fraction of the sample rate of the record."""
    below_edge: float = 0.95
    """Part of the excited band that is analysed; the false modes lie above 0.97 of it."""

    # Its parts, at rates of their own.
    upper: float = 0.4
    """Accepted poles lie below this fraction of the rate of a band that was decimated: up to
    there its filter is flat."""
    lower: float = 0.09
    """And above this one: the next band begins there."""
    high_pass: float = 0.03
    """Corner of a band's high-pass filter as a fraction of its sample rate."""
    fewest_samples: int = 1000
    """In a band that is split off, at its own rate."""
    seen: tuple[float, ...] = 0.25, 0.6
    """Reach of the filters below the corner of the high-pass (48 dB), and over the rate (70 dB).
    """
    decimated_pass: float = 0.4
    """Edge of the decimation filter over the new rate; what is folded lands above it."""
    attenuation_db: float = 70.0
    """Of the decimation filter: what is folded is below 1/3000 of its amplitude."""
    high_pass_order: int = 4
    """Order of the high-pass filter, Butterworth: 48 dB at a quarter of its corner."""

    # References.
    most_references: int = 12
    """What a channel adds to a dozen well chosen ones is less than what it costs."""
    lags: tuple[int, ...] = (1, 2, 3, 5, 8, 13, 21, 34)
    """Lags [samples] at which covariances tell what a channel adds: close together for fast modes,
    far apart for slow ones."""
    looked_at: int = 20000
    """Rows of a record that references are chosen by."""


COVARIANCE = CovarianceLimits()
