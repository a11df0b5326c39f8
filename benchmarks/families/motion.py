"""What a moving robot adds to its sensors: accelerations of its moves, gravity that turns."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.families.chance import log_uniform
from benchmarks.families.family import Range

Array = NDArray[np.float64]
MOVE_PERIODS = (5.0, 20.0)
"""Length of a move in periods of the lowest mode: robots are moved slower than they vibrate."""
MOVES = (3, 8)
"""Of a working cycle, which is repeated by half of the robots."""
AXES = (1, 3)
GRAVITY = (0.3, 3.0)
"""Deviation of the turning gravity over that of the accelerations: a link of 1 m turned in 1 s
has 1.7."""


def draw_motion(
    rng: np.random.Generator,
    size: tuple[int, ...],
    rate_hz: float,
    lowest_hz: float,
    level: Range,
) -> Array:
    """Draw the motion seen by every sensor, over the deviation of the responses.

    Parameters
    ----------
    size : (n_samples, n_channels)
        Of the record.
    rate_hz, lowest_hz : float [Hz]
        Of the samples; lowest natural frequency that may be drawn.
    level : pair of float
        Of its standard deviation, a mean over the channels.
    """
    n_samples, n_channels = size
    motion = np.zeros((n_samples, n_channels))
    for _ in range(int(rng.integers(AXES[0], AXES[1] + 1))):
        angle, acceleration = one_axis(rng, n_samples, rate_hz, lowest_hz)
        turned = log_uniform(rng, GRAVITY) * angle / angle.std()
        motion += np.outer(acceleration / acceleration.std(), rng.standard_normal(n_channels))
        motion += np.outer(turned, rng.standard_normal(n_channels))
    return np.asarray(motion * log_uniform(rng, level) / motion.std(axis=0).mean())


def one_axis(
    rng: np.random.Generator, n_samples: int, rate_hz: float, lowest_hz: float
) -> tuple[Array, Array]:
    """Draw angle and acceleration of an axis that goes from place to place, and waits there."""
    n_moves = int(rng.integers(MOVES[0], MOVES[1] + 1))
    lengths_s = log_uniform(rng, MOVE_PERIODS) / lowest_hz * rng.uniform(0.7, 1.4, 2 * n_moves)
    repeats = rng.random() < 0.5
    places = rng.uniform(-1.0, 1.0, n_moves)
    edges = np.concatenate([[0.0], np.cumsum(lengths_s)])
    time = np.arange(n_samples) / rate_hz
    cycle = (time // edges[-1]).astype(int)
    if not repeats:
        places = rng.uniform(-1.0, 1.0, (int(cycle[-1]) + 1) * n_moves)
    inside = time - cycle * edges[-1]
    stage = np.searchsorted(edges, inside, side='right') - 1
    move = cycle * n_moves + stage // 2
    start, end = places[move % len(places)], places[(move + 1) % len(places)]
    share = np.where(stage % 2, 1.0, (inside - edges[stage]) / lengths_s[stage])
    # The quintic of least jerk, at rest at both ends (Flash and Hogan 1985).
    angle = start + (end - start) * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    bend = 60.0 * share - 180.0 * share**2 + 120.0 * share**3
    return angle, (end - start) * bend / lengths_s[stage] ** 2
