"""Which taps are good, and why the others are not."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from impact_testing.record import ImpactRecord
from impact_testing.taps.search import REBOUND_S, Tap, taps_of
from impact_testing.thresholds import IMPACT
from modal_core.words.named import named

Real = NDArray[np.float64]
FILTER_SAMPLES = 40
"""A segment begins, and the window of the force ends, so many samples beside the pulse: the filter
of a sigma-delta converter rings as long before and behind, and what is cut off there is missing at
the upper end of the band."""
LEAST_SHARE = 0.5
"""Of the usual time between taps."""
BEHIND_S = 0.25
"""The largest response comes so soon behind a tap."""
NAMED = 3
"""Channels told one by one."""
TWO_APART = 10.0
"""Times as many steps must two taps differ by as three."""
LONGEST_S = 16.0
"""Of a segment, where nobody says otherwise: 1/(ζω) of 1 Hz with 1 %."""


class Fault(StrEnum):
    """What makes a tap useless."""

    DOUBLE_HIT = 'double hit'
    FORCE_CLIPPED = 'force clipped'
    RESPONSE_CLIPPED = 'response clipped'
    WEAK = 'too weak'
    TOO_CLOSE = 'too close'
    RECORD_ENDS = 'record ends'
    UNLIKE = 'unlike the other taps'


@dataclass(frozen=True, slots=True)
class JudgedTap:
    """A tap with what is wrong with it.

    Parameters
    ----------
    tap : Tap
        Where it is.
    faults : tuple of (Fault, str)
        What, and by how much; empty: a good tap.
    """

    tap: Tap
    faults: tuple[tuple[Fault, str], ...] = ()

    @property
    def good(self) -> bool:
        """Whether it takes part."""
        return not self.faults

    @property
    def words(self) -> str:
        """What is wrong, for people."""
        return '; '.join(f'{fault}: {how}' for fault, how in self.faults) or 'good'

    def has(self, fault: Fault) -> bool:
        """Tell whether this is wrong with it."""
        return any(each == fault for each, _ in self.faults)

    def with_fault(self, fault: Fault, how: str) -> 'JudgedTap':
        """Return the tap with one more fault."""
        return JudgedTap(self.tap, (*self.faults, (fault, how)))


def judge_taps(record: ImpactRecord, as_read: ImpactRecord | None = None) -> tuple[JudgedTap, ...]:
    """Find the taps of a record and judge each by itself; how long they ring comes later.

    Parameters
    ----------
    record : ImpactRecord
    as_read : ImpactRecord or None
        The same as the converter gave it, where what is clipped shows; None: that is it.
    """
    read = as_read or record
    taps = taps_of(record)
    usual = float(np.median([tap.peak_n for tap in taps])) if taps else 0.0
    judged = [JudgedTap(tap, tuple(_faults(read, tap, usual))) for tap in taps]
    return tuple(_at_a_limit_of_responses(read, list(_at_the_limit(read, judged))))


def _at_the_limit(record: ImpactRecord, judged: Sequence[JudgedTap]) -> Iterator[JudgedTap]:
    """Yield the taps; those that reach a limit that others were seen to be cut at are cut, too.

    A short pulse has two samples there, or one.  Pulses that differ and whose largest force is the
    very same are cut, three of them, or two with two samples there: those of a converter with a
    thousand steps are so alike by chance once in a hundred thousand tests.
    """
    forces = [np.abs(record.force_n[each.tap.first : each.tap.last + 1]) for each in judged]
    peaks = [float(force.max()) for force in forces]
    highest = max(peaks, default=0.0)
    top = [number for number, peak in enumerate(peaks) if peak == highest]
    differ = len({float(forces[number].sum()) for number in top}) > 1
    flat = sum(int(np.count_nonzero(forces[number] == highest)) > 1 for number in top)
    cut = any(judged[number].has(Fault.FORCE_CLIPPED) for number in top)
    cut = cut or (differ and (flat > 1 or len(top) > 2))
    for each, peak in zip(judged, peaks, strict=True):
        if cut and peak == highest and not each.has(Fault.FORCE_CLIPPED):
            each = each.with_fault(Fault.FORCE_CLIPPED, f'at {highest:.3g} N')
        yield each


def _at_a_limit_of_responses(
    record: ImpactRecord, judged: Sequence[JudgedTap]
) -> Iterator[JudgedTap]:
    """Yield the taps; those whose responses reach what several reach exactly are cut, too.

    A structure answers as it is struck: taps whose forces differ by more than a few steps of the
    converter have largest responses that do.  Where three reach the very same value none the less,
    or two with two samples each, it is the limit.  Of peaks that scatter over n steps three of
    five are alike by chance about once in n² / 10.  Measured: of 400 healthy records of three
    channels, by converters of 8 to 16 bits used to a tenth of their range, three were blamed.
    """
    if len(judged) < 2:
        yield from judged
        return
    rows = [behind(record, each.tap) for each in judged]
    peaks = np.array([each.tap.peak_n for each in judged])
    limits = [_limit([each[:, n] for each in rows], peaks) for n in range(rows[0].shape[1])]
    names = record.responses.channel_names
    for each, own in zip(judged, rows, strict=True):
        cut = [
            name
            for name, limit, column in zip(names, limits, own.T, strict=True)
            if limit is not None and bool((np.abs(column) >= limit).any())
        ]
        if cut and not each.has(Fault.RESPONSE_CLIPPED):
            each = each.with_fault(Fault.RESPONSE_CLIPPED, named(cut, NAMED))
        yield each


def _limit(columns: Sequence[Real], peaks_n: Real) -> float | None:
    """Return the size at which a channel is cut; None: it is not seen to be."""
    every = np.concatenate(columns)
    steps = np.abs(np.diff(every))
    step = float(steps[steps > 0.0].min(initial=np.inf))
    found = []
    for sign in (1.0, -1.0):
        top = float((sign * every).max())
        counts = np.array([int(np.count_nonzero(sign * each == top)) for each in columns])
        force = peaks_n[counts > 0]
        differ = top * (float(force.max() / force.min()) - 1.0) / step / IMPACT.steps_of_top
        if differ > (1.0 if len(force) > 2 else TWO_APART) and (
            len(force) > 2 or np.count_nonzero(counts > 1) > 1
        ):
            found.append(top)
    return min(found) if found else None


def behind(record: ImpactRecord, tap: Tap) -> Real:
    """Return the responses behind a tap, where they are largest, (n, n_channels) array."""
    end = min(tap.first + round(BEHIND_S * record.rate_hz), record.run_of(tap.first).end)
    return np.asarray(record.responses.widened(slice(tap.first, end)))


def usual_length(gaps_s: Sequence[float]) -> float:
    """Return the longest segments for which no tap is lost that has half the usual time.

    How long they are matters little: what the ends leave out is known.

    Parameters
    ----------
    gaps_s : sequence of float [s]
        From each good tap to what ends its segment.
    """
    lengths = np.minimum(np.asarray(gaps_s, dtype=float), LONGEST_S)
    if not lengths.size:
        return 0.0
    return float(lengths[lengths >= LEAST_SHARE * np.median(lengths)].min())


def gaps(record: ImpactRecord, taps: Sequence[JudgedTap]) -> list[float]:
    """Return the time from the begin of each tap to the next one, or the end of its recording."""
    begins = [begin_of(record, each.tap) for each in taps]
    ends = [record.run_of(begin).end for begin in begins]
    ends = [min(pair) for pair in zip(ends, (*begins[1:], *ends[-1:]), strict=True)]
    return [(end - begin) / record.rate_hz for begin, end in zip(begins, ends, strict=True)]


def begin_of(record: ImpactRecord, tap: Tap) -> int:
    """Return the first row of a tap's segment."""
    return max(record.run_of(tap.first).first, tap.first - FILTER_SAMPLES)


