"""Holds results against a baseline: running means of departures, and a stated false-alarm rate.

Four means with exponential weights run side by side (EWMA; Roberts 1959,
doi:10.2307/1266443): long ones see small changes, short ones see large changes soon.  Each has a
limit from its own standard deviation, which holds the estimates' σ, the scatter of the baseline
with its memory, and how well the baseline itself is known.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from modal_core.work.compiled import compiled
from modal_history.alarm.baseline import Baseline, Departures, estimate_variance, FARTHEST
from modal_history.alarm.covariates import SOAKING_S
from modal_history.alarm.missing import Presence
from modal_history.alarm.wander import Wander
from modal_history.trend import Trend

Array = NDArray[np.float64]
LENGTHS = (6.0, 60.0, 600.0, 6000.0)
"""Of the means, in results: at one a minute 6 min, 1 h, 10 h, 4 days."""
LEAST_RESULTS = 4.0
"""Results a mean must rest on: no single one raises an alarm."""
LOOKS = 40.0
"""Independent looks in the length of a mean: an Ornstein-Uhlenbeck process crosses a level of L
standard deviations L² times as often as a look a length; L is 5 to 6 here."""
MONTH_S = 30.44 * 86_400.0
AT_ONCE, LEAD = 40_000, 12_000
"""Results held against the baseline at once, and how many before them are looked at again."""
FOREVER_S = 1e12
LOST = 'lost'
LOST_SHARE = 0.5
"""Part of the false alarms that modes which are found no more may have: limits of the others are
wider by a fortieth for it."""
N_BEGINS = 60
"""Rows at which a step is tried: each a seventh further back than the one before at 6000 rows."""
SOAKED_NS = round(5e9 * SOAKING_S)


@dataclass(frozen=True)
class WatchSettings:
    """How often an alarm may be false.

    Parameters
    ----------
    false_a_month : float
        False alarms a month, of all modes of a robot together.
    """

    false_a_month: float = 0.1


@dataclass(frozen=True, slots=True)
class Change:
    """A mode is not what it was.

    Parameters
    ----------
    id : int
        Mode.
    raised_ns, since_ns : int [ns]
        When it was sure; when it most likely began.
    share, share_std : float
        Change of the frequency as a share of it, and its standard deviation; NaN of a mode that
        is found no more.
    surprise : float
        Departure of the mean that raised it, in its standard deviations; of a mode that is found
        no more windows without it.
    bound : float
        What chance reaches, at the stated rate.
    kind : str
        ``moved``, or ``lost``: found no more.
    """

    id: int
    raised_ns: int
    since_ns: int
    share: float
    share_std: float
    surprise: float
    bound: float
    kind: str = 'moved'

    def words(self) -> str:
        """Say what changed, by how much, and how sure that is."""
        if self.kind == LOST:
            return (
                f'mode {self.id}: not found in {self.surprise:.0f} windows in which it used to'
                f' be, where chance reaches {self.bound - 1.0:.0f} in a row'
            )
        return (
            f'mode {self.id}: natural frequency {100.0 * self.share:+.2f}'
            f' ± {100.0 * self.share_std:.2f} %, {abs(self.surprise):.1f} standard deviations'
            f' where chance reaches {self.bound:.1f}'
        )


def lost(
    heard: Trend,
    presence: Presence,
    number: int,
    n_modes: int = 1,
    settings: WatchSettings | None = None,
) -> Change | None:
    """Return whether a mode is found no more.

    Parameters
    ----------
    heard : Trend
        Windows in which any mode was found, since this one was found last.
    presence : Presence
        Where it used to be found.
    number : int
        Its id.
    n_modes, settings
        As for :func:`watch`.
    """
    rows = np.flatnonzero(presence.counts(heard)) if len(heard) else np.empty(0, dtype=int)
    false = LOST_SHARE * (settings or WatchSettings()).false_a_month / n_modes
    bound = presence.longest(false, MONTH_S)
    if len(rows) < bound:
        return None
    return Change(
        id=number,
        raised_ns=int(heard.time_ns[rows[bound - 1]]),
        since_ns=int(heard.start_ns[rows[0]]),
        share=math.nan,
        share_std=math.nan,
        surprise=float(len(rows)),
        bound=float(bound),
        kind=LOST,
    )


@dataclass(frozen=True, slots=True)
class Watched:
    """What became of a mode since its baseline.

    Parameters
    ----------
    id : int
        Mode.
    change : Change or None
        The first one.
    n : int
        Results held against the baseline.
    n_left_out : int
        Results without a covariate that the baseline has.
    detectable : float
        Share of its frequency from which a change that lasts raises an alarm, as of the last
        result; NaN while nothing can.
    """

    id: int
    change: Change | None
    n: int
    n_left_out: int
    detectable: float


def watch(
    trend: Trend, baseline: Baseline, n_modes: int = 1, settings: WatchSettings | None = None
) -> Watched:
    """Hold the results after a baseline against it.

    Parameters
    ----------
    trend : Trend
        Of the mode, by time; what lies before the baseline's end is passed over.
    baseline : Baseline
        What is usual.
    n_modes : int
        Modes watched together: they share the false-alarm rate.
    settings : WatchSettings or None
        None: the defaults.
    """
    settings = settings or WatchSettings()
    usual_ns = baseline.end_ns
    if len(trend) and trend.time_ns[0] > usual_ns:
        # Gone on with: the first hours tell how warm the castings are, and were watched before.
        usual_ns = trend.time_ns[0] + SOAKED_NS
    start = int(np.searchsorted(trend.time_ns, usual_ns, 'right'))
    chances = _Chances(trend, n_modes, settings)
    n, n_looked, change, detectable = 0, 0, None, math.nan
    for first in range(start, len(trend), AT_ONCE):
        end = min(first + AT_ONCE, len(trend))
        # As far back as the longest mean remembers.
        found = _departures(trend, baseline, max(start, first - LEAD), end)
        n_looked += end - first
        n += int(np.count_nonzero(found.trend.time_ns >= trend.time_ns[first]))
        if len(found.away) >= LEAST_RESULTS:
            means = _means(found, baseline, chances)
            smallest = [float(m.limit[-1] * m.std[-1]) for m in means if m.grown[-1]]
            detectable = min(smallest, default=math.nan)
            change = _first_change(found, baseline, means)
        if change is not None:
            break
    return Watched(trend.id, change, n, n_looked - n, detectable)


def needed_since(trend: Trend, baseline: Baseline) -> int:
    """Return since when results must be known to go on where a trend ends [ns]."""
    begin = max(int(np.searchsorted(trend.time_ns, baseline.end_ns)), len(trend) - LEAD)
    return int(trend.time_ns[min(begin, len(trend) - 1)]) - SOAKED_NS


def _departures(trend: Trend, baseline: Baseline, begin: int, end: int) -> Departures:
    """Return departures of some rows; how warm the castings are is known from rows before."""
    early = int(np.searchsorted(trend.time_ns, trend.time_ns[begin] - SOAKED_NS))
    found = baseline.departures(trend.rows(np.arange(early, end)))
    return found.since(int(np.searchsorted(found.trend.time_ns, trend.time_ns[begin])))


@dataclass(frozen=True, slots=True)
class _Mean:
    """One running mean: values, standard deviations and limits of the ratio, each (n,)."""

    value: Array
    std: Array
    limit: Array
    grown: NDArray[np.bool_]

    @property
    def beyond(self) -> Array:
        """How far it is beyond its limit; at most 1: not."""
        ratio = np.abs(self.value) / (self.std * self.limit)
        return np.where(self.grown, ratio, 0.0)


class _Chances:
    """What each mean's limit may let through by chance, one look after the other."""

    def __init__(self, trend: Trend, n_modes: int, settings: WatchSettings) -> None:
        steps = np.diff(trend.time_ns) / 1e9
        self.step_s = max(float(np.median(steps)), 1e-3) if len(steps) else 1.0
        moved = (1.0 - LOST_SHARE) * settings.false_a_month
        self._share = moved / (n_modes * len(LENGTHS))

    def of(self, length: float) -> float:
        """Return the chance of one look at a mean of so many results."""
        return self._share / (MONTH_S / self.step_s * min(1.0, LOOKS / length))


