"""How long the intake waits, what it keeps and when it excludes, in one place with the reasons."""

from dataclasses import dataclass

from modal_core.measurements import NANOSECONDS_PER_SECOND


@dataclass(frozen=True, slots=True)
class IntakeLimits:
    """Times, bounds of memory, and shares that decide on windows and channels."""

    # When sources belong together.
    slice_ns: int = NANOSECONDS_PER_SECOND // 5
    """Messages of one poll are taken over in slices of so much data time, sensors and joints in
    turn."""
    wild_ns: int = 60 * NANOSECONDS_PER_SECOND
    """From the middle of a batch: no batch of one poll lasts so long."""
    start_ns: int = NANOSECONDS_PER_SECOND
    """Data time that the first source is observed for others that begin with it."""
    expect_ns: int = 5 * NANOSECONDS_PER_SECOND
    """Sources that begin within this time begin together."""
    together_ns: int = 5 * NANOSECONDS_PER_SECOND
    """Sources whose newest samples are no further from one another keep one time: a silent source
    is not waited for any longer (``wait_ns``)."""
    leader_stays: float = 1.5
    """Two equal sources do not take turns; two of three that were set go on together."""
    wait_ns: int = 5 * NANOSECONDS_PER_SECOND
    """Data time a silent source is waited for."""
    near_ns: int = 5 * NANOSECONDS_PER_SECOND
    """A joint state this near to the samples' time needs no other to confirm it."""

    # What rate a source has.
    fewest_for_rate: int = 20
    """Samples that a rate is learned from."""
    learn_ns: int = NANOSECONDS_PER_SECOND
    """Data time that a rate is learned from."""
    same_rate: float = 1.01
    """Clocks of one nominal rate differ by less, and so does what a second of stamps tells."""
    rate_change: float = 0.1
    """Share by which the rate of the stamps must change to count as another rate."""
    largest_rate_factor: float = 256.0
    """Times the rate of the neighbours: on so fine a grid they would say nothing above 1/256 of
    the band, and the filters that put the fast source on theirs would be 256 times as long."""

    # How much is kept.
    most_sources: int = 256
    """Sources, topics or sensors in blocks, that are listened to."""
    most_window_bytes: int = 2**30
    """Samples of one window, as float64: 100 channels at 4 kHz for 335 s."""
    most_pending_bytes: int = 2**28
    """Samples of one source that may wait before they are given up: 100 channels at 4 kHz for 80
    s."""
    most_joint_samples: int = 2_000_000
    """Joint states kept."""
    most_joint_numbers: int = 30_000_000
    """Positions, velocities and efforts kept: 240 MB, or 1 kHz of six joints for half an hour."""

    # Which windows and channels are good.
    shortest_partial: float = 0.1
    """Share of a window that is worth a partial window at a break or at the end."""
    degraded_share: float = 0.01
    """Share of filled samples that makes a window degraded."""
    most_mended: float = 0.05
    """Share of a channel's samples that were no numbers and were filled, from where on it is
    excluded: half of that from where on filled samples were seen to cost damping (see
    ``time_axis/thresholds.py``)."""
    most_named: int = 4
    """Channels named one by one in a warning."""


INTAKE = IntakeLimits()
