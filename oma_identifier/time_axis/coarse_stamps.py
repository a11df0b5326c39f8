"""Times for samples whose stamps are coarser than their steps: counted, and led by the stamps.

A driver that reads ten samples at once gives them one stamp; a clock of 10 ms gives two samples
at 200 Hz one stamp.  The samples come at equal steps all the same.  Either the first sample of a
stamp follows it by less than a step (a clock that ticks), or the last one precedes it by less (a
buffer that is read out): a line through these tells the step and, but for half a step, the time.
A sample that is lost puts all that follow off the line by a step; then nothing is told.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.time_axis.thresholds import TIME_AXIS


@dataclass(frozen=True, slots=True)
class Counted:
    """What counting makes of stamps.

    Parameters
    ----------
    stamp_ns : (n_samples,) int64 array [ns]
        Strictly increasing, at equal steps.
    period_ns : float [ns]
        Step.
    reach_ns : float [ns]
        How far times lie from stamps at most.
    is_sure : bool
        The stamps fit the count: nothing was lost.
    """

    stamp_ns: NDArray[np.int64]
    period_ns: float
    reach_ns: float
    is_sure: bool


def tick_of(stamp_ns: NDArray[np.int64]) -> int:
    """Return the greatest step that all stamps are whole multiples of apart [ns]."""
    return int(np.gcd.reduce(np.diff(stamp_ns))) if len(stamp_ns) > 1 else 0


def is_coarse(stamp_ns: NDArray[np.int64]) -> bool:
    """Tell whether samples must be counted to know their times."""
    steps = np.diff(stamp_ns)
    if len(steps) < TIME_AXIS.fewest_stamps:
        return False
    if np.count_nonzero(steps == 0) > TIME_AXIS.least_shared * len(steps):
        return True
    tick = tick_of(stamp_ns)
    # Steps of one and two ticks may be those of a coarse clock, or of one with samples lost: the
    # count stays on a line only of the former.
    mixed = np.count_nonzero(steps > 1.5 * tick) > TIME_AXIS.least_shared * len(steps)
    if not mixed or tick <= TIME_AXIS.counted_tick * float(np.mean(steps)):
        return False
    counted = count(stamp_ns)
    return counted is not None and counted.is_sure


def count(stamp_ns: NDArray[np.int64]) -> Counted | None:
    """Return the times of samples in order, None where there are too few stamps.

    Parameters
    ----------
    stamp_ns : (n_samples,) int64 array [ns]
        In order; several may be equal.
    """
    stamps, first, sizes = np.unique(stamp_ns, return_index=True, return_counts=True)
    if len(stamps) < TIME_AXIS.fewest_stamps:
        return None
    time = (stamps - stamps[0]).astype(np.float64)
    # The first and the last stamp may be those of a part of their samples.
    inner = slice(1, -1)
    lines = [_line(place[inner], time[inner]) for place in (first, first + sizes - 1)]
    period, start, spread = best = min(lines, key=lambda line: line[2])
    place = first if best is lines[0] else first + sizes - 1
    beside = time - start - period * place
    is_broken = _has_step(place[inner], beside[inner], period)
    tick = tick_of(stamps)
    if lines[0][2] <= lines[1][2] and tick > TIME_AXIS.least_tick * period:
        start += 0.5 * min(tick, period)
    times = stamps[0] + np.rint(start + period * np.arange(len(stamp_ns))).astype(np.int64)
    return Counted(
        stamp_ns=times,
        period_ns=period,
        reach_ns=float(np.abs(times - stamp_ns).max()),
        is_sure=period > 0.0 and spread <= TIME_AXIS.off_line * period and not is_broken,
    )


def _line(place: NDArray[np.int64], time: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return slope, start and half the spread of stamps about a line [ns]."""
    middle, centre = place.mean(), time.mean()
    away = place - middle
    slope = float(away @ (time - centre) / (away @ away)) if np.ptp(place) else 0.0
    beside = time - centre - slope * away
    return slope, float(centre - slope * middle), float(np.ptp(beside)) / 2.0


def _has_step(place: NDArray[np.int64], beside: NDArray[np.float64], period: float) -> bool:
    """Tell whether stamps beside a line are better described by a line with a step."""
    n = len(place)
    if n < 2 * TIME_AXIS.fewest_stamps:
        return False
    away = (place - place.mean()) / (np.std(place) * np.sqrt(n))
    later = np.arange(n - 2, 1, -1)
    # What lies after each place, freed of the line: its sums, from the end.
    along = np.cumsum(away[::-1])[n - later - 1]
    count_after = (n - later).astype(np.float64)
    free = count_after - count_after**2 / n - along**2
    step = np.cumsum(beside[::-1])[n - later - 1] / free
    explained = step**2 * free
    best = int(np.argmax(explained))
    is_large = abs(step[best]) > TIME_AXIS.broken_step * period
    return bool(is_large and explained[best] > TIME_AXIS.broken_share * float(beside @ beside))
