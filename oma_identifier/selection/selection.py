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

from dataclasses import dataclass
import logging
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.poles import PoleStatus
from oma_identifier.likelihood import least_blur
from oma_identifier.selection.average import average, Trials, trials_of
from oma_identifier.selection.cluster import Cluster, cluster_poles
from oma_identifier.selection.distinct import beside_others, without_repeats
from oma_identifier.selection.identified_band import IdentifiedBand
from oma_identifier.selection.selected_pole import SelectedPole
from oma_identifier.selection.stabilise import stabilise
from oma_identifier.selection.thresholds import SELECTION
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import SpectralPeaks

log = logging.getLogger(__name__)


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
    unsure : tuple of (Cluster, Trials)
        Clusters that the data determine to a half-width, and that are no modes all the same.
    """

    band: IdentifiedBand
    selected: tuple[SelectedPole, ...]
    status: NDArray[np.uint8]
    unsure: tuple[tuple[Cluster, Trials], ...] = ()


@dataclass(frozen=True, slots=True)
class _Refusal:
    """Why a cluster of poles is no mode."""

    status: PoleStatus
    why: str


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
    least = band.least_members
    small = _Refusal(PoleStatus.SMALL_CLUSTER, f'at fewer than {least} model orders')
    likely = []
    for cluster in cluster_poles(poles, candidates):
        if len(cluster) >= least:
            likely.append(cluster)
        else:
            status[cluster.members] = _turned_down(band, cluster, small)
    selected = []
    judged = list(zip(likely, trials_of(band, likely), strict=True))
    for cluster, trials in judged:
        verdict = _judge(band, cluster, trials, peaks)
        if isinstance(verdict, SelectedPole):
            status[cluster.members] = PoleStatus.KEPT
            selected.append(verdict)
        else:
            status[cluster.members] = _turned_down(band, cluster, verdict)
    distinct = beside_others(without_repeats(selected))
    for pole in selected:
        if not any(pole is other for other in distinct):
            status[pole.cluster.members] = PoleStatus.CLUSTER_OUTLIER
    modes = {pole.cluster.centre for pole in distinct}
    unsure = [
        (cluster, trials)
        for cluster, trials in judged
        if trials.blur < SELECTION.widest_mean and cluster.centre not in modes
    ]
    return BandSelection(band, tuple(distinct), status, tuple(unsure))


def _turned_down(band: IdentifiedBand, cluster: Cluster, refusal: _Refusal) -> PoleStatus:
    log.debug(
        '%.4g Hz: %s; at %d of %d model orders',
        abs(band.poles.pole[cluster.centre]) / (2.0 * math.pi),
        refusal.why,
        len(cluster),
        band.n_orders,
    )
    return refusal.status


def _judge(
    band: IdentifiedBand, cluster: Cluster, trials: Trials, peaks: SpectralPeaks | None
) -> SelectedPole | _Refusal:
    widest = max(SELECTION.widest, _widest(band, cluster))
    if not trials.blur < widest:
        why = f'scatters by {trials.blur:.2g} half-widths, {widest:.2g} or more'
        return _Refusal(PoleStatus.UNCERTAIN, why)
    pole = average(band, cluster, trials)
    if why := _undetermined(pole, peaks):
        return _Refusal(PoleStatus.UNCERTAIN, why)
    turns = pole.has_complex_shape
    if (turns or pole.from_limit > SELECTION.doubtful) and not _peaks(pole, turns, peaks):
        status = PoleStatus.COMPLEX_SHAPE if turns else PoleStatus.UNCERTAIN
        what = 'a complex shape' if turns else f'{pole.from_limit:.2g} times the least scatter'
        return _Refusal(status, f'{what}, and no peak of the spectrum')
    return pole


def _undetermined(pole: SelectedPole, peaks: SpectralPeaks | None) -> str:
    """Say why the data do not determine a pole; empty where they do."""
    if not pole.is_determined:
        return f'its mean scatters by {pole.blur:.2g} half-widths'
    if pole.from_limit > SELECTION.farthest:
        return f'scatters by {pole.from_limit:.2g} times the least possible'
    if peaks is not None and is_edge(peaks, pole.frequency_hz, pole.damping_ratio):
        return f'the edge of an excited band, damped by {pole.damping_ratio:.2g} of critical'
    return ''


def _widest(band: IdentifiedBand, cluster: Cluster) -> float:
    """Return the blur [half-widths] up to which the number of model orders speaks for a pole."""
    if 2 * len(cluster) <= band.n_orders:
        return 0.0
    width_hz = -band.poles.pole[cluster.centre].real / (2.0 * math.pi)
    return SELECTION.doubtful * least_blur(width_hz * band.duration_s)


def _peaks(pole: SelectedPole, turns: bool, peaks: SpectralPeaks | None) -> bool:
    """Tell whether the spectrum peaks at a pole, as far as that can be told."""
    far = pole.from_limit > SELECTION.far
    if peaks is None or (far and pole.blur > SELECTION.widest_far):
        return not turns and not far
    chance = peaks.chance(pole.frequency_hz, pole.half_width_hz)
    return chance is None or chance < SELECTION.peak_chance


def is_edge(peaks: SpectralPeaks, frequency_hz: float, damping_ratio: float) -> bool:
    """Tell whether a pole describes where a response ends or, if broad, falls to another level."""
    width_hz = damping_ratio * frequency_hz
    return (
        peaks.is_by_end(frequency_hz, width_hz)
        or peaks.is_cut(frequency_hz, width_hz)
        or (damping_ratio > SELECTION.broad and peaks.is_edge(frequency_hz, width_hz))
    )
