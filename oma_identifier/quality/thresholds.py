"""What tells that samples are no measurements, in one place, with source or measure."""

from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True)
class QualityThresholds:
    """Limits of the tests of single channels, fault by fault."""

    # Figures of a window.
    clipped_share: float = 1e-3
    """Share of samples at the very same extreme value that only a limit can cause."""
    clipped_at_least: int = 8
    """Samples at an extreme value, however short the window; a Gaussian has its largest value
    once."""
    steeper_than_tone: float = 2.5
    """Samples at the largest value of a coarse converter over those at the next; of a sine at most
    1 / (√2 - 1) = 2.4."""
    clipped_harms: float = 5e-3
    """Share of clipped samples above which a channel takes no part. With all channels of 20 random
    chains clipped in 0.25 % of the samples, and of 12 in 1 %, modes, their errors and deviations
    were those of the samples before; with 1.2 % in one channel a false mode was seen."""
    flat_share: float = 0.1
    """Share of the window without any change of value."""
    impulsive_kurtosis: float = 30.0
    """Kurtosis of a channel with knocks: a tone has 1.5, random vibration 3, and of n samples of
    it the estimate scatters by √(24 / n), 0.1 of 2,400."""

    # Channels with the samples of another.
    copied_roundings: float = 4.0
    """Roundings of the largest value by which copies may differ once both were put on one grid:
    in single precision 5e-7 of it, where noise of one step of 20 bits takes two channels farther
    apart at some sample of any window."""

    # Channels far smaller or larger than the others.
    small_factor: float = 500.0
    """Times that a channel is smaller than the median of its kind: half of what milli makes. Of
    4000 random structures each, 0.3 % of drawn shapes, 0.2 % of cantilevers with sensors anywhere
    and 0.8 % of those with one or two modes have such a channel by nature, chains and beams on
    two supports none; of channels with a factor of 1000 it finds 78 to 98 %.  Of 16,000 structures
    none has a channel so many times larger; of those in a unit 1000 times too large it finds 70 to
    90 %, all but those of few channels, one of which is at rest."""
    mostly_noise: float = 0.8
    """Share of the rms that white noise may be: of noise alone the estimate is 1, within 0.1."""
    fewest_alike: int = 3
    """Channels of a kind whose median tells what is usual."""

    # Values that are no new measurements.
    held_share: float = 0.01
    """Share of samples that were held: noise of at most 2 % of the channel's power."""
    held_at_least: int = 8
    """The same in samples, of a short window."""
    longest_held: int = 15
    """Samples; what stands still longer is a flat line or a quiet channel."""
    large_change: float = 4.0
    """Converter steps. As many samples change by one to four steps, up or down, as eight times
    those that do not change at all, or more, as long as changes spread over a step and a half:
    three times as many where they spread over one."""
    float_steps: float = 5e-7
    """Rounding of a second difference in single precision, of the largest value."""
    flat_at_least: int = 16
    """Equal values in a row, at least, of a channel that froze: one more than may be held."""
    flat_range: float = 16.0
    """Converter steps a channel moves over before it freezes; one that dies away moves over fewer.
    """
    flat_chance: float = 1e-9
    """Probability of a run of equal values, by the share of equal ones before it, at which it is
    one that froze: at 4 kHz and 100 channels one in forty minutes is left to the range."""

    # Overflows of a converter.
    large_step: float = 0.6
    """Of the range: where no neighbours are farther apart there is no overflow to look for."""
    nearly_the_range: float = 0.7
    """Of the range: an innovation that adding the range makes smaller by more than half."""
    large_before: float = 0.4
    """Of the range: what is predicted from such a sample says nothing of the next."""
    end: float = 0.1
    """Of the range: what lies at either end."""
    most_at_the_ends: float = 0.35
    """Share of the samples at both ends: a tone has 0.41, a square wave all, and leaps without
    fault; what wraps has less than 0.25."""
    fewest_at_an_end: float = 0.007
    """Share of the samples at one end. What wraps goes on there (a Gaussian that wraps beyond
    three standard deviations: 0.008); single knocks fill no end."""
    often_at_an_end: float = 0.04
    """The same from where on overflows follow one another so closely that large innovations before
    one are no objection."""
    fewest_overflows: int = 2
    """A single leap may be a knock."""
    beyond: tuple[float, ...] = (0.2, 0.7)
    """Median distance of predictions from the middle, of the range: overflows are measured to
    begin 0.22 to 0.64 away, knocks nearer, and what a model cannot follow is farther."""
    overflow_chance: float = 1e-4
    """Probability that predictions amid knocks, anywhere among the values, lie so near an end."""

    # A sign that is missing.
    near_zero: float = 0.1
    """Of the standard deviation: a Gaussian without sign has 0.048 of its samples so near to zero.
    """
    touching_share: float = 0.02
    """Share of the samples so near to zero, at least; less than half of what a Gaussian has."""
    one_sided: float = 4.0
    """Times as many samples lie near zero as near the other end; of a healthy channel whose offset
    happens to be its amplitude as many (a Gaussian without sign: above ten)."""
    coarse_levels: int = 24
    """Values of a channel: few steps of a converter touch zero, and leap, without any fault."""

    # Rows in reversed order.
    fewest_blocks: int = 4
    """Blocks in what is looked at together, so that their length recurs."""
    largest_power: float = 50.0
    """Of the median power: a knock is not the whole course."""
    recurrence: float = 8.0
    """Standard deviations of the autocorrelation of white noise: below, nothing recurs and no
    block is turned round."""
    less_power: float = 1.05
    """Times the power of the innovations falls when blocks are turned round."""
    recurrence_left: float = 0.25
    """Share of the recurrence that may be left."""
    recurs_alike: float = 0.5
    """Share of the strongest recurrence from where on a length is tried as well."""

    # Where the watch looks.
    fewest_rows: int = 512
    """Rows at the end of a window that tell something."""
    lost_step: float = 1.5
    """Steps between stamps, in the usual one, from where on a sample is missing."""
    smallest_range: float = 1e-100
    """A range below is of no sensor, and its square no number."""
    largest_value: float = 1e100
    """A value beyond is of no sensor, and its square no number."""

    # Samples that were filled in.
    most_filled: float = 0.2
    """Share of samples filled in up to which damping keeps to its deviation: up to 0.2 none of 601
    estimates was beyond three deviations, at 0.35 4 of 149, at 0.5 20 of 151 (10 random
    structures, all sensors losing alike). Frequencies keep to theirs throughout."""
    unsure_windows: float = 0.25
    """Share of such windows that makes a record unsure."""

    # Gravity.
    least_factor: float = math.sqrt(2.0)
    """By which a wrong length is off: offsets of plain MEMS accelerometers, up to 250 mg by their
    data sheets, stay below."""
    least_gravity_m_s2: float = 3.0
    """Below, there may be no more than the offset of an amplifier."""
    g_error: float = 0.1
    """Share by which gravity in g may be off, so that no offset is taken for it."""


QUALITY = QualityThresholds()
