"""How fast the two sides of each gear move against the frame: the axis itself and its twist."""

import numpy as np
from numpy.typing import NDArray

from excitation_planner.motion import PredictedSpectrum
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Modes beyond this part above the excited band ring little.
BEYOND_BAND = 1.2


def twist_rate_rms(
    model: FlexibleJointModel, q: Array, spectrum: PredictedSpectrum, highest_hz: float
) -> Array:
    """Return the speed of the twist of every drive, from the modes that ring, [rad/s].

    Mode i obeys η'' + 2ζωη' + ω²η = φᵢᵀ B a, so that its speed has the mean square G / (8ζω), G
    the one-sided density [1/Hz] of the right side (white noise through an oscillator).

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    q : (n_joints,) array [rad]
        Pose, serial joints.
    spectrum : PredictedSpectrum
        Of the accelerations of the controller axes.
    highest_hz : float [Hz]
        Upper end of the excited band.

    Returns
    -------
    (n_joints,) array [rad/s]
        Of the controller axes.
    """
    modes = model.modes(q)
    inside = modes.frequency_hz <= BEYOND_BAND * highest_hz
    shapes, frequency_hz = modes.shapes[:, inside], modes.frequency_hz[inside]
    drive = shapes.T @ model.input_matrix(q) @ np.linalg.inv(model.axes.matrix)
    force = np.sum(drive**2 * spectrum.at(frequency_hz), axis=1)
    square = force / (8.0 * modes.damping_ratio[inside] * 2.0 * np.pi * frequency_hz)
    twist = model.axes.matrix @ _serial_twists(model, shapes)
    return np.asarray(np.sqrt(twist**2 @ square))


def _serial_twists(model: FlexibleJointModel, shapes: Array) -> Array:
    """Return the rows of the drives' twists, zeros for a drive without a spring."""
    names = list(model.dof_names)
    twists = np.zeros((len(model.joint_names), shapes.shape[1]))
    for row, joint in enumerate(model.joint_names):
        if f'{joint}/drive' in names:
            twists[row] = shapes[names.index(f'{joint}/drive')]
    return twists
