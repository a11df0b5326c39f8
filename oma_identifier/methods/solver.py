"""What solves one band at any model order, and what its poles are without stretches of it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.methods.jackknife import found_again
from oma_identifier.subspace import RawPoles

Stretch = tuple[int, int]  # First row, and the one after the last.
Solve = Callable[[Sequence[int], Stretch | None], RawPoles]


class Solver(ABC):
    """A band whose sums are known."""

    @abstractmethod
    def solve(self, orders: Sequence[int]) -> RawPoles:
        """Return the poles at even model orders."""

    @abstractmethod
    def without(
        self,
        stretches: Sequence[Stretch],
        order: NDArray[np.int64],
        pole: NDArray[np.complex128],
        shape: NDArray[np.complex128],
    ) -> NDArray[np.complex128]:
        """Return what becomes of some poles when stretches are left out in turn.

        Parameters
        ----------
        stretches : sequence of (first, last)
            Rows that have no part in it.
        order : (n_modes,) int array
            Model order of each pole.
        pole : (n_modes,) complex array
            Natural logarithm of the eigenvalues.
        shape : (n_channels, n_modes) complex array
            Their shapes.

        Returns
        -------
        (n_stretches, n_modes) complex array
            As ``pole``; NaN where there is no such pole any more.
        """


@dataclass(frozen=True, slots=True)
class SolvedAnew(Solver):
    """Solves once more for each stretch that is left out.

    Parameters
    ----------
    anew : callable
        From even model orders, and the rows of a stretch to leave out, to poles.
    """

    anew: Solve

    def solve(self, orders: Sequence[int]) -> RawPoles:
        """Return the poles at even model orders."""
        return self.anew(orders, None)

    def without(
        self,
        stretches: Sequence[Stretch],
        order: NDArray[np.int64],
        pole: NDArray[np.complex128],
        shape: NDArray[np.complex128],
    ) -> NDArray[np.complex128]:
        """Look for each pole among those of its order without the stretch."""
        orders = sorted(set(order.tolist()))
        return np.array(
            [found_again(self.anew(orders, each), order, pole, shape) for each in stretches]
        )
