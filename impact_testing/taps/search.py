"""Pulses of a hammer in its force: where they begin and end, and which belong to one tap."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from impact_testing.record import ImpactRecord
from impact_testing.thresholds import IMPACT

Real = NDArray[np.float64]
REBOUND_S = 0.25
"""A hammer that bounces is back within this; a person does not tap twice as fast."""
TO_SIGMA = 1.4826
"""Median absolute deviation of a Gaussian to its standard deviation."""
FOOT = 0.1
"""Share of the peak at which the width of a pulse is taken."""


@dataclass(frozen=True, slots=True)
class Tap:
    """One tap: its first pulse, and how much more came at once.

    Parameters
    ----------
    first, last : int
        Rows where the force leaves the noise before the peak, and returns to it.
    peak : int
        Row of the largest force.
    peak_n : float [N]
        Largest force, positive.
    width_s : float [s]
        Between the two places where the force is a tenth of its peak.
    rebound_share : float
        Largest force of a second pulse over the first's; 0: there is none.
    goes_on_s : float [s]
        From the peak to the last pulse that large.
    """

    first: int
    peak: int
    last: int
    peak_n: float
    width_s: float
    rebound_share: float = 0.0
    goes_on_s: float = 0.0


@dataclass(frozen=True, slots=True)
class ForceLevel:
    """Rest and noise of a force channel.

    Parameters
    ----------
    rest_n, noise_n : float [N]
        What it reads without a tap, and its standard deviation.
    """

    rest_n: float
    noise_n: float

    @classmethod
    def of(cls, force_n: Real) -> 'ForceLevel':
        """Return the level of a record of which taps are a small part."""
        rest = float(np.median(force_n))
        return cls(rest, TO_SIGMA * float(np.median(np.abs(force_n - rest))))

    @property
    def least_n(self) -> float:
        """Force of what stands out of the noise [N]."""
        return IMPACT.above_noise * self.noise_n


def taps_of(record: ImpactRecord) -> tuple[Tap, ...]:
    """Return the taps of a record, in order."""
    return tuple(
        replace(
            tap,
            first=run.first + tap.first,
            peak=run.first + tap.peak,
            last=run.first + tap.last,
        )
        for run in record.runs
        for tap in find_taps(record.force_n[run.first : run.end], record.rate_hz)
    )


def find_taps(force_n: Real, rate_hz: float) -> tuple[Tap, ...]:
    """Return the taps of a record.

    Parameters
    ----------
    force_n : (n_samples,) array [N]
        Of one sign in all taps: a hammer pushes.
    rate_hz : float [Hz]
        Sample rate.

    Returns
    -------
    tuple of Tap
        In order of time; a hammer that bounces counts once.
    """
    level = ForceLevel.of(force_n)
    force = force_n - level.rest_n
    force = force if force.max(initial=0.0) >= -force.min(initial=0.0) else -force
    # Without noise (a made record) what is a thousandth of the largest pulse is rest.
    least = max(level.least_n, 1e-3 * force.max(initial=0.0))
    above = np.flatnonzero(force > least)
    if not above.size:
        return ()
    apart = np.flatnonzero(np.diff(above) > round(REBOUND_S * rate_hz))
    groups = np.split(above, apart + 1)
    # Ringing of the structure in the hammer, or a knock of its handle, is no tap of its own.
    return tuple(tap_of(force, int(rows[0]), int(rows[-1]), rate_hz, least) for rows in groups)


def tap_of(force: Real, first: int, last: int, rate_hz: float, least_n: float) -> Tap:
    """Return the tap between two rows, its first large pulse apart from what follows."""
    inside = force[first : last + 1]
    peak_n = float(inside.max())
    large = np.flatnonzero(inside > 0.5 * peak_n)
    end_of_first = int(large[np.flatnonzero(np.diff(large, append=len(inside) + 9) > 1)[0]])
    peak = first + int(np.argmax(inside[: end_of_first + 1]))
    foot = FOOT * force[peak]
    left, right = _reach(force, peak, -1, foot), _reach(force, peak, 1, foot)
    width = right - left
    begin = _reach(force, left, -1, least_n)
    end = _reach(force, right, 1, least_n)
    reach = round(IMPACT.pulse_widths * width)
    behind, second = force[peak : last + 1], max(IMPACT.double_share * peak_n, least_n)
    rebound = _rebound(behind, reach, peak_n, second)
    notch = _notch(force[left : min(peak + reach, last) + 1])
    goes_on_s = float(np.flatnonzero(behind > second)[-1]) / rate_hz
    return Tap(begin, peak, end, peak_n, width / rate_hz, max(rebound, notch), goes_on_s)


def _reach(force: Real, row: int, step: int, level: float) -> int:
    """Return the first row at or below a level, going from a row."""
    while 0 < row < len(force) - 1 and force[row] > level:
        row += step
    return row


def _rebound(behind: Real, reach: int, peak_n: float, second_n: float) -> float:
    """Return the share of the peak that the force reaches again behind the pulse."""
    later = behind[reach:]
    highest = float(later.max(initial=0.0))
    return highest / peak_n if highest > second_n else 0.0


def _notch(pulse: Real) -> float:
    """Return the share of a second top in one pulse; both stand twice above what is between.

    A filter of a converter rings here: its lobes are no second tops.
    """
    inner = pulse[1:-1]
    tops = 1 + np.flatnonzero((inner > pulse[:-2]) & (inner >= pulse[2:]))
    if len(tops) < 2:
        return 0.0
    highest = int(tops[np.argmax(pulse[tops])])
    shares = [
        float(pulse[top] / pulse[highest])
        for top in tops.tolist()
        if top != highest
        and 2.0 * pulse[min(top, highest) : max(top, highest) + 1].min() < pulse[top]
    ]
    return max((share for share in shares if share > IMPACT.ringing_share), default=0.0)
