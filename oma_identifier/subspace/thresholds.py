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
    the covariances at as many lags again, from where on a whole record may have twice as many rows
    and twice the order.  Of 397 bands of 144 records of random families 4 were missed by more (a
    robot's own motion, single channels); those of cables, bridges and plates with more than 20
    modes in a band by 2.6 to 67.  At 2.5 the motion of a robot has 8 false modes more in 40
    records, which weighs more than what some dense bands would gain."""
    foreseen_less: float = 0.7
    """Share that is missed of the later covariances, up to where they are taken for modes."""
    rings_on: float = 14.0
    """Times their scatter, as squares, from where on later covariances are of modes even where
    hardly any are foreseen.  Five of 40 dense bands were missed by more than the share above, with
    14 to 69 here; of five bands of motion that twice the rows harmed four, with 6 to 11."""
    left_out: float = 2.0
    """Times that by chance, of the singular value just above an order with room to spare, from
    where on there are twice as many rows and twice the order.  Of 279 bands of records of random
    families with up to 25 modes 4 had more, all of 19 or more modes; of 270 bands of windows 8,
    of two such records; the others at most 1.5.  In 17 records of 24 to 60 modes that were below
    4.0 at the highest order itself, as asked before, 5 modes more of 230 are found and 5 false
    ones instead of 8.  Windows of 60 s of 25, 30, 35 and 40 modes show 25, 29, 33 and 38 of them
    instead of 23, 22, 21 and 20."""
    spans_between: int = 4
    """Spans of a sliding window after which it is asked again: it costs as much as a solution."""

    # Canonical variates.
    least_white: float = 1e-3
    """Power added to past and future before they are made white, over their mean.  Of 325 modes of
    40 random crowds 307 were found with 1e-4, 308 with 1e-3, 307 with 0.01 and 305 with 0.1."""
    canonical_samples: float = 10.0
    """Samples of a record per row of the matrix: of fewer every past foresees every future."""

    # When it is solved again.
    refreshed: float = 1.0 / 16.0
    """Share of the blocks that are new when a band is solved again."""

    # Deviations from the scatter of blocks.
    fewest_terms: int = 6
    """Cosine terms that the scatter is taken from: of six a deviation is known to 30 %."""


SUBSPACE = SubspaceLimits()
