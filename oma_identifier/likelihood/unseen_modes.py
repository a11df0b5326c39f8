"""Modes above the spectrum: nobody sees them, but their tails move in step with the forces.

A structure does not end where its record does.  In a band below, each mode beyond Nyquist's
frequency answers like a spring, as f² along a fixed shape.  Where a band is described badly
without, such tails are taken into its model, their shapes from the score of the likelihood.

References
----------
Ewins (2000), Modal Testing, 2nd ed., section 4.4 (residuals); Rao (1948),
doi:10.1017/S0305004100023987 (score test).
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, eigh

from oma_identifier.likelihood.band_model import (
    accelerance,
    BandData,
    BandFit,
    BandModel,
    expected_spectra,
    forced_gain,
)

NYQUIST = 0.5
"""Frequency of an unseen mode over the sample rate: nearer ones reach further down.  At 1 the
frequencies of 31 modes scattered by 1.25 of their deviations, at 0.65 by 1.17, at 0.5 by 1.09."""
DAMPING = 0.01
"""Of no effect so far away."""
AT_ONCE, ROUNDS = 3, 2
"""Unseen modes that are taken in between two fits, and how often."""
LEAST_RISE = 10.0
"""Rise of the log-likelihood by an unseen mode."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Fit = Callable[[BandModel, BandModel], BandFit]
"""Fits a band; of where the priors are centred, and where to begin."""


def with_unseen(
    data: BandData,
    start: BandModel,
    fit: BandFit,
    sample_rate_hz: float,
    holds: Callable[[BandFit], bool],
    fit_from: Fit,
) -> tuple[BandModel, BandFit]:
    """Return a start and its fit with as many unseen modes as a band needs to be described.

    Parameters
    ----------
    data, start, fit : BandData, BandModel and BandFit
        Without any.
    sample_rate_hz : float [Hz]
        Of the record.
    holds : callable
        Tells whether a fit describes the band.
    fit_from : callable
        Fits the band anew.
    """
    hz = NYQUIST * sample_rate_hz
    for _ in range(ROUNDS):
        if holds(fit):
            break
        shapes, forces = _unseen(data, fit.model, hz)
        if not len(forces):
            break
        wider = _joined(start, shapes, forces, hz)
        again = fit_from(wider, _joined(fit.model, shapes, forces, hz))
        if not again.misfit < fit.misfit:
            break
        start, fit = wider, again
    return start, fit


def precision_and_residual(data: BandData, model: BandModel) -> tuple[Complex, Complex]:
    """Return E⁻¹ and E⁻¹ (P - E) E⁻¹ at all lines."""
    covariance = expected_spectra(model, model.shapes * forced_gain(data, model)[:, None, :])
    precision = np.linalg.inv(covariance)
    residual = precision @ (data.periodogram - covariance) @ precision
    return np.asarray(precision), np.asarray(residual)


def _unseen(data: BandData, model: BandModel, frequency_hz: float) -> tuple[Complex, Real]:
    """Return shapes and forces of the unseen modes that a model lacks most."""
    gain = accelerance(data.frequency_hz, np.array([frequency_hz]), np.array([DAMPING]))[:, 0]
    power = np.abs(gain) ** 2
    weight = data.n_averaged * power
    try:
        precision, residual = precision_and_residual(data, model)
        score, metric = (np.tensordot(weight, each, axes=1) for each in (residual, precision))
        shapes = eigh(score, metric)[1][:, : -AT_ONCE - 1 : -1]
    except (np.linalg.LinAlgError, ValueError):  # a model with next to no power somewhere
        return np.empty((len(model.shapes), 0), dtype=complex), np.empty(0)
    shapes /= np.linalg.norm(shapes, axis=0)
    slope = np.einsum('im,ij,jm->m', shapes.conj(), score, shapes).real
    own = np.einsum('im,kij,jm->km', shapes.conj(), precision, shapes).real
    information = (weight * power) @ own**2
    lacking = (slope > 0.0) & (0.5 * slope**2 > LEAST_RISE * information)
    return shapes[:, lacking], slope[lacking] / information[lacking]


def _joined(model: BandModel, shapes: Complex, forces: Real, frequency_hz: float) -> BandModel:
    n_more = len(forces)
    return replace(
        model,
        frequency_hz=np.append(model.frequency_hz, np.full(n_more, frequency_hz)),
        damping_ratio=np.append(model.damping_ratio, np.full(n_more, DAMPING)),
        shapes=np.column_stack([model.shapes, shapes]),
        force=block_diag(model.force, np.diag(forces)).astype(complex),
    )
