"""Automatic selection: which clusters of poles are modes of the structure.

What decides are statistical statements instead of tuned thresholds.  The data must determine the
pole: its half-power half-width must be two standard deviations from zero, or most model orders
have it and it scatters by a small multiple of what the information in the record allows any
method, u₀ = 1 / sqrt(2π ζ f T) half-widths.  A spurious pole follows the noise, so that its width
is its own blur, at any rate, length and number of channels, and its blur many times u₀; a mode of
light damping that rings for as long as the record is as sharp as that allows.  Where the blur is a
multiple of u₀, or the shape complex, the spectrum must peak: edges of an excited band do not; and
where it is a large multiple, the width must be three standard deviations from zero.

References
----------
Au (2014), doi:10.1016/j.ymssp.2014.03.008 (uncertainty laws of operational modal analysis).
"""

from collections.abc import Sequence
from dataclasses import dataclass
import logging
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.indicators import mac, mpc
from modal_core.poles import PoleStatus
from oma_identifier.covariance import UPPER, UPPER_UNDECIMATED
from oma_identifier.selection.cluster import Cluster, cluster_poles
from oma_identifier.selection.identified_band import IdentifiedBand
from oma_identifier.selection.stabilise import stabilise
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import SpectralPeaks, SUSPECT_DAMPING
from oma_identifier.subspace import PoleDeviation

WIDEST = 0.5
"""Largest standard deviation of the most precise member, in half-power half-widths; where most
model orders have the pole ``DOUBTFUL`` times u₀.  In 125 random records of light, heavy and mixed
damping, 1 to 12 channels and 20 to 60 s, 45 poles of modes passed by that alone, 7 within two
spectral lines of a mode, and no other; spurious poles follow the noise, and begin at 9 u₀."""
WIDEST_MEAN = 1.0
"""Largest standard deviation of what is reported, in half-power half-widths."""
DOUBTFUL, FAR, FARTHEST = 4.0, 6.0, 9.0
"""Multiples of u₀ from where on the spectrum must peak, the blur be below ``WIDEST_FAR``, and
there is no mode."""
WIDEST_FAR = 1.0 / 3.0
TOO_CERTAIN = 0.7
"""Multiple of u₀ below which nothing that random forces move can scatter."""
LEAST_CYCLES = 1.0
"""Least number of half-power half-widths ζf that the record resolves, ζfT; of fewer, the damping
is biased upwards and its deviation means nothing: it is reported without.  And what it is must be
shown: it could be a line."""
BROAD = 0.03
"""Damping ratio from where on a pole may describe the edge of an excited band."""
PEAK_CHANCE = 0.01
"""Probability of taking the edge of an excited band for a peak."""
LEAST_MPC = 0.5
"""Below, the phases of a shape are nearer to a circle than to a line; a close pair mixes."""
CLOSE = 3.0
"""Distance of a close pair, in half-power half-widths of the wider mode."""
SAME_MAC = 0.9
TRIALS = (0.0, 0.2, 0.5, 0.9)
"""Members whose standard deviations are compared, as shares of a cluster by model order; those of
low order scatter least, those of higher order tell whether the lower ones are biased."""
SECOND_TRIALS = (0.1, 0.3, 0.4, 0.7)
"""Members that are compared where the first say no of a pole that most model orders have: of two
modes so close that some orders make one of them, single members are blurred at random."""
LOOSEST = 0.5
"""Largest median distance of members of successive orders, of all or of the lower half, in
half-power half-widths; u₀ where that is larger."""
WITHIN = 2.0
"""Members whose variance is within this factor of the best are averaged."""
BIASED = 1.5
"""Squared difference over its variance from where on a member counts as biased; 1 on average."""

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SelectedPole:
    """One mode candidate.

    Parameters
    ----------
    band : IdentifiedBand
        Where it was found.
    cluster : Cluster
        Poles it is the mean of.
    pole : complex [rad/s]
        Continuous time.
    shape : (n_channels,) complex array
        Mode shape over channels divided by their root mean square in the band.
    deviation : PoleDeviation
        Standard deviations of the mean.
    blur : float
        Standard deviation of the most precise member in half-power half-widths, root mean square
        of frequency and damping.
    """

    band: IdentifiedBand
    cluster: Cluster
    pole: complex
    shape: NDArray[np.complex128]
    deviation: PoleDeviation
    blur: float

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
        return np.asarray(self.shape * self.band.scale)

    @property
    def is_determined(self) -> bool:
        """Whether the data determine the mean pole; False when a deviation is NaN."""
        widest = max(WIDEST_MEAN, DOUBTFUL * _least_blur(self._cycles)) * self.damping_ratio
        return (
            self.deviation.frequency_std_hz < widest * self.frequency_hz
            and self.deviation.damping_ratio_std < widest
        )

    @property
    def is_unresolved(self) -> bool:
        """Whether the record is too short to see its bell, and to tell its damping."""
        return self._cycles < LEAST_CYCLES

    @property
    def damping_ratio_std(self) -> float:
        """Standard deviation of the damping ratio; NaN where the record is too short for it."""
        return math.nan if self.is_unresolved else self.deviation.damping_ratio_std

    @property
    def is_too_certain(self) -> bool:
        """Whether it scatters less than the response to any random force allows."""
        return self.band.is_blind and self.from_limit < TOO_CERTAIN

    @property
    def from_limit(self) -> float:
        """The blur in multiples of the least that any method can reach."""
        return self.blur / _least_blur(self._cycles)

    @property
    def _cycles(self) -> float:
        return self.damping_ratio * self.frequency_hz * self.band.duration_s


