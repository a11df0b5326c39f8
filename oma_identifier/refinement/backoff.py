"""Back-off: a place where refinement failed is left alone for more and more windows."""

from dataclasses import dataclass
import math

LONGEST = 8
"""Windows for which a place is left alone where refinement failed many times."""
SAME_PLACE = 0.03
"""Distance in ln f."""
MOST_PLACES = 64


@dataclass(slots=True)
class Rest:
    """A place that is left alone: for how many windows, now and next time."""

    frequency_hz: float
    left: int = 1
    following: int = 2


class Backoff:
    """Exponential back-off of places in frequency.

    Where the model does not describe the spectrum in one window it hardly does in the next, and
    finding that out costs as much as a refinement.
    """

    def __init__(self) -> None:
        self._rests: list[Rest] = []

    def at(self, frequency_hz: float) -> Rest | None:
        """Return what is known of a place."""

        def apart(rest: Rest) -> float:
            return abs(math.log(rest.frequency_hz / frequency_hz))

        nearest = min(self._rests, key=apart, default=None)
        return nearest if nearest is not None and apart(nearest) < SAME_PLACE else None

    def next_window(self) -> None:
        """Count down."""
        for rest in self._rests:
            rest.left = max(0, rest.left - 1)

    def succeeded(self, at: Rest | None) -> None:
        """Forget a place."""
        self._rests = [rest for rest in self._rests if rest is not at]

    def failed(self, at: Rest | None, frequency_hz: float) -> None:
        """Leave a place alone for twice as many windows as last time."""
        if at is None:
            self._rests = [*self._rests, Rest(frequency_hz)][-MOST_PLACES:]
        else:
            at.left, at.following = at.following, min(2 * at.following, LONGEST)
