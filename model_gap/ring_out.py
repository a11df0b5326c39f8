"""What a force in the arm leaves ringing when a record ends: its spectra lack that."""

import numpy as np
from numpy.typing import NDArray

from model_gap.pose_system import PoseSystem
from model_gap.spectra import RecordSpectra

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Older than so many times the decay, a force is forgotten.
FORGOTTEN = 12.0


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
    ringing = np.flatnonzero(system.poles.imag > 0.0)
    poles = system.poles[ringing]
    newest_first = force[::-1]
    state = np.zeros(len(poles), dtype=complex)
    for number, pole in enumerate(poles):
        count = min(len(force), round(FORGOTTEN / max(-pole.real, 1e-6) / period_s) + 1)
        turns = np.exp(pole * period_s * np.arange(count))
        state[number] = (newest_first[:count] @ turns) * (np.exp(pole * period_s) - 1.0) / pole
    state *= system.drives[ringing] @ place
    shapes = system.shapes[:, ringing]
    shift, speed = 2.0 * (shapes @ state).real, 2.0 * (shapes @ (poles * state)).real
    still = system.mass @ speed + system.damping @ shift
    turning = np.outer(system.mass @ shift, 1j * item.omega.ravel())
    return np.asarray(-item.end_scale * (still[:, None] + turning))
