"""How a torque in a joint follows a slightly changed arm: stepped again along its twist."""

from collections.abc import Sequence
import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import RecordSpectra
from model_gap.cell import CellModel, JointForce, PoseSystem
from model_gap.predict.arm_change import ArmChange, Complex64, forces, parts, Reals, stacked
from model_gap.predict.joint_path import JointPath, with_rate
from model_gap.predict.step_torque import step_torque
from model_gap.predict.torque_spectra import long_spectrum, SteppedTorque, whole_force

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


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

    def pushes(
        self, changes: Sequence[ArmChange], stiffness: Sequence[float], heavier: Sequence[float]
    ) -> list[Complex]:
        """Return the change of the force on the deflections, (n_dof, 3 n_bins) per change.

        Parameters
        ----------
        changes : sequence of ArmChange
            Of the arm.
        stiffness : sequence of float
            Of the joint in each changed arm.
        heavier : sequence of float
            By how much gravity twists the joint farther there.
        """
        present = self.stepped.path
        loads = zip(stiffness, heavier, strict=True)
        if not self.predicted:
            own = present.stiffness
            return [
                (k / own - 1.0) * self.stepped.force + load * self._per_load for k, load in loads
            ]
        motion, row = self._long
        turns = np.matmul(row[:, None], forces(motion, changes))[:, 0].T
        paths = (
            dataclasses.replace(
                present,
                stiffness=k,
                static_twist=present.static_twist + load,
                twist=present.twist + twist,
                rate=present.rate + rate,
            )
            for (k, load), twist, rate in zip(
                loads, *with_rate(turns, self.item, present.steps_per_s), strict=True
            )
        )
        return [self._change(path) for path in paths]

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
    def _long(self) -> tuple[Reals, Complex64]:
        """``parts`` of the long motion, and twist per force, (n, n_dof)."""
        system, vector = self.system, self.stepped.path.vector
        omega, *recorded = self.item.long_motion
        inputs = self.cell.driven(omega, *recorded)
        force = system.force(*inputs)
        force = force - vector[:, None] * long_spectrum(self.stepped.torque, self.item)
        motion = stacked(omega, system.deflection(omega, force), *inputs)
        row = system.twist_per_force(omega, vector).astype(np.complex64)
        return parts(motion), np.ascontiguousarray(row.T)
