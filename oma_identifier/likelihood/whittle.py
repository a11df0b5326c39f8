"""The Whittle likelihood of a few modes in one frequency band.

The discrete Fourier transforms F_k of all channels at the frequencies of a band are independent
complex Gaussian vectors with covariance E_k = Φ H_k S H_kᴴ Φᴴ + diag s: mode shapes Φ,
accelerances H_k, the cross spectral density S of the modal forces, whose logarithm is a parabola
over that of frequency, and the noise s of each channel.
Modes beside the band take part with fixed poles and shapes, since their tails are coherent with
the forces of the band's own modes.

References
----------
Au (2017), Operational Modal Analysis, Springer, doi:10.1007/978-981-10-4118-1, chapters 10, 12;
Whittle (1953), Arkiv för Matematik 2, 423-434.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood import shape_prior
from oma_identifier.likelihood.band_model import (
    accelerance,
    BandData,
    BandModel,
    expected_spectra,
    force_colour,
    force_orders,
)
from oma_identifier.likelihood.force_prior import Prior
from oma_identifier.likelihood.known_mean import derivatives_by, Mean
from oma_identifier.likelihood.thresholds import LIKELIHOOD
from oma_identifier.likelihood.whittle_gradient import Evaluated, gradient

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """One model against the data: likelihood, L⁻¹ of E_k = L Lᴴ, H, ΦH and L⁻¹(P - E)L⁻ᴴ."""

    value: float
    whitening: Complex
    bare: Complex
    gain: Complex
    amplitude: Complex
    residual: Complex
    mean: Mean | None = None


def evaluate(data: BandData, model: BandModel, prior: Prior) -> Evaluation | None:
    """Return the likelihood of a model; None where it is no covariance."""
    # Written so that a parameter that is no number is refused as well.
    if not (np.all(model.damping_ratio > 1e-5) and np.all(model.damping_ratio < 0.9)):
        return None
    bare = accelerance(data.frequency_hz, model.frequency_hz, model.damping_ratio)
    gain = bare * force_colour(data, model)[:, None]
    amplitude = model.shapes * gain[:, None, :]
    identity = np.eye(len(model.shapes))
    covariance = expected_spectra(model, amplitude)
    if not np.isfinite(covariance).all():
        return None
    try:
        factor = np.linalg.cholesky(covariance)
        whitening = np.asarray(np.linalg.inv(factor))
    except np.linalg.LinAlgError:
        return None
    pivots = np.einsum('kii->ki', factor).real
    if np.any(pivots**2 < LIKELIHOOD.least_power * model.noise):
        return None
    mean = None if data.known is None else Mean.of(data, data.known, model, whitening)
    periodogram = data.periodogram if mean is None else mean.left
    white: Complex = whitening @ periodogram @ whitening.conj().transpose(0, 2, 1)
    logarithm = 2.0 * np.sum(np.log(pivots), axis=1)
    value = np.sum(data.n_averaged * (logarithm + np.einsum('kii->k', white).real))
    value += prior.value(model)
    value += shape_prior.penalty(model.shapes[:, : model.n_free])
    if not np.isfinite(value):
        return None
    return Evaluation(
        float(value),
        whitening,
        bare,
        gain,
        amplitude,
        np.asarray(white - identity),
        mean,
    )


def downhill_gradient(
    data: BandData,
    model: BandModel,
    prior: Prior,
    at: Evaluation,
    evaluated: Evaluated | None = None,
) -> Real:
    """Return the downhill gradient, priors included."""
    evaluated = evaluated or evaluated_at(data, model, at)
    downhill = gradient(evaluated)
    if at.mean is not None:
        derivatives = derivatives_of(model, at, evaluated)
        driven = at.mean.gradient(data, at.whitening, *derivatives)
        downhill[: len(driven)] += driven
    pull = prior.weight * prior.offset(model)
    downhill[-len(pull) :] += pull
    modes = downhill[: model.n_free * 2 * len(model.shapes)].reshape(model.n_free, -1)
    modes[:, 2:] += shape_prior.gradient(model.shapes[:, : model.n_free], evaluated.across)
    return downhill


def evaluated_at(data: BandData, model: BandModel, at: Evaluation) -> Evaluated:
    """Return what the derivatives of the likelihood are made of."""
    free = slice(0, model.n_free)
    beta = model.frequency_hz[free] / data.frequency_hz[:, None]
    by_damping = at.bare[:, free] * 2j * model.damping_ratio[free] * beta
    back = at.whitening.conj().transpose(0, 2, 1)
    return Evaluated(
        count=data.n_averaged,
        amplitude=at.amplitude,
        response=at.amplitude @ model.force[:, free],
        precision=np.asarray(back @ at.whitening),
        residual=np.asarray(back @ at.residual @ at.whitening),
        excess=np.einsum('kii->k', at.residual).real,
        gain=at.gain[:, free],
        by_frequency=at.bare[:, free] * 2.0 * beta**2 + by_damping,
        by_damping=by_damping,
        colours=force_orders(data, model),
        noise=model.noise,
        across=across(model.shapes[:, free]),
        root=model.root,
    )


def derivatives_of(
    model: BandModel, at: Evaluation, evaluated: Evaluated
) -> tuple[Complex, NDArray[np.intp]]:
    """Return the derivatives of the columns that known motion drives, see :class:`Mean`."""
    bare = at.bare[:, : model.n_free]
    return derivatives_by(
        model, bare, evaluated.by_frequency, evaluated.by_damping, evaluated.across
    )


def across(shapes: Complex) -> Complex:
    """Return orthonormal bases of the directions across shapes: Householder's reflections.

    Shapes are columns; the bases are (n_shapes, n_channels, n_channels - 1).
    """
    normal = shapes.T.copy()
    first = np.abs(normal[:, 0])
    length = np.linalg.norm(normal, axis=1)
    phase = np.divide(normal[:, 0], first, out=np.ones_like(normal[:, 0]), where=first > 0.0)
    normal[:, 0] += length * phase
    mirrored = (-2.0 / np.sum(np.abs(normal) ** 2, axis=1))[:, None] * normal[:, 1:].conj()
    basis = normal[:, :, None] * mirrored[:, None]
    basis[:, 1:] += np.eye(len(shapes) - 1)
    return np.asarray(basis)
