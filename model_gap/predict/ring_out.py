"""What a force in the arm leaves ringing when a record ends: its spectra lack that."""

import numpy as np
from numpy.typing import NDArray

from modal_core.work.compiled import compiled
from model_gap.campaign import RecordSpectra
from model_gap.cell import PoseSystem

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def end_force(
    force: Array, period_s: float, place: Array, item: RecordSpectra, system: PoseSystem
) -> Complex:
    """Return the force that takes what another leaves ringing out of a record, (n_dof, 3 n_bins).

    A record ends while the arm moves on: its spectra lack the free motion from the state x, x' at
    the end, and a force -(M x' + (iω M + C) x) takes that away.  Where friction or play keep a
    joint from ringing, the arm without their torque would ring far more.

    Parameters
    ----------
    force : (n_steps,) array
        Mean over each step, to the end of the record; none before the record.
    period_s : float [s]
        Of a step.
    place : (n_dof,) array
        Force on the deflections per unit.
    item : RecordSpectra
        The record.
    system : PoseSystem
        The arm at its pose.
    """
    ringing, count = system.one_of_pairs
    poles = system.poles[ringing]
    turns = np.exp(poles * period_s)
    state = summed(np.ascontiguousarray(force), turns) * (turns - 1.0) / poles
    state *= count * (system.drives[ringing] @ place)
    shapes = system.shapes[:, ringing]
    shift, speed = (shapes @ state).real, (shapes @ (poles * state)).real
    still = system.arm.M @ speed + system.arm.C @ shift
    turning = np.outer(system.arm.M @ shift, 1j * item.omega.ravel())
    return np.asarray(-item.end_scale * (still[:, None] + turning))


@compiled
def summed(force: Array, turns: Complex) -> Complex:
    """Return Σ force[n]·turnᵏ, k steps from n to the end, for every turn of a step."""
    state = np.zeros(len(turns), dtype=np.complex128)
    for value in force:
        for mode in range(len(turns)):
            state[mode] = state[mode] * turns[mode] + value
    return state