def with_length(
    record: ImpactRecord, taps: Sequence[JudgedTap], length_s: float
) -> tuple[JudgedTap, ...]:
    """Turn down taps whose segment is cut short."""
    said = []
    last = {record.run_of(each.tap.first): each for each in taps}
    for each, gap in zip(taps, gaps(record, taps), strict=True):
        if each.good and gap < length_s - 0.5 / record.rate_hz:
            ends = last[record.run_of(each.tap.first)] is each
            fault, what = (Fault.RECORD_ENDS, '') if ends else (Fault.TOO_CLOSE, 'the next ')
            each = each.with_fault(fault, f'{what}{gap:.3g} s later, {length_s:.3g} s needed')
        said.append(each)
    return tuple(said)


def _faults(record: ImpactRecord, tap: Tap, usual_n: float) -> list[tuple[Fault, str]]:
    said = []
    if tap.rebound_share and tap.goes_on_s > REBOUND_S:
        # No hammer bounces for so long: these are taps, each within a rebound of the last.
        how = f'the next within {REBOUND_S:g} s, on and on for {tap.goes_on_s:.2g} s'
        said.append((Fault.TOO_CLOSE, how))
    elif tap.rebound_share:
        said.append((Fault.DOUBLE_HIT, f'the second of {100 * tap.rebound_share:.0f} %'))
    if is_clipped(record.force_n[tap.first : tap.last + 1]):
        said.append((Fault.FORCE_CLIPPED, f'at {tap.peak_n:.3g} N'))
    if tap.peak_n < IMPACT.weak_share * usual_n:
        said.append((Fault.WEAK, f'{tap.peak_n:.2g} N of usually {usual_n:.2g} N'))
    rows = behind(record, tap)
    names = record.responses.channel_names
    clipped = [name for name, column in zip(names, rows.T, strict=True) if is_clipped(column)]
    if clipped:
        said.append((Fault.RESPONSE_CLIPPED, named(clipped, NAMED)))
    return said


def is_clipped(values: Real) -> bool:
    """Tell a top cut off from a round one that a converter shows as a few equal samples.

    A round top with three equal samples falls by less than four steps of the converter to its
    neighbours; one that is cut falls by the slope of the signal.
    """
    steps = np.abs(np.diff(values))
    step = float(steps[steps > 0.0].min(initial=np.inf))
    return any(_is_cut(side, step) for side in (values, -values))


def _is_cut(values: Real, step: float) -> bool:
    top = values.max(initial=-np.inf)
    at = values >= top
    edges = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(int)))
    for first, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        beside = [values[row] for row in (first - 1, end) if 0 <= row < len(values)]
        if end - first >= 3 and len(beside) == 2:
            return bool(top - max(beside) > IMPACT.steps_of_top * step)
    return False
