"""The arm about one pose: exact steps of its linear part."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from modal_core.channel import Channel
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LinearStep:
    """Steps of x'' = -M⁻¹ (C x' + K x) + u, u straight lines from sample to sample.

    Parameters
    ----------
    pose : (n_joints,) array [rad]
        Serial joints.
    advance : (2 n_dof, 4 n_dof) array
        State after a sample, over the state before it and u at both its ends.
    rise : (n_dof, 2 n_dof) array
        -M⁻¹ [K C].
    inverse_mass : (n_dof, n_dof) array
        M⁻¹.
    held, rising : (2 n_dof, n_joints) array
        State over drive torques held over a sample, and over those that rise from 0 within it.
    gear_rise : (n_dof, n_joints) array
        x'' over drive torques; all three are taken off.
    jacobian : (n_channels, n_dof) array
        Of accelerometers on x'', of gyroscopes on x'.
    """

    pose: Array
    advance: Array
    rise: Array
    inverse_mass: Array
    held: Array
    rising: Array
    gear_rise: Array
    jacobian: Array

    @classmethod
    def at(
        cls,
        model: FlexibleJointModel,
        pose: Array,
        channels: Sequence[Channel],
        step_s: float,
        gear_place: Array,
    ) -> 'LinearStep':
        """Linearise about a pose.

        Parameters
        ----------
        model : FlexibleJointModel
            The arm.
        pose : (n_joints,) array [rad]
            Serial joints.
        channels : sequence of Channel
            Sensors.
        step_s : float [s]
            Time between samples.
        gear_place : (n_dof, n_joints) array
            Load on x per torque of each drive, taken off.
        """
        matrices, n_dof = model.matrices(pose), model.n_dof
        inverse = np.asarray(np.linalg.inv(matrices.M), float)
        rise = -inverse @ np.hstack([matrices.K, matrices.C])
        # States x, x' and u with its slope: one exponential gives the exact step.
        eye = np.eye(n_dof)
        rate = np.zeros((4 * n_dof, 4 * n_dof))
        rate[:n_dof, n_dof : 2 * n_dof] = eye
        rate[n_dof : 2 * n_dof, : 2 * n_dof] = rise
        rate[n_dof : 2 * n_dof, 2 * n_dof : 3 * n_dof] = eye
        rate[2 * n_dof : 3 * n_dof, 3 * n_dof :] = eye
        full = expm(rate * step_s)[: 2 * n_dof]
        held = full[:, 2 * n_dof : 3 * n_dof]
        sloped = full[:, 3 * n_dof :] / step_s
        gear_rise = inverse @ gear_place
        return cls(
            pose=pose.copy(),
            advance=np.hstack([full[:, : 2 * n_dof], held - sloped, sloped]),
            rise=rise,
            inverse_mass=inverse,
            held=held @ gear_rise,
            rising=sloped @ gear_rise,
            gear_rise=gear_rise,
            jacobian=model.sensor_jacobian(pose, channels),
        )
