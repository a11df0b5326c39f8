"""Rates of sources: learned from their stamps, and refused where they ask for too many rows.

No message decides over the memory.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oma_identifier.intake.buffer_counters import BufferCounters
from oma_identifier.intake.source import Source
from oma_identifier.intake.thresholds import INTAKE
from oma_identifier.time_axis import tells_rate


@dataclass(frozen=True, slots=True)
class Refusal:
    """A source that takes no part.

    Parameters
    ----------
    source : Source
        Which.
    reason : str
        Code.
    text : str
        One line: what was found, what is expected, and advice.
    """

    source: Source
    reason: str
    text: str


def refuse_rates(sources: Sequence[Source], window_s: float) -> list[Refusal]:
    """Return the sources to leave out so that the rows of a window stay within bounds.

    The fastest go first.

    Parameters
    ----------
    sources : sequence of Source
        With known rates.
    window_s : float [s]
        Length of a window.
    """
    refusals: list[Refusal] = []
    left = sorted(sources, key=lambda source: source.rate_hz)
    while left and (refusal := _refuse_fastest(left, window_s)) is not None:
        refusals.append(refusal)
        left.pop()
    return refusals


def _refuse_fastest(sources: Sequence[Source], window_s: float) -> Refusal | None:
    fastest, others = sources[-1], sources[:-1]
    name, rate_hz = fastest.name.split()[0], fastest.rate_hz
    if others:
        usual_hz = float(np.median([source.rate_hz for source in others]))
        if rate_hz > INTAKE.largest_rate_factor * usual_hz:
            found = f'{name}: {rate_hz:g} Hz beside sources of {usual_hz:g} Hz'
            return Refusal(
                fastest,
                'rate_refused',
                f'{found}; at most {INTAKE.largest_rate_factor:g} times as fast',
            )
    n_channels = sum(len(source.channels) for source in sources)
    n_bytes = 8.0 * n_channels * max(2.0, window_s * rate_hz)
    if n_bytes <= INTAKE.most_window_bytes:
        return None
    longest_s = window_s * INTAKE.most_window_bytes / n_bytes
    return Refusal(
        fastest,
        'window_too_large',
        f'{name}: {window_s:g} s of {n_channels} channels at {rate_hz:g} Hz are '
        f'{n_bytes / 2**30:.3g} GiB; at most {INTAKE.most_window_bytes / 2**30:g}: '
        f'give a window_s of {longest_s:.2g} s or less, or samples of a lower rate',
    )


class RateCheck:
    """Learns the rates of sources and refuses those that ask for too much.

    Parameters
    ----------
    window_s : float [s]
        Length of a window.
    counters : BufferCounters
        Where what is refused or not known is counted.
    """

    def __init__(self, window_s: float, counters: BufferCounters) -> None:
        self.window_s = window_s
        self.counters = counters
        self._refused: set[str] = set()
        self._checked: tuple[str, ...] = ()
        self._untold: set[str] = set()

    def learn(self, source: Source) -> None:
        """Learn the rate of a source from its stamps, when they tell one."""
        source.learn_period()
        if source.clock is None and source.period_ns > 0.0:
            if not tells_rate(source.stream.samples().stamp_ns, source.period_ns):
                source.period_ns = 0.0
                if source.name not in self._untold:
                    self._untold.add(source.name)
                    self.counters.note('rate_unconfirmed', text=f'{source.name}: too few samples')

    def check(self, sources: Sequence[Source]) -> None:
        """Refuse rates that ask for more rows than a window may have."""
        timed = [source for source in sources if source.period_ns > 0.0]
        asked = tuple(f'{source.name} {source.rate_hz:.2g}' for source in timed)
        if asked == self._checked:
            return
        self._checked = asked
        refusals = refuse_rates(timed, self.window_s)
        self._refused = {refusal.source.name for refusal in refusals}
        for refusal in refusals:
            self.counters.note(refusal.reason, text=refusal.text)

    def refuses(self, source: Source) -> bool:
        """Tell whether a source takes no part."""
        return source.name in self._refused
