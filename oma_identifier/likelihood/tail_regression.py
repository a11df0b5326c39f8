"""How much of each mode's motion lies along the shapes of the modes beside a band.

There the responses hold the tails of these modes too, and tails have forces in common with the
band's own modes.  But a tail follows the force, smoothly, where a mode resonates: what responds
like the resonance belongs to the mode.  So the coordinate of each tail is regressed on the motion
of the band's modes and on their forces times the accelerance of the tail; what is left, the part
of the tail that has other forces, is the noise of the regression.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
RCOND = 1e-10


@dataclass(frozen=True, slots=True)
class TailData:
    """Averages of one band over motions of its own modes and coordinates of the tails.

    Parameters
    ----------
    count : (n_lines,) array
        Frequencies in each average.
    moment : (n_own + n_tails, n_own + n_tails, n_lines) complex array
        Averaged products of all with the complex conjugates of all.
    own : (n_own, n_lines) complex array
        Accelerance of the band's own modes.
    change : (n_parameters, n_own, n_lines) complex array
        Of its inverse, by one standard deviation of each parameter of a pole.
    tail : (n_tails, n_lines) complex array
        Accelerance of the tails.
    """

    count: Real
    moment: Complex
    own: Complex
    change: Complex
    tail: Complex


@dataclass(frozen=True, slots=True)
class Along:
    """Parts of the band's shapes along the shapes of the tails.

    Parameters
    ----------
    parts : (n_tails, n_own) complex array
        Estimates.
    scatter : (n_own, n_tails, n_directions) complex array
        Their errors along independent directions of one standard deviation each.
    by_mixing : (n_own, n_tails, n_own) complex array
        What is added to a part where the shape inside the band holds a share of another mode's:
        as much of its motion is missing in the other's, and so in the force that drives the tail.
    """

    parts: Complex
    scatter: Complex
    by_mixing: Complex


def parts_along(data: TailData) -> Along:
    """Regress the coordinates of the tails, weighted by what tails of white force scatter."""
    found = _Regression.of(data)
    shifts = found.shifts(data, np.concatenate([data.change, 1.0 / data.own[None]]))
    own, n_errors = np.arange(len(data.own)), len(data.change)
    poles = shifts[:, :, :n_errors, own, own].reshape(len(own), len(data.tail), -1)
    return Along(found.coefficients[0].T, found.scatter(poles), shifts[own, :, n_errors, :, own])


@dataclass(frozen=True, slots=True)
class _Regression:
    """Least squares of all tails, each on the motions and on the forces times its accelerance.

    Parameters
    ----------
    weight : (n_tails, n_lines) array
        Of the residuals.
    regressors : (2, n_own, n_tails, n_lines) complex array
        Both kinds per unit of each motion, weighted.
    moment : (2, n_own, n_tails, 2, n_own, n_tails) complex array
        Of the regressors.
    inverse : (n_tails, 2, n_own, 2, n_own) complex array
        Of its part that belongs to each tail.
    coefficients : (2, n_own, n_tails) complex array
        That leave least.
    left_over : (n_tails, n_tails) complex array
        Covariance of the weighted residuals.
    """

    weight: Real
    regressors: Complex
    moment: Complex
    inverse: Complex
    coefficients: Complex
    left_over: Complex

    @classmethod
    def of(cls, data: TailData) -> '_Regression':
        weight = 1.0 / np.abs(data.tail)
        n_own, n_tails = len(data.own), len(data.tail)
        counted = data.count * data.moment
        x = np.empty((2, n_own, *weight.shape), dtype=complex)
        x[0] = weight
        x[1] = weight * data.tail / data.own[:, None]
        by_own = x.swapaxes(0, 1).reshape(n_own, 2 * n_tails, -1)
        back = by_own.conj().swapaxes(1, 2)
        moment = (by_own[:, None] * counted[:n_own, :n_own, None]) @ back
        moment = moment.reshape(n_own, n_own, 2, n_tails, 2, n_tails).transpose(2, 0, 3, 4, 1, 5)
        onto = (counted[n_own:, :n_own].swapaxes(0, 1) * weight) @ back
        onto = onto.reshape(n_own, n_tails, 2, n_tails).transpose(1, 2, 0, 3)
        every = np.arange(n_tails)
        own = moment[:, :, every, :, :, every].reshape(n_tails, 2 * n_own, -1)
        inverse = np.asarray(np.linalg.pinv(own, rcond=RCOND, hermitian=True), dtype=complex)
        found = onto[every, :, :, every].reshape(n_tails, 1, -1) @ inverse
        coefficients = found.reshape(n_tails, 2, n_own).transpose(1, 2, 0)
        square = np.einsum('ik,ijk,jk->ij', weight, counted[n_own:, n_own:], weight)
        fitted = np.einsum('tiau,iau->tu', onto, coefficients.conj())
        both = _pairs(coefficients, moment)
        freedom = max(float(data.count.sum()) - 2 * n_own, 1.0)
        left_over = (square - fitted - fitted.conj().T + both) / freedom
        inverse = inverse.reshape(n_tails, 2, n_own, 2, n_own)
        return cls(weight, x, moment, inverse, coefficients, left_over)

    def scatter(self, poles: Complex) -> Complex:
        """Return the errors of what belongs to the motions, (n_own, n_tails, n_directions).

        Parameters
        ----------
        poles : (n_own, n_tails, n_parameters) complex array
            What errors of the poles do.
        """
        result = []
        for own, by_poles in enumerate(poles):
            column = self.inverse[:, :, :, 0, own].transpose(1, 2, 0)
            covariance = self.left_over * _pairs(column.conj(), self.moment).conj()
            variance, directions = np.linalg.eigh(covariance)
            half = directions * np.sqrt(0.5 * np.maximum(variance, 0.0))
            result.append(np.concatenate([half, 1j * half, by_poles], axis=1))
        return np.stack(result)

    def shifts(self, data: TailData, wrong: Complex) -> Complex:
        """Return what belongs to the motions by mistake when the forces are mistaken.

        Parameters
        ----------
        wrong : (n_errors, n_own, n_lines) complex array
            Each force errs by this times a motion.

        Returns
        -------
        (n_own, n_tails, n_errors, n_own, n_own) complex array
            Of the part along each motion: by errors of each force that are times each motion.
        """
        n_own, n_tails, n_lines = len(data.own), *data.tail.shape
        motion = data.count * data.moment[:n_own, :n_own]
        mistaken = wrong[:, :, None, None] * motion  # errors, forces, times motions, motions
        mistaken = mistaken.reshape(-1, n_own, n_lines).swapaxes(0, 1)
        onto = (self.weight * data.tail) * self.regressors.conj()
        onto = onto.transpose(1, 3, 0, 2).reshape(n_own, n_lines, -1)
        onto = (mistaken @ onto).reshape(n_own, len(wrong), n_own, n_own, 2, n_tails)
        wanted = self.inverse[:, :, :, 0].transpose(3, 0, 2, 1)  # motions, tails, motions, kinds
        shifts = np.einsum('befmit,otbi->otefm', onto, wanted)
        return np.asarray(shifts * self.coefficients[1].T[:, None, :, None])


def _pairs(coefficients: Complex, moment: Complex) -> Complex:
    """Return the products of combinations of regressors, (n_tails, n_tails)."""
    half = np.einsum('iatjbu,jbu->iatu', moment, coefficients.conj())
    return np.asarray(np.einsum('iat,iatu->tu', coefficients, half))
