"""What recordings of a campaign must be to count, in one place, with source or measure."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CampaignThresholds:
    """Limits of reading recordings, and of the spectra that are compared."""

    # Channels that were clipped.
    fewest_flat: int = 8
    """Samples in the outermost layer, at least: chosen, not measured."""

    # Joint states.
    motion_up_to_hz: float = 110.0
    """Motions are read from joint states up to here: chosen, not measured."""
    usable_share: float = 0.45
    """Of a recorded rate: what lies above is the interpolation's, not the robot's."""
    least_agreement: float = 0.98
    """Correlation of recorded joint velocities with the derivative of the positions.
    Chosen, not measured."""
    most_lag_s: float = 1e-4
    """Of velocities behind positions [s]: 2° of phase at 60 Hz."""
    scale_error: float = 0.1
    """Of their sizes, as a share. Chosen, not measured."""
    noise_from: float = 0.7
    """Where of the recorded spectrum, in parts of half the rate, its noise begins to be
    read."""
    noise_to: float = 0.95
    """And where it ends: filters of loggers begin there."""
    noise_parts: int = 6
    """Parts of that stretch of which the quietest counts. Chosen, not measured."""

    # Recordings.
    longest_s: float = 60.0
    """Of a recording is used at most [s]: chosen, for its cost."""
    reserve_s: float = 3.0
    """Read beyond what is asked for [s]: sensors that begin later, and a second to interpolate
    from. Chosen, not measured."""
    shortest_s: float = 4.0
    """Of sensors and joint states together, at least [s]: a dozen periods of 3 Hz."""
    highest_rate_hz: float = 640.0
    """Accelerations are kept at about this rate: twice what is compared, and room to see
    the noise."""
    least_band_hz: float = 55.0
    """Joint states that tell less are said to limit the comparison. Chosen, not measured."""
    at_rest: float = 0.3
    """Speed at the beginning over that of the whole recording, from which on it begins in
    motion. Chosen, not measured."""
    pose_said_rad: float = 0.05
    """Between the pose that is written down and the joint states [rad]: 3°; chosen, not
    measured."""
    full_turns: float = 3.0
    """Turns beyond the range that are still radians: angles in degrees are mostly more."""
    full_travels: float = 3.0
    """Travels beyond the range that are still metres: millimetres are mostly more."""
    longest_travel_m: float = 100.0
    """Of a joint that slides without end [m]: the longest gantries."""
    g_band: float = 0.15
    """A sensor that reads 1 at rest within this share has g for its unit."""

    # Series of samples.
    finer: int = 8
    """Points per sample between which a spline interpolates: chosen, not measured."""
    padding_s: float = 1.0
    """Mirrored at each end against ringing [s]. Chosen, not measured."""
    largest_gap_steps: float = 1.5
    """Twice so many steps without a sample end a stretch: one that is lost leaves two."""
    fewest_samples: int = 16
    """Of a series, at least. Chosen, not measured."""
    least_finite: float = 0.5
    """Share of a channel's samples that are numbers, at least. Chosen, not measured."""
    least_change: float = 1e-9
    """Of a channel's largest value: what changes less changes by rounding only."""

    # Spectra.
    target_bins: int = 160
    """Bins in which a band is compared: what they cost grows with them."""
    smoothing_bins: int = 12
    """Bins to either side over which powers are averaged for the noise of the motion: 25 in
    all, known to 20 %."""
    linearisation_error: float = 0.005
    """Of the amplitude: what a linear model misses of an arm that shakes, once the motion
    of second order has been taken out."""
    motion_hz: float = 120.0
    """Motions are known up to here at most [Hz]."""
    tail_s: float = 25.0
    """How much of the motion counts for what rings when a record ends [s]: a mode of 3 Hz and
    0.5 % has fallen to a tenth."""
    noise_top: float = 0.92
    """Noise is read up to this part of half the rate: above, filters begin."""
    quietest: float = 30.0
    """Per cent of what is there that count as noise: chosen, not measured."""
    least_width: float = 2.0
    """Upper edge of a band over the lower one, at least. Chosen, not measured."""
    band_edges_hz: tuple[float, ...] = 3.0, 8.0, 12.0, 18.0, 26.0, 38.0, 60.0, 120.0
    """Bands that results are told by [Hz]."""


CAMPAIGN = CampaignThresholds()
