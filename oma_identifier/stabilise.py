"""Which poles repeat from one model order to the next, and why the others do not count."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modal_core.indicators import mac
from modal_core.poles import PoleStatus
from oma_identifier.bands import Band

LEAST_RELATIVE_STEP = 0.005
"""Frequencies this close agree whatever the damping: lightly damped poles are as sharp as that."""
DAMPING_STEP = 0.5
"""Damping ratios agree within this share of their mean; twice what 10 cycles ζfT determine."""
LEAST_MAC = 0.8


@dataclass(frozen=True, slots=True)
class BandPoles:
    """Continuous-time poles of one band over the model order.

    Parameters
    ----------
    model_order : (n_poles,) int array
        Even orders.
    eigenvalue : (n_poles,) complex array
        Discrete time.
    pole : (n_poles,) complex array [rad/s]
        Continuous time.
    shape : (n_channels, n_poles) complex array
        Of channels divided by their root mean square: gains do not matter.
    """

    model_order: NDArray[np.int64]
    eigenvalue: NDArray[np.complex128]
    pole: NDArray[np.complex128]
    shape: NDArray[np.complex128]

    @property
    def frequency_hz(self) -> NDArray[np.float64]:
        """Natural frequencies [Hz]."""
        return np.abs(self.pole) / (2.0 * np.pi)

    @property
    def damping_ratio(self) -> NDArray[np.float64]:
        """Damping ratios."""
        return -self.pole.real / np.abs(self.pole)


def stabilise(poles: BandPoles, band: Band, max_damping_ratio: float) -> NDArray[np.uint8]:
    """Give every pole a status: kept when it passes the hard and the soft criteria.

    Hard: stable, not overdamped, inside the band.  Soft: a pole of the neighbouring order (below
    or above) agrees in frequency within the pole's half-power half-width, in damping and in shape.

    Returns
    -------
    (n_poles,) uint8 array
        A :class:`PoleStatus` each.
    """
    frequency, damping = poles.frequency_hz, poles.damping_ratio
    status = np.full(len(frequency), PoleStatus.KEPT, dtype=np.uint8)
    status[(frequency < band.low_hz) | (frequency > band.high_hz)] = PoleStatus.OUT_OF_BAND
    status[damping > max_damping_ratio] = PoleStatus.OVERDAMPED
    status[damping <= 0.0] = PoleStatus.UNSTABLE_POLE
    eligible = np.flatnonzero(status == PoleStatus.KEPT)
    order = poles.model_order[eligible]
    best = np.full(len(eligible), np.iinfo(np.uint8).max, dtype=np.uint8)
    for low, high in pairwise(np.unique(poles.model_order)):
        below, above = np.flatnonzero(order == low), np.flatnonzero(order == high)
        if len(below) == 0 or len(above) == 0:
            continue
        reason = _agreement(poles, eligible[below], eligible[above])
        best[below] = _better(best[below], reason.min(axis=1))
        best[above] = _better(best[above], reason.min(axis=0))
    best[best == np.iinfo(np.uint8).max] = len(_REASONS) - 1
    status[eligible] = _REASONS[best]
    return status


# Index = how far the pair got through the criteria, best first.
_REASONS = np.array(
    [
        PoleStatus.KEPT,
        PoleStatus.SHAPE_NOT_STABLE,
        PoleStatus.DAMPING_NOT_STABLE,
        PoleStatus.FREQUENCY_NOT_STABLE,
    ],
    dtype=np.uint8,
)


def _agreement(
    poles: BandPoles, first: NDArray[np.int64], second: NDArray[np.int64]
) -> NDArray[np.uint8]:
    """Return how far each pair gets, (n_first, n_second) array of indices into the reasons."""
    f1, f2 = poles.frequency_hz[first][:, None], poles.frequency_hz[second][None]
    d1, d2 = poles.damping_ratio[first][:, None], poles.damping_ratio[second][None]
    mean_damping = (d1 + d2) / 2.0
    frequency_differs = np.abs(f1 / f2 - 1.0) > np.maximum(mean_damping, LEAST_RELATIVE_STEP)
    damping_differs = np.abs(d1 - d2) > np.maximum(
        DAMPING_STEP * mean_damping, LEAST_RELATIVE_STEP
    )
    shape_differs = mac(poles.shape[:, first], poles.shape[:, second]) < LEAST_MAC
    return np.where(
        frequency_differs, 3, np.where(damping_differs, 2, np.where(shape_differs, 1, 0))
    ).astype(np.uint8)


def _better(first: NDArray[np.uint8], second: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.minimum(first, second)
