"""How a torque in a joint follows a slightly changed arm: stepped again along its twist."""

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from model_gap.joint_path import JointPath, on_steps
from model_gap.pose_system import PoseArm, PoseSystem
from model_gap.setup import JointForce, Setup
from model_gap.spectra import RecordSpectra
from model_gap.step_torque import step_torque
from model_gap.torque_spectra import long_spectrum, whole_force

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class ArmChange:
    """From one arm to another at a pose.

    Parameters
    ----------
    M, C, K : (n, n) array
        Change of mass, damping and stiffness.
    inertia_input, shift_input : (n, n_joints) array
        Of the inputs.
    """

    M: Array
    C: Array
    K: Array
    inertia_input: Array
    shift_input: Array

    @classmethod
    def between(cls, one: PoseArm, other: PoseArm) -> 'ArmChange':
        """Return the change from one arm to another."""
        return cls(
            other.M - one.M,
            other.C - one.C,
            other.K - one.K,
            other.inertia_input - one.inertia_input,
            other.shift_input - one.shift_input,
        )

    def force(
        self, omega: Array, deflection: Complex, acceleration: Complex, shift: Complex
    ) -> Complex:
        """Return the force on the old arm that is the change to first order, (n, n_omega)."""
        force = np.zeros_like(deflection)
        for matrix, motion in (
            (self.M, omega**2 * deflection),
            (-self.C, 1j * omega * deflection),
            (-self.K, deflection),
            (self.inertia_input, acceleration),
            (self.shift_input, shift),
        ):
            rows = np.flatnonzero(matrix.any(axis=1))
            if rows.size:
                force[rows] += matrix[rows] @ motion
        return force


@dataclass(frozen=True)
class TorqueFollowing:
    """One torque in one record, ready to be stepped along slightly changed twists.

    Parameters
    ----------
    path, torque : JointPath, (n_steps,) array [N m]
        Of the arm as it is.
    law : JointForce
        The torque.
    item : RecordSpectra
        The record.
    system : PoseSystem
        The arm at its pose.
    setup : Setup
        Gives the steps before the motors.
    bends : bool
        Whether it is stepped again; else it stays but for its own spring and load.
    """

    path: JointPath
    torque: Array
    law: JointForce
    item: RecordSpectra
    system: PoseSystem
    setup: Setup
    bends: bool

    def push(self, change: ArmChange, stiffness: float, static_twist: float) -> Complex:
        """Return the change of the force on the deflections, (n_dof, 3 n_bins).

        Parameters
        ----------
        change : ArmChange
            Of the arm.
        stiffness, static_twist : float
            Of the joint in the changed arm.
        """
        if not self.law.law.of_spring:
            return np.zeros((len(self.path.vector), self.item.omega.size), dtype=complex)
        if not self.bends:
            stronger = stiffness / self.path.stiffness - 1.0
            heavier = static_twist - self.path.static_twist
            return stronger * self._force + heavier * self._per_load
        path = dataclasses.replace(self.path, stiffness=stiffness, static_twist=static_twist)
        omega, deflection, acceleration, shift, row = self._long
        force = change.force(omega, deflection, acceleration, shift)
        rows = np.flatnonzero(force.any(axis=1))
        twist = np.einsum('nf,nf->f', row[rows], force[rows])
        steps = len(path.twist)
        path = dataclasses.replace(
            path,
            twist=path.twist + on_steps(twist, self.item, steps),
            rate=path.rate + on_steps(1j * omega * twist, self.item, steps),
        )
        return self._force_of(step_torque(path, self.law) - self.torque)

    @cached_property
    def _force(self) -> Complex:
        return self._force_of(self.torque)

    @cached_property
    def _per_load(self) -> Complex:
        """Change of the force per change of the twist at rest."""
        step = 1e-3 * max(abs(self.path.static_twist), 1e-6)
        path = dataclasses.replace(self.path, static_twist=self.path.static_twist + step)
        return self._force_of((step_torque(path, self.law) - self.torque) / step)

    def _force_of(self, torque: Array) -> Complex:
        return whole_force(torque, self.path, self.item, self.system)

    @cached_property
    def _long(self) -> tuple[Array, Complex, Complex, Complex, Complex]:
        """The long motion: frequencies, deflection, motors, and twist per force."""
        system, vector = self.system, self.path.vector
        omega, *motion = self.item.long_motion
        acceleration, shift = self.setup.driven(omega, *motion)
        force = system.force(acceleration, shift)
        force = force - vector[:, None] * long_spectrum(self.torque, self.item)
        row = system.twist_per_force(omega, vector)
        return omega, system.deflection(omega, force), acceleration, shift, row
