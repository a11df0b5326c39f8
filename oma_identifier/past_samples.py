"""What came before a window, for methods whose memory is longer than it."""

from dataclasses import replace

import numpy as np

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples


class PastSamples:
    """Joins windows that follow from each other, and keeps so much of them.

    Parameters
    ----------
    reach_s : float [s]
        Back from the end of the newest window.
    """

    def __init__(self, reach_s: float) -> None:
        self._reach_s = reach_s
        self._kept: Samples | None = None

    def up_to(self, samples: Samples) -> Samples:
        """Return a window with what came before it.

        The window alone where it does not follow from the last one without a gap, or has other
        channels or another rate.
        """
        if samples.duration_s >= self._reach_s:
            return samples
        joined = samples if self._kept is None else _joined(self._kept, samples)
        rate_hz = joined.sample_rate_hz
        first = max(0, len(joined.acceleration) - round(self._reach_s * rate_hz))
        self._kept = joined.part(slice(first, None))
        return self._kept


def _joined(past: Samples, samples: Samples) -> Samples:
    """Return both as one; where they overlap the newer counts."""
    step_ns = NANOSECONDS_PER_SECOND / samples.sample_rate_hz
    before = (samples.start_ns - past.start_ns) / step_ns
    n_before = round(before)
    follows = 0 <= n_before <= len(past.acceleration) and abs(before - n_before) < 0.5
    alike = past.channels == samples.channels and past.sample_rate_hz == samples.sample_rate_hz
    if not (follows and alike and (past.known is None) == (samples.known is None)):
        return samples
    known = None
    if past.known is not None and samples.known is not None:
        known = np.concatenate([past.known[:n_before], samples.known])
    rows = np.concatenate([past.acceleration[:n_before], samples.acceleration])
    return replace(samples, acceleration=rows, known=known, start_ns=past.start_ns)