def _least_blur(cycles: float) -> float:
    """Return the least standard deviation that any method can reach, u₀, in half-widths."""
    return 1.0 / math.sqrt(2.0 * math.pi * cycles)


@dataclass(frozen=True, slots=True)
class BandSelection:
    """Selected poles of one band and the status of all its poles.

    Parameters
    ----------
    band : IdentifiedBand
        The band.
    selected : tuple of SelectedPole
        Candidates that passed, by frequency.
    status : (n_poles,) uint8 array
        A PoleStatus each.
    """

    band: IdentifiedBand
    selected: tuple[SelectedPole, ...]
    status: NDArray[np.uint8]


def select_in_band(
    band: IdentifiedBand, settings: IdentificationSettings, peaks: SpectralPeaks | None = None
) -> BandSelection:
    """Select the modes of one band.

    Parameters
    ----------
    band : IdentifiedBand
        Poles over the model order.
    settings : IdentificationSettings
        Limit of the damping.
    peaks : SpectralPeaks or None
        Of the same samples; None where they are no longer at hand.
    """
    poles = band.poles
    status = stabilise(poles, band.band, settings.max_damping_ratio)
    candidates = np.flatnonzero(status == PoleStatus.KEPT)
    status[candidates] = PoleStatus.CLUSTER_OUTLIER
    # What costs least comes first: most clusters never need a gradient.
    likely = []
    for cluster in cluster_poles(poles, candidates):
        if len(cluster) < band.least_members:
            status[cluster.members] = PoleStatus.SMALL_CLUSTER
        elif _wanders(poles.pole[cluster.members], band.duration_s):
            status[cluster.members] = PoleStatus.UNCERTAIN
        else:
            likely.append(cluster)
    selected = []
    for cluster, trials in zip(likely, _trials(band, likely), strict=True):
        verdict, pole = _judge(band, cluster, trials, peaks)
        if pole is None and _deserves_another_look(band, cluster):
            (others,) = _trials(band, [cluster], SECOND_TRIALS)
            verdict, pole = _judge(band, cluster, others, peaks)
        status[cluster.members] = verdict
        if pole is None:
            log.debug(
                '%.4g Hz: %s, at %d of %d model orders',
                abs(poles.pole[cluster.centre]) / (2.0 * math.pi),
                verdict.name.lower(),
                len(cluster),
                band.n_orders,
            )
        if pole is not None:
            selected.append(pole)
    distinct = _beside_others(without_repeats(selected))
    for pole in selected:
        if not any(pole is other for other in distinct):
            status[pole.cluster.members] = PoleStatus.CLUSTER_OUTLIER
    return BandSelection(band, tuple(distinct), status)


