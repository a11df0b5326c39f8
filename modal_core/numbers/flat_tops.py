"""Signals that ran into a limit: their samples pile up at the outermost value."""

import numpy as np
from numpy.typing import NDArray

LAYER = 2e-3
"""Thickness of a layer, of the way from the median to the largest value."""
LAYERS = 6
"""Layers that are looked at; chosen, as the thickness is: what follows holds for them."""
PILED_UP = 4.0
"""Samples in the outermost layer over those in the next ones together: 0.4 for a sine and 0.7 for
one in steps of a converter, the steepest of smooth signals; 5 or more where a Gaussian is cut off
below three standard deviations, in floating point or in 256 steps cut off below two."""


def n_on_flat_top(signal: NDArray[np.floating]) -> int:
    """Return how many samples pile up at the largest value; 0 where they do not.

    A limit cuts off a signal that goes on just below it.  A value far from all others, such as
    zeros in place of samples, is no limit.

    Parameters
    ----------
    signal : (n_samples,) array
        Finite.
    """
    top = float(signal.max())
    height = top - float(np.median(signal))
    below = signal[signal < top]
    if not height > 0.0 or not len(below):
        return 0
    layer = max(LAYER * height, top - float(below.max()))  # of a coarse converter: one step
    if (LAYERS - 0.5) * layer >= height:
        return 0
    outermost = int(np.count_nonzero(signal > top - 0.5 * layer))
    next_few = int(np.count_nonzero(signal > top - (LAYERS - 0.5) * layer)) - outermost
    return outermost if outermost > PILED_UP * max(next_few, 1) else 0
