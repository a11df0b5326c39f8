"""Nonlinear torque of one joint in one record: exact linear steps in modal form, implicit torque.

The twist of a joint is that of the linear arm, found by Fourier transform, plus the response to
the torque, stepped mode by mode.  Only the torque comes out; it enters the linear prediction as a
further force, so that sensors, poses and leakage are treated as for any other force.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from modal_core.compiled import compiled
from model_gap.joint_path import JointPath
from model_gap.laws.law import Lane, MEMORY, Solve
from model_gap.setup import JointForce

Array = NDArray[np.float64]


def step_torque(path: JointPath, force: JointForce) -> Array:
    """Step the torque along a path.

    Returns
    -------
    (n_steps,) array [N m]
        Torque of the law on the twist, mean from each step to the next; the arm feels its
        negative.

    References
    ----------
    Exact step of a modal state under a force linear between steps: Van Loan (1978),
    doi:10.1109/TAC.1978.1101743.
    """
    period = 1.0 / path.steps_per_s
    poles, residues = path.poles, path.residues
    grow = np.exp(poles * period)
    now = (grow - 1.0) / poles
    change = (now / period - 1.0) / poles
    give = float((residues @ change).real) + path.instant
    rate_give = float((residues * poles @ change).real)
    lane = Lane(
        stiffness=path.stiffness,
        static_twist=path.static_twist,
        give=give,
        rate_give=max(rate_give, 1e-3 * give / period),
        period_s=period,
    )
    constants = np.array(force.law.constants(force.values, lane), dtype=float)
    # The state without the present torque: y' = g y - (g change + held) N.
    modes = np.array([residues, residues * poles, grow, now, grow * change + now - change])
    return _loop_of(force.law.solve)(constants, modes, path.twist, path.rate, path.speed)


@cache
def _loop_of(solve: Solve) -> Callable[..., Array]:
    """Return the loop over the steps of a record with a law compiled into it."""

    @compiled
    def loop(constants, modes, twist, rate, speed):  # type: ignore[no-untyped-def]
        readout, rate_readout, grow, now, mixed = modes
        state = np.zeros(len(grow), dtype=np.complex128)
        memory = np.zeros(MEMORY)
        means = np.empty(len(twist))
        last = 0.0
        for number in range(len(twist)):
            free, free_rate = twist[number], rate[number]
            for mode in range(len(grow)):
                free += (readout[mode] * state[mode]).real
                free_rate += (rate_readout[mode] * state[mode]).real
            torque, surplus = solve(constants, memory, free, free_rate, speed[number])
            means[number - 1] = 0.5 * (last + torque) + surplus  # from the step before to this one
            last = torque
            for mode in range(len(grow)):
                left = state[mode] - now[mode] * surplus
                state[mode] = grow[mode] * left - mixed[mode] * torque
        means[-1] = means[-2]
        return means

    return loop
