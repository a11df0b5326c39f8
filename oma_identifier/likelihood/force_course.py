"""How the strength of the forces changes over a record, and what that does to deviations.

Forces that grow, or come in bursts, make neighbouring lines of a spectrum alike: those m lines
apart by the share c_m, the Fourier coefficient of the forces' power over time.  A likelihood that
takes lines for independent counts them all; what it finds scatters more, by Σ|c_m|² over as many
lines as its derivatives hardly change within.  For an average over the whole band that is the mean
square over the squared mean of the power.

References
----------
Loève (1978), Probability Theory II, section 37 (harmonisable processes); Newey and West (1987),
doi:10.2307/1913610 (scatter of estimates from dependent values).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, ifft, next_fast_len
from scipy.stats import chi2

from oma_identifier.likelihood.band_model import forced_gain, without_negative
from oma_identifier.likelihood.group_fits import GroupFit
from oma_identifier.likelihood.line_spectra import Spectra
from oma_identifier.likelihood.record_ends import without_ends

TESTED = 16
"""Distances of lines, from one on, that are asked whether they are alike."""
CHANCE = 1e-3
"""Probability of taking steady forces for unsteady ones."""
LEAST_PAIRS = 0.25
"""Of as many pairs of lines as there are lines, for a distance to be looked at."""

TINY = 1e-300
NEGLIGIBLE = 1e-12
"""Of the largest power of a force of the band: less is rounding."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class ForceCourse:
    """How alike the forces are at lines that are some apart.

    Parameters
    ----------
    alike : (n_distances,) array
        |c_m|² for m = 1, 2, ...; without bias, so that some may be below zero.  Empty: steady.
    duration_s : float [s]
        One over the distance of lines.
    """

    alike: Real
    duration_s: float

    @classmethod
    def of(cls, spectra: Spectra, fits: Sequence[GroupFit]) -> 'ForceCourse':
        """Return the course of the forces that all fits tell of together.

        Of a record with gaps nothing is told.
        """
        steady = cls(np.empty(0), spectra.durations_s[0])
        forces = [force for each in fits for force in _forces(spectra, each)]
        if not forces or len(spectra.durations_s) > 1:
            return steady
        size = max(force.values.shape[1] for force in forces)
        product, chance, full = np.zeros(size, dtype=complex), np.zeros(size), np.zeros(size)
        for force in forces:
            here = slice(0, force.values.shape[1])
            for total, part in zip((product, chance, full), force.products(), strict=True):
                total[here] += part
        kept = full > LEAST_PAIRS * full[0]
        last = int(np.argmin(kept)) if not kept.all() else size
        near = slice(1, max(1, min(last, TESTED + 1)))
        n_tested = len(chance[near])
        likely = np.abs(product[near]) ** 2 / np.maximum(chance[near], TINY)
        if n_tested == 0 or chi2.sf(2.0 * likely.sum(), 2 * n_tested) > CHANCE:
            return steady
        every = slice(1, last)
        alike = (np.abs(product[every]) ** 2 - chance[every]) / full[every] ** 2
        return cls(alike, spectra.durations_s[0])

    def widening(self, half_width_hz: float) -> float:
        """Return the factor of a mode's deviations, 1 where the forces are steady."""
        # The derivatives by a pole are about as wide as the bell; alike are those of a line and
        # another where both are large: a bell of twice the width.
        away = np.arange(1, len(self.alike) + 1) / (2.0 * half_width_hz * self.duration_s)
        return float(np.sqrt(max(1.0, 1.0 + 2.0 * np.sum(self.alike / (1.0 + away**2)))))


@dataclass(frozen=True, slots=True)
class _Forces:
    """The forces of the modes of one band, as far as the data tell them.

    Parameters
    ----------
    values : (n_modes, n_lines) complex array
        On a grid without gaps, 0 where a line is left out.
    weight : (n_modes, n_lines) array
        Their expected root mean squares.
    """

    values: Complex
    weight: Real

    def products(self) -> tuple[Complex, Real, Real]:
        """Return sums over pairs of lines 0, 1, ... apart.

        Of the products of their values, of the squares that independent lines would give that
        sum, and of what it would be if lines were the same.
        """
        n_modes = len(self.values)
        pairs = [(one, other) for one in range(n_modes) for other in range(one, n_modes)]
        # Of two modes the product comes twice, conjugate the second time.
        between = np.stack(
            [
                (1.0 if one == other else np.sqrt(2.0))
                * self.values[one]
                * self.values[other].conj()
                for one, other in pairs
            ]
        )
        return (
            _correlated(self.values),
            _correlated(between).real,
            _correlated(self.weight.astype(complex)).real,
        )


def _forces(spectra: Spectra, each: GroupFit) -> Iterator[_Forces]:
    """Yield the forces of a band, where it was fitted."""
    if each.band is None or each.fit is None or not each.fit.converged:
        return
    # What a fit made of the power of weak forces may be below zero: of them it tells nothing.
    model, data = without_negative(each.fit.model), each.band.data
    if not model.force.any():
        return
    own = slice(0, model.n_free)
    amplitude = model.shapes * forced_gain(data, model)[:, None, :]
    adjoint = model.force[own] @ amplitude.conj().transpose(0, 2, 1)
    covariance = amplitude @ model.force @ amplitude.conj().transpose(0, 2, 1)
    best = adjoint @ np.linalg.inv(covariance + np.diag(model.noise))
    known = np.einsum('kmc,kmc->km', best, adjoint.conj()).real
    power = np.diag(model.force).real[own]
    there = power > NEGLIGIBLE * power.max()
    power = np.where(there, power, 1.0)
    share = np.where(there, np.clip(known / power, 0.0, 1.0), 0.0)
    scale = np.sqrt(share / power)
    count = data.n_averaged.astype(int)
    lines = each.band.lines
    reduced = spectra.combined(each.band.project, lines).T
    if each.band.motion is not None:
        reduced = reduced - each.band.motion.values
    # What begins and ends with the record is no force, and alike at all lines.
    reduced = without_ends(spectra, lines, reduced, data, model)
    best = np.repeat(best * scale[:, :, None], count, axis=0)
    values = np.zeros((model.n_free, lines[-1] - lines[0] + 1), dtype=complex)
    weight = np.zeros(values.shape)
    values[:, lines - lines[0]] = np.einsum('kmc,kc->mk', best, reduced)
    weight[:, lines - lines[0]] = np.repeat(share, count, axis=0).T
    yield _Forces(values, weight)


def _correlated(rows: Complex) -> Complex:
    """Return Σ x_k x*_{k+m} for m = 0, 1, ..., of all rows together."""
    length = next_fast_len(2 * rows.shape[1])
    power = sum(np.abs(fft(row, length)) ** 2 for row in rows)
    return np.asarray(ifft(power)[: rows.shape[1]].conj())
