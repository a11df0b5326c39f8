"""What tells lines, modes and peaks in spectra, all in one place, with source or measure."""

from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True)
class SpectraThresholds:
    """Limits of the tests for lines, of modes beside lines, and for peaks."""

    # A line of a machine or a drive.
    suspect_damping: float = 0.004
    """Poles damped less than this are suspected lines."""
    line_chance: float = 1e-6
    """Probability of calling noise a line; about 1,000 suspected frequencies are tested an
    hour."""
    sharp_line_chance: float = 1e-3
    """The same where a pole without any damping repeats over the model orders, itself rare."""
    line_stands_out: float = 50.0
    """Peak over the median around it: of 10⁶ powers of noise one is above 20."""
    line_over_bell: float = 20.0
    """The same over the median close by, from where on it is asked whether a peak is a line."""
    line_fall: float = 1e-2
    """Power of a line within six spectral lines to both sides, over that at its peak, with a
    taper."""

    # Line or mode: odds in logarithms.
    sure_line: float = math.log(100.0)
    """Log odds of line against mode from where on a line is sure: a wrong one in a hundred.  A
    record four times as long tells what this one does not: a line 10 dB above the noise of a
    segment is sure in 97 of a hundred, and a mode of ζfT = 0.05 is taken for one in 3 instead of
    53."""
    narrow_mode: float = math.log(3.0)
    """Log odds of a narrow mode from where on a response whose bell is too narrow to be seen is
    one. Of simulated lines 5 to 50 dB above the noise of a segment 0.1 of a hundred passed with 32
    segments, 2 with 12 (in records of few periods); of noise none and 1.5."""
    least_damping: float = 3e-4
    """Damping ratio below which no structure is expected; welded steel has 5e-4 and more."""

    # A mode beside lines, or their leakage.
    response_chance: float = 0.01
    """Probability that noise is taken for response, over all channels."""
    no_skirts_chance: float = 1e-4
    """Probability that a mode is taken for a line, on each flank and in each channel."""
    shown: float = 0.1
    """Share of the power in the strongest channel from where on a channel shows a mode."""
    bell_excess: float = 3.0
    """Factor by which the bell of an estimated mode may be too high on its flanks: damping off by
    two of its deviations, and the antiresonance beside a neighbour."""
    untouched: float = 0.1
    """Share of the power at a mode that is left in every channel where lines do not explain it; at
    spurious modes it was 0.06 and less in one, at modes beside a stronger one 0.3."""
    flank_share: float = 0.45
    """Share of the sample rate where flanks end: above it stand the filters before converters, as
    above the highest band that is identified."""
    least_flank: float = 0.25
    """Share of a flank that must be free of sinusoids."""
    narrow: float = 8.0
    """Half-width of a mode in spectral lines below which it could pass for a line itself."""
    resolved: float = 1.0
    """Half-width of a mode in spectral lines below which it has no bell: it looks like a
    sideband."""
    sidebands: float = 16.0
    """Spectral lines to both sides of a line in which its modulation may have such sidebands."""

    # A peak, or the edge of an excited band.
    fewest_peak_lines: int = 40
    """Spectral lines in a peak at least; narrower ones are no edges, and too few lines for the
    test."""
    fewest_edge_lines: int = 12
    """Spectral lines in a peak from where on its flanks tell an edge."""
    edge: float = 10.0
    """Ratio of the powers of all channels on the two flanks from where on they may be an
    edge's."""
    edge_block: int = 8
    """Spectral lines in the smallest block that is compared with its neighbours."""
    edge_fall: float = 32.0
    """Fall from where on an edge ends the response; single resonances fall by 9 at most.  Between
    resonances and zeros of 600 random structures, 1 to 8 channels, such a fall stood near 2 of
    3,554 modes, one of 16 near 11."""
    edge_share: float = 0.02
    """Largest block, as a share of the edge's frequency: the fourth power of the frequency changes
    by 1.4 over the fall, which leaves resonances below the limit."""
    edge_reach: float = 2.5
    """Distance from such an edge, in half-widths, within which a pole may be the edge's: of 12
    false modes in 8 records 11 lay within 1.1, one at 2.2."""
    cut: float = 0.15
    """Power above a peak, over what its bell would leave there, below which the response ends: of
    4,034 modes of 1,000 random structures, 1 to 8 channels and 1 to 3 forces, none came there."""
    no_peak: float = 0.2
    """Chance from where on there is no peak at all: a resonance comes there in one of a
    hundred."""
    unsteady: float = 0.35
    """Mean power squared over the mean of its square, from moment to moment, below which a peak
    may be that of few loud moments.  Of 10,000 modes under steady forces, of one channel and a
    half-width of 5 to 200 lines, none came there (seed 985390); one in a thousand below 0.45."""
    sure_peak_chance: float = 1e-4
    """Chance below which there is a peak for sure, whatever became of it without these moments."""
    usual_peak_chance: float = 0.02
    """Chance, with all moments counted alike, above which they had no more than noise has.  Of
    bridges crossed by vehicles and of beams tapped 1 to 15 times (seeds 985000 to 985011 each) the
    12 false modes came to 0.06 and more, 119 true ones in unsteady bands to 0.006 at most.  Of
    12 more of each (from 985200) 19 of 25 false modes were told and no true one; of 24 records of
    growing or bursting forces (`unsteady`, from 382000) none, but two weak ones of a quarter, 28 s
    long, of one of them."""


SPECTRA = SpectraThresholds()