def _means(found: Departures, baseline: Baseline, chances: _Chances) -> list[_Mean]:
    trend, wander = found.trend, baseline.wander
    time_s = (trend.time_ns - trend.time_ns[0]) / 1e9
    variance = estimate_variance(trend) + wander.white**2
    doubt = np.sum(found.doubts**2, axis=1) + found.untold**2
    reach = FARTHEST * np.sqrt(variance + wander.size**2 + doubt)
    away, means = np.clip(found.away, -reach, reach), []
    for length in LENGTHS:
        unknown = (found.doubts, found.untold, found.cell)
        run = _run(time_s, away, variance, *unknown, length * chances.step_s, wander.memory_s)
        value, white, slow, own, n_results = run
        slow *= wander.size**2
        # Welch and Satterthwaite: the limit is as wide as the scatter is uncertain.
        freedom = (white + slow + own) ** 2 / (white**2 / baseline.n + slow**2 / baseline.memory_n)
        limit = student.isf(chances.of(length) / 2.0, np.maximum(freedom, 1.0))
        # A young mean is a short one, and would be looked at as often as that.
        grown = (n_results >= LEAST_RESULTS) & (time_s >= length * chances.step_s)
        means.append(_Mean(value, np.sqrt(white + slow + own), limit, grown))
    return means


