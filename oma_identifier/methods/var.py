"""Vector autoregressive model, free of the bias of measurement noise, as a method.

The references z and all channels y obey z_t = Σ A_i z_{t-i} + e_t and y_t = Σ D_i z_{t-i} + e'_t,
i = 1 .. p, the rows of D at the references being those of A.  Least squares would be biased:
the noise of z_{t-i} is on both sides of its equations, and damping comes out too high (the trap of
autoregressive models).  Older samples than those of the model, z_{t-p-1} .. z_{t-p-q}, share the
response with them and not the noise.  They serve as instruments (two-stage least squares):
D = Y W⁻¹ Xᵀ (X W⁻¹ Xᵀ)⁻¹ with the products X of the model's samples and Y of the newest sample
with the instruments, and W of these with themselves.  The errors of a structure's model reach
back over p samples (it is a moving average as well), which is why the instruments begin before.

Poles are the logarithms of the eigenvalues μ of the companion matrix of A, shapes Σ D_i μ^-i v.

References
----------
Vu, Thomas, Lakis and Marcouiller (2011), doi:10.1016/j.ymssp.2010.08.006 (vector AR of operational
modal analysis, all orders from one factor); Söderström and Stoica (1983), Instrumental Variable
Methods for System Identification, doi:10.1007/BFb0009019 (instruments); Rissanen (1978),
doi:10.1016/0005-1098(78)90005-5 (order).
"""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, eig, solve, solve_triangular

from oma_identifier.covariance import choose_references, HankelGram
from oma_identifier.methods.banded import BandedMethod, no_raw_poles, Problem
from oma_identifier.methods.solver import SolvedAnew
from oma_identifier.methods.thresholds import METHOD
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import RawPoles

Real = NDArray[np.float64]
RIDGE = 1e-10
"""Of the mean square; keeps factors defined when channels repeat each other."""


class Var(BandedMethod):
    """Vector AR, order by description length, deviations by the jackknife of blocks."""

    name = 'var'

    def prepare(self, problem: Problem, settings: IdentificationSettings) -> SolvedAnew:
        """Sum the products; the order of the model counts twice."""
        references = choose_references(problem.rows, settings.n_references or METHOD.references)
        n_samples = round(problem.duration_s * problem.band.sample_rate_hz)
        sums = VarSums(problem.rows, references, n_samples)

        def solve_orders(orders: Sequence[int], left_out: tuple[int, int] | None) -> RawPoles:
            rest = sums.without(left_out)
            found = [rest.poles(order // 2) for order in orders if 2 <= order // 2 <= sums.highest]
            return _joined(found, problem.n_channels)

        return SolvedAnew(solve_orders)


class VarSums:
    """Products of samples with earlier ones, from which the models of all orders follow.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Conditioned responses.
    references : (n_references,) int array
        Columns that the model is of.
    n_counted : int or None
        Samples of equal weight that tell as much as the rows; None: as many as there are.
    """

    def __init__(
        self, rows: Real, references: NDArray[np.int64], n_counted: int | None = None
    ) -> None:
        n_samples = len(rows) if n_counted is None else n_counted
        self.references = np.asarray(references, dtype=np.intp)
        n_references = len(references)
        most = math.ceil(METHOD.var_size / n_references)
        most = max(METHOD.var_fewest, min(most, n_samples // (20 * n_references)))
        self.n_instruments = max(METHOD.var_instruments, most)
        self._gram = HankelGram(rows, rows[:, references], most + self.n_instruments + 1)
        chosen = order_by_description_length(
            self._gram.gram(range(most + 1), self.references), n_samples, n_references
        )
        self.highest = min(most, max(METHOD.var_fewest, math.ceil(METHOD.var_beyond * chosen)))
        self._last = most + self.n_instruments

    def without(self, left_out: tuple[int, int] | None) -> 'VarSums':
        """Return the sums without the windows that touch a stretch of the record."""
        rest = object.__new__(VarSums)
        rest.__dict__.update(self.__dict__, _gram=self._gram.without(left_out))
        return rest

    def coefficients(self, order: int) -> Real:
        """Return D of one order, (n_channels, order * n_references)."""
        first = self._last - order - self.n_instruments
        past, own = range(first, first + self.n_instruments), range(self._last - order, self._last)
        factor = cholesky(
            _ridged(self._gram.gram(past, self.references)), lower=True, check_finite=False
        )
        newest = self._gram.product(range(self._last, self._last + 1), past)
        model = self._gram.product(own, past, self.references)
        # The block rows run with time, the coefficients against it.
        model = model.reshape(order, len(self.references), -1)[::-1].reshape(-1, model.shape[1])
        both = solve_triangular(
            factor, np.concatenate([model, newest]).T, lower=True, check_finite=False
        )
        seen, wanted = both[:, : len(model)], both[:, len(model) :]
        return np.asarray(solve(_ridged(seen.T @ seen), seen.T @ wanted, assume_a='pos').T)

    def poles(self, order: int) -> RawPoles:
        """Return the poles of one order."""
        coefficients = self.coefficients(order)
        n_references = len(self.references)
        companion = np.eye(order * n_references, k=-n_references)
        companion[:n_references] = coefficients[self.references]
        value, vector = eig(companion, check_finite=False)
        upper = value.imag > 0.0
        value, vector = value[upper], vector[:, upper]
        return RawPoles(np.full(len(value), 2 * order), value, coefficients @ vector)


def order_by_description_length(gram: Real, n_samples: int, n_references: int) -> int:
    """Return the order of least description length, N ln |Σ_p| + p r² ln N.

    Parameters
    ----------
    gram : (n * n_references, n * n_references) array
        Products of n samples in a row, oldest first; orders up to n - 1 are compared.  The block
        of its Cholesky factor at sample p is that of the errors of a prediction by p samples.
    n_samples, n_references : int
        Of the record.
    """
    factor = cholesky(_ridged(gram), lower=True, check_finite=False)
    error = 2.0 * np.log(np.diag(factor)).reshape(-1, n_references).sum(axis=1)
    order = np.arange(len(error))
    length = n_samples * error + order * n_references**2 * math.log(n_samples)
    return int(np.argmin(length))


def _ridged(gram: Real) -> Real:
    return np.asarray(gram + RIDGE * np.trace(gram) / len(gram) * np.eye(len(gram)))


def _joined(found: list[RawPoles], n_channels: int) -> RawPoles:
    every = [no_raw_poles(n_channels), *found]
    return RawPoles(
        np.concatenate([each.model_order for each in every]),
        np.concatenate([each.eigenvalue for each in every]),
        np.concatenate([each.shape for each in every], axis=1),
    )
