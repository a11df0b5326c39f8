"""What a prediction neglects, in one place, with source or measure."""

from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True)
class PredictionThresholds:
    """Limits of predicting what sensors read."""

    # Steps of a joint that is not linear.
    steps_per_s: float = 1200.0
    """Of the path of a joint: ten at 120 Hz, where motions end."""
    rough_steps_per_s: float = 600.0
    """For numbers that are still far off."""
    noise_seed: int = 0
    """Of the motion that nobody knows: the same numbers in every prediction."""
    slow_pole_1_s: float = 2.0 * math.pi * 220.0
    """Faster poles follow a torque at once [rad/s]."""

    # Motion below what is compared, which is measured.
    parting_1_s: tuple[float, ...] = tuple(2.0 * math.pi * hz for hz in (2.8, 3.5, 4.4))
    """Poles of the filter that parts what is predicted, below, from what is measured, above
    [rad/s]."""
    least_1_s: float = 2.0 * math.pi * 1.5
    """Below, a twist is not measured [rad/s]."""
    fade_s: float = 0.25
    """The end of a record is faded out [s]: what rings on after it is not there."""
    same_pose_rad: float = 2e-3
    """Records nearer to one another are of one pose [rad]: 0.1°; chosen, not measured."""

    # Lines and errors.
    power_neighbours: int = 6
    """Bins to either side over which the power of a torque's error is averaged. Chosen, not
    measured."""
    line_neighbours: tuple[int, ...] = -2, -1, 0, 1, 2
    """Neighbours of a line in steps of one over the record's length: a machine whose speed
    wanders a little."""
    line_bins: float = 3.5
    """Bins to either side of a line by which its kind is judged: what a Hann window spreads
    (1.5) and ``line_neighbours`` (2)."""
    line_ridge: float = 1e-9
    """Of the trace, against neighbours that are alike."""


PREDICTION = PredictionThresholds()
