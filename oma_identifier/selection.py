"""Automatic selection: which clusters of poles are modes of the structure.

What decides is a statistical statement instead of a tuned threshold: the data must determine the
pole.  Its standard deviations, in half-power half-widths, must be smaller than one (the peak is
narrower than its own blur), and not much larger than the information in the record allows any
method to reach for a real mode, u₀ = 1 / sqrt(2π ζ f T).  A mode comes within a small multiple of
that limit; a spurious pole follows the noise and misses it by a factor of ten or more, at any
rate, length and number of channels.

References
----------
Au (2014), doi:10.1016/j.ymssp.2014.03.008 (uncertainty laws of operational modal analysis).
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.indicators import mac, mpc
from modal_core.poles import PoleStatus
from oma_identifier.bands import UPPER, UPPER_UNDECIMATED
from oma_identifier.cluster import Cluster, cluster_poles
from oma_identifier.settings import IdentificationSettings
from oma_identifier.ssi_poles import BandIdentification
from oma_identifier.stabilise import stabilise
from oma_identifier.uncertainty import deviation_from, PoleDeviation

WIDEST = 0.7
"""Largest standard deviation of the most precise member, in half-power half-widths."""
WIDEST_MEAN = 1.0
"""Largest standard deviation of what is reported, in half-power half-widths."""
WIDEST_LIMIT = 0.3
"""Largest limit u₀: noise has peaks that look like less certain modes."""
FROM_LIMIT = 6.0
"""Largest standard deviation in multiples of what the record allows."""
WIDEST_FROM_LIMIT = 3.0
"""Largest product of the two: what is blurred must be near the limit."""
LEAST_MPC = 0.5
"""Below, the phases of a shape are nearer to a circle than to a line."""
ORDERS_SHARE = 6
"""A mode repeats over at least one in this many model orders, and over three."""
SAME_MAC = 0.9
HOPELESS = 1.5
"""A cluster is dropped early when three members miss what is asked for by this factor."""
TRIALS = 6
"""Members of a cluster, spread over the model orders, whose standard deviations are compared."""
WITHIN = 2.0
"""Members whose variance is within this factor of the best are averaged."""
BIASED = 1.5
"""Squared difference over its variance from where on a member counts as biased; 1 on average."""


@dataclass(frozen=True, slots=True)
class SelectedPole:
    """One mode candidate.

    Parameters
    ----------
    band : BandIdentification
        Where it was found.
    cluster : Cluster
        Poles it is the mean of.
    pole : complex [rad/s]
        Continuous time.
    shape : (n_channels,) complex array
        Mode shape over channels divided by their root mean square in the band.
    deviation : PoleDeviation
        Standard deviations of the mean.
    best : PoleDeviation
        Standard deviations of the most precise member: whether there is a mode at all.
    """

    band: BandIdentification
    cluster: Cluster
    pole: complex
    shape: NDArray[np.complex128]
    deviation: PoleDeviation
    best: PoleDeviation

    @property
    def frequency_hz(self) -> float:
        """Natural frequency [Hz]."""
        return abs(self.pole) / (2.0 * math.pi)

    @property
    def damping_ratio(self) -> float:
        """Damping ratio."""
        return -self.pole.real / abs(self.pole)

    @property
    def physical_shape(self) -> NDArray[np.complex128]:
        """Mode shape in units of the channels."""
        return np.asarray(self.shape * self.band.source.scale)

    def _widths(self, deviation: PoleDeviation) -> float:
        """Return the larger standard deviation in half-power half-widths."""
        width = self.damping_ratio * self.frequency_hz
        return max(
            deviation.frequency_std_hz / width, deviation.damping_ratio_std / self.damping_ratio
        )

    @property
    def is_determined(self) -> bool:
        """Whether the data determine the pole; False when a deviation is NaN."""
        blur, reported = self._widths(self.best), self._widths(self.deviation)
        cycles = self.damping_ratio * self.frequency_hz * self.band.source.covariance.duration_s
        limit = 1.0 / math.sqrt(2.0 * math.pi * cycles)
        return (
            limit < WIDEST_LIMIT
            and reported < WIDEST_MEAN
            and blur < min(WIDEST, FROM_LIMIT * limit)
            and blur**2 < WIDEST_FROM_LIMIT * limit
        )


@dataclass(frozen=True, slots=True)
class BandSelection:
    """Selected poles of one band and the status of all its poles.

    Parameters
    ----------
    band : BandIdentification
        The band.
    selected : tuple of SelectedPole
        Candidates that passed, by frequency.
    status : (n_poles,) uint8 array
        A PoleStatus each.
    """

    band: BandIdentification
    selected: tuple[SelectedPole, ...]
    status: NDArray[np.uint8]


def select_in_band(band: BandIdentification, settings: IdentificationSettings) -> BandSelection:
    """Select the modes of one band."""
    poles = band.poles
    status = stabilise(poles, band.source.band, settings.max_damping_ratio)
    candidates = np.flatnonzero(status == PoleStatus.KEPT)
    status[candidates] = PoleStatus.CLUSTER_OUTLIER
    least = max(3, math.ceil(band.n_orders / ORDERS_SHARE))
    selected = []
    for cluster in cluster_poles(poles, candidates):
        verdict, pole = _judge(band, cluster, least)
        status[cluster.members] = verdict
        if pole is not None:
            selected.append(pole)
    distinct = without_repeats(selected)
    for pole in selected:
        if not any(pole is other for other in distinct):
            status[pole.cluster.members] = PoleStatus.CLUSTER_OUTLIER
    return BandSelection(band, tuple(distinct), status)


def _judge(
    band: BandIdentification, cluster: Cluster, least: int
) -> tuple[PoleStatus, SelectedPole | None]:
    if len(cluster) < least:
        return PoleStatus.SMALL_CLUSTER, None
    picks = np.unique(np.linspace(0, len(cluster) - 1, TRIALS).round().astype(int))
    rows = cluster.members[picks]
    # What costs least comes first: most clusters never need a gradient.
    if _turns(mean_shape(band.poles.shape[:, rows])):
        return PoleStatus.COMPLEX_SHAPE, None
    if _hopeless(band, rows):
        return PoleStatus.UNCERTAIN, None
    pole = _average(band, cluster, rows)
    if not pole.is_determined or _cut_off(pole):
        return PoleStatus.UNCERTAIN, None
    if _turns(pole.shape):
        return PoleStatus.COMPLEX_SHAPE, None
    return PoleStatus.KEPT, pole


def _turns(shape: NDArray[np.complex128]) -> bool:
    """Tell whether the phases of a shape are nearer to a circle than to a line."""
    return len(shape) > 1 and bool(mpc(shape[:, None])[0] < LEAST_MPC)


def _cut_off(pole: SelectedPole) -> bool:
    """Tell whether the upper flank of a peak lies where anti-aliasing filters fall.

    The edge of such a filter under noise looks like a broad resonance.
    """
    rate = pole.band.source.band.sample_rate_hz
    flank = pole.frequency_hz * (1.0 + 2.0 * pole.damping_ratio)
    return pole.frequency_hz > UPPER * rate and flank > UPPER_UNDECIMATED * rate


def _hopeless(band: BandIdentification, rows: NDArray[np.int64]) -> bool:
    """Tell from up to three members whether it is worth looking at the others."""
    duration_s = band.source.covariance.duration_s
    pole = band.poles.pole[rows]
    cycles = np.median(-pole.real) * duration_s / (2.0 * math.pi)
    limit = 1.0 / math.sqrt(2.0 * math.pi * cycles)
    if limit > HOPELESS * WIDEST_LIMIT:
        return True
    widest = min(WIDEST, FROM_LIMIT * limit, math.sqrt(WIDEST_FROM_LIMIT * limit))
    for member in (len(rows) // 2, len(rows) - 1, 0):
        series = band.influence(rows[member : member + 1])[:, 0]
        variance = np.mean(np.abs(series) ** 2) / len(series)
        # The variance of a complex pole is that of frequency and damping together.
        if variance <= 2.0 * (HOPELESS * widest * pole.real[member]) ** 2:
            return False
    return True


def _average(band: BandIdentification, cluster: Cluster, rows: NDArray[np.int64]) -> SelectedPole:
    """Average the best determined members, with the deviation of that average.

    The members' influence series are averaged like the members themselves, so the deviation of
    the average is exact to first order however strongly the model orders are correlated.
    """
    series = band.influence(rows)
    duration_s = band.source.covariance.duration_s
    best = int(np.argmin(np.mean(np.abs(series) ** 2, axis=0)))
    good = _agreeing(band.poles.pole[rows], series)
    pole = complex(np.mean(band.poles.pole[rows[good]]))
    deviation = deviation_from(series[:, good].mean(axis=1), pole, duration_s)
    shape = mean_shape(band.poles.shape[:, rows[good]])
    precise = deviation_from(series[:, best], complex(band.poles.pole[rows[best]]), duration_s)
    return SelectedPole(band, cluster, pole, shape, deviation, precise)


def _agreeing(poles: NDArray[np.complex128], series: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Return which members to average: precise, and not biased by too low a model order.

    Members of higher order have less bias and more scatter.  The anchor is the most precise
    member whose differences to those of higher order are no larger than such differences
    scatter; the others must agree with the anchor in the same way.
    """
    n_blocks = len(series)
    variance = np.mean(np.abs(series) ** 2, axis=0) / n_blocks
    spread = np.mean(np.abs(series[:, :, None] - series[:, None]) ** 2, axis=0) / n_blocks
    differs = np.abs(poles[:, None] - poles) ** 2
    surprise = np.divide(differs, spread, out=np.zeros_like(differs), where=spread > 0.0)
    anchor = len(poles) - 1
    for member in np.argsort(variance):
        above = surprise[member, member + 1 :]
        if len(above) == 0 or np.median(above) <= BIASED:
            anchor = int(member)
            break
    near = surprise[anchor] <= 2.0 * BIASED
    near[anchor] = True
    return np.asarray(near & (variance <= WITHIN * variance[anchor]))


