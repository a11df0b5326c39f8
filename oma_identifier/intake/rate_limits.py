"""How many rows the rates of sources may ask for: no message decides over the memory."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oma_identifier.intake.source import Source

LARGEST_FACTOR = 256.0
"""Times the rate of the neighbours: on so fine a grid they would say nothing above 1/256 of the
band, and the filters that put the fast source on theirs would be 256 times as long."""
MOST_WINDOW_BYTES = 2**30
"""Samples of one window, as float64: 100 channels at 4 kHz for 335 s."""


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
        if rate_hz > LARGEST_FACTOR * usual_hz:
            found = f'{name}: {rate_hz:g} Hz beside sources of {usual_hz:g} Hz'
            return Refusal(
                fastest, 'rate_refused', f'{found}; at most {LARGEST_FACTOR:g} times as fast'
            )
    n_channels = sum(len(source.channels) for source in sources)
    n_bytes = 8.0 * n_channels * max(2.0, window_s * rate_hz)
    if n_bytes <= MOST_WINDOW_BYTES:
        return None
    longest_s = window_s * MOST_WINDOW_BYTES / n_bytes
    return Refusal(
        fastest,
        'window_too_large',
        f'{name}: {window_s:g} s of {n_channels} channels at {rate_hz:g} Hz are '
        f'{n_bytes / 2**30:.3g} GiB; at most {MOST_WINDOW_BYTES / 2**30:g}: '
        f'give a window_s of {longest_s:.2g} s or less, or samples of a lower rate',
    )
