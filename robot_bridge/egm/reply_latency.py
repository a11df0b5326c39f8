"""How long the controller waits for its answer."""

from dataclasses import dataclass
import math

import numpy as np


@dataclass(frozen=True, slots=True)
class LatencySummary:
    """Quantiles of the last replies.

    Parameters
    ----------
    p50_s, p99_s, max_s : float [s]
        From the kernel's receipt of a packet to its reply leaving; NaN without replies.
    n : int
        Replies the quantiles are over.
    """

    p50_s: float
    p99_s: float
    max_s: float
    n: int


class ReplyLatency:
    """Ring of the last latencies; one writer, any reader."""

    def __init__(self, length: int = 4096) -> None:
        self._ring = np.full(length, math.nan)
        self._count = 0

    def add(self, latency_s: float) -> None:
        """Note one reply's latency [s]."""
        self._ring[self._count % len(self._ring)] = latency_s
        self._count += 1

    def summary(self) -> LatencySummary:
        """Return the quantiles of what the ring holds."""
        values = self._ring[: min(self._count, len(self._ring))].copy()
        if not len(values):
            return LatencySummary(math.nan, math.nan, math.nan, 0)
        p50, p99 = np.quantile(values, (0.5, 0.99))
        return LatencySummary(float(p50), float(p99), float(values.max()), len(values))
