"""When to look anew at a window: when half of it is new, or the clock was set back."""

from modal_core.channel import Channel
from modal_core.samples import Samples


class HalfWindows:
    """Tells of which windows something is estimated anew, among those that overlap."""

    def __init__(self) -> None:
        self._of: tuple[tuple[Channel, ...], float] = ((), 0.0)
        self._start_ns = self._middle_ns = 0

    def has_seen(self, samples: Samples) -> bool:
        """Tell whether the last one looked at was of these channels and this rate."""
        return (samples.channels, samples.sample_rate_hz) == self._of

    def is_due(self, samples: Samples) -> bool:
        """Tell whether to look at a window; it is then taken to be looked at."""
        if self.has_seen(samples) and self._start_ns <= samples.start_ns < self._middle_ns:
            return False
        self._of = samples.channels, samples.sample_rate_hz
        self._start_ns = samples.start_ns
        self._middle_ns = (samples.start_ns + samples.end_ns) // 2
        return True
