"""What the ends of a record do to its transform, taken out of the lines of a band.

A transform takes a record for one period of an endless motion.  Where its ends do not meet, the
modes decay freely, from the state they begin in less the one they end in, and slow motion jumps.
Both are smooth over frequency and come to the forced response as if further forces of the same
shapes: under few forces, or beside strong motion, much more than noise.

References
----------
Pintelon and Schoukens (2012), System Identification, 2nd ed., doi:10.1002/9781118287422, section
2.6 (transients of finite records).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.band_model import (
    BandData,
    BandModel,
    expected_spectra,
    forced_gain,
    without_negative,
)
from oma_identifier.likelihood.line_spectra import Spectra

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
LOOSE = 10.0
"""Variance of a mode's state over that under steady forces: a record may begin with a blow.  At
1 a decay ten times as strong was left by a quarter; at 100 short records (ζfT 1 to 3) scattered
4 % more than they said.  Without bound, found from the states themselves, stronger decays go as
well, but at the poles of the start: two of 120 modes of a milling arm were then off by 7 and 10 σ
at a misfit of 1.03.  With it they misfit, and the plain estimate stands."""
ROUNDING = 1e-12


@dataclass(frozen=True, slots=True)
class _Ends:
    """Transforms of what the ends of one stretch leave, per unit of each unknown.

    Parameters
    ----------
    decay, mirrored : (n_modes, n_lines) complex array
        Of free decays at the pole of each mode and at its conjugate.
    jump : (2, n_lines) complex array
        Of a jump and of a kink.
    shapes : (n_channels, n_modes) complex array
        Of the modes.
    """

    decay: Complex
    mirrored: Complex
    jump: Complex
    shapes: Complex

    @classmethod
    def of(cls, spectra: Spectra, lines: NDArray[np.intp], model: BandModel) -> '_Ends':
        later = np.exp(-2j * np.pi * spectra.frequency_hz[lines] / spectra.sample_rate_hz)
        omega = 2.0 * np.pi * model.frequency_hz / spectra.sample_rate_hz
        zeta = model.damping_ratio
        pole = np.exp(omega * (1j * np.sqrt(1.0 - zeta**2) - zeta))[:, None]
        jump = 1.0 / (1.0 - later)
        return cls(
            1.0 / (1.0 - pole * later),
            1.0 / (1.0 - pole.conj() * later),
            np.stack([jump, jump**2]),
            model.shapes,
        )

    def averaged(self, first: NDArray[np.intp], count: NDArray[np.intp]) -> '_Ends':
        """Return the same at averages over neighbouring lines."""

        def mean(of_lines: Complex) -> Complex:
            return np.asarray(np.add.reduceat(of_lines, first, axis=1) / count)

        return _Ends(mean(self.decay), mean(self.mirrored), mean(self.jump), self.shapes)

    def columns(self) -> Complex:
        """Return what each unknown does, (n_lines, n_channels, 2 n_modes + 2 n_channels)."""
        here = self.decay.T[:, None, :] * self.shapes
        there = self.mirrored.T[:, None, :] * self.shapes.conj()
        each = np.eye(len(self.shapes))
        jumps = [each * jump[:, None, None] for jump in self.jump]
        return np.concatenate([here + there, 1j * (here - there), *jumps], axis=2)

    def values(self, unknowns: Real) -> Complex:
        """Return all together, (n_lines, n_channels)."""
        n_modes = self.shapes.shape[1]
        state = unknowns[:n_modes] + 1j * unknowns[n_modes : 2 * n_modes]
        jumps = unknowns[2 * n_modes :].reshape(2, -1)
        return np.asarray(
            self.decay.T @ (self.shapes * state).T
            + self.mirrored.T @ (self.shapes * state).conj().T
            + self.jump.T @ jumps
        )


def without_ends(
    spectra: Spectra, lines: NDArray[np.intp], values: Complex, data: BandData, model: BandModel
) -> Complex:
    """Return the values of a band without what the ends of its stretches do to them.

    Least squares, weighted by what a model expects of the spectra; the states of the modes are not
    much larger than its forces make them.

    Parameters
    ----------
    spectra, lines : Spectra and (n_lines,) int array
        Which lines of what.
    values : (n_lines, n_channels) complex array
        There, in the coordinates of the model.
    data : BandData
        Their averages.
    model : BandModel
        Near the truth.
    """
    average = np.repeat(np.arange(len(data.n_averaged)), data.n_averaged.astype(int))
    precision = _precision(data, model)
    cleaned = values.copy()
    for stretch, duration_s in enumerate(spectra.durations_s):
        own = np.flatnonzero(spectra.stretch[lines] == stretch)
        if not len(own):
            continue
        ends = _Ends.of(spectra, lines[own], model)
        known, first, count = np.unique(average[own], return_index=True, return_counts=True)
        mean = np.add.reduceat(values[own], first, axis=0) / count[:, None]
        weight = count[:, None, None] * precision[known]
        ridge = _ridge(model, duration_s * spectra.sample_rate_hz, spectra.sample_rate_hz)
        unknowns = _solved(
            ends.averaged(first, count).columns(), np.asarray(mean, dtype=complex), weight, ridge
        )
        cleaned[own] -= ends.values(unknowns)
    return cleaned


def _precision(data: BandData, model: BandModel) -> Complex:
    """Return E⁻¹ at all averages."""
    amplitude = model.shapes * forced_gain(data, model)[:, None, :]
    covariance = expected_spectra(model, amplitude)
    if np.linalg.eigvalsh(model.force)[0] < 0.0:
        covariance = expected_spectra(without_negative(model), amplitude)
    return np.asarray(np.linalg.inv(covariance))


def _ridge(model: BandModel, n_samples: float, sample_rate_hz: float) -> Real:
    """Return 1/σ² of each unknown: states as under white forces, jumps free."""
    width = np.pi * model.damping_ratio * model.frequency_hz / sample_rate_hz
    # Mean of |H|² over the spectrum: that of a resonance of height 1/(2ζ).
    gain = width / (2.0 * model.damping_ratio) ** 2
    level = np.abs(np.diag(model.force).real)
    variance = LOOSE * np.maximum(level, ROUNDING * level.max()) * gain / n_samples
    return np.concatenate([np.tile(2.0 / variance, 2), np.zeros(2 * len(model.shapes))])


def _solved(columns: Complex, mean: Complex, weight: Complex, ridge: Real) -> Real:
    """Return the unknowns that explain the means best, (n_unknowns,)."""
    onto = weight @ columns
    back = columns.conj().transpose(0, 2, 1)
    # The log-likelihood of complex values has no factor of one half.
    normal = 2.0 * np.sum((back @ onto).real, axis=0) + np.diag(ridge)
    wanted = 2.0 * np.einsum('kcj,kc->j', onto.conj(), mean).real
    size = np.sqrt(np.diag(normal))
    scaled = normal / np.outer(size, size)
    return np.asarray(np.linalg.lstsq(scaled, wanted / size, rcond=ROUNDING)[0] / size)
