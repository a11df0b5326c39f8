"""What a band of the likelihood is made of, and what is assumed before the data, in one place."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LikelihoodThresholds:
    """Limits of bands, of what goes into their models, and the scales of the priors.

    Reaches and widths are in half-power half-widths.
    """

    # Which modes and frequencies make a band.
    reach: float = 8.0
    """Reach of a band on both sides of a mode; a half-width counts one spectral line at least."""
    reach_of_one_channel: float = 40.0
    """Of several channels, what they do not have in common tells the noise; of one, only what is
    far from its modes does.  There cannot be less than none, and where it is told badly damping
    comes out too small: mean error of ζ over σ with 8, 20 and 40, of one mode (60 records of
    60 s) -0.85 ± 0.13, -0.51 and -0.15, the scatter a third less; of four modes (30 records)
    -0.49 ± 0.11, -0.04 and 0.11."""
    least_reach: float = 2.0
    """To which bands of overlapping modes are narrowed; nearer, a frequency is always the
    mode's."""
    most_modes: int = 4
    """Modes estimated jointly; a longer chain of overlapping bands is narrowed until it breaks."""
    lowest_share: float = 0.3
    """A band does not reach below this share of its lowest natural frequency."""
    highest_share: float = 0.435
    """Share of the sample rate up to which lines are used: above, anti-aliasing filters shape the
    spectrum."""
    line_reach: int = 4
    """Frequencies left out on both sides of a harmonic."""
    least_lines_per_mode: int = 12
    """Fewer frequencies of a band do not determine its modes, with shapes, forces and noise."""
    averages_per_half_width: float = 4.0
    """Averaging over the half-width of a peak/4 loses no information on it."""
    averages_per_distance: float = 6.0
    """Nor does averaging over the distance to it/6, unless the response turns meanwhile."""
    turned: float = 0.05
    """Part of an average over what is expected of it that may be due to its width.  Under one
    force it is 0.5 to 4 before averages are divided, under forces of full rank below 0.4 and
    mostly below 0.05; lower limits left coverage as it was (50 modes: 96 % of 2 σ)."""
    most_divisions: int = 2
    """Times that averages are divided; four find no mode more."""
    coarse_parts: int = 2
    """Parts that the averages of a band may still want to be divided into.  At noise 60 dB below
    one force more were wanted, and 7 % of shapes were off by five times their loss of MAC."""

    # What is published of a fit.
    least_scatter: float = 1.1
    untold_cycles: float = 0.1
    """Least deviation over that of the law, and what is added to its ζfT there: what a record does
    not rule out.  In 154 records of random families 2σ covered 97 ± 2 instead of 90 ± 3 % of 129
    frequencies with ζfT below 1, refined or not, and 92 ± 2 instead of 87 ± 3 % of 134 damping
    ratios of 1 to 50 that were not refined.  Higher values widened what was right."""
    told_cycles: float = 1.0
    """ζfT from where on a damping ratio has a deviation; below, 2σ covered 15 of 19 refined
    ones."""

    # Which known inputs take part.
    known_chance: float = 1e-4
    """Probability that inputs which have nothing to do with the responses explain so much of
    them."""
    known_rounds: int = 3
    """Fits with known inputs, between which what the ends of the record do is estimated anew."""

    # Which combinations of channels it is fitted to.
    few_channels: int = 12
    """So few channels are not reduced: all modes are in the model."""
    strong: float = 2.0
    """Power over that of the noise, of a direction in which the band's own modes move."""
    common_power: tuple[float, ...] = (2.0, 1.2)
    """Power over that of the noise, of a direction common to the channels: first while their noise
    is of different power, then afterwards."""
    least_across: float = 0.02
    """Least share of a channel's noise across these directions."""

    # What modes beside it do there.
    least_tail: float = 0.3
    """Least part of a shape beside the band that is projected out, times its tail over the
    noise."""
    least_part: float = 0.15
    """The same of unit length."""
    least_visible: float = 0.3
    """Least length a unit shape keeps across the shapes of the other modes."""
    least_remainder: float = 1.0
    """Part of a tail, over the noise, that is left after projecting out and goes into the
    model."""
    most_tails: int = 14
    """Modes beside the band in its model where none is projected out.  On 14 random
    records 115 modes were refined with 9, 121 with 14 and 121 with 20, which costs more."""
    most_root_parameters: int = 700
    """Real and imaginary parts of what few forces do to modes and residuals; of more such a fit
    takes longer than all else (three of a crowd 49 s of 65).  What it ever told was of 3 or 4
    forces, 12 modes and 15 channels: up to 336."""
    most_coherent: int = 30
    """Modes beside the band in its model where few forces drive them all."""
    most_remainders: int = 4
    """Remainders in the model where the others are projected out."""

    # How many forces drive them.
    quiet_blocks: float = 0.25
    turning_blocks: float = 0.5
    """Share of the blocks of a band that are taken to hold less noise, and fewer forces."""

    # What is assumed before the data.
    root_variance: float = 10.0
    """Of an entry of the root of few forces, over the force of its mode."""
    noise_log_std: float = 1.0
    """Standard deviation of the logarithm of the noise."""
    slope_std: float = 1.0
    """Standard deviation of the exponent of the force density: 3 dB per octave."""
    steep: float = 4.0
    """Deviations of a slope from none, assumed and estimated together, from where on a force is
    steep: one band in 16,000 by chance.  At 3 a band that lacked a mode seemed to be."""
    integrated_twice: float = 4.0
    """Exponent of a force density where displacements are called accelerations: no end of it."""
    slope_reach: float = 1.0
    """Distance in ln f over which the slope changes: an octave and a half."""
    complexity: float = 0.25
    """Standard deviation of the imaginary part of a shape of unit length: MPC 0.78."""

    # What a fit must give.
    misfit_chance: float = 1.5
    """Standard deviations of the misfit that are left to chance."""
    separable: float = 0.1
    """Least singular value, of the largest, of shapes that are told apart."""
    converged_change: float = 0.01
    """Change of the log-likelihood at which no parameter moves by more than 0.14 of its
    deviation."""
    least_power: float = 0.01
    """Share of the noise that forces of tails below zero must leave."""
    least_length: float = 0.1
    """Part of a shape that new coordinates see; less of it says nothing about the force."""


LIKELIHOOD = LikelihoodThresholds()
