"""Sensors that are not heard for a while: a loose cable or plug, knocks of their own.

A short stretch is filled in from the others, as lost samples are from those about them; a sensor
that is not heard for longer takes no part in the window.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from oma_identifier.motion import Cleaned
from oma_identifier.synchrony.block_regression import BlockRegression, Regressors
from oma_identifier.synchrony.half_windows import HalfWindows
from oma_identifier.synchrony.in_step import columns_of, in_step
from oma_identifier.synchrony.interruption_search import Follows, InterruptionSearch
from oma_identifier.synchrony.thresholds import SYNCHRONY

INTERRUPTED = 'interrupted'
MOST_TOGETHER = 64
"""Channels regressed on one another; of more every second, third, ... are."""
EDGE = 3.0
"""Standard deviations of what is usually left, from where on a sample is not heard."""

Real = NDArray[np.float64]
Spans = tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class _Interruption:
    """When a channel is not heard, and what the others say it would show.

    Parameters
    ----------
    name : str
        Channel.
    weights : (n_columns,) array
        Of the prediction, in the units of the samples.
    regressors : Regressors
        Whose columns these are.
    n_beside : int
        Rows to either side that offsets are read off.
    spans_ns : tuple of (int, int) [ns]
        From when to when.
    """

    name: str
    weights: Real
    regressors: Regressors
    n_beside: int
    spans_ns: Spans

    def rows(self, samples: Samples) -> Spans:
        """Return first rows of the stretches in a window, and those after their last."""
        per_ns = samples.sample_rate_hz / NANOSECONDS_PER_SECOND
        n_rows = len(samples.acceleration)
        spans = [
            [min(max(0, round((each - samples.start_ns) * per_ns)), n_rows) for each in span]
            for span in self.spans_ns
        ]
        return tuple((first, last) for first, last in spans if last > first)


class Interruptions:
    """Mends window after window; what sensors were is remembered."""

    def __init__(self) -> None:
        self._known: dict[str, Follows] = {}
        self._held: list[_Interruption] = []
        self._half_windows = HalfWindows()

    def mend(self, cleaned: Cleaned) -> Cleaned:
        """Return a window without what is no measurement; the very same one where there is none.

        Channels say when they were interrupted, and which were left out.  A robot that moves far
        moves its sensors as no structure does: nothing is told of these.
        """
        samples = cleaned.samples
        if 'gross_motion' in cleaned.flags:
            return cleaned
        self._look(samples)
        found = {each.name: rows for each in self._held if (rows := each.rows(samples))}
        if not found:
            return cleaned
        most = SYNCHRONY.most_interrupted * len(samples.acceleration)
        lost = {name: sum(last - first for first, last in rows) for name, rows in found.items()}
        out = tuple(name for name, n_rows in lost.items() if n_rows > most)
        filled = [each for each in self._held if each.name in found and each.name not in out]
        mended = replace(
            cleaned,
            samples=_filled(samples, filled) if filled else samples,
            channel_flags={**cleaned.channel_flags, **dict.fromkeys(found, INTERRUPTED)},
            interrupted_ns={n: _times(samples, rows) for n, rows in found.items()},
        )
        if not out:
            return mended
        kept = np.array([name not in out for name in samples.channel_names])
        mended = in_step(mended, np.zeros(len(kept)), kept)
        return replace(mended, left_out=(*mended.left_out, *out))

    def _look(self, samples: Samples) -> None:
        if not self._half_windows.is_due(samples):
            return
        self._held = []
        n_groups = math.ceil(len(samples.channels) / MOST_TOGETHER)
        for first in range(n_groups):
            places = np.arange(first, len(samples.channels), n_groups)
            regression = BlockRegression(samples, places)
            if regression.n_blocks >= SYNCHRONY.fewest_blocks:
                self._held += self._interrupted(samples, regression)

    def _interrupted(self, samples: Samples, regression: BlockRegression) -> list[_Interruption]:
        channels = [samples.channels[place] for place in regression.channels]
        names = tuple(channel.name for channel in channels)
        search = InterruptionSearch(
            regression, list(columns_of(channels).values()), names, self._known
        )
        marks = search.marks()
        self._known |= search.known
        found = []
        for place, marked in marks.items():
            weights, limit = search.physical(place), EDGE * search.usual_left(place)
            spans = _spans(samples, regression, weights, place, marked, limit)
            found.append(
                _Interruption(
                    names[place],
                    weights,
                    regression.regressors,
                    regression.n_rows,
                    _times(samples, spans),
                )
            )
        return found


def _spans(
    samples: Samples,
    regression: BlockRegression,
    weights: Real,
    place: int,
    marked: NDArray[np.bool_],
    limit: float,
) -> Spans:
    """Return the rows of stretches, told sample by sample at their edges."""
    size, lags, n_all = regression.n_rows, regression.n_lags, len(samples.acceleration)
    column, margin = int(regression.channels[place]), max(2, size // 10)
    near = np.convolve(marked, [1, 1, 1], mode='same') > 0
    edges = np.flatnonzero(np.diff(np.concatenate([[0], near, [0]])))
    spans = []
    for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        first = lags + begin * size if begin else 0
        last = lags + end * size if end < len(marked) else n_all
        away = samples.acceleration[first:last, column]
        away = away - regression.regressors.about(samples, first - lags, last - lags) @ weights
        beyond = np.flatnonzero(np.abs(away - np.median(away)) > limit)
        if len(beyond):
            first, last = first + int(beyond[0]), first + int(beyond[-1]) + 1
        spans.append((max(0, first - margin), min(n_all, last + margin)))
    return tuple(spans)


def _filled(samples: Samples, found: Sequence[_Interruption]) -> Samples:
    """Return samples with what the others say in place of what is not heard.

    Offsets before and after are joined by a straight line.
    """
    values = samples.acceleration.copy()
    for each in found:
        column = samples.channel_names.index(each.name)
        reach, lags = each.n_beside, each.regressors.n_lags
        for first, last in each.rows(samples):
            low, high = max(0, first - reach), min(len(values), last + reach)
            said = each.regressors.about(samples, low - lags, high - lags) @ each.weights
            away = samples.acceleration[low:high, column] - said
            beside = away[: first - low], away[last - low :]
            ends = [part.mean() for part in beside if len(part)] or [0.0]
            line = np.linspace(ends[0], ends[-1], last - first)
            values[first:last, column] = said[first - low : last - low] + line
    return replace(samples, acceleration=values)


def _times(samples: Samples, spans: Spans) -> Spans:
    step_ns = NANOSECONDS_PER_SECOND / samples.sample_rate_hz
    return tuple(
        (samples.start_ns + round(first * step_ns), samples.start_ns + round(last * step_ns))
        for first, last in spans
    )
