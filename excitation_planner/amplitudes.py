"""How strongly each axis shakes: as much as it may, but for what would drown a direction.

Large axes turn the whole arm and small ones a tool: at equal accelerations the torques that the
first exert on the structure leave those of the others unseen (link inertias of 400 and 2 kg m²),
so that the torque projection matrix has, but for noise, rank 2.  The strong axes give way, step by
step, each time the one that costs the modes least information for what the weakest direction
gains.
"""

import numpy as np
from numpy.typing import NDArray

from excitation_planner.forecast import direction_ratio, joint_axes, structure_torque
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Amplitudes are whole numbers of these: finer ones would tell numerical libraries apart.
STEP_DB = 1.0
MOST_DB = 50.0
# What one mode loses by a step: no axis is lowered just because no mode needs it.
ONE_MODE = STEP_DB * np.log(10.0) / 10.0
# Above what a plan needs: the pose changes along its path; strengths of few pulses scatter.
ROOM, ROOM_OF_PULSES = 1.15, 1.8


def informative_amplitudes(
    model: FlexibleJointModel,
    q: Array,
    moving: NDArray[np.bool_],
    highest_hz: float,
    room: float = ROOM,
) -> Array:
    """Return the relative amplitude of every axis, largest 1, (n_joints,).

    The information on mode i grows with its force density F_i = Σ (φᵢᵀB)² a², so its loss is
    measured as Σ ln F_i over the modes; the gain is that of the smallest over the largest
    singular value of D(τ).  Where no amplitudes give every direction its part all stay 1: the
    axes do not span space, and the plan says so.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    q : (n_joints,) array [rad]
        Pose, serial joints.
    moving : (n_joints,) array of bool
        Controller axes that may move.
    highest_hz : float [Hz]
        Modes above do not count.
    room : float
        By how much the weakest direction shall exceed what a plan needs.
    """
    axes, inertia, drive = (
        joint_axes(model, q),
        model.link_inertia(q),
        _drive(model, q, highest_hz),
    )
    lowered_db = np.zeros(len(q))

    def amplitude(lowered: Array) -> Array:
        return np.asarray(moving * 10.0 ** (-lowered / 20.0))

    while np.max(lowered_db) < MOST_DB:
        now = amplitude(lowered_db)
        ratio = direction_ratio(axes, structure_torque(inertia, now))
        if ratio.smallest >= room * ratio.needed:
            return now
        best, best_value = -1, 0.0
        for axis in np.flatnonzero(moving):
            less = amplitude(lowered_db + STEP_DB * (np.arange(len(q)) == axis))
            gain = direction_ratio(axes, structure_torque(inertia, less)).balance - ratio.balance
            lost = _information(drive, now) - _information(drive, less)
            value = gain / (lost + ONE_MODE)
            if gain > 1e-9 and value > best_value:
                best, best_value = int(axis), value
        if best < 0:
            break
        lowered_db[best] += STEP_DB
    return moving.astype(float)


def _drive(model: FlexibleJointModel, q: Array, highest_hz: float) -> Array:
    """Return the squared modal force per acceleration of each axis, (n_modes, n_joints)."""
    modes = model.modes(q)
    shapes = modes.shapes[:, modes.frequency_hz <= highest_hz]
    force = shapes.T @ model.input_matrix(q) @ np.linalg.inv(model.axes.matrix)
    return np.asarray(force**2)


def _information(drive: Array, amplitude: Array) -> float:
    return float(np.sum(np.log(drive @ amplitude**2 + 1e-300)))
