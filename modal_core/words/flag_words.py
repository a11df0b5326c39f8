"""What every flag of the health of data means, in words."""

FLAG_WORDS = {
    # A channel that takes no part.
    'flatline': 'no signal (flat line)',
    'clipping': 'signal clipped at the sensor range',
    'not_finite': 'values that are not numbers',
    'lost': 'samples lost for longer than is filled in',
    'missing': 'no samples',
    'sample_and_hold': 'values repeated instead of measured',
    'wrapped': 'values beyond the range come back at its other end',
    'rectified': 'values without their sign',
    'rows_reversed': 'rows in reversed order',
    'copied': 'the same samples as a channel before it: a copied or miswired column',
    'clock_unknown': 'stamps too coarse to tell the rate, or samples lost among coarse stamps',
    'clock_apart': 'another time than the other sensors',
    'not_synchronous': 'sampled later or earlier than the other sensors',
    'clock_drifts': 'a clock that runs away from that of the other sensors: identify it alone',
    'incoherent': 'another motion than the other sensors',
    # What is to be known about a channel.
    'interrupted': 'for a while nothing of what the other sensors show: check cable and plug',
    'gap': 'gaps in the data',
    'impulsive': 'knocks',
    'clipped_seldom': 'a few samples clipped at the sensor range',
    'coarse_stamps': 'stamps coarser than the samples',
    'rate_unconfirmed': 'too short to confirm the sample rate',
    'phases_turned': 'phases that no delay explains: across a turning shaft, or another quantity',
    'no_response': 'shows nothing of what the other sensors show',
    'unit_g_suspicion': 'gravity reads 1: perhaps in g instead of m/s²',
    'gravity_suspicion': 'gravity has the wrong length: check gain and unit',
    'gain_suspicion': "too large or small for the robot's motion: check gain and unit",
    'large_suspicion': 'far larger than others of its kind: check unit and gain',
    'small_suspicion': 'far smaller than others of its kind, yet no noise: check unit and gain',
    'polarity_suspicion': "the robot's motion the wrong way round: check polarity",
    'axes_suspicion': "another axis' motion of the robot: check axes and mounting",
    'rigid_motion_mismatch': "does not fit the robot's motion: check polarity, axes and place",
    # What became of a sensor.
    'sensor_changed': 'the sensor is not as it was',
    'polarity_changed': 'the sensor was turned round',
    'gain_changed': 'the gain of the sensor changed',
    'sensor_rotated': 'the sensor was rotated',
    'sensor_swapped': 'sensors were exchanged',
    'shape_changed': 'the sensor, or the structure, is not as it was',
    # A window or a record as a whole.
    'degraded': 'identified from fewer channels than expected',
    'partial': 'shorter than a full window',
    'rate_change': 'sample rate changed',
    'rate_mismatch': 'the declared sample rate is not that of the stamps',
    'clock_jump': 'clock jumped',
    'overload': 'windows were skipped: more data than time to identify them',
    'restarted': 'the identifier was started again',
    'channels_changed': 'channels changed during the record',
    'modes_vary': 'windows disagree about modes: these drift or move with the pose',
    'windows_too_short': 'windows too short for the lowest modes: give longer ones',
    'few_windows': 'modes that most windows do not show: give longer windows',
    'damping_unsure': 'too many samples filled in for a deviation of damping',
    'rigid_motion_removed': 'rigid motion of the arm taken out',
    'known_motion': "modes marked so were estimated with the joints' known motion",
    'drive_lines': 'lines of the drives taken out',
    'gross_motion': 'the robot moved far',
    'line_or_mode': 'a harmonic may be a mode, light or under a force of a narrow band: a record'
    ' four times as long tells',
}


def flag_words(flag: str) -> str:
    """Return a flag in words."""
    return FLAG_WORDS.get(flag, flag.replace('_', ' '))
