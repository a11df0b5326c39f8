"""Where to measure next: the pose that takes most variance from the workspace per second.

The exact fall of the variance of log f at other poses when the modes of a candidate are added
(Cohn 1996, arXiv:cs/9603104).  It does not hang on what will be measured, so that a whole series
can be chosen, checked and released before the first motion.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import scipy.linalg

from workspace_map.arm import frequency_slopes, local_modes, LocalModes
from workspace_map.prior import FREQUENCY, SHAPE, structure_parts
from workspace_map.regression import Rows
from workspace_map.rows import flat, principal_rows
from workspace_map.workspace_map import WorkspaceMap

Array = NDArray[np.float64]
SHAPE_STD = 0.01
"""Of a shape of unit length, as an identification of a minute has it."""


@dataclass(frozen=True)
class Candidates:
    """Poses that may be measured and what their modes would tell.

    Parameters
    ----------
    q : (n_candidates, n_joints) array [rad]
        Serial joint angles.
    rows : Rows
        Of log f and of the shapes, of all candidates.
    variance : (n_rows,) array
        Of a measurement of each, with the part of each row that no function of the pose has.
    of_interest : Rows
        log f at the poses of interest.
    """

    q: Array
    rows: Rows
    variance: Array
    of_interest: Rows


def frequency_bound(modes: LocalModes, duration_s: float) -> Array:
    """Return twice the least σ of log f that a record allows: sqrt(ζ / (2 π f T))."""
    cycles = modes.frequency_hz * duration_s
    return np.asarray(2.0 * np.sqrt(modes.damping_ratio / (2.0 * np.pi * cycles)))


def candidates(known: WorkspaceMap, q: Array, of_interest: Array, duration_s: float) -> Candidates:
    """Return what may be measured.

    Parameters
    ----------
    known : WorkspaceMap
        So far; also one without measured poses.
    q : (n_candidates, n_joints) array [rad]
        Poses the arm can be measured at.
    of_interest : (n_poses, n_joints) array [rad]
        Where frequencies shall be known: the workspace, or a path.
    duration_s : float [s]
        Of a record.
    """
    there = [_modes(known, pose) for pose in q]
    own = [_frequency_parts(known, modes) for modes in (_modes(known, p) for p in of_interest)]
    both, variance, kinds = [], [], []
    white = known.found_scales[0].white
    for modes in there:
        shapes = principal_rows(known.arm, modes)
        each = zip(_frequency_parts(known, modes), shapes.parts, strict=True)
        both.append(tuple(np.vstack([a, flat(b)]) for a, b in each))
        kind = np.repeat([FREQUENCY, SHAPE], [modes.n, modes.n * shapes.turn.shape[1]])
        std = np.full(len(kind), SHAPE_STD)
        std[: modes.n] = frequency_bound(modes, duration_s)
        kinds.append(kind)
        variance.append(std**2 + white[kind] ** 2)
    return Candidates(
        q, _together(both, q, kinds), np.concatenate(variance), _together(own, of_interest)
    )


def choose_series(
    known: WorkspaceMap,
    choice: Candidates,
    count: int,
    seconds: Callable[[Array | None, Array], Array],
    start: Array | None = None,
) -> list[int]:
    """Return which candidates to measure, in order, each chosen as if those before were measured.

    Parameters
    ----------
    known : WorkspaceMap
        So far.
    choice : Candidates
        What may be measured.
    count : int
        How many.
    seconds : callable
        Time of motion and record, from a pose (None: from anywhere) to each candidate.
    start : (n_joints,) array [rad], optional
        Where the arm is.
    """
    found = known.fitted.structure
    inner = _Left(
        found.covariance(choice.rows, choice.rows),
        found.covariance(choice.rows, choice.of_interest),
    )
    taken: list[int] = []
    here = start
    members = [np.flatnonzero(choice.rows.pose == n) for n in range(len(choice.q))]
    for _ in range(min(count, len(choice.q))):
        gain = np.array([inner.gain(rows, choice.variance[rows]) for rows in members])
        worth = gain / seconds(here, choice.q)
        worth[taken] = -np.inf
        best = int(np.argmax(worth))
        taken.append(best)
        inner = inner.given(members[best], choice.variance[members[best]])
        here = choice.q[best]
    return taken


@dataclass(frozen=True)
class _Left:
    """Covariance of candidates with each other and with what is of interest, so far."""

    own: Array
    cross: Array

    def gain(self, rows: NDArray[np.intp], variance: Array) -> float:
        """Return by how much the summed variance of interest falls when rows are measured."""
        factor = np.linalg.cholesky(self.own[np.ix_(rows, rows)] + np.diag(variance))
        seen = scipy.linalg.solve_triangular(
            factor, self.cross[rows], lower=True, check_finite=False
        )
        return float(np.sum(seen**2))

    def given(self, rows: NDArray[np.intp], variance: Array) -> '_Left':
        """Return what is left when rows are measured."""
        factor = np.linalg.cholesky(self.own[np.ix_(rows, rows)] + np.diag(variance))
        solve = {'lower': True, 'check_finite': False}
        own = scipy.linalg.solve_triangular(factor, self.own[rows], **solve)
        cross = scipy.linalg.solve_triangular(factor, self.cross[rows], **solve)
        return _Left(self.own - own.T @ own, self.cross - own.T @ cross)


def _modes(known: WorkspaceMap, q: Array) -> LocalModes:
    return local_modes(known.arm.at(q), known.state(q), known.highest_hz)


def _frequency_parts(known: WorkspaceMap, modes: LocalModes) -> tuple[Array, ...]:
    return structure_parts(known.arm, frequency_slopes(modes))


def _together(
    parts: Sequence[tuple[Array, ...]], q: Array, kinds: Sequence[NDArray[np.intp]] = ()
) -> Rows:
    sizes = [len(each[0]) for each in parts]
    return Rows(
        tuple(np.vstack(each) for each in zip(*parts, strict=True)),
        q,
        np.repeat(np.arange(len(q)), sizes),
        np.concatenate(kinds) if len(kinds) else np.zeros(sum(sizes), dtype=np.intp),
    )
