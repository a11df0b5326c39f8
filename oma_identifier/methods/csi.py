"""Combined deterministic-stochastic subspace identification as a method of the catalogue."""

from collections.abc import Sequence
from dataclasses import replace

from oma_identifier.covariance import choose_references
from oma_identifier.methods.banded import BandedMethod, Problem
from oma_identifier.methods.solver import SolvedAnew, Solver
from oma_identifier.methods.ssi_data import BLOCK_ROWS, prepare_ssi_data
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import combined_gram, combined_poles, RawPoles


class Csi(BandedMethod):
    """Part of the force is known; deviations by the jackknife of blocks."""

    name = 'csi'
    needs_inputs = True

    def prepare(self, problem: Problem, settings: IdentificationSettings) -> Solver:
        """Sum what the method needs; a band in which no input moves is solved without."""
        outputs = problem.rows[:, : problem.n_channels]
        inputs = problem.rows[:, problem.n_channels :]
        inputs = inputs[:, inputs.any(axis=0)]
        if not inputs.size:
            return prepare_ssi_data(replace(problem, rows=outputs), settings)
        references = choose_references(outputs, settings.n_references)
        block_rows = settings.block_rows or BLOCK_ROWS
        gram = combined_gram(outputs, inputs, block_rows)

        def solve(orders: Sequence[int], left_out: tuple[int, int] | None) -> RawPoles:
            rest = gram.without(left_out)
            return combined_poles(rest, inputs.shape[1], references, block_rows, orders)

        return SolvedAnew(solve)