def _first_change(found: Departures, baseline: Baseline, means: Sequence[_Mean]) -> Change | None:
    beyond = np.array([mean.beyond for mean in means])
    rows = np.flatnonzero((beyond > 1.0).any(axis=0))
    if not len(rows):
        return None
    last = int(rows[0])
    mean, before = means[int(np.argmax(beyond[:, last]))], found.until(last + 1)
    begin = _begin(before, baseline.wander)
    share, std = _size(before.since(begin), baseline)
    return Change(
        id=found.trend.id,
        raised_ns=int(found.trend.time_ns[last]),
        since_ns=int(found.trend.start_ns[begin]),
        share=math.expm1(share),
        share_std=std,
        surprise=float(mean.value[last] / mean.std[last]),
        bound=float(mean.limit[last]),
    )


def _begin(found: Departures, wander: Wander) -> int:
    """Return where a step most likely began, given a scatter that wanders.

    Steps far back are tried far apart, then all near the likeliest.
    """
    n = len(found.away)
    first = n - np.unique(np.geomspace(1.0, n, N_BEGINS).astype(int))[::-1]
    near = int(np.argmax(_gain(found, wander, first)))
    low, high = first[max(near - 1, 0)], first[min(near + 1, len(first) - 1)]
    again = np.unique(np.linspace(low, high, N_BEGINS).astype(int))
    return int(again[np.argmax(_gain(found, wander, again))])


def _gain(found: Departures, wander: Wander, begins: NDArray[np.int64]) -> Array:
    """Return what a step at each row explains of the departures: twice the log likelihood."""
    trend = found.trend
    time_s = (trend.time_ns - trend.time_ns[0]) / 1e9
    steps = (np.arange(len(found.away))[:, None] >= begins).astype(float)
    columns = np.column_stack([steps, found.away])
    white, _ = wander.whitened(time_s, estimate_variance(trend), columns)
    seen = white[:, :-1].T @ white[:, -1]
    return np.asarray(seen**2 / np.sum(white[:, :-1] ** 2, axis=0))


def _size(found: Departures, baseline: Baseline) -> tuple[float, float]:
    """Return the mean departure, and its standard deviation."""
    wander, trend = baseline.wander, found.trend
    time_s = (trend.time_ns - trend.time_ns[0]) / 1e9
    variance = estimate_variance(trend) + wander.white**2
    unknown = (found.doubts, found.untold, found.cell)
    value, white, slow, own, _ = _run(
        time_s, found.away, variance, *unknown, FOREVER_S, wander.memory_s
    )
    return float(value[-1]), math.sqrt(white[-1] + wander.size**2 * slow[-1] + own[-1])


@compiled
def _run(
    time_s: Array,
    away: Array,
    variance: Array,
    doubts: Array,
    untold: Array,
    cell: NDArray[np.int64],
    length_s: float,
    memory_s: float,
) -> tuple[Array, Array, Array, Array, Array]:
    """Return the running mean, the three parts of its variance, and its results.

    Weights are exp(-age/length) over the variance.  Of a scatter with correlation exp(-lag/memory)
    and variance 1 the mean has the second part; the third is what is not known of the usual: what
    places do not tell is one number near each of them.
    """
    n, p = doubts.shape
    value, white, slow = np.zeros(n), np.zeros(n), np.zeros(n)
    own, results, doubt = np.zeros(n), np.zeros(n), np.zeros(p)
    unknown, seen = np.zeros(cell.max() + 1), 0.0
    total = weighted = squares = noise = cross = double = 0.0
    for row in range(n):
        fade = 1.0
        if row:
            step = time_s[row] - time_s[row - 1]
            fade = np.exp(-step / length_s)
            cross *= fade * np.exp(-step / memory_s)
            total, weighted, unknown = total * fade, weighted * fade, unknown * fade
            squares, noise, double = squares * fade**2, noise * fade**2, double * fade**2
            seen *= fade**2
        weight = 1.0 / variance[row]
        double += 2.0 * weight * cross + weight**2
        cross += weight
        total += weight
        weighted += weight * away[row]
        # The sum of squares over all places, kept up to date.
        share = weight * untold[row]
        seen += share * (2.0 * unknown[cell[row]] + share)
        unknown[cell[row]] += share
        squares += weight**2
        noise += weight
        summed = 0.0
        for term in range(p):
            doubt[term] = fade * doubt[term] + weight * doubts[row, term]
            summed += doubt[term] ** 2
        value[row] = weighted / total
        white[row] = noise / total**2
        slow[row] = double / total**2
        own[row] = (summed + seen) / total**2
        results[row] = total**2 / squares
    return value, white, slow, own, results