def _deserves_another_look(band: IdentifiedBand, cluster: Cluster) -> bool:
    """Tell whether most model orders have a pole, and it is no image of a line."""
    pole = band.poles.pole[cluster.centre]
    return 2 * len(cluster) > band.n_orders and -pole.real > SUSPECT_DAMPING * abs(pole)


def _wanders(members: NDArray[np.complex128], duration_s: float) -> bool:
    """Tell whether successive orders disagree, all of them and the lower half as well."""
    steps = np.abs(np.diff(members))
    step = min(_median(steps), _median(steps[: (len(steps) + 1) // 2]))
    width = _median(-members.real)
    return step > max(LOOSEST, _least_blur(width * duration_s / (2.0 * math.pi))) * width


def _median(values: NDArray[np.float64]) -> float:
    ordered = np.sort(values)
    middle = len(ordered) // 2
    return float(ordered[middle] + ordered[~middle]) / 2.0


def _beside_others(poles: list[SelectedPole]) -> list[SelectedPole]:
    """Return the poles that make sense beside the others.

    A complex shape needs a neighbour that it is mixed with.  And the peak that speaks for a
    doubtful pole must be its own, not that of a narrower mode inside it.
    """
    if not poles:
        return []
    turns = _turn(np.column_stack([pole.shape for pole in poles]))
    return [
        pole
        for pole, complex_shape in zip(poles, turns, strict=True)
        if (not complex_shape or _near(pole, poles, CLOSE, narrower=False))
        and (pole.from_limit < DOUBTFUL or not _near(pole, poles, 1.0, narrower=True))
    ]


def _near(pole: SelectedPole, poles: list[SelectedPole], reach: float, *, narrower: bool) -> bool:
    """Tell whether there is another mode within half-power half-widths, of the wider."""
    return any(
        abs(pole.pole - other.pole) < reach * -min(pole.pole.real, other.pole.real)
        for other in poles
        if other is not pole and (other.pole.real > pole.pole.real or not narrower)
    )


def _judge(
    band: IdentifiedBand, cluster: Cluster, trials: '_Trials', peaks: SpectralPeaks | None
) -> tuple[PoleStatus, SelectedPole | None]:
    if not trials.blur < max(WIDEST, _widest(band, cluster)):
        return PoleStatus.UNCERTAIN, None
    pole = _average(band, cluster, trials)
    if not pole.is_determined or pole.from_limit > FARTHEST or _cut_off(pole):
        return PoleStatus.UNCERTAIN, None
    if peaks is not None and pole.damping_ratio > BROAD and _is_edge(pole, peaks):
        return PoleStatus.UNCERTAIN, None
    turns = bool(_turn(pole.shape[:, None])[0])
    if (turns or pole.from_limit > DOUBTFUL) and not _peaks(pole, turns, peaks):
        return PoleStatus.COMPLEX_SHAPE if turns else PoleStatus.UNCERTAIN, None
    return PoleStatus.KEPT, pole


def _widest(band: IdentifiedBand, cluster: Cluster) -> float:
    """Return the blur [half-widths] up to which the number of model orders speaks for a pole."""
    if 2 * len(cluster) <= band.n_orders:
        return 0.0
    width_hz = -band.poles.pole[cluster.centre].real / (2.0 * math.pi)
    return DOUBTFUL * _least_blur(width_hz * band.duration_s)


def _peaks(pole: SelectedPole, turns: bool, peaks: SpectralPeaks | None) -> bool:
    """Tell whether the spectrum peaks at a pole, as far as that can be told."""
    far = pole.from_limit > FAR
    if peaks is None or (far and pole.blur > WIDEST_FAR):
        return not turns and not far
    chance = peaks.chance(pole.frequency_hz, _half_width_hz(pole))
    return chance is None or chance < PEAK_CHANCE


def _is_edge(pole: SelectedPole, peaks: SpectralPeaks) -> bool:
    return peaks.is_edge(pole.frequency_hz, _half_width_hz(pole))


def _half_width_hz(pole: SelectedPole) -> float:
    return pole.damping_ratio * pole.frequency_hz


def _turn(shapes: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Return of which shapes, one per column, the phases are nearer to a circle than to a line."""
    return np.asarray((mpc(shapes) < LEAST_MPC) & (len(shapes) > 1))


def _cut_off(pole: SelectedPole) -> bool:
    """Tell whether the upper flank of a peak lies where anti-aliasing filters fall.

    The edge of such a filter under noise looks like a broad resonance.
    """
    rate = pole.band.band.sample_rate_hz
    flank = pole.frequency_hz * (1.0 + 2.0 * pole.damping_ratio)
    return pole.frequency_hz > UPPER * rate and flank > UPPER_UNDECIMATED * rate


@dataclass(frozen=True, slots=True)
class _Trials:
    """The members of a cluster whose standard deviations are compared, by model order.

    Parameters
    ----------
    rows : (n_trials,) int array
        Rows of the poles.
    series : (n_blocks, n_trials) complex array [rad/s]
        What each block of time does to them.
    blur : float
        The least of their deviations, in half-power half-widths.
    """

    rows: NDArray[np.int64]
    series: NDArray[np.complex128]
    blur: float


def _trials(
    band: IdentifiedBand, clusters: Sequence[Cluster], shares: Sequence[float] = TRIALS
) -> list[_Trials]:
    """Return the trials of all clusters, whose gradients are cheaper together."""
    if not clusters:
        return []
    rows = [cluster.members[_places(len(cluster), shares)] for cluster in clusters]
    together = np.concatenate(rows)
    series = band.influence(together)
    # The variance of a complex pole is that of frequency and damping together.
    variance = np.mean(np.abs(series) ** 2, axis=0) / len(series) / 2.0
    blur = np.sqrt(variance) / -band.poles.pole[together].real
    ends = np.cumsum([len(each) for each in rows])
    parts = zip(rows, np.split(series, ends[:-1], axis=1), np.split(blur, ends[:-1]), strict=True)
    return [_Trials(each, own, float(least.min())) for each, own, least in parts]


def _places(n_members: int, shares: Sequence[float]) -> list[int]:
    return sorted({round(share * (n_members - 1)) for share in shares})


def _average(band: IdentifiedBand, cluster: Cluster, trials: _Trials) -> SelectedPole:
    """Average the best determined members, with the deviation of that average.

    The members' influence series are averaged like the members themselves, so the deviation of
    the average is exact to first order however strongly the model orders are correlated.
    """
    rows, series = trials.rows, trials.series
    good = _agreeing(band.poles.pole[rows], series)
    pole = complex(np.mean(band.poles.pole[rows[good]]))
    deviation = band.deviation(series[:, good].mean(axis=1), pole)
    shape = mean_shape(band.poles.shape[:, rows[good]])
    return SelectedPole(band, cluster, pole, shape, deviation, trials.blur)


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
        if len(above) == 0 or _median(above) <= BIASED:
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
    own = first.band.scale
    other = second.physical_shape * np.divide(1.0, own, out=np.zeros_like(own), where=own > 0.0)
    alike = bool(mac(first.shape, other)[0, 0] > SAME_MAC)
    if first.band is not second.band:
        return alike
    # Two modes show up at the same model orders side by side; two views of one mode take turns.
    orders = first.band.poles.model_order
    shared = np.intersect1d(orders[first.cluster.members], orders[second.cluster.members])
    side_by_side = len(shared) > 0.5 * min(len(first.cluster), len(second.cluster))
    return alike or not side_by_side
