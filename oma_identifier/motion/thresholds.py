"""What tells the robot's own motion from vibration, in one place, with source or measure."""

from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True)
class MotionThresholds:
    """Limits of taking out rigid motion, of delays, of orders of drives, and of sensor checks."""

    # How joint positions become accelerations.
    fewest_samples: int = 16
    """Joint states that motion is made of."""
    end_samples: int = 11
    """Samples at either end that its curvature is taken from."""
    beyond_ends: int = 24
    """Samples that either end is continued by."""
    noise_band: float = 0.75
    """Above this share of the band the positions hold noise only."""
    noise_safety: float = 2.0
    """Times its estimate that the noise is reckoned with: a gain must not follow its scatter."""
    taper: float = 0.85
    """Share of the band from where on everything fades out."""
    fade: float = 1.3
    """A lower end of the band fades out up to this many times its frequency."""

    # Delays between sensors and joints.
    latest_s: float = 0.5
    """Largest delay that is looked for."""
    first_line: int = 2
    """The taper blurs those before with the mean."""
    pooled_lines: int = 12
    """Fourier lines pooled to one value of power, phase and coherence."""
    coherent: float = 0.5
    """Least squared coherence of predicted and measured readings that move together."""
    power_ratio: float = 3.0
    """Powers of predicted and measured readings of a rigid arm differ by less than this factor."""
    followed: float = 1.0 / 3.0
    """Of the reach, up to where flexibility adds at most 1/8 of the motion."""
    useful: float = 0.5
    """Share of the power that removal may leave to be worth it."""
    assumed_damping: float = 0.02
    """Of the first mode, which delays what it amplifies: the uncertainty allows for that much."""
    few_sensors: int = 5
    """Below, their scatter tells nothing."""
    significant: float = 3.0
    """Standard deviations a delay must have to be put right."""
    apart: float = 5.0
    """Standard deviations from where on a sensor has another delay than the others."""

    # Windows that rigid motion is taken out of.
    gross_rad: float = 0.1
    """Range of a joint in a window that self-excitation stays far below."""
    most_outside_s: float = 0.25
    """Time at either end of a window that the joint states may leave uncovered."""
    worse: float = 1.5
    """Times its power below the vibrations that removal may leave on a channel the model fits."""
    same_grid: float = 0.01
    """Steps between the samples of two windows that pass for none."""
    slow_hz: float = 2.0
    """Below, rigid motion outweighs vibration: where model and sensor are compared."""
    surprise: float = 3.0
    """Standard deviations from where on a newer delay is another one."""
    same_reach: float = 0.3
    """Share by which the reach may scatter from window to window."""

    # A peak of the joints' own motion.
    explained: float = 0.7
    """Share of the power that gains must explain; a mode under white accelerations leaves more,
    for arctan(5)/5 = 0.27 of its power within five half-widths is in phase with its mean."""
    model_error: float = 0.01
    """Share of the power of rigid motion that removal may leave: a tenth of the amplitude."""
    half_widths: float = 5.0
    """Half-widths of a peak, to either side, over which it is regressed on the motion."""
    fewest_lines: int = 20
    """Spectral lines to either side, at least."""
    highest: float = 0.45
    """Share of the joint states' rate up to which they tell the motion."""

    # Orders of the drives.
    fewest_turns: float = 30.0
    """Periods of an order in a window below which it is no line."""
    highest_order: float = 0.45
    """Share of the sample rate up to which an order is looked for."""
    segments_asked: float = 0.6
    """Share of the segments that decide."""
    order_stands_out: float = 1.5
    """Ratio to the neighbourhood that its slope and curvature may cause."""
    order_chance: float = 1e-6
    """Probability of calling noise an order."""

    # Sensors against gravity and slow motion.
    offset_m_s2: float = 0.5
    """Standard deviation of the constant error of a sensor: a third of the 150 mg that the data
    sheets of plain MEMS accelerometers allow."""
    flexible: float = 0.04
    """What flexibility adds to slow motion, as a share of the largest on the arm: a third of the
    1/8 that a mode adds at a third of its frequency."""
    gain_tolerance: float = 0.1
    """Standard deviation of a healthy gain: calibration, place and mounting together."""
    wrong_from: float = 4.0
    """Standard deviations from where on a reading is wrong (as 3 in 10,000 are of two values that
    tell)."""
    explained_within: float = 3.0
    """Standard deviations within which a fault explains a reading."""
    least_factor: float = math.sqrt(2.0)
    """A wrong gain is nearer to twice or half what it should be."""


MOTION = MotionThresholds()
