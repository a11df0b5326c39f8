"""Nonlinear torques in the joints, stepped in time for all records of a predictor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from model_gap.campaign import Complex, hann, RecordSpectra
from model_gap.cell import CellModel, JointForce, PoseSystem
from model_gap.laws import Follow
from model_gap.predict.joint_path import joint_path, JointPath
from model_gap.predict.step_torque import step_torque
from model_gap.predict.torque_following import TorqueFollowing
from model_gap.predict.torque_spectra import (
    force_spectra,
    SteppedTorque,
    sum_of_forces,
    whole_force,
)
from structural_model import FlexibleJointModel

# By joint, record and the twist it sees.
Paths = dict[tuple[str, int, Follow], JointPath]


@dataclass(frozen=True)
class Torques:
    """What the torques of one cell do.

    Parameters
    ----------
    forces : list of (n_dof, 3 n_bins) complex array
        On the deflections, per record; empty where a cell has no torques.
    errors : dict of (str, int) to (n_bins,) complex array
        By joint and record: a sample of the error of torques that see a measured twist.
    stepped : list of list of SteppedTorque
        Per record and torque.
    """

    forces: list[Complex] = field(default_factory=list)
    errors: dict[tuple[str, int], Complex] = field(default_factory=dict)
    stepped: list[list[SteppedTorque]] = field(default_factory=list)


@dataclass(frozen=True)
class LocalTorques:
    """Steps torques along the motion of records.

    Parameters
    ----------
    records : sequence of RecordSpectra
        The records.
    groups : tuple of int
        Which pose each has.
    steps_per_s : float [Hz]
        Fewer than usual are for numbers that are still far off.
    paths : callable
        Gives where the paths of a cell are collected.
    screening : bool
        Laws are screened, not fitted: what they say of the measured twist is nearly linear.
    """

    records: Sequence[RecordSpectra]
    groups: tuple[int, ...]
    steps_per_s: float
    paths: Callable[[CellModel], Paths] = field(repr=False)
    screening: bool = False

    def followed(self, force: JointForce) -> Follow:
        """Return which twist a torque sees."""
        return force.law.sees_screened if self.screening else force.law.sees

    def is_predicted(self, force: JointForce) -> bool:
        """Return whether a torque is on the predicted twist.

        What a small change of the arm makes of it is stepped again: no constant gain stands for
        that.
        """
        return self.followed(force) is Follow.PREDICTED

    def of(
        self, cells: Sequence[CellModel], model: FlexibleJointModel, systems: Sequence[PoseSystem]
    ) -> list[Torques]:
        """Return the torques of several cells with one arm and one motion."""
        paths = self.paths(cells[0])
        found = []
        for cell in cells:
            torques = Torques()
            for index, (item, group) in enumerate(zip(self.records, self.groups, strict=True)):
                system = systems[group]
                stepped = []
                for force in cell.forces:
                    key = (force.joint, index, self.followed(force))
                    if key not in paths:
                        paths[key] = self._path(force, cell, model, item, system)
                    path = paths[key]
                    torque = step_torque(path, force)
                    push = whole_force(torque, path, item, system)
                    stepped.append(SteppedTorque(path, torque, push))
                    if path.noisy is not None:
                        noisy = step_torque(path.with_noise(), force)
                        place = force_spectra(noisy - torque, path, item)
                        error = path.vector @ place / (path.vector @ path.vector)
                        torques.errors[force.joint, index] = hann(error.reshape(-1, 3))
                torques.stepped.append(stepped)
                if stepped:
                    torques.forces.append(sum_of_forces(stepped))
            found.append(torques)
        return found

    def following(
        self, cell: CellModel, torques: Torques, systems: Sequence[PoseSystem]
    ) -> list[list[TorqueFollowing]]:
        """Return what follows slight changes of the arm: springs' torques, per record."""
        return [
            [
                TorqueFollowing(one, force, item, systems[group], cell, self.is_predicted(force))
                for force, one in zip(cell.forces, stepped, strict=True)
                if force.law.of_spring or self.is_predicted(force)
            ]
            for item, group, stepped in zip(
                self.records, self.groups, torques.stepped, strict=True
            )
        ]

    def _path(
        self,
        force: JointForce,
        cell: CellModel,
        model: FlexibleJointModel,
        item: RecordSpectra,
        system: PoseSystem,
    ) -> JointPath:
        follow = self.followed(force)
        return joint_path(model, force.joint, item, system, cell, self.steps_per_s, follow)
