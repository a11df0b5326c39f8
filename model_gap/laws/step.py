"""A law stepped along a record, as machine code."""

from collections.abc import Callable
from functools import cache

import numba
import numpy as np
from numpy.typing import NDArray

from modal_core.work.compiled import compiled_for
from model_gap.laws.law import Array, MEMORY, Torque

Complex = NDArray[np.complex128]
Stepper = Callable[[Torque, Array, Complex, Array, Array, Array], Array]


def stepped(
    torque: Torque, constants: Array, modes: Complex, twist: Array, rate: Array, speed: Array
) -> Array:
    """Return the mean torque from each step to the next.

    Parameters
    ----------
    torque : compiled function
        Of the law.
    constants : (n_constants,) array
        Of the law in this joint of this record.
    modes : (5, n_modes) complex array
        Residues of twist and rate; factors of a step: of the state, of a torque held over it, of
        one that rises linearly from nothing and falls back.
    twist, rate, speed : (n_steps,) array
        Twist and rate without the torque; motor speed.
    """
    whole = np.ascontiguousarray
    return _stepper()(torque, constants, whole(modes), whole(twist), whole(rate), whole(speed))


@cache
def _stepper() -> Stepper:
    """Compile the loop once for all laws: it calls them by their address."""
    real, series = numba.float64, numba.float64[::1]
    pair = numba.types.UniTuple(real, 2)
    law = numba.types.FunctionType(pair(series, series, real, real, real))
    return compiled_for(series(law, series, numba.complex128[:, ::1], series, series, series))(
        _step
    )


def _step(
    torque: Torque, constants: Array, modes: Complex, twist: Array, rate: Array, speed: Array
) -> Array:
    readout, rate_readout, grow, now, mixed = modes[0], modes[1], modes[2], modes[3], modes[4]
    state = np.zeros(len(grow), dtype=np.complex128)
    memory = np.zeros(MEMORY)
    means = np.zeros(len(twist))
    last = 0.0
    for number in range(len(twist)):
        free, free_rate = twist[number], rate[number]
        for mode in range(len(grow)):
            free += (readout[mode] * state[mode]).real
            free_rate += (rate_readout[mode] * state[mode]).real
        load, surplus = torque(constants, memory, free, free_rate, speed[number])
        if number > 0:
            means[number - 1] = 0.5 * (last + load) + surplus
        last = load
        for mode in range(len(grow)):
            left = state[mode] - now[mode] * surplus
            state[mode] = grow[mode] * left - mixed[mode] * load
    if len(means) > 1:
        means[-1] = means[-2]
    return means
