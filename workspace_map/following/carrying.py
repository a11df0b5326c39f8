"""Shapes carried from pose to pose, and which mode has which of them."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from workspace_map.rows import nearest_rotation, subspaces

Array = NDArray[np.float64]


class Modes(Protocol):
    """What is needed of the modes of a pose."""

    @property
    def frequency_hz(self) -> Array:
        """Natural frequencies, rising, (n,) [Hz]."""

    @property
    def damping_ratio(self) -> Array:
        """Of these modes, (n,)."""

    @property
    def shapes(self) -> Array:
        """Mass-normalised, of all modes, (n_dof, n_dof)."""


@dataclass(frozen=True)
class Carried:
    """Shapes at a pose, one per mode of interest.

    Parameters
    ----------
    frequency_hz : (n_modes,) array [Hz]
        Of each shape, by Rayleigh's quotient.
    shapes : (n_dof, n_modes) array
        Mass-normalised.
    share : (n_modes,) array
        Least share of itself that each found in one mode, or in one subspace, on its way.
    """

    frequency_hz: Array
    shapes: Array
    share: Array

    @classmethod
    def of(cls, modes: Modes) -> 'Carried':
        """Return the shapes of the modes themselves."""
        hz = modes.frequency_hz
        return cls(hz, modes.shapes[:, : len(hz)], np.ones(len(hz)))

    def turned(self, turn: Array) -> 'Carried':
        """Return the shapes times a rotation, (n_modes, n_modes)."""
        hz = np.sqrt(self.frequency_hz**2 @ turn**2)
        return replace(self, frequency_hz=hz, shapes=self.shapes @ turn)


def carried_on(before: Carried, modes: Modes) -> tuple[NDArray[np.intp], Carried]:
    """Carry shapes to a neighbouring pose.

    Parameters
    ----------
    before : Carried
        At the pose before.
    modes : Modes
        At the neighbouring pose.

    Returns
    -------
    came : (n_modes,) int array
        Which of those before each is; -1: none.
    after : Carried
        In that order.
    """
    n = len(modes.frequency_hz)
    # Mass-normalised shapes: inv(shapes) = shapesᵀ M, so that no mass is needed.
    like = np.linalg.solve(modes.shapes, before.shapes)
    rows, columns = linear_sum_assignment(-(like**2))
    came = np.full(len(like), -1)
    came[rows] = columns
    came = came[:n]
    turn, share = np.eye(n), np.ones(n)
    number = subspaces(modes.frequency_hz, modes.damping_ratio)
    for each in np.unique(number):
        own = np.flatnonzero(number == each)
        held = own[came[own] >= 0]
        if not len(held):
            continue
        block = np.eye(len(own))
        block[:, came[own] >= 0] = like[np.ix_(own, came[held])]
        turn[np.ix_(own, own)] = nearest_rotation(block)
        within = np.sum(like[np.ix_(own, came[held])] ** 2, axis=0)
        share[held] = np.minimum(before.share[came[held]], within)
    return came, replace(Carried.of(modes).turned(turn), share=share)
