"""One tooth period of the tool in the cut as a linear map: its spectral radius decides.

Between samples the force stands on a straight line, of what the tool does now as of what it did a
period ago, and the modes answer to it exactly; engagement is averaged exactly inside each step.

References
----------
Insperger and Stépán (2004), doi:10.1002/nme.1061 (semi-discretisation); Ding et al. (2010),
doi:10.1016/j.ijmachtools.2010.01.003 (straight lines for the present force too).
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.sparse.linalg import ArpackNoConvergence, eigs

from machining.cut import Cut
from modal_core.tool_modes import ToolModes
from modal_core.work.compiled import compiled

Real = NDArray[np.float64]
PER_CYCLE = 48
"""Steps per cycle of the highest mode: limits are then within 0.5 % of those of many more."""
FEWEST_STEPS = 96
"""Per tooth period: engagement has to be seen too."""
MOST_STEPS = 4000
WHOLE = 70
"""Up to this size all eigenvalues are faster than the largest alone."""
LARGEST = 6
"""Eigenvalues asked for: of a robot several modes are equally near the circle."""


@dataclass(frozen=True, slots=True)
class FreeStep:
    """What modes do over one step under a force on a straight line.

    Parameters
    ----------
    own : (n_modes, 2, 2) array
        New displacement and speed of what they were.
    begin, end : (n_modes, 2) array
        Of the force per modal mass at both ends of the step.
    """

    own: Real
    begin: Real
    end: Real

    @classmethod
    def of(cls, modes: ToolModes, step_s: float) -> 'FreeStep':
        """Return it for modes and a length of step."""
        omega = 2.0 * math.pi * modes.frequency_hz
        block = np.zeros((modes.n_modes, 4, 4))
        block[:, 0, 1] = block[:, 1, 2] = step_s
        block[:, 2, 3] = 1.0
        block[:, 1, 0] = -(omega**2) * step_s
        block[:, 1, 1] = -2.0 * modes.damping_ratio * omega * step_s
        after = np.stack([expm(each) for each in block])
        return cls(
            np.ascontiguousarray(after[:, :2, :2]),
            np.ascontiguousarray(after[:, :2, 2] - after[:, :2, 3]),
            np.ascontiguousarray(after[:, :2, 3]),
        )


def steps_per_period(modes: ToolModes, period_s: float) -> int:
    """Return how many samples a tooth period has."""
    wanted = math.ceil(PER_CYCLE * float(modes.frequency_hz.max()) * period_s)
    return min(max(wanted, FEWEST_STEPS), MOST_STEPS)


def spectral_radius(
    modes: ToolModes, cut: Cut, speed_rpm: float, depth_m: float, finer: float = 1.0
) -> float:
    """Return by what a small vibration is multiplied per tooth period; above 1 it grows.

    Parameters
    ----------
    modes : ToolModes
        In the axes of the cut.
    cut : Cut
    speed_rpm, depth_m : float [rpm], [m]
        Where.
    finer : float
        Factor on the number of steps.
    """
    period_s = cut.cutter.tooth_period_s(speed_rpm)
    n_steps = round(finer * steps_per_period(modes, period_s))
    free = FreeStep.of(modes, period_s / n_steps)
    turn = np.linspace(0.0, cut.cutter.pitch_rad, n_steps + 1)
    directional = depth_m * cut.directional(turn, depth_m)
    return _radius(_period_map(free.own, free.begin, free.end, *_in_modes(modes, directional)))


def _in_modes(modes: ToolModes, directional: Real) -> tuple[Real, Real, NDArray[np.int64]]:
    """Return the feedback in few coordinates.

    What is delayed is the tool's displacement along the axes that change the chip; of a single
    mode it is that mode itself.

    Returns
    -------
    gain : (n_steps, n_modes, n_delayed) array
        Modal force of the coordinates.
    out : (n_delayed, n_modes) array
        The coordinates of the modes.
    place : (n_steps + 1,) array
        Column of what is remembered of each sample; -1 where nobody asks for it.
    """
    felt = np.abs(directional).max(axis=(0, 1)) > 0.0
    out = modes.shape[:, felt].T
    gain = np.einsum('mi,sij->smj', modes.shape, directional[:, :, felt])
    if modes.n_modes <= out.shape[0]:
        gain, out = gain @ out, np.eye(modes.n_modes)
    cutting = np.abs(gain).max(axis=(1, 2)) > 0.0
    needed = np.append(cutting, False) | np.append(False, cutting)
    place = np.where(needed, np.cumsum(needed) - 1, -1).astype(np.int64)
    return np.ascontiguousarray(gain), np.ascontiguousarray(out), place


@compiled
def _period_map(
    own: Real, begin: Real, end: Real, gain: Real, out: Real, place: NDArray[np.int64]
) -> Real:
    """Return the map of the state at the period's begin, and what is remembered, to its end.

    Rows and columns: displacements, then speeds of the modes, then the coordinates of those
    samples of the last period that are asked for.
    """
    n_steps, n_modes, n_out = gain.shape
    first = 2 * n_modes
    size = first + n_out * (place[:-1].max() + 1)
    made, state = np.zeros((size, size)), np.zeros((2, n_modes, size))
    for mode in range(n_modes):
        state[0, mode, mode] = state[1, mode, n_modes + mode] = 1.0
    start = out @ state[0]
    for step in range(n_steps):
        if place[step] >= 0:
            row = first + n_out * place[step]
            made[row : row + n_out] = out @ state[0]
        if np.abs(gain[step]).max() == 0.0:
            state = _moved(own, begin, state, np.zeros((n_modes, size)))
            continue
        ago = _remembered(first + n_out * place[step], n_out, size)
        state = _moved(own, begin, state, gain[step] @ (out @ state[0] - ago))
        if step + 1 == n_steps:
            ago = start
        else:
            ago = _remembered(first + n_out * place[step + 1], n_out, size)
        # The force at the end of the step depends on what it makes: solve for it.
        lent = out @ (end[:, :1] * gain[step])
        late = np.linalg.solve(np.eye(n_out) - lent, out @ state[0] - ago)
        force = gain[step] @ late
        for mode in range(n_modes):
            for of in range(2):
                state[of, mode] += end[mode, of] * force[mode]
    made[:n_modes], made[n_modes:first] = state[0], state[1]
    return made


@compiled
def _remembered(column: int, n_out: int, size: int) -> Real:
    """Return the coordinates of a sample of the last period: themselves."""
    made = np.zeros((n_out, size))
    for each in range(n_out):
        made[each, column + each] = 1.0
    return made


@compiled
def _moved(own: Real, begin: Real, state: Real, push: Real) -> Real:
    """Return displacements and speeds a step later, under a force that falls to zero."""
    made = np.empty_like(state)
    for mode in range(state.shape[1]):
        for of in range(2):
            made[of, mode] = (
                own[mode, of, 0] * state[0, mode]
                + own[mode, of, 1] * state[1, mode]
                + begin[mode, of] * push[mode]
            )
    return made


def _radius(matrix: Real) -> float:
    """Return the largest modulus of a matrix's eigenvalues."""
    if len(matrix) > WHOLE:
        try:
            begin = np.ones(len(matrix))
            return float(np.abs(eigs(matrix, k=LARGEST, v0=begin, tol=1e-9)[0]).max())
        except ArpackNoConvergence:
            pass
    return float(np.abs(np.linalg.eigvals(matrix)).max())
