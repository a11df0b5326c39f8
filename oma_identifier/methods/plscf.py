"""Poly-reference least squares in the frequency domain as a method of the catalogue."""

from collections.abc import Sequence

from oma_identifier.covariance import choose_references
from oma_identifier.methods.banded import BandedMethod, Problem, Solve
from oma_identifier.methods.half_spectra import LagSums
from oma_identifier.methods.polyreference import poles_of_covariance
from oma_identifier.methods.thresholds import METHOD
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import RawPoles


class Plscf(BandedMethod):
    """Half spectra fitted by a matrix polynomial; deviations by the jackknife of blocks."""

    name = 'plscf'

    def prepare(self, problem: Problem, settings: IdentificationSettings) -> Solve:
        """Sum the covariances; the order of the polynomial counts twice."""
        references = choose_references(problem.rows, settings.n_references or METHOD.references)
        band, rate = problem.band, problem.band.sample_rate_hz
        reach = (0.7 * band.low_hz / rate, min(0.49, 1.05 * band.high_hz / rate))
        sums = LagSums(problem.rows, references, min(METHOD.lags, len(problem.rows) // 4))
        highest = max(3, 2 * problem.orders[-1] // len(references))

        def solve(orders: Sequence[int], left_out: tuple[int, int] | None) -> RawPoles:
            # A polynomial order has a pole pair for every two references.
            degrees = [order // 2 for order in orders if 2 <= order // 2 <= highest]
            raw = poles_of_covariance(sums.covariance(left_out), degrees, reach)
            return RawPoles(2 * raw.model_order // len(references), raw.eigenvalue, raw.shape)

        return solve
