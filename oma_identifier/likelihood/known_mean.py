"""Motion that is known drives the modes: the mean of the spectra of a band.

Joints whose motion is measured shake the arm: beside what unknown forces do, F_k holds T_k u_k,
with transforms u_k of the inputs and T_k = Φ H_k B + D₀ + D₁ (f - f₀).  B says how they drive the
modes, D what they do without resonance: direct motion of sensors, modes far away, and whatever of
the drive changes over the band, as delays do (h_m (f - f₀) is a constant but for a share of h_m).
T is linear in B and D, which are therefore taken out of the problem (variable projection); what
is left of the spectra is described by the covariance as it is without inputs, and the errors of T
are counted in those of poles and shapes.

References
----------
McKelvey and Guérin (2012), doi:10.3182/20120711-3-BE-2027.00415 (local rational models);
Pintelon and Schoukens (2012), doi:10.1002/9781118287422, chapter 7; Golub and Pereyra (1973),
doi:10.1137/0710036 (variable projection); Harville (1977), doi:10.1080/01621459.1977.10480998
(what estimated means take from the variance).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from oma_identifier.likelihood.band_model import accelerance, BandData, BandModel, KnownInputs

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
RCOND = 1e-10


@dataclass(frozen=True, slots=True)
class Mean:
    """What the inputs explain under one model.

    Parameters
    ----------
    columns : (n_averages, n_channels, n_columns) complex array
        C: what each row of the coefficients does, T = C Θ; whitened, L⁻¹ C.
    coefficients : (n_columns, n_inputs) complex array
        Θ: first B, a row per mode, then D₀ and D₁.
    transfer : (n_averages, n_channels, n_inputs) complex array
        T.
    onto : (n_averages, n_channels, n_inputs) complex array
        What is left of the products of values and inputs, whitened.
    inverse : (n, n) complex array
        Of the normal matrix of Θ by rows.
    rise : float
        Of the log-likelihood, by the inputs.
    left : (n_averages, n_channels, n_channels) complex array
        Periodogram of what is left, without bias by the coefficients.
    """

    columns: Complex
    coefficients: Complex
    transfer: Complex
    onto: Complex
    inverse: Complex
    rise: float
    left: Complex

    @property
    def chance(self) -> float:
        """Probability that inputs which have nothing to do with the values explain so much."""
        return float(chi2.sf(2.0 * self.rise, 2 * self.coefficients.size))

    @classmethod
    def of(
        cls,
        data: BandData,
        known: KnownInputs,
        model: BandModel,
        whitening: Complex,
        degree: int = 1,
    ) -> 'Mean':
        """Return the maximum over B and D, of a degree in f, for a model of everything else."""
        plain = columns_at(data.frequency_hz, known, model, degree)
        columns = whitening @ plain
        n_columns, n_inputs = columns.shape[2], known.cross.shape[2]
        counted = data.n_averaged[:, None, None]
        back = columns.conj().transpose(0, 2, 1)
        inner = (counted * (back @ columns)).reshape(len(columns), -1)
        power = known.power.reshape(len(columns), -1)
        products = (inner.T @ power).reshape(n_columns, n_columns, n_inputs, n_inputs)
        # (i, c), (j, d): Σ n (Cᴴ E⁻¹ C)_ij <u_d u_c*>
        normal = products.transpose(0, 3, 1, 2).reshape(n_columns * n_inputs, -1)
        wanted = np.sum(counted * (back @ (whitening @ known.cross)), axis=0)
        inverse = _inverse(normal)
        coefficients = (inverse @ wanted.ravel()).reshape(n_columns, n_inputs)
        transfer = plain @ coefficients
        product = transfer @ known.cross.conj().transpose(0, 2, 1)
        left = data.periodogram - product - product.conj().transpose(0, 2, 1)
        left += transfer @ known.power @ transfer.conj().transpose(0, 2, 1)
        if known.spread is not None:
            left += known.spread
        rise = float(np.vdot(wanted, coefficients).real)
        onto = whitening @ (known.cross - transfer @ known.power)
        return cls(columns, coefficients, transfer, onto, inverse, rise, left)

    def spread(self, data: BandData, known: KnownInputs, model: BandModel) -> Complex:
        """Return the covariance of T u by the errors of T, (n_averages, n_channels, n_channels).

        What is left of the spectra is short of it (restricted maximum likelihood); that of one
        model belongs to the next fit.
        """
        n_columns, n_inputs = self.coefficients.shape
        errors = self.inverse.reshape(n_columns, n_inputs, n_columns, n_inputs)
        both = errors.transpose(0, 2, 1, 3).reshape(n_columns**2, -1)
        power = known.power.reshape(len(known.power), -1)
        inside = (power @ both.T).reshape(-1, n_columns, n_columns)
        plain = columns_at(data.frequency_hz, known, model)
        return np.asarray(plain @ inside @ plain.conj().transpose(0, 2, 1))

    def bends(self, data: BandData, known: KnownInputs, model: BandModel, white: Complex) -> float:
        """Return the probability that chance alone makes D₂ (f - f₀)² explain so much more.

        What is not described by D₀ and D₁ has a curvature: inputs that are late by more than a
        band bears, a mode that is not in the model, forces that are no multiple of the inputs.
        """
        curved = Mean.of(data, known, model, white, degree=2)
        freedom = 2 * (curved.coefficients.size - self.coefficients.size)
        return float(chi2.sf(2.0 * max(curved.rise - self.rise, 0.0), freedom))

    def gradient(
        self, data: BandData, whitening: Complex, derivatives: Complex, modes: NDArray[np.intp]
    ) -> Real:
        """Return the downhill gradient of the likelihood's part that the mean has.

        ``derivatives`` are those of the columns Φ H by each parameter, see :meth:`information`.
        """
        pulled = whitening.conj().transpose(0, 2, 1) @ self.onto
        pulled = pulled * data.n_averaged[:, None, None]
        by_mode = pulled.conj() @ self.coefficients[modes].T
        return np.asarray(2.0 * np.einsum('kia,kia->a', by_mode, derivatives).real)

    def information(
        self,
        data: BandData,
        known: KnownInputs,
        whitening: Complex,
        derivatives: Complex,
        modes: NDArray[np.intp],
    ) -> Real:
        """Return the information that the mean has on parameters of the modes.

        Parameters
        ----------
        data, known, whitening : BandData, KnownInputs and (n_averages, n, n) complex array
            As for :meth:`of`.
        derivatives : (n_averages, n_channels, n_parameters) complex array
            Of the column of its mode by each parameter.
        modes : (n_parameters,) int array
            Whose parameter it is.
        """
        counted = data.n_averaged[:, None, None]
        white = whitening @ derivatives
        drive = self.coefficients[modes]
        driven = known.power.swapaxes(1, 2) @ drive.T  # (k, c, a): <(b_a u) u_c*>
        inner = white.conj().transpose(0, 2, 1) @ white
        met = drive.conj() @ driven
        own = np.einsum('kab,kab->ab', counted * inner, met)
        mixed = counted * (self.columns.conj().transpose(0, 2, 1) @ white)
        cross = np.einsum('kia,kca->ica', mixed, driven, optimize=True)
        cross = cross.reshape(-1, len(modes))
        return np.asarray(2.0 * (own - cross.conj().T @ self.inverse @ cross).real)


def columns_at(
    frequency_hz: Real, known: KnownInputs, model: BandModel, degree: int = 1
) -> Complex:
    """Return Φ H, 1, f - f₀ and further powers of it, (n, n_channels, n_columns)."""
    bare = accelerance(frequency_hz, model.frequency_hz, model.damping_ratio)
    resonant = model.shapes * bare[:, None, :]
    each = np.broadcast_to(np.eye(len(model.shapes)), (len(bare), *2 * (len(model.shapes),)))
    place = (frequency_hz - known.middle_hz) / known.reach_hz
    powers = [each * place[:, None, None] ** power for power in range(degree + 1)]
    return np.concatenate([resonant, *powers], axis=2)


def derivatives_by(
    model: BandModel, gain: Complex, by_frequency: Complex, by_damping: Complex, across: Complex
) -> tuple[Complex, NDArray[np.intp]]:
    """Return the derivatives of the free modes' columns by their parameters, and whose each is.

    Parameters
    ----------
    model : BandModel
        Parameters are in the order of
        :func:`~oma_identifier.likelihood.whittle_gradient.gradient`.
    gain, by_frequency, by_damping : (n_averages, n_free) complex array
        Accelerances, their derivatives by ln f and ln ζ over them.
    across : (n_free, n_channels, n_channels - 1) complex array
        Directions across the shapes.
    """
    found = []
    for mode in range(model.n_free):
        own = gain[:, mode, None] * model.shapes[:, mode]
        turned = gain[:, mode, None, None] * across[mode]
        by_shape = np.stack([turned, 1j * turned], axis=3).reshape(*own.shape, -1)
        poles = np.stack([by_frequency[:, mode, None] * own, by_damping[:, mode, None] * own], 2)
        found.append(np.concatenate([poles, by_shape], axis=2))
    size = found[0].shape[2]
    return np.concatenate(found, axis=2), np.repeat(np.arange(model.n_free), size)


def _inverse(normal: Complex) -> Complex:
    size = np.sqrt(np.maximum(np.diag(normal).real, 1e-300))
    scaled = normal / np.outer(size, size)
    inverse = np.linalg.pinv(scaled, rcond=RCOND, hermitian=True)
    return np.asarray(inverse / np.outer(size, size))
