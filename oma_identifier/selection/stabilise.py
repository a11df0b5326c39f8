"""Which poles repeat from one model order to the next, and why the others do not count."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.numbers.indicators import mac_of_pairs
from modal_core.poles import PoleStatus
from oma_identifier.covariance import Band
from oma_identifier.selection.thresholds import SELECTION


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
    first, second = _neighbours(poles.model_order, eligible)
    reason = _agreement(poles, first, second)
    best = np.full(len(status), len(_REASONS) - 1, dtype=np.uint8)
    np.minimum.at(best, first, reason)
    np.minimum.at(best, second, reason)
    status[eligible] = _REASONS[best[eligible]]
    return status


def _neighbours(
    orders: NDArray[np.int64], eligible: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return all pairs of poles of successive model orders, lower order first."""
    level = np.unique(orders, return_inverse=True)[1][eligible]
    eligible, level = eligible[np.argsort(level, kind='stable')], np.sort(level)
    starts, ends = np.searchsorted(level, level + 1), np.searchsorted(level, level + 2)
    count = ends - starts
    first = np.repeat(np.arange(len(level)), count)
    second = np.arange(len(first)) - np.repeat(np.cumsum(count) - count - starts, count)
    return eligible[first], eligible[second]


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
    """Return how far each pair gets, (n_pairs,) array of indices into the reasons."""
    frequency, damping = poles.frequency_hz, poles.damping_ratio
    mean_damping = (damping[first] + damping[second]) / 2.0
    frequency_differs = np.abs(frequency[first] / frequency[second] - 1.0) > np.maximum(
        mean_damping, SELECTION.least_relative_step
    )
    damping_differs = np.abs(damping[first] - damping[second]) > np.maximum(
        SELECTION.damping_step * mean_damping, SELECTION.least_relative_step
    )
    reason = np.where(frequency_differs, 3, np.where(damping_differs, 2, 0)).astype(np.uint8)
    alike = np.flatnonzero(reason == 0)
    reason[alike] = mac_of_pairs(poles.shape[:, first[alike]], poles.shape[:, second[alike]]) < (
        SELECTION.repeated_mac
    )
    return reason
