"""What remembers its past: the state of friction before it slides, of play in a gear."""

import numpy as np
from numpy.typing import NDArray

from modal_core.work.compiled import compiled

Array = NDArray[np.float64]


@compiled
def play_state(path: Array, width: float, first: float) -> Array:
    """Return the elasto-plastic state z in -1..1: dz = dq/width, held at ±1 (Prandtl 1928).

    Parameters
    ----------
    path : (n,) array [rad]
        Position.
    width : float [rad]
        Way from rest to sliding.
    first : float
        State before the first sample.
    """
    state = np.empty_like(path)
    now = first
    before = path[0]
    for place in range(len(path)):
        now += (path[place] - before) / width
        now = min(1.0, max(-1.0, now))
        before = path[place]
        state[place] = now
    return state


def sliding(path: Array, width: float) -> tuple[Array, Array]:
    """Return the state and what of it depends on where it stood before.

    Where a recording starts the state is unknown: the state is the first plus the second times a
    number between -1 and 1, exactly so once it has slid, nearly so before.

    Parameters
    ----------
    path : (n,) array [rad]
        Position.
    width : float [rad]
        Way from rest to sliding.
    """
    high, low = play_state(path, width, 1.0), play_state(path, width, -1.0)
    return 0.5 * (high + low), 0.5 * (high - low)
