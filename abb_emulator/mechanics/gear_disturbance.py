"""Torques in the drives that depend on motor angle and time alone: ripple and tones."""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray

from abb_emulator.mechanics.arm_effect import ArmEffect
from abb_emulator.mechanics.arm_structure import check_place
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


class GearDisturbance:
    """Load on the flexible coordinates.

    The error e(θ) of a gear moves the motor end of its spring and damper: k e + d e'.

    Parameters
    ----------
    effects : sequence of ArmEffect
        Transmission errors and tones; others do nothing.
    model : FlexibleJointModel
        The arm.
    place : (n_dof, n_joints) array
        Load on the flexible coordinates per torque of each drive.

    References
    ----------
    Tuttle and Seering (1996), doi:10.1109/70.499818.
    """

    def __init__(
        self, effects: Sequence[ArmEffect], model: FlexibleJointModel, place: Array
    ) -> None:
        self._place, self._to_axes = place, model.axes.matrix.T
        self._ripples: list[tuple[int, ArmEffect, float, float]] = []
        self._tones: list[tuple[int, ArmEffect]] = []
        for effect in effects:
            if effect.type not in ('transmission_error', 'tonal_disturbance'):
                continue
            check_place(effect, model.joint_names)
            axis = model.joint_names.index(effect.place)
            if effect.type == 'tonal_disturbance':
                self._tones.append((axis, effect))
            else:
                spring = model.spec.joints[axis].drive.spring
                self._ripples.append((axis, effect, spring.stiffness, spring.damping))

    @property
    def active(self) -> bool:
        """There is any."""
        return bool(self._ripples or self._tones)

    def load(self, q: Array, qd: Array, time_s: Array) -> Array:
        """Return the load over some samples, (n_samples, n_dof).

        Parameters
        ----------
        q, qd : (n_samples, n_joints) array [rad], [rad/s]
            Serial motor-side motion.
        time_s : (n_samples,) array [s]
            Since the arm was switched on.
        """
        torque = np.zeros((len(q), self._place.shape[1]))
        angle, speed = q @ self._to_axes, qd @ self._to_axes
        for axis, effect, stiffness, damping in self._ripples:
            a, b, order = (effect.number(name) for name in ('sine', 'cosine', 'order'))
            sine, cosine = np.sin(order * angle[:, axis]), np.cos(order * angle[:, axis])
            slope = order * (a * cosine - b * sine) * speed[:, axis]
            torque[:, axis] += stiffness * (a * sine + b * cosine) + damping * slope
        for axis, effect in self._tones:
            turn = 2.0 * math.pi * effect.number('frequency') * time_s + effect.number('phase')
            torque[:, axis] += effect.number('torque') * np.cos(turn)
        return np.asarray(torque @ self._place.T)
