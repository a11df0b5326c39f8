"""Records by pose, and what sensors read in them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex, hann, RecordSpectra
from model_gap.cell import CellModel, PoseSystem
from model_gap.predict.solved import RecordState
from model_gap.predict.thresholds import PREDICTION
from structural_model import FlexibleJointModel


@dataclass(frozen=True, eq=False)
class PosedRecords:
    """Records of one robot; those of one pose share one linear system.

    Parameters
    ----------
    model : FlexibleJointModel
        Gives kinematics.
    records : sequence of RecordSpectra
        What was measured.
    """

    model: FlexibleJointModel
    records: Sequence[RecordSpectra]

    @cached_property
    def poses(self) -> list[NDArray[np.float64]]:
        """Different poses of the records [rad]."""
        poses: list[NDArray[np.float64]] = []
        for item in self.records:
            if _pose_number(item.record.pose, poses) is None:
                poses.append(item.record.pose)
        return poses

    @cached_property
    def groups(self) -> tuple[int, ...]:
        """Number of the pose of every record."""
        numbers = (_pose_number(item.record.pose, self.poses) for item in self.records)
        return tuple(number for number in numbers if number is not None)

    def readings(
        self, systems: Sequence[PoseSystem], states: Sequence[RecordState]
    ) -> list[Complex]:
        """Return what the sensors read, Hann window, before the outputs' steps."""
        found = []
        for state, group in zip(states, self.groups, strict=True):
            raw = systems[group].reading(
                state.omega, state.deflection, state.acceleration, state.shift
            )
            found.append(hann(raw.reshape(len(raw), -1, 3)))
        return found

    def outputs(self, cell: CellModel, readings: Sequence[Complex]) -> list[Complex]:
        """Apply the outputs' steps."""
        return [
            cell.seen(item.omega[:, 1], reading)
            for item, reading in zip(self.records, readings, strict=True)
        ]


def _pose_number(pose: NDArray[np.float64], poses: Sequence[NDArray[np.float64]]) -> int | None:
    """Return which of some poses a pose is, the first one that is near; None for none."""
    near = (
        n for n, other in enumerate(poses) if np.abs(other - pose).max() < PREDICTION.same_pose_rad
    )
    return next(near, None)
