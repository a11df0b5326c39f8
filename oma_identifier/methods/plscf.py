"""Poly-reference least squares in the frequency domain as a method of the catalogue."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from oma_identifier.covariance import choose_references
from oma_identifier.methods.banded import BandedMethod, Problem
from oma_identifier.methods.half_spectra import half_spectra, HalfSpectra, LagSums
from oma_identifier.methods.pole_gradient import pole_gradient
from oma_identifier.methods.polyreference import NormalEquations, poles_of
from oma_identifier.methods.solver import Solver, Stretch
from oma_identifier.methods.thresholds import METHOD
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import RawPoles


class Plscf(BandedMethod):
    """Half spectra fitted by a matrix polynomial; deviations by the jackknife to first order."""

    name = 'plscf'
    raises_order = True

    def prepare(self, problem: Problem, settings: IdentificationSettings) -> Solver:
        """Sum the covariances."""
        references = choose_references(problem.rows, settings.n_references or METHOD.references)
        band, rate = problem.band, problem.band.sample_rate_hz
        reach = (0.7 * band.low_hz / rate, min(0.49, 1.05 * band.high_hz / rate))
        sums = LagSums(problem.rows, references, min(METHOD.lags, len(problem.rows) // 4))
        return PlscfSolver(sums, reach, max(3, 2 * problem.orders[-1] // len(references)))


class PlscfSolver(Solver):
    """One band; a model order is twice the order of the polynomial.

    A polynomial order has a pole pair for every two references.

    Parameters
    ----------
    sums : LagSums
        Of the rows.
    reach : (2,) tuple
        Ends of the fitted band as fractions of the sample rate.
    highest : int
        Highest polynomial order.
    """

    def __init__(self, sums: LagSums, reach: tuple[float, float], highest: int) -> None:
        self._sums, self._reach, self._highest = sums, reach, highest
        self._spectra = self._spectra_without(None)
        self._equations = NormalEquations(self._spectra, highest)

    def solve(self, orders: Sequence[int]) -> RawPoles:
        """Return the poles at even model orders."""
        degrees = [order // 2 for order in orders if 2 <= order // 2 <= self._highest]
        raw = poles_of(self._equations, degrees, self._spectra.decay)
        n_references = self._equations.n_references
        return RawPoles(2 * raw.model_order // n_references, raw.eigenvalue, raw.shape)

    def without(
        self,
        stretches: Sequence[Stretch],
        order: NDArray[np.int64],
        pole: NDArray[np.complex128],
        shape: NDArray[np.complex128],
    ) -> NDArray[np.complex128]:
        """Return where the change of the spectra moves the poles, to first order."""
        root = np.exp(pole - self._spectra.decay)
        changes = np.array(
            [self._equations.change(self._spectra_without(each).value) for each in stretches]
        )
        moved = np.empty((len(stretches), len(pole)), dtype=complex)
        for each in np.unique(order):
            own = order == each
            gradient = pole_gradient(self._equations, int(each) // 2, root[own])
            moved[:, own] = pole[own] + changes @ gradient.T
        return moved

    def _spectra_without(self, stretch: Stretch | None) -> HalfSpectra:
        return half_spectra(self._sums.covariance(stretch), *self._reach)
