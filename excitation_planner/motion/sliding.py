"""Slow sweeps that keep joints sliding, and what part of the time joints slide.

A gear that has turned back is wound through its lost motion and its friction through presliding
before it slides again; till then the joint is as stiff as one that stands.  Noise of ±0.04 deg
stays inside that.  So each axis sweeps slowly to and fro, faster than the noise moves it back, and
turns at times and places of its own.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Of the part of the time joints shall slide, the least for which sweeping is worth its motion.
LEAST_OF_SHARE = 0.8
# Sweeps are this many standard deviations of the noise's speed, so that it rarely turns them back
# (0.13 % of the time), and never slower than friction is Coulomb's (assumed).
SPEED_SIGMAS, LEAST_SPEED_RAD_S = 3.0, 0.01
# In which a sweep turns; softer than the band of interest begins.
TURN_S = 0.25
# Turning points lie in this outer part of the range, at random.
NEAREST_TURN = 0.6
# A joint counts as sliding when it has gone this part of the presliding travel since it turned.
WOUND = 0.9
# A joint stands that goes less than this part of the presliding travel in this time.
STANDING, MOVING_S = 0.05, 0.1


@dataclass(frozen=True, slots=True)
class SweepSettings:
    """How sweeps are drawn.

    Parameters
    ----------
    half_range : (n_joints,) array [rad]
        Turning points lie within this of the start; 0 keeps an axis where it is.
    speed : (n_joints,) array [rad/s]
        Between turns.
    """

    half_range: Array
    speed: Array


def sweep_speed(noise_speed_rms: Array) -> Array:
    """Return the speed that keeps axes sliding against their noise, (n_joints,) [rad/s]."""
    wanted = np.maximum(SPEED_SIGMAS * noise_speed_rms, LEAST_SPEED_RAD_S)
    return np.where(noise_speed_rms > 0.0, wanted, 0.0)


def turn_rise(speed: Array) -> Array:
    """Return the largest acceleration of a sweep, where it turns, (n_joints,) [rad/s²]."""
    # From one speed to the opposite under a Hann window, whose peak is twice its mean.
    return np.asarray(2.0 * 2.0 * speed / TURN_S)


def wanted_half_range(speed: Array, presliding_rad: float, share: float) -> Array:
    """Return how far sweeps must go for joints to slide this part of the time, [rad].

    A stroke is 2 (1 + NEAREST_TURN) / 2 half ranges long on the average; after each turn the joint
    sticks for a quarter of the turn and the presliding travel.
    """
    return speed * _stuck_s(speed, presliding_rad) / (1.0 - share) / (1.0 + NEAREST_TURN)


def expected_share(half_range: Array, speed: Array, presliding_rad: float) -> Array:
    """Return the part of the time joints slide in sweeps, the inverse of the above."""
    stroke_s = (1.0 + NEAREST_TURN) * half_range / np.maximum(speed, 1e-12)
    stuck = _stuck_s(speed, presliding_rad) / np.maximum(stroke_s, 1e-12)
    return np.asarray(np.maximum(1.0 - stuck, 0.0))


def _stuck_s(speed: Array, presliding_rad: float) -> Array:
    return np.asarray(0.25 * TURN_S + presliding_rad / np.maximum(speed, 1e-12))


def sweep_velocity(
    settings: SweepSettings,
    duration_s: float,
    sample_period_s: float,
    generator: np.random.Generator,
) -> Array:
    """Draw the sweeps of every axis; they start and end at rest at the start pose.

    Parameters
    ----------
    settings : SweepSettings
        How to draw.
    duration_s, sample_period_s : float [s]
        Length and grid of the record.
    generator : numpy.random.Generator
        Source of the turning points; each axis gets its own stream.

    Returns
    -------
    (n_samples, n_joints) array [rad/s]
    """
    n_samples = round(duration_s / sample_period_s) + 1
    velocity = np.zeros((n_samples, len(settings.speed)))
    turn = max(2, round(TURN_S / sample_period_s))
    kernel = np.hanning(turn + 2)[1:-1]
    kernel /= np.sum(kernel)
    for axis, own in enumerate(generator.spawn(len(settings.speed))):
        if settings.half_range[axis] > 0.0:
            sharp = _sharp_strokes(
                settings.half_range[axis],
                settings.speed[axis] * sample_period_s,
                n_samples - 1 - turn,
                own,
            )
            # Rows 1 to n - 1 at most: at rest at both ends.
            smooth = np.convolve(sharp, kernel) / sample_period_s
            velocity[1 : 1 + len(smooth), axis] = smooth
    return velocity


def _sharp_strokes(
    half_range: float, step: float, n_steps: int, generator: np.random.Generator
) -> Array:
    """Return steps of strokes between random turning points that fill a time and end at 0."""
    turns, length = [0.0], 0.0
    side = 1.0 if generator.random() < 0.5 else -1.0
    while True:
        place = side * half_range * generator.uniform(NEAREST_TURN, 1.0)
        way = abs(place - turns[-1])
        # The speed is fitted to the time: more strokes than this would be faster than asked.
        if len(turns) > 1 and length + way + abs(place) > step * n_steps:
            break
        turns.append(place)
        length, side = length + way, -side
    turns.append(0.0)
    ways = np.diff(turns)
    ends = np.round(n_steps * np.cumsum(np.abs(ways)) / np.sum(np.abs(ways))).astype(int)
    counts = np.maximum(np.diff(np.concatenate([[0], ends])), 1)
    return np.concatenate([np.full(n, way / n) for n, way in zip(counts, ways, strict=True)])


def sliding(position: Array, sample_period_s: float, presliding_rad: float) -> NDArray[np.bool_]:
    """Return when joints slide: moving, and gone through presliding since they last turned.

    Parameters
    ----------
    position : (n_samples, n_joints) array [rad]
        Path.
    sample_period_s : float [s]
        Its grid.
    presliding_rad : float [rad]
        Travel after a turn before a joint slides.

    Returns
    -------
    (n_samples, n_joints) array of bool
        Not before the joint has first gone that far.
    """
    if not len(position):
        return np.zeros(position.shape, dtype=bool)
    return SlidingJoints(position[0], presliding_rad).slide(position, sample_period_s)


class SlidingJoints:
    """Whether joints slide, told of a path piece by piece.

    Parameters
    ----------
    start : (n_joints,) array [rad]
        Where they are at first.
    presliding_rad : float [rad]
        Travel after a turn before a joint slides.
    """

    def __init__(self, start: Array, presliding_rad: float) -> None:
        self._presliding_rad = presliding_rad
        self._middle = [float(angle) for angle in start]

    def slide(self, position: Array, sample_period_s: float) -> NDArray[np.bool_]:
        """Return when they slide in the next piece, (n_samples, n_joints)."""
        half = 0.5 * self._presliding_rad
        found = np.empty(position.shape, dtype=bool)
        for joint, column in enumerate(position.T):
            middle = self._dragged(joint, column.tolist(), half)
            found[:, joint] = np.abs(column - middle) >= WOUND * half
        half_width = round(0.5 * MOVING_S / sample_period_s)
        return found & _moving(position, half_width, self._presliding_rad)

    def _dragged(self, joint: int, places: list[float], half: float) -> list[float]:
        """Drag a play of that width along: at its wall the joint slides."""
        middle, path = self._middle[joint], []
        for place in places:
            middle = min(max(middle, place - half), place + half)
            path.append(middle)
        self._middle[joint] = middle
        return path


def _moving(position: Array, half_width: int, presliding_rad: float) -> NDArray[np.bool_]:
    """Return where a joint goes on within a stretch around each sample."""
    rows = np.arange(len(position))
    after = position[np.minimum(rows + half_width, len(position) - 1)]
    before = position[np.maximum(rows - half_width, 0)]
    return np.asarray(np.abs(after - before) >= STANDING * presliding_rad)


def sliding_share(position: Array, sample_period_s: float, presliding_rad: float) -> Array:
    """Return the part of the time each joint slides, (n_joints,); see :func:`sliding`."""
    return np.asarray(np.mean(sliding(position, sample_period_s, presliding_rad), axis=0))
