"""The dynamic sensitivity coefficient: how much a natural frequency changes with the pose.

Jiao et al. (2025), doi:10.1038/s41598-025-95339-6: the definition, Eq. (1), needs the modes at
both poses; the prediction, Eqs. (5)-(11), needs the mode shape of one pose only.  In joint
coordinates a change of pose changes the mass matrix by ΔM, and Eq. (9) with this ΔM in place of a
mass added to one degree of freedom reads ω'²(1 + φᵀΔMφ) = ω²(1 + φᵀΔKφ/ω²), ΔK being gravity's.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from excitation_planner.pose_range.mode_following import (
    BEYOND_BAND,
    follow,
    FollowedModes,
    modes_at,
)
from modal_core.channel import Channel
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Beyond this the sensors do not tell the model's modes apart.
LARGEST_CONDITION = 1e3
# From a pose to (n_modes,) signed relative changes of frequency against the centre pose.
FrequencyChange = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class SensitivityTable:
    """Sensitivity of every mode to every joint at one pose.

    Parameters
    ----------
    frequency_hz : (n_modes,) array [Hz]
        At the pose.
    joint_names : tuple of str
        Columns.
    step_rad : float [rad]
        By which each joint is turned.
    actual : (n_modes, n_joints) array
        Eq. (1), from the modes at both poses.
    predicted : (n_modes, n_joints) array
        Magnitude of Eq. (11) in the form above, from the shapes at the pose alone.
    """

    frequency_hz: Array
    joint_names: tuple[str, ...]
    step_rad: float
    actual: Array
    predicted: Array


def added_mass_change(
    shape_component: ArrayLike, added_mass_kg: float, modal_scale: float = 1.0
) -> Array:
    """Return Eq. (11): relative change of frequency when a mass is added at one point.

    Parameters
    ----------
    shape_component : array
        φᵢᵣ, normalised component of each mode at the point.
    added_mass_kg : float [kg]
        m_r.
    modal_scale : float
        αᵢ, from the normalised to the mass-normalised shape; 1 when it is mass-normalised.
    """
    squared = np.abs(np.asarray(shape_component)) ** 2
    return np.asarray(1.0 / np.sqrt(1.0 + modal_scale**2 * added_mass_kg * squared) - 1.0)


def actual_change(model: FlexibleJointModel, q: Array, highest_hz: float) -> FrequencyChange:
    """Return the signed Eq. (1) as a function of the other pose, modes followed by shape."""
    start = modes_at(model, q, highest_hz)
    n_modes = _n_inside(start, highest_hz)

    def change(other: Array) -> Array:
        reached = follow(model, start, q, other)
        return np.asarray((reached.frequency_hz / start.frequency_hz - 1.0)[:n_modes])

    return change


def predicted_change(model: FlexibleJointModel, q: Array, highest_hz: float) -> FrequencyChange:
    """Return the shape-based prediction from the model's own shapes at ``q``."""
    start = modes_at(model, q, highest_hz)
    n_modes = _n_inside(start, highest_hz)
    return shape_change(model, q, start.frequency_hz[:n_modes], start.shapes[:, :n_modes])


def shape_change(
    model: FlexibleJointModel, q: Array, frequency_hz: Array, shapes: Array
) -> FrequencyChange:
    """Return the shape-based prediction from any shapes, for example identified ones.

    Parameters
    ----------
    model : FlexibleJointModel
        Gives ΔM and ΔK.
    q : (n_joints,) array [rad]
        Pose of the shapes.
    frequency_hz : (n_modes,) array [Hz]
        Natural frequencies.
    shapes : (n_dof, n_modes) real array
        Any scale; see :func:`expanded_shapes`.
    """
    here = model.matrices(q)
    modal_mass = np.einsum('im,ij,jm->m', shapes, here.M, shapes)
    scaled = shapes / np.sqrt(modal_mass)
    squared = (2.0 * np.pi * frequency_hz) ** 2

    def change(other: Array) -> Array:
        there = model.matrices(other)
        mass = np.einsum('im,ij,jm->m', scaled, there.M - here.M, scaled)
        stiffness = np.einsum('im,ij,jm->m', scaled, there.K - here.K, scaled) / squared
        ratio = np.maximum(1.0 + stiffness, 0.0) / np.maximum(1.0 + mass, 1e-9)
        return np.asarray(np.sqrt(ratio) - 1.0)

    return change


def expanded_shapes(
    model: FlexibleJointModel,
    q: Array,
    channels: tuple[Channel, ...],
    shapes: NDArray[np.complex128],
    highest_hz: float,
) -> Array:
    """Expand identified shapes from sensor channels to the model's degrees of freedom.

    Fitted by the model's own modes in and somewhat above the band (SEREP), fewer when the
    channels cannot tell so many apart.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    q : (n_joints,) array [rad]
        Pose the shapes were identified in.
    channels : tuple of Channel
        Rows of ``shapes``.
    shapes : (n_channels, n_modes) complex array
        As identified; their real part is used.
    highest_hz : float [Hz]
        Upper end of the band.

    Returns
    -------
    (n_dof, n_modes) array

    References
    ----------
    O'Callahan, Avitabile and Riemer (1989), System equivalent reduction expansion process.
    """
    modes = model.modes(q, channels)
    n_used = int(np.sum(modes.frequency_hz <= BEYOND_BAND * highest_hz))
    n_used = max(1, min(n_used, 2 * len(channels) // 3))
    while n_used > 1 and np.linalg.cond(modes.channel_shapes[:, :n_used]) > LARGEST_CONDITION:
        n_used -= 1
    weight = np.linalg.lstsq(modes.channel_shapes[:, :n_used], shapes.real, rcond=None)[0]
    return np.asarray(modes.shapes[:, :n_used] @ weight)


def sensitivity_table(
    model: FlexibleJointModel, q: Array, step_rad: float, highest_hz: float
) -> SensitivityTable:
    """Turn each joint by a step and compare definition and prediction."""
    actual = actual_change(model, q, highest_hz)
    predicted = predicted_change(model, q, highest_hz)
    poses = q + step_rad * np.eye(len(q))
    return SensitivityTable(
        frequency_hz=_inside(modes_at(model, q, highest_hz), highest_hz),
        joint_names=model.joint_names,
        step_rad=step_rad,
        actual=np.abs(np.column_stack([actual(pose) for pose in poses])),
        predicted=np.abs(np.column_stack([predicted(pose) for pose in poses])),
    )


def _n_inside(modes: FollowedModes, highest_hz: float) -> int:
    return int(np.sum(modes.frequency_hz <= highest_hz))


def _inside(modes: FollowedModes, highest_hz: float) -> Array:
    return modes.frequency_hz[: _n_inside(modes, highest_hz)]
