"""Guidance while somebody taps: each tap is judged as soon as it is over."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impact_testing.record import ImpactRecord
from impact_testing.taps.judge import BEHIND_S, Fault, judge_taps, JudgedTap, LEAST_SHARE
from impact_testing.taps.search import REBOUND_S
from impact_testing.thresholds import IMPACT
from modal_core.channel import Channel
from modal_core.samples import Samples

Real = NDArray[np.float64]
KEPT_S = 4.0
"""Of the stream: a tap with what comes before and behind, however long it lasts."""
REMEMBERED = 50
"""Taps that say what is usual."""


@dataclass(frozen=True, slots=True)
class Guidance:
    """What to tell the person at the hammer.

    Parameters
    ----------
    time_s : float [s]
        Of the peak, since the stream began.
    judged : JudgedTap
        The tap; its rows are those of the stretch it was judged in.
    n_good : int
        Good taps so far.
    """

    time_s: float
    judged: JudgedTap
    n_good: int

    @property
    def words(self) -> str:
        """One line: ``good, 3 so far`` or ``again: double hit: the second of 40 %``."""
        return f'good, {self.n_good} so far' if self.judged.good else f'again: {self.judged.words}'


class TapJudge:
    """Judges a stream of force and responses, block by block, in memory of four seconds.

    Parameters
    ----------
    sample_rate_hz : float [Hz]
    channels : tuple of Channel
        Of the responses.
    """

    def __init__(self, sample_rate_hz: float, channels: tuple[Channel, ...]) -> None:
        self._rate_hz, self._channels = sample_rate_hz, channels
        self._force = np.empty(0)
        self._motion = np.empty((0, len(channels)))
        self._first_row = 0
        self._judged_to = 0
        self._peaks_n: list[float] = []
        self._begins_s: list[float] = []
        self._n_good = 0

    def feed(self, force_n: Real, motion: Real) -> list[Guidance]:
        """Take a block, and return what can be said of taps that are over.

        Parameters
        ----------
        force_n : (n,) array [N]
        motion : (n, n_channels) array
        """
        self._force = np.concatenate([self._force, force_n])
        self._motion = np.concatenate([self._motion, motion])
        said = self._judge()
        too_many = max(0, len(self._force) - round(KEPT_S * self._rate_hz))
        self._force, self._motion = self._force[too_many:], self._motion[too_many:]
        self._first_row += too_many
        return said

    def _judge(self) -> list[Guidance]:
        if len(self._force) < 2:
            return []
        samples = Samples(self._motion, self._rate_hz, self._channels)
        over = len(self._force) - round(max(REBOUND_S, BEHIND_S) * self._rate_hz)
        said = []
        for each in judge_taps(ImpactRecord(self._force, samples)):
            row = self._first_row + each.tap.peak
            if each.tap.last < over and row > self._judged_to and each.tap.first > 0:
                # What follows within a rebound is part of this tap.
                self._judged_to = row + round(REBOUND_S * self._rate_hz)
                said.append(self._guidance(each, row / self._rate_hz))
        return said

    def _guidance(self, each: JudgedTap, time_s: float) -> Guidance:
        usual = float(np.median([*self._peaks_n, each.tap.peak_n]))
        weak = each.tap.peak_n < IMPACT.weak_share * usual
        if weak and Fault.WEAK not in {fault for fault, _ in each.faults}:
            how = f'{each.tap.peak_n:.2g} N of usually {usual:.2g} N'
            each = each.with_fault(Fault.WEAK, how)
        pauses = np.diff(self._begins_s)
        pause = time_s - self._begins_s[-1] if self._begins_s else np.inf
        if len(pauses) and pause < LEAST_SHARE * np.median(pauses):
            how = f'{pause:.2g} s after the last, usually {np.median(pauses):.2g} s'
            each = each.with_fault(Fault.TOO_CLOSE, how)
        self._peaks_n = [*self._peaks_n, each.tap.peak_n][-REMEMBERED:]
        self._begins_s = [*self._begins_s, time_s][-REMEMBERED:]
        self._n_good += each.good
        return Guidance(time_s, each, self._n_good)
