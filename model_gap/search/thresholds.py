"""What an effect must promise to be looked at, in one place, with source or measure."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SearchThresholds:
    """Limits of screening and of ending a search."""

    # Screening.
    largest_amplitude: float = 1.3
    """Of a screened effect, in that of its start: beyond, its derivative holds no more;
    chosen, not measured."""
    least_moved: float = 0.2
    """Of σ, rms over all data. A start that moves the prediction by less cannot gain the 12
    units that a further effect must: 300 ln(1 + 0.2²); it is made larger."""
    least_seen: float = 0.02
    """What moves it by less at its largest gains nothing at all, 0.1 units: it is not
    offered."""
    growth: float = 4.0
    """Times a start is made larger, and"""
    most_grown: int = 5
    """how often: a thousand times in all."""

    # Enough.
    further_share: float = 0.3
    """Of what is left over, which a further effect must take away."""
    least_chance: float = 2.0
    """So many standard deviations less than expected is what tolerances cost by chance at
    least."""

    # What is said of progress.
    left_at_first: float = 0.9
    """Of the whole work, before the first round, and"""
    left_after: float = 0.4
    """of that after each: what is left after a round is mostly less than it."""


SEARCH = SearchThresholds()