def mean_shape(shapes: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the direction that the columns share, scaled like the first of them."""
    left, values, _ = np.linalg.svd(shapes / np.linalg.norm(shapes, axis=0), full_matrices=False)
    return np.asarray(left[:, 0] * values[0])


def without_repeats(poles: list[SelectedPole]) -> list[SelectedPole]:
    """Return one pole per mode, the best determined, by frequency."""
    kept: list[SelectedPole] = []
    for pole in sorted(poles, key=_absolute_uncertainty):
        if not any(_same_mode(pole, other) for other in kept):
            kept.append(pole)
    return sorted(kept, key=lambda pole: pole.frequency_hz)


def _absolute_uncertainty(pole: SelectedPole) -> float:
    return pole.deviation.frequency_std_hz / pole.frequency_hz


def _same_mode(first: SelectedPole, second: SelectedPole) -> bool:
    width = max(-first.pole.real, -second.pole.real)
    if abs(first.pole - second.pole) > 2.0 * width:
        return False
    own = first.band.source.scale
    other = second.physical_shape * np.divide(1.0, own, out=np.zeros_like(own), where=own > 0.0)
    alike = bool(mac(first.shape, other)[0, 0] > SAME_MAC)
    if first.band is not second.band:
        return alike
    # Two modes show up at the same model orders side by side; two views of one mode take turns.
    orders = first.band.poles.model_order
    shared = np.intersect1d(orders[first.cluster.members], orders[second.cluster.members])
    side_by_side = len(shared) > 0.5 * min(len(first.cluster), len(second.cluster))
    return alike or not side_by_side
