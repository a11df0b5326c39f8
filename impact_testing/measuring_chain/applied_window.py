"""Responses that were windowed before they were saved: their damping is not the structure's."""

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.stats import f as fisher

from impact_testing.record import ImpactRecord, runs_of
from impact_testing.taps import begin_of, taps_of
from modal_core.errors import IdentificationError

Real = NDArray[np.float64]
AT_END = 0.1
"""Share of a run whose noise is compared with that before the tap."""
ORDER = 16
"""Samples that let expect the next: what rings is expected, noise is not."""
FEWEST_ROWS, MOST_ROWS = 6 * ORDER, 256 * ORDER
CHANCE = 1e-6
"""Of runs whose noise is as even as noise is."""
LEAST_FALL = 0.5
"""Share of the amplitude: less of a window adds less damping than modes of a structure differ."""


def check_unwindowed(records: Sequence[ImpactRecord]) -> None:
    """Refuse responses whose noise falls within every run, as an exponential window makes it.

    That of a structure that rings before the tap, or behind it, is the same.

    Raises
    ------
    IdentificationError
        Naming how far it falls.
    """
    for record in records:
        falls = [_fall(run) for run in runs_of(record)]
        if falls and None not in falls:
            fall = float(np.median(np.array(falls, dtype=float)))
            raise IdentificationError(
                'an exponential window was applied to these responses',
                where=record.name,
                found=f'noise that falls to {fall:.2g} of what it is before the tap',
                expected='samples as they were measured: what a window adds to the damping is'
                ' not known',
                advice='save them without windows of force and response; none is needed',
            )


def _fall(run: ImpactRecord) -> float | None:
    """Return to which share the noise falls within a run; None where it does not surely."""
    first = min((begin_of(run, tap) for tap in taps_of(run)), default=0)
    n_rest, n_end = min(first, MOST_ROWS), min(round(AT_END * len(run.force_n)), MOST_ROWS)
    if min(n_rest, n_end) < FEWEST_ROWS:
        return None
    before = _noise(run.responses.widened(slice(first - n_rest, first)))
    after = _noise(run.responses.widened(slice(-n_end, None)))
    ratio = float(np.median(after / np.maximum(before, 1e-300)))
    chance = fisher.cdf(ratio, n_end - 2 * ORDER, n_rest - 2 * ORDER)
    fall = float(np.sqrt(ratio))
    return fall if chance < CHANCE and 0.0 < fall < LEAST_FALL else None


def _noise(rows: Real) -> Real:
    """Return the power of what the samples before do not let expect, by channel."""
    return np.array([_unexpected(column) for column in (rows - rows.mean(axis=0)).T])


def _unexpected(values: Real) -> float:
    before = sliding_window_view(values[:-1], ORDER)
    weights, *_ = np.linalg.lstsq(before, values[ORDER:], rcond=None)
    left = values[ORDER:] - before @ weights
    return float(np.sum(left**2) / (len(left) - ORDER))
