"""What a cell says the sensors read, for the motion that was recorded."""

from collections.abc import Sequence
import dataclasses
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from model_gap.campaign import Complex, RecordSpectra, Rows, Weighting
from model_gap.cell import (
    CellModel,
    HeldTorque,
    pose_arm,
    pose_system,
    PoseArm,
    PoseSystem,
    with_channels,
)
from model_gap.predict.arm_motion import arm_motion
from model_gap.predict.local_torques import LocalTorques, Paths, Torques
from model_gap.predict.posed_records import PosedRecords
from model_gap.predict.prediction_cache import Identity, PredictionCache
from model_gap.predict.solved import motion_of, Solved
from model_gap.predict.thresholds import PREDICTION
from model_gap.predict.tone import follow, rows_of
from model_gap.predict.whitening import Whitening
from structural_model import FlexibleJointModel, ModelSpec


@dataclass(frozen=True, eq=False)
class Predictor:
    """Predict the spectra of records under any cell.

    Parameters
    ----------
    model : FlexibleJointModel
        Gives kinematics; its spec is replaced by the cell's.
    records : sequence of RecordSpectra
        What to predict.
    steps_per_s : float [Hz]
        Of nonlinear torques; fewer than usual are for numbers that are still far off.
    hanging : bool
        Linear about how the arm hangs in its springs, not about the motors' angles.
    screening : bool
        Torque laws are screened, not fitted: they may see the twist as measured.
    cache : PredictionCache
        Where what was computed last is kept; one of its own unless it is handed in.
    """

    model: FlexibleJointModel
    records: Sequence[RecordSpectra]
    steps_per_s: float = PREDICTION.steps_per_s
    hanging: bool = True
    screening: bool = False
    cache: PredictionCache = field(default_factory=PredictionCache, repr=False)

    @cached_property
    def _basis(self) -> tuple[Identity, float, bool, bool]:
        """What every key begins with: all that an answer depends on beside the cell."""
        records = Identity((self.model, *self.records))
        return records, self.steps_per_s, self.hanging, self.screening

    @cached_property
    def posed(self) -> PosedRecords:
        """The records by pose."""
        return PosedRecords(self.model, self.records)

    @property
    def poses(self) -> list[NDArray[np.float64]]:
        """Different poses of the records [rad]."""
        return self.posed.poses

    @property
    def groups(self) -> tuple[int, ...]:
        """Number of the pose of every record."""
        return self.posed.groups

    @cached_property
    def local_torques(self) -> LocalTorques:
        """Steps the nonlinear torques."""
        return LocalTorques(
            self.records, self.groups, self.steps_per_s, self._paths, self.screening
        )

    @cached_property
    def weighting(self) -> Weighting:
        """How spectra become rows, and what was measured as rows."""
        return Weighting.of(self.records)

    def rows(self, cell: CellModel) -> Rows:
        """Return the prediction as rows."""
        return self.weighting.rows(self.predict(cell))

    def systems(self, spec: ModelSpec, channels: tuple[Channel, ...]) -> list[PoseSystem]:
        """Linearise at every pose."""

        def linearise() -> list[PoseSystem]:
            model = self.arm(spec)
            return [pose_system(model, pose, channels, self.hanging) for pose in self.poses]

        return self.cache.systems.of((*self._basis, spec, channels), linearise)

    def _paths(self, cell: CellModel) -> Paths:
        """Return where the paths of an arm and its motion are collected."""
        bare = dataclasses.replace(cell, forces=())
        return self.cache.paths.of((*self._basis, bare), dict)

    def arms(self, spec: ModelSpec, most: int | None = None) -> list[PoseArm]:
        """Return the matrices at every pose, or at the first few."""
        model = self.arm(spec)
        return [pose_arm(model, pose, self.hanging) for pose in self.poses[:most]]

    def arm(self, spec: ModelSpec) -> FlexibleJointModel:
        """Return an arm with the kinematics of the model."""
        return self.cache.arms.of(
            (*self._basis, spec), lambda: dataclasses.replace(self.model, spec=spec)
        )

    def sensors_moved(self, cell: CellModel, systems: Sequence[PoseSystem]) -> list[PoseSystem]:
        """Return the systems with the channels of a cell, dynamics unchanged."""
        model = self.arm(cell.spec)
        return [
            with_channels(system, model, pose, cell.channels, self.hanging)
            for system, pose in zip(systems, self.poses, strict=True)
        ]

    def solved(self, cell: CellModel) -> Solved:
        """Return how the arm moves under a cell."""

        def solve() -> Solved:
            systems = self.systems(cell.spec, cell.channels)
            (torques,) = self.torques([cell], systems)
            return arm_motion(self.posed, cell, systems, torques)

        found = self.cache.motions.of((*self._basis, motion_of(cell)), solve)
        return dataclasses.replace(found, cell=cell)

    def seen_changes(self, solved: Solved, changes: Sequence[Complex]) -> list[Complex]:
        """Return changes of the readings as changes of the prediction.

        Behind the outputs' steps, whitened as the residual is, less what free tones would follow.

        Golub and Pereyra (1973), doi:10.1137/0710036, as simplified by Kaufman (1975),
        doi:10.1007/BF01932995: numbers that are free in every record are eliminated.
        """
        seen = self.posed.outputs(solved.cell, changes)
        seen = Whitening.of(self.posed, solved, solved.cell).changes(seen)
        if not solved.patterns:
            return seen
        found = []
        for item, patterns, change in zip(self.records, solved.patterns, seen, strict=True):
            rows = rows_of(change, item)
            rows = rows - follow(patterns, rows) @ patterns
            half = len(rows) // 2
            scaled = (rows[:half] + 1j * rows[half:]).reshape(change.shape)
            found.append(item.from_noise(scaled))
        return found

    def torques(self, cells: Sequence[CellModel], systems: Sequence[PoseSystem]) -> list[Torques]:
        """Return the nonlinear torques of several cells with one arm and one motion."""
        return self.local_torques.of(cells, self.arm(cells[0].spec), systems)

    def hold(self, cell: CellModel) -> CellModel:
        """Return a cell whose nonlinear torques stay as they are now, whatever changes."""
        if not cell.forces:
            return cell
        systems = self.systems(cell.spec, cell.channels)
        names, held = systems[0].dof_names, []
        for force in cell.forces:
            alone = dataclasses.replace(cell, forces=(force,))
            (torques,) = self.torques([alone], systems)
            held.append(HeldTorque(names, tuple(torques.forces), torques.errors))
        return dataclasses.replace(cell, forces=(), held=(*cell.held, *held))

    def predict_many(self, cells: Sequence[CellModel]) -> list[list[Complex]]:
        """Predict several cells; if only nonlinear forces differ, their paths are shared."""
        first = dataclasses.replace(cells[0], forces=())
        alike = all(dataclasses.replace(item, forces=()) == first for item in cells)
        if not alike or not any(item.forces for item in cells):
            return [self.predict(item) for item in cells]
        systems = self.systems(first.spec, first.channels)
        return [
            self._predicted(arm_motion(self.posed, cell, systems, torques), cell)
            for cell, torques in zip(cells, self.torques(cells, systems), strict=True)
        ]

    def squares(self, cell: CellModel) -> list[NDArray[np.float64]]:
        """Return |Y - Ŷ|²/σ² of every record, (n_channels, n_bins) each; 0 where nothing is."""
        return [
            item.squares(item.measured - reading)
            for item, reading in zip(self.records, self.predict(cell), strict=True)
        ]

    def predict(self, cell: CellModel) -> list[Complex]:
        """Return the predicted spectra of every record, (n_channels, n_bins) each.

        Effects of sensors cost next to nothing after others.
        """
        return self._predicted(self.solved(cell), cell)

    def excused_misfit(self, cell: CellModel, law: CellModel) -> float:
        """Return χ of a cell, were its residual judged as another one's is, who has more torques.

        A torque that follows a measured twist is doubtful along one direction, and the residual
        counts for less there.  That alone may take away what is wrong for other reasons: noise of
        the known motion goes through the same arm.
        """
        solved = self.solved(law)
        readings = self.posed.outputs(cell, self.solved(cell).readings)
        judged = Whitening.of(self.posed, solved, law).prediction(readings)
        return self.weighting.misfit(self.weighting.rows(judged))

    def _predicted(self, solved: Solved, cell: CellModel) -> list[Complex]:
        seen = self.posed.outputs(cell, solved.readings)
        return Whitening.of(self.posed, solved, cell).prediction(seen)
