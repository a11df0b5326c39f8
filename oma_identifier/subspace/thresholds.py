"""Sizes of the matrices of a band, and when they are made anew, in one place, with the reasons."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SubspaceLimits:
    """Limits of the subspace identification of a band."""

    # The block Hankel matrix.
    most_references: int = 8
    """What a channel adds to so many well chosen ones is less than its cost."""
    most_outputs: int = 12
    """More channels are combined to this many outputs; mode shapes keep all channels."""
    fewest_block_rows: int = 20
    """Rows of blocks, however many the references and low the model order."""
    rows_per_order: float = 1.5
    """Rows of the block Hankel matrix (and columns) per unit of the highest model order."""
    unforeseen: float = 5.0
    """Times their scatter, as squares, by which a model of the order that such rows are for misses
    the covariances at as many lags again, from where on a whole record has twice as many rows.  Of
    397 bands of 144 records of random families 4 were missed by more (a robot's own motion, single
    channels); those of cables with 24 to 43 modes in a band by 5.6 to 55."""

    # When it is solved again.
    refreshed: float = 1.0 / 16.0
    """Share of the blocks that are new when a band is solved again."""

    # Deviations from the scatter of blocks.
    fewest_terms: int = 6
    """Cosine terms that the scatter is taken from: of six a deviation is known to 30 %."""


SUBSPACE = SubspaceLimits()
