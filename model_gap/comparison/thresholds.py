"""What a model is compared by, in one place, with source or measure."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ComparisonLimits:
    """Limits of comparing a model with recordings, without a search."""

    weak: float = 0.1
    """Share of noise in a recorded motion from which on small differences are noise.
    Chosen, not measured."""
    lost: float = 1.0
    """Share from which on nothing can be concluded: as much noise as motion."""
    near_bins: float = 1.5
    """Bins to either side of a line that are of it: what a Hann window spreads."""
    around_hz: float = 1.5
    """Around a line, to see what is there without it [Hz]. Chosen, not measured."""
    lowest_hz: float = 3.0
    """Modes are compared from here on [Hz], and"""
    highest_hz: float = 58.0
    """up to here at most: half of what joint states of 125 Hz carry, nearly."""
    most_poses: int = 4
    """Poses whose modes are compared, those told best. Chosen, not measured."""
    frequency_weight: float = 2.0
    """Of 100 % of frequency beside a MAC of 0, in pairing modes. Chosen, not measured."""
    least_mac: float = 0.4
    """Of a pair. Chosen, not measured."""
    most_off: float = 0.35
    """Of the frequencies of a pair, as a share: a joint half as stiff moves a mode by 0.29
    at most."""
    beyond: float = 1.3
    """Modes up to so many times the highest frequency take part in the fit; higher ones respond
    below as a stiffness does."""
    stands_out: float = 5.0
    """Standard deviations of chance by which a mode explains more than noise."""
    least_told: float = 0.03
    """Standard deviation of a frequency, as a share, beyond which a mode is not told.
    Chosen, not measured."""
    independent: float = 0.67
    """Independent values per bin: neighbouring Hann bins share information."""
    least_coherence: float = 1e-6
    """Below, a deviation is of no use."""


LIMITS = ComparisonLimits()
