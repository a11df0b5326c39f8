"""Which modes the data of a band demand: one that its model lacks, one that it has twice.

The derivative of the log-likelihood by the force of a further mode at rest, over its standard
deviation, says without a fit by how much the likelihood would rise.  For a given pole it is
greatest for one shape, an eigenvector.  Whether a mode is there is decided by the likelihoods of
the fits with and without it.

References
----------
Rao (1948), doi:10.1017/S0305004100023987 (score test); Schwarz (1978),
doi:10.1214/aos/1176344136 (evidence).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from oma_identifier.likelihood import (
    accelerance,
    BandData,
    BandIndex,
    BandModel,
    expected_spectra,
    fit_band,
    forced_gain,
    GroupFit,
    overlaps,
    ReducedBand,
    unit,
    value_at,
)
from oma_identifier.refinement.thresholds import REFINEMENT

TRIED_DAMPING = (0.005, 0.015, 0.045)

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class MissingMode:
    """Where a mode seems to be missing.

    Parameters
    ----------
    frequency_hz, damping_ratio : float [Hz], [-]
        Roughly.
    shape : (n_channels,) complex array
        Of unit length.
    rise : float
        Of the log-likelihood, to be expected.
    """

    frequency_hz: float
    damping_ratio: float
    shape: Complex
    rise: float


def missing_mode(of: GroupFit) -> MissingMode | None:
    """Return the mode whose absence from a group's model shows most, or None."""
    if of.fit is None or of.band is None:
        return None
    data = of.band.data
    precision, residual = _precision_and_residual(data, of.fit.model)
    n_channels = residual.shape[1]
    best = None
    for ratio in TRIED_DAMPING:
        low = data.frequency_hz[0] / (1.0 - REFINEMENT.inside * ratio)
        high = data.frequency_hz[-1] / (1.0 + REFINEMENT.inside * ratio)
        if low >= high:
            continue
        place = np.exp(np.arange(np.log(low), np.log(high), ratio))
        power = np.abs(accelerance(data.frequency_hz, place, np.full(len(place), ratio))).T ** 2
        weight = power * data.n_averaged
        score = (weight @ residual.reshape(len(residual), -1)).reshape(-1, n_channels, n_channels)
        metric = (weight @ precision.reshape(len(residual), -1)).reshape(score.shape)
        for at, frequency_hz in enumerate(place):
            try:
                shape = eigh(score[at], metric[at])[1][:, -1]
            except np.linalg.LinAlgError:  # a model with next to no power in some direction
                continue
            slope = float(np.vdot(shape, score[at] @ shape).real)
            own = np.einsum('i,kij,j->k', shape.conj(), precision, shape).real
            rise = 0.5 * slope**2 / float(np.sum(weight[at] * power[at] * own**2))
            if slope > 0.0 and rise > (REFINEMENT.least_rise if best is None else best.rise):
                best = MissingMode(float(frequency_hz), ratio, shape, rise)
    return best and replace(best, shape=unit(of.band.back @ best.shape))


def _precision_and_residual(data: BandData, model: BandModel) -> tuple[Complex, Complex]:
    """Return E⁻¹ and E⁻¹ (P - E) E⁻¹ at all lines."""
    covariance = expected_spectra(model, model.shapes * forced_gain(data, model)[:, None, :])
    precision = np.linalg.inv(covariance)
    residual = precision @ (data.periodogram - covariance) @ precision
    return np.asarray(precision), np.asarray(residual)


def is_demanded(of: GroupFit, position: BandIndex) -> bool:
    """Tell whether the data determine a free mode and demand it.

    Without it their likelihood must fall by more than half the logarithm of the number of
    frequencies for each of its parameters (Schwarz).
    """
    if of.fit is None or of.band is None or not of.fit.converged:
        return False
    model, data = of.fit.model, of.band.data
    frequency_hz, ratio = model.frequency_hz[position], model.damping_ratio[position]
    reach = REFINEMENT.inside * ratio * frequency_hz
    if not (
        ratio > REFINEMENT.added_damping
        and data.frequency_hz[0] < frequency_hz - reach
        and frequency_hz + reach < data.frequency_hz[-1]
        and of.fit.frequency_std[position] < REFINEMENT.determined * ratio
        and of.fit.damping_ratio_std[position] < REFINEMENT.determined
    ):
        return False
    return _value_without(data, model, position) - of.fit.value > _worth(data, model)


def superfluous(of: GroupFit) -> BandIndex | None:
    """Return the position of a free mode that the data of its band do without, or None.

    It is the one whose absence costs least at once.  Without it their likelihood, the others free
    to take its place, must fall by less than its parameters are worth.  A second view of a mode is
    such a one, and a mode that the fit finds nowhere.
    """
    if of.fit is None or of.band is None or not of.misfit < REFINEMENT.decisive_misfit:
        return None
    band, fit = of.band, of.fit
    if fit.model.n_free < 2:
        return None
    worth = _worth(band.data, fit.model)
    left = [
        _Remainder.of(band, fit.model, BandIndex(position)) for position in range(fit.model.n_free)
    ]
    least = BandIndex(int(np.argmin([each.value for each in left])))
    at_once = left[least].value - fit.value
    if at_once > REFINEMENT.irreplaceable * worth and not _has_company(fit.model, least):
        return None
    start, near = left[least].start, left[least].near
    without = fit_band(band.data, start, REFINEMENT.replacing_steps, near=near)
    return least if without.value - fit.value < worth else None


@dataclass(frozen=True, slots=True)
class _Remainder:
    """A band without one of its modes: where a fit begins, and the likelihood there."""

    start: BandModel
    near: BandModel
    value: float

    @classmethod
    def of(cls, band: ReducedBand, model: BandModel, position: BandIndex) -> '_Remainder':
        """Begin where the others are, or were: two views of one mode may balance each other."""
        start, rest = _without(band.model, position), _without(model, position)
        values = [value_at(band.data, near, start) for near in (start, rest)]
        best = int(np.argmin(values))
        return cls(start, (start, rest)[best], values[best])


def _has_company(model: BandModel, position: BandIndex) -> bool:
    """Tell whether the bell of another free mode touches that of a mode."""
    frequency_hz = model.frequency_hz[: model.n_free]
    width_hz = frequency_hz * model.damping_ratio[: model.n_free]
    return bool(overlaps(frequency_hz, width_hz)[position].sum() > 1)


def _worth(data: BandData, model: BandModel) -> float:
    """Return what a mode must add to the log-likelihood for its parameters (Schwarz)."""
    n_parameters = 2 * len(model.shapes) + 2 * len(model.frequency_hz) - 1
    return float(0.5 * n_parameters * np.log(data.n_averaged.sum()))


def _value_without(data: BandData, model: BandModel, position: int) -> float:
    if len(model.frequency_hz) > 1:
        return fit_band(data, _without(model, position)).value
    power = np.einsum('kcc->kc', data.periodogram).real
    level = np.average(power, axis=0, weights=data.n_averaged)
    return float(np.sum(data.n_averaged) * np.sum(np.log(level) + 1.0))


def _without(model: BandModel, position: int) -> BandModel:
    return replace(
        model,
        frequency_hz=np.delete(model.frequency_hz, position),
        damping_ratio=np.delete(model.damping_ratio, position),
        shapes=np.delete(model.shapes, position, axis=1),
        force=np.delete(np.delete(model.force, position, axis=0), position, axis=1),
        n_free=max(1, model.n_free - 1),  # a tail may move in its place
    )
