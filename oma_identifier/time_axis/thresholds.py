"""Which stamps, counts and gaps are believed, in one place, with the reasons."""

from dataclasses import dataclass

from modal_core.measurements import NANOSECONDS_PER_SECOND


@dataclass(frozen=True, slots=True)
class TimeAxisLimits:
    """Limits of what makes a time axis, from a message that comes to a lattice of samples."""

    # Messages that nothing confirms yet.
    confirm: int = 10
    """Consistent messages that confirm one another: so many false ones in a row that also follow
    one another are taken for a clock that was set."""
    most_runs: int = 8
    """Runs that wait at a time; of more, the oldest goes."""
    most_waiting_bytes: int = 64 * 2**20
    """Memory for what waits."""
    reorder_ns: int = NANOSECONDS_PER_SECOND
    """Samples this late are still put in place."""
    forward_ns: int = 2 * NANOSECONDS_PER_SECOND
    """A stamp further ahead than this must be confirmed by the next ones."""

    # Whether the declared rate of blocks is possible.
    fewest_blocks_for_rate: int = 3
    """Blocks that tell a rate, when they span long enough."""
    least_span_s: float = 0.2
    """Hosts stamp blocks up to 0.1 s late (``stamp_error_ns``): shorter spans tell no rate."""
    enough_span_s: float = 1.0
    """Over a second few blocks tell a rate."""
    longest_wait_s: float = 30.0
    """That others wait for blocks to be confirmed, however long these claim to be."""
    largest_step_s: float = 0.25
    """Beside the length of a block: what a host's stamps may be off, with room; longer gaps than
    that split a record (``longest_filled_s``)."""
    contradiction_s: float = 2.0
    """Span from where on a rate that is not possible is refused at once: over 2 s stamps 0.1 s
    late tell a rate to 5 %."""
    largest_factor: float = 2.5
    """Declared rate over that of the stamps, or the other way round. Smaller errors
    leave the source out of the window (``rate_mismatch``)."""

    # The clock of blocks: a counter, led by stamps.
    stamp_error_ns: int = NANOSECONDS_PER_SECOND // 10
    """A stamp further from the count is no late one: the recorder began anew."""
    counter_step_ns: int = 2 * NANOSECONDS_PER_SECOND
    """A step of the stamps beyond this ends what the rate is measured over; smaller ones happen
    when the declared rate is wrong, and the count goes on."""
    slew_s: float = 20.0
    """Time within which the count follows the stamps: scatter of 0.1 s moves it by 5 ms in a
    second at most."""
    remembered_blocks: int = 256
    """Blocks, any of which may come once more."""
    settled_s: float = 2.0
    """Span of stamps that a rate is measured from."""
    fewest_settled: int = 8
    """Blocks whose scatter about a line tells whether they run away from it."""
    rate_tolerance: float = 0.02
    """Share by which stamps of a few seconds must differ from the declared rate."""
    crystal_error: float = 1e-3
    """No crystal is so far off, nor a host's clock that is kept by others (200 to 500 ppm)."""
    out_of_scatter: float = 8.0
    """Standard deviations of the stamps about their own line by which they have run away from the
    count before another rate is proved; a step of the host's clock amounts to six of them."""

    # Stamps coarser than the samples.
    least_shared: float = 0.05
    """Share of samples with the stamp of the one before that makes a stream coarse; below it they
    are strays."""
    least_tick: float = 0.02
    """Ticks below this share of a step are taken as none: the phase errs by 2 degrees at most."""
    counted_tick: float = 0.45
    """Ticks above this share of a step make the steps between stamps unclear: samples are counted.
    """
    off_line: float = 0.6
    """Steps by which stamps may scatter about the line to either side; a lost sample makes a
    whole."""
    tick_reach: float = 1.1
    """Ticks over which the stamps of even samples spread, line fit included."""
    broken_step: float = 0.6
    """A step in the line this large, in steps of the samples, is a lost sample if it explains
    ``broken_share`` of the scatter."""
    broken_share: float = 0.25
    """One sample lost explains two fifths of the scatter even where stamps scatter over a whole
    step, and chance hardly ever a quarter, among more than 35 stamps."""
    fewest_stamps: int = 4
    """Different stamps that a line is laid through."""

    # The rate that regular steps tell.
    least_covered_ns: int = NANOSECONDS_PER_SECOND // 50
    """Time that regular steps must cover before they tell a rate: 20 steps at 1 kHz, one at 50 Hz.
    """
    fewest_short: int = 8
    """Steps shorter than the median, at least, that are taken for the period."""
    least_short: float = 0.2
    """Their share, at least: at a random loss of 70 % there are 30 % of them."""
    step_alike: float = 0.1
    """How nearly steps must be of one length: jitter makes no such pile."""
    mostly_alike: float = 0.6
    """How many of them must be."""

    # Samples on a lattice.
    smallest_jitter: float = 1e-4
    """Steps; below it the samples are taken as lying on their places."""
    largest_jitter: float = 0.25
    """Steps a sample may lie beside its place (Kadec)."""
    same_place: float = 0.02
    """Steps between a grid point and a sample that pass for none."""
    most_places: int = 10_000
    """A lattice with more places than that, and ``sparsest`` per sample, holds next to nothing."""
    sparsest: int = 64
    """Places per sample."""

    # Gaps and values that are no numbers.
    longest_filled_s: float = 0.25
    """Gaps that are bridged. Beyond some tens of samples the bridge sinks to the mean, which takes
    that share of the response away. Random structures at 50, 200 and 1000 Hz keep all their modes,
    frequencies within three deviations; damping leaves them (by 4 to 6) when a tenth or more is
    bridged, far above the share that makes a window degraded."""
    fewest_filled: int = 4
    """The same in samples, where the rate is low."""
    largest_value: float = 1e6
    """[m/s²]; anything above is no measurement."""

    # Values far outside of all others.  Of 400 healthy made records of four channels (Gaussian,
    # heavy tails to t with two degrees of freedom, bursts, taps, sines, steps, coarse or clipped;
    # seeds from 989500) none had any but those whose channel stands at its limit, and 7 of 40 with
    # a channel beside the hammer, whose pulse of one sample no ringing stands out after.
    suspect_reach: float = 7.0
    """Median distances from the middle up to which nothing is looked for: 4.7 standard deviations,
    beyond which a stretch of 500 Gaussian samples comes once in 800 times."""
    far_again: float = 3.0
    """Times what all others reach from where on a value that recurs exactly is a placeholder."""
    far_alone: float = 10.0
    """The same of one sample alone, a spark."""
    answer: int = 32
    """Samples before and behind one alone that tell whether it is a tap."""
    grown: float = 3.0
    """Times what a channel reaches before a tap that it reaches behind it, at least."""
    fewest_values: int = 24
    """Different values of the others, at least: few steps of a converter leave bands empty."""
    rest_beside: int = 4
    """Ordinary samples to either side of one alone."""
    remembered: float = 0.97
    """Of the farthest ordinary value, from stretch to stretch of a second: half of it is left
    after 23."""


TIME_AXIS = TimeAxisLimits()
