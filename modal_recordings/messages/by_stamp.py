"""Topics side by side by the stamps of their samples, where log times do not say when those were.

A bag that was written anew by another program (converted, copied, filtered, cut) may have the
times of that: all at once, or one topic after the other.  Taken in that order one sensor would be
through before the next begins, and be given up as silent.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
import heapq

import numpy as np

from modal_core.measurements import Measurement, NANOSECONDS_PER_SECOND, SampleBlock

MOST_NS = 2 * NANOSECONDS_PER_SECOND
"""By their stamps, what a batch of a quarter of a second of log time may hold.  Who waits for a
sensor waits for longer, and a recorder that was late by as much is taken as well either way."""


def log_times_mislead(batch: Sequence[Measurement]) -> bool:
    """Tell whether a batch holds more than its log times say, by what was measured.

    One stamp that is wrong does not count, nor a clock that is set.
    """
    held_ns: dict[object, float] = defaultdict(float)
    for each in batch:
        if isinstance(each, SampleBlock):
            seconds = len(each.acceleration) / max(each.sample_rate_hz, 1e-9)
            held_ns[each.source] += seconds * NANOSECONDS_PER_SECOND
        elif len(each.stamp_ns) > 1:
            steps = np.abs(np.diff(each.stamp_ns))
            key = getattr(each, 'source', None)  # None: joint states.
            held_ns[key] += float(np.median(steps)) * len(steps)
    return max(held_ns.values(), default=0.0) > MOST_NS


def side_by_side(topics: Sequence[Iterable[Measurement]]) -> Iterator[Measurement]:
    """Yield the measurements of several topics by their first stamps.

    Parameters
    ----------
    topics : sequence of iterable of Measurement
        Each of one topic, whose own order stays.
    """
    keyed = [_reached(number, each) for number, each in enumerate(topics)]
    for _, _, measurement in heapq.merge(*keyed, key=lambda item: item[:2]):
        yield measurement


def _reached(
    number: int, measurements: Iterable[Measurement]
) -> Iterator[tuple[int, int, Measurement]]:
    """Yield measurements behind how far their topic has come."""
    reached_ns = 0
    for each in measurements:
        reached_ns = max(reached_ns, first_stamp(each))
        yield reached_ns, number, each


def first_stamp(measurement: Measurement) -> int:
    """Return the earliest stamp of a batch [ns]."""
    return int(np.min(measurement.stamp_ns))
