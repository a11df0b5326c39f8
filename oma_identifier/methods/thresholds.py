"""Orders, lags and limits of the methods, in one place, with the reasons."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MethodThresholds:
    """What the methods beside ssi_cov decide by."""

    # Methods that solve every band afresh.
    samples_per_order: int = 20
    """Samples of the record per unit of the highest model order: higher orders would fit noise."""
    least_share: float = 0.5
    """Share of the model orders over which a mode repeats; spurious poles repeat over fewer."""
    still: float = 1e-3
    """Share of the strongest input below which another does not move in a band."""

    # Their deviations, by leaving out stretches.
    least_found: float = 0.8
    """Share of the blocks without which a pole must be found again."""
    farthest: float = 4.0
    """Half-widths from the pole within which it is looked for."""
    resonance_power: int = 4
    """Of the distance from resonance in half-widths, where the response counts for a mode's share.
    """

    resonance_reach: float = 16.0
    """Half-widths to either side of resonance that are looked at for it: beyond, a response counts
    for less than 1 / 65,000 of its amplitude."""

    # Poly-reference least squares.
    references: int = 6
    """References, where none are asked for."""
    lags: int = 512
    """Lags of the covariances, at most."""
    end_of_window: float = 0.01
    """Value of the exponential window at the longest lag."""

    # Vector autoregressive models.
    var_size: int = 90
    """Highest order times references: poles of the model.  Of 60, 90 and 120, 90 found most at its
    cost, and scattered least, on 15 random records."""
    var_fewest: int = 8
    """Least of the highest orders, so that a pole can repeat over some."""
    var_beyond: float = 1.5
    """Highest order over that of least description length, for the weak modes that it leaves out.
    """
    var_instruments: int = 20
    """Older samples that serve as instruments, at least; as the block rows of the others."""

    # Transmissibility between loading conditions.
    transfer_segments: int = 48
    """Segments of a record, which overlap by half: their length is what spectra resolve."""
    transfer_parts: int = 16
    """Parts of a record that loading conditions are made of."""
    transfer_differs: float = 4.0
    """Median of 1 - MAC between directions of two conditions, over that between the halves of a
    part, which chance gives."""

    # Frequency domain decomposition.
    most_coordinates: int = 12
    """Principal coordinates of the scaled channels that are decomposed at every frequency."""
    coordinate_lines: int = 64
    """Lines of the spectrum that share these: a whole record has more modes than coordinates."""
    segments: int = 48
    """Segments that the cross spectral density is averaged of: of 12, 24, 48 and 96 on 16 random
    chains (60 to 240 s, 90 modes) 12 found 13 false peaks, 24 four, 48 and 96 none, all 86 modes.
    """
    fewest_segments: int = 12
    """The same of short records, whose lines would lie too far apart."""
    segment_s: float = 2.0
    """Length below which segments are not cut for the sake of their number [s]."""
    significant: float = 5.0
    """Prominence of a peak of ln σ₁ over its own scatter.  It is the difference of a largest and a
    least value among many: of 12 segments 4 let 13 false peaks pass, 5 one, of 48 both none."""
    bell_mac: float = 0.8
    """Least MAC with the shape at the peak of what belongs to its bell."""
    bell_half_widths: float = 6.0
    """Half-widths of a bell, to either side, in which its damping is fitted."""


METHOD = MethodThresholds()
