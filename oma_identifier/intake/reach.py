"""How far beyond a stretch samples are wanted, so that gaps across its ends have both sides."""

import numpy as np
from numpy.typing import NDArray

from oma_identifier.time_axis import longest_filled, no_measurement, OrderedSamples

BESIDE_GAP = 40
"""Samples beside a gap."""


def reach_before(held: OrderedSamples, start_ns: int, before_ns: int, period_ns: float) -> int:
    """Return from when on samples are wanted [ns].

    Parameters
    ----------
    held : OrderedSamples
        Of one source.
    start_ns : int [ns]
        Where the stretch begins.
    before_ns : int [ns]
        From when on they are wanted anyway.
    period_ns : float [ns]
        Step.
    """
    place = int(np.searchsorted(held.stamp_ns, start_ns, 'right')) - 1
    last_ns = start_ns if place < 0 else int(held.stamp_ns[place]) - int(BESIDE_GAP * period_ns)
    first = int(np.searchsorted(held.stamp_ns, before_ns))
    if no_measurement(held.values[first : place + 1]).any():
        last_ns = min(last_ns, start_ns - _longest_ns(period_ns))
    return min(before_ns, last_ns)


def reach_after(held: OrderedSamples, end_ns: int, after_ns: int, period_ns: float) -> int:
    """Return until when samples are wanted [ns].

    Parameters
    ----------
    held : OrderedSamples
        Of one source.
    end_ns : int [ns]
        The last row of the stretch.
    after_ns : int [ns]
        Until when they are wanted anyway.
    period_ns : float [ns]
        Step.
    """
    if _is_bad_at(held, end_ns, after_ns, period_ns):
        after_ns = max(after_ns, end_ns + _longest_ns(period_ns))
    return max(after_ns, _after_gap(held.stamp_ns, end_ns, after_ns, period_ns))


def _after_gap(stamp_ns: NDArray[np.int64], end_ns: int, after_ns: int, period_ns: float) -> int:
    """Return where to end so that a gap across the end has samples after it [ns]."""
    place = int(np.searchsorted(stamp_ns, after_ns))
    if place in (0, len(stamp_ns)) or stamp_ns[place - 1] > end_ns - period_ns / 2:
        return after_ns
    gap_ns = stamp_ns[place] - stamp_ns[place - 1]
    if gap_ns > (longest_filled(period_ns) + 1.5) * period_ns:
        return after_ns
    return int(stamp_ns[place]) + int(BESIDE_GAP * period_ns)


def _is_bad_at(held: OrderedSamples, end_ns: int, after_ns: int, period_ns: float) -> bool:
    """Tell whether values are no measurement about the end, and were not long before it."""
    first_ns = round(end_ns - 1.5 * period_ns)
    first, last = np.searchsorted(held.stamp_ns, [first_ns, after_ns])
    bad = no_measurement(held.values[first:last])
    if not bad.any():
        return False
    # Of a channel that is silent for longer nothing is filled.
    earlier = held.values[max(0, first - longest_filled(period_ns)) : first]
    silent = no_measurement(earlier).all(axis=0) if len(earlier) else False
    return bool((bad.any(axis=0) & ~np.asarray(silent)).any())


def _longest_ns(period_ns: float) -> int:
    return int((longest_filled(period_ns) + 1 + BESIDE_GAP) * period_ns)
