"""The whole nonlinear arm at one instant: forces on its springs, motion of its bodies.

One run of the recursive Newton-Euler algorithm over the expanded arm, rigid and flexible motion
together, gives both: nothing is linearised.

References
----------
Luh, Walker and Paul (1980), doi:10.1115/1.3149599.
"""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
N_MOTION = 12


class WholeArm:
    """Recursion with work space of its own.

    Parameters
    ----------
    model : FlexibleJointModel
        The arm.
    joints : sequence of int
        Bodies of the expanded arm whose motion is asked for.
    """

    def __init__(self, model: FlexibleJointModel, joints: Sequence[int]) -> None:
        assembly, damping = model.assembly, model.spec.damping
        self._assembly, self._data = assembly, assembly.model.createData()
        self._n_dof, self._count = model.n_dof, len(assembly.flexible)
        dampers = assembly.damping + damping.stiffness_proportional_s * assembly.stiffness
        self._springs = np.hstack([assembly.stiffness, dampers])
        self._mass_damping = damping.mass_proportional_1_s
        self._compensators = []
        for item in model.spec.compensators:
            name = f'{item.joint}/drive'
            if name in model.dof_names:
                place = int(assembly.drives[model.joint_names.index(item.joint)])
                row = model.dof_names.index(name)
                neutral = model.dynamics.neutral(item)
                self._compensators.append((row, place, item.strength_nm, neutral))
        # These arrays are windows into pinocchio's memory: what the last run left there.
        self._windows = [
            window
            for joint in joints
            for window in (self._data.v[joint].vector, self._data.a_gf[joint].vector)
        ]
        self.n_motion = N_MOTION * len(joints)

    def motor_side(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return the motion of the motor side in the coordinates of the expanded arm.

        Parameters
        ----------
        q, qd, qdd : (n_samples, n_joints) array [rad], [rad/s], [rad/s²]
            Serial joint motion.

        Returns
        -------
        (n_samples, 3, nv) array
        """
        full = np.zeros((len(q), 3, self._assembly.model.nv))
        for row, part in enumerate((q, qd, qdd)):
            full[:, row, self._assembly.drives] = part
        return full

    def unbalanced(self, motor: Array, state: Array, rise: Array) -> Array:
        """Return the force on x that a supposed x'' leaves over, (n_dof,).

        Parameters
        ----------
        motor : (3, nv) array
            One row of ``motor_side``; the flexible motion is added to it.
        state : (2 n_dof,) array
            x and x'.
        rise : (n_dof,) array
            x''.
        """
        n_dof, count, flexible = self._n_dof, self._count, self._assembly.flexible
        # Damping in proportion to mass goes with the acceleration.
        heavy = rise + self._mass_damping * state[n_dof:]
        position, rate, rising = motor
        position[flexible] += state[:count]
        rate[flexible] += state[n_dof : n_dof + count]
        rising[flexible] += heavy[:count]
        force = -self._springs @ state
        force[:count] -= pin.rnea(self._assembly.model, self._data, *motor)[flexible]
        # Motors behind soft servos are no part of the recursion; their inertia is constant.
        force[count:] -= self._assembly.motor_inertia * heavy[count:]
        for row, place, strength, phase in self._compensators:
            force[row] -= strength * math.sin(position[place] - phase)
        return np.asarray(force)

    def motion(self, into: Array) -> None:
        """Write the motion of the bodies asked for: v, ω, a - g, ω' of each, in its own axes.

        The accelerations have the damping in proportion to mass in them.

        Parameters
        ----------
        into : (n_motion,) array
            Linear parts are spatial ones at the body's origin.
        """
        if self._windows:
            np.concatenate(self._windows, out=into)
