"""Data-driven subspace identification as a method of the catalogue."""

from collections.abc import Sequence
import math

from oma_identifier.covariance import choose_references
from oma_identifier.methods.banded import BandedMethod, Problem
from oma_identifier.methods.solver import SolvedAnew, Solver
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import data_gram, data_poles, RawPoles

BLOCK_ROWS = 20


def prepare_ssi_data(problem: Problem, settings: IdentificationSettings) -> Solver:
    """Sum what data-driven subspace identification needs of a band."""
    references = choose_references(problem.rows, settings.n_references)
    block_rows = settings.block_rows or max(
        BLOCK_ROWS, math.ceil(1.5 * problem.orders[-1] / len(references))
    )
    gram = data_gram(problem.rows, references, block_rows)

    def solve(orders: Sequence[int], left_out: tuple[int, int] | None) -> RawPoles:
        return data_poles(gram.without(left_out), references, block_rows, orders)

    return SolvedAnew(solve)


class SsiData(BandedMethod):
    """Projection of future on past responses; deviations by the jackknife of blocks."""

    name = 'ssi_data'
    raises_order = True

    def prepare(self, problem: Problem, settings: IdentificationSettings) -> Solver:
        """Sum what the method needs of a band."""
        return prepare_ssi_data(problem, settings)
