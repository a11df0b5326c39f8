"""How a torque in a joint follows a slightly changed arm: stepped again along its twist."""

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import RecordSpectra
from model_gap.cell import CellModel, JointForce, PoseArm, PoseSystem
from model_gap.predict.joint_path import JointPath, with_rate
from model_gap.predict.step_torque import step_torque
from model_gap.predict.torque_spectra import long_spectrum, SteppedTorque, whole_force

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Complex64 = NDArray[np.complex64]


@dataclass(frozen=True)
class ArmChange:
    """From one arm to another at a pose.

    Parameters
    ----------
    matrix : (n_dof, 3 n_dof + 2 n_joints) array
        Force on the old arm per ``stacked`` motion.
    """

    matrix: Array

    @classmethod
    def between(cls, one: PoseArm, other: PoseArm) -> 'ArmChange':
        """Return the change from one arm to another."""
        parts = (
            one.M - other.M,
            one.C - other.C,
            one.K - other.K,
            other.inertia_input - one.inertia_input,
            other.shift_input - one.shift_input,
        )
        return cls(np.hstack(parts))

    def force(self, motion: Complex64) -> Complex64:
        """Return the force on the old arm that is the change to first order, (n_dof, n_omega)."""
        rows = np.flatnonzero(self.matrix.any(axis=1))
        columns = np.flatnonzero(self.matrix.any(axis=0))
        force = np.zeros((len(self.matrix), motion.shape[1]), dtype=np.complex64)
        force[rows] = self.matrix[np.ix_(rows, columns)].astype(np.complex64) @ motion[columns]
        return force


def stacked(
    omega: Array,
    deflection: Complex,
    acceleration: Complex,
    shift: Complex,
    end: tuple[Array, Array] | None = None,
) -> Complex64:
    """Return x'', x', x of the deflections and both inputs, one below the other.

    In single precision: differences lose nothing by it.  ``end`` is x and x' when the record ends,
    (n_dof,) each, by parts beside the spectra of x' and x''.  Without it masses, springs and
    dampers that all grow alike would seem to change the motion, by a percent of what each does:
    fits hardly moved along that line, and σ across it was too small.
    """
    end_shift, end_speed = (0.0, 0.0) if end is None else (part[:, None] for part in end)
    velocity = 1j * omega * deflection + end_shift
    motion = [1j * omega * velocity + end_speed, velocity, deflection, acceleration, shift]
    return np.concatenate(motion).astype(np.complex64)


@dataclass(frozen=True)
class TorqueFollowing:
    """A torque in one record, ready to be stepped along slightly changed twists.

    Parameters
    ----------
    stepped : SteppedTorque
        Of the arm as it is.
    law : JointForce
        The torque.
    item : RecordSpectra
        The record.
    system : PoseSystem
        The arm at its pose.
    cell : CellModel
        Gives the steps before the motors.
    predicted : bool
        Whether it is stepped again; else it stays but for its own spring and load.
    """

    stepped: SteppedTorque
    law: JointForce
    item: RecordSpectra
    system: PoseSystem
    cell: CellModel
    predicted: bool

    def push(self, change: ArmChange, stiffness: float, heavier: float) -> Complex:
        """Return the change of the force on the deflections, (n_dof, 3 n_bins).

        Parameters
        ----------
        change : ArmChange
            Of the arm.
        stiffness : float
            Of the joint in the changed arm.
        heavier : float
            By how much gravity twists the joint farther there.
        """
        present = self.stepped.path
        if not self.predicted:
            stronger = stiffness / present.stiffness - 1.0
            return stronger * self.stepped.force + heavier * self._per_load
        motion, row = self._long
        change_of_twist = np.einsum('nf,nf->f', row, change.force(motion))
        twist, rate = with_rate(change_of_twist, self.item, present.steps_per_s)
        path = dataclasses.replace(
            present,
            stiffness=stiffness,
            static_twist=present.static_twist + heavier,
            twist=present.twist + twist,
            rate=present.rate + rate,
        )
        return self._change(path)

    @cached_property
    def _per_load(self) -> Complex:
        """Change of the force per change of the twist at rest."""
        present = self.stepped.path
        step = 1e-3 * max(abs(present.static_twist), 1e-6)
        path = dataclasses.replace(present, static_twist=present.static_twist + step)
        return self._change(path, step)

    def _change(self, path: JointPath, step: float = 1.0) -> Complex:
        """Return how the force changes from the present path to another, per step."""
        torque = (step_torque(path, self.law) - self.stepped.torque) / step
        return whole_force(torque, path, self.item, self.system)

    @cached_property
    def _long(self) -> tuple[Complex64, Complex64]:
        """The long motion, and twist per force."""
        system, vector = self.system, self.stepped.path.vector
        omega, *recorded = self.item.long_motion
        inputs = self.cell.driven(omega, *recorded)
        force = system.force(*inputs)
        force = force - vector[:, None] * long_spectrum(self.stepped.torque, self.item)
        motion = stacked(omega, system.deflection(omega, force), *inputs)
        return motion, system.twist_per_force(omega, vector).astype(np.complex64)
