"""How the readings change with the arm, to first order, for many changes at once."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex, hann
from model_gap.cell import CellModel, joint_spring
from model_gap.fit.thresholds import FIT
from model_gap.predict import ArmChange, forces, parts, Predictor, stacked, static_twist

Complex64 = NDArray[np.complex64]


class ArmDerivative:
    """First-order change of the readings when the arm changes, by the direct method."""

    def __init__(self, cell: CellModel, predictor: Predictor) -> None:
        self.predictor = predictor
        self.solved = predictor.solved(cell)
        self.base = [system.arm for system in self.solved.systems]
        systems, local = self.solved.systems, predictor.local_torques
        self.following = local.following(cell, self.solved.torques, systems)
        self.at_rest = self._twists_at_rest(cell)
        sag = max(np.abs(arm.rest).max(initial=0.0) for arm in self.base)
        self.hangs_far = sag > FIT.little_sag
        self.motions = [
            parts(
                stacked(
                    state.omega,
                    state.deflection,
                    state.acceleration,
                    state.shift,
                    (state.end_shift, state.end_speed),
                )
            )
            for state in self.solved.states
        ]
        # Records of one pose that last as long share theirs.
        shared: dict[tuple[int, bytes], Complex64] = {}
        keys = [
            (group, state.omega.tobytes())
            for state, group in zip(self.solved.states, predictor.groups, strict=True)
        ]
        for key, state in zip(keys, self.solved.states, strict=True):
            if key not in shared:
                transfer = systems[key[0]].transfer(state.omega)
                shared[key] = np.ascontiguousarray(transfer.transpose(2, 0, 1))
        self.transfers = [shared[key] for key in keys]

    def changes(
        self, cells: Sequence[CellModel], step: float, springs_only: bool = False
    ) -> list[list[Complex]]:
        """Return the change of the readings per prior standard deviation, per cell and record.

        Parameters
        ----------
        cells : sequence of CellModel
            Not far away; at least one.
        step : float
            How far, in prior standard deviations.
        springs_only : bool
            Mass and inputs are those of the base, the same change at all poses; not of an arm
            that hangs far in its springs, and elsewhere in others.
        """
        springs_only = springs_only and not self.hangs_far
        changes = [self._arm_changes(cell, 1 if springs_only else None) for cell in cells]
        twists = [self._twists_at_rest(cell) for cell in cells]
        found: list[list[Complex]] = [[] for _ in cells]
        for number, group in enumerate(self.predictor.groups):
            arms = [change[0 if springs_only else group] for change in changes]
            force = forces(self.motions[number], arms)
            for place, torque in enumerate(self.following[number]):
                joint = torque.law.joint
                stiffness = [joint_spring(cell.spec, joint).stiffness for cell in cells]
                # Of two poses that count as one each record has its own twist: only what changes.
                at_rest = self.at_rest[group][place]
                heavier = [twist[group][place] - at_rest for twist in twists]
                for column, push in enumerate(torque.pushes(arms, stiffness, heavier)):
                    force[:, :, column] += push.T
            changed = np.matmul(self.transfers[number], force / np.float32(step))
            readings = hann(changed.transpose(2, 1, 0).reshape(*changed.shape[:0:-1], -1, 3))
            for own, reading in zip(found, readings.astype(complex), strict=True):
                own.append(reading)
        if self.hangs_far:
            for cell, own in zip(cells, found, strict=True):
                self._add_turned(cell, step, own)
        return found

    def _arm_changes(self, moved: CellModel, most: int | None) -> list[ArmChange]:
        arms = self.predictor.arms(moved.spec, most)
        return [ArmChange.between(one, two) for one, two in zip(self.base, arms, strict=False)]

    def _add_turned(self, moved: CellModel, step: float, changes: list[Complex]) -> None:
        """Add what sensors see otherwise because the arm hangs otherwise."""
        turned = self.predictor.sensors_moved(moved, self.solved.systems)
        readings = self.predictor.posed.readings(turned, self.solved.states)
        for change, new, old in zip(changes, readings, self.solved.readings, strict=True):
            change += (new - old) / step

    def _twists_at_rest(self, moved: CellModel) -> list[list[float]]:
        """Return the twists under gravity in a changed arm, per pose and torque."""
        if not any(self.following):
            return [[] for _ in self.predictor.poses]
        model = self.predictor.arm(moved.spec)
        vectors = [torque.stepped.path.vector for torque in self.following[0]]
        return [
            [static_twist(model, vector, pose) for vector in vectors]
            for pose in self.predictor.poses
        ]
