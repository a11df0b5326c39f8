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
    independent: float = 0.67
    """Independent values per bin: neighbouring Hann bins share information."""
    least_coherence: float = 1e-6
    """Below, a deviation is of no use."""


LIMITS = ComparisonLimits()
