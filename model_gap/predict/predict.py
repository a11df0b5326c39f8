"""What a cell says the sensors read, for the motion that was recorded."""

from collections.abc import Sequence
import dataclasses
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from model_gap.campaign import hann, RecordSpectra, Rows, Weighting
from model_gap.cell import (
    CellModel,
    HeldTorque,
    joint_vector,
    pose_arm,
    pose_system,
    PoseArm,
    PoseSystem,
    with_channels,
)
from model_gap.predict.driven import driven_motion
from model_gap.predict.error_covariance import error_covariance, ErrorCovariance, whitened
from model_gap.predict.joint_path import STEPS_PER_S
from model_gap.predict.local_torques import LocalTorques, Paths, Torques
from model_gap.predict.prediction_cache import Identity, PredictionCache
from model_gap.predict.ripple import ripple_force
from model_gap.predict.solved import motion_of, RecordState, Solved
from model_gap.predict.tone import best_motion, follow, rows_of, tone_motions
from structural_model import FlexibleJointModel, ModelSpec

Complex = NDArray[np.complex128]
SAME_POSE_RAD = 2e-3


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
    cache : PredictionCache
        Where what was computed last is kept; one of its own unless it is handed in.
    """

    model: FlexibleJointModel
    records: Sequence[RecordSpectra]
    steps_per_s: float = STEPS_PER_S
    hanging: bool = True
    cache: PredictionCache = field(default_factory=PredictionCache, repr=False)

    @cached_property
    def _basis(self) -> tuple[Identity, float, bool]:
        """What every key begins with: all that an answer depends on beside the cell."""
        return Identity((self.model, *self.records)), self.steps_per_s, self.hanging

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
        """Number of the pose of every record: those of one pose share one linear system."""
        numbers = (_pose_number(item.record.pose, self.poses) for item in self.records)
        return tuple(number for number in numbers if number is not None)

    @cached_property
    def local_torques(self) -> LocalTorques:
        """Steps the nonlinear torques."""
        return LocalTorques(self.records, self.groups, self.steps_per_s, self._paths)

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
        model = dataclasses.replace(self.model, spec=cell.spec)
        return [
            with_channels(system, model, pose, cell.channels, self.hanging)
            for system, pose in zip(systems, self.poses, strict=True)
        ]

    def solved(self, cell: CellModel) -> Solved:
        """Return how the arm moves under a cell."""

        def solve() -> Solved:
            systems = self.systems(cell.spec, cell.channels)
            (torques,) = self.torques([cell], systems)
            return self._solve(cell, systems, torques)

        found = self.cache.motions.of((*self._basis, motion_of(cell)), solve)
        return dataclasses.replace(found, cell=cell)

    def _solve(self, cell: CellModel, systems: list[PoseSystem], torques: Torques) -> Solved:
        states = []
        for index, (item, group) in enumerate(zip(self.records, self.groups, strict=True)):
            omega = item.omega.ravel()
            motion = driven_motion(item, cell)
            system = systems[group]
            force = system.force(motion.acceleration, motion.shift)
            for ripple in cell.ripples:
                force = force + ripple_force(ripple, item, self.model, cell.spec, system)
            for torque in cell.held:
                rows = [system.dof_names.index(name) for name in torque.dof_names]
                force[rows] += torque.spectra[index]
            if torques.forces:
                force = force + torques.forces[index]
            ringing = system.end_state(motion.tail, item.coarse_period_s)
            deflection = system.deflection(omega, force, ringing * item.end_scale)
            states.append(RecordState(omega, motion.acceleration, motion.shift, deflection))
        patterns: list[NDArray[np.float64]] = []
        if cell.tones:
            states, patterns = self._with_tones(cell, systems, states)
        return Solved(cell, systems, torques, states, self.readings(systems, states), patterns)

    def _with_tones(
        self, cell: CellModel, systems: Sequence[PoseSystem], states: Sequence[RecordState]
    ) -> tuple[list[RecordState], list[NDArray[np.float64]]]:
        """Add to every record the tones that fit what is left of it best."""
        found, patterns = [], []
        readings = self.outputs(cell, self.readings(systems, states))
        for item, group, state, reading in zip(
            self.records, self.groups, states, readings, strict=True
        ):
            seen = partial(_seen, cell, item, systems[group])
            kinds = tone_motions(cell.tones, item, systems[group], self.model)
            rest = item.measured - reading
            motion, own = best_motion(cell.tones, kinds, item, seen, rest)
            patterns.append(own)
            found.append(dataclasses.replace(state, deflection=state.deflection + motion))
        return found, patterns

    def seen_changes(self, solved: Solved, changes: Sequence[Complex]) -> list[Complex]:
        """Return changes of the readings as changes of the prediction.

        Behind the outputs' steps, whitened as the residual is, less what free tones would follow.

        Golub and Pereyra (1973), doi:10.1137/0710036, as simplified by Kaufman (1975),
        doi:10.1007/BF01932995: numbers that are free in every record are eliminated.
        """
        seen = self.outputs(solved.cell, changes)
        seen = self._whitened(self._error_covariances(solved, solved.cell), seen)
        if not solved.patterns:
            return seen
        found = []
        for item, patterns, change in zip(self.records, solved.patterns, seen, strict=True):
            rows = rows_of(change, item)
            rows = rows - follow(patterns, rows) @ patterns
            half = len(rows) // 2
            scaled = (rows[:half] + 1j * rows[half:]).reshape(change.shape)
            found.append(scaled * np.sqrt(item.noise_power))
        return found

    def torques(self, cells: Sequence[CellModel], systems: Sequence[PoseSystem]) -> list[Torques]:
        """Return the nonlinear torques of several cells with one arm and one motion."""
        return self.local_torques.of(cells, self.arm(cells[0].spec), systems)

    def _error_covariances(self, solved: Solved, cell: CellModel) -> tuple[ErrorCovariance, ...]:
        """Return that of every record; nothing where no torque sees a measured twist."""
        systems = solved.systems
        sources = (*(item.errors for item in cell.held), solved.torques.errors)
        errors = {key: error for source in sources for key, error in source.items()}
        if not errors:
            return ()
        places = {
            joint: joint_vector(self.model, joint, systems[0].dof_names) for joint, _ in errors
        }
        found = []
        for index, (item, group) in enumerate(zip(self.records, self.groups, strict=True)):
            omega = item.omega[:, 1]
            responses, samples = [], []
            for joint, place in places.items():
                responses.append(cell.seen(omega, systems[group].response(omega, place)))
                samples.append(errors[joint, index])
            found.append(error_covariance(responses, samples, item))
        return tuple(found)

    def _whitened(
        self, covariances: Sequence[ErrorCovariance], changes: Sequence[Complex]
    ) -> list[Complex]:
        """Return changes of the readings, whitened as residuals are."""
        if not covariances:
            return list(changes)
        count = sum(item.measured.size for item in self.records)
        growth = np.exp(0.5 * sum(item.log_det for item in covariances) / count)
        return [
            growth * whitened(change, covariance, item)
            for change, covariance, item in zip(changes, covariances, self.records, strict=True)
        ]

    def _with_whitened_rest(
        self, covariances: Sequence[ErrorCovariance], readings: list[Complex]
    ) -> list[Complex]:
        """Return readings such that what is measured beyond them is the whitened residual."""
        if not covariances:
            return readings
        measured = [item.measured for item in self.records]
        rest = [one - two for one, two in zip(measured, readings, strict=True)]
        return [
            one - two for one, two in zip(measured, self._whitened(covariances, rest), strict=True)
        ]

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
            self._predicted(self._solve(cell, systems, torques), cell)
            for cell, torques in zip(cells, self.torques(cells, systems), strict=True)
        ]

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

    def squares(self, cell: CellModel) -> list[NDArray[np.float64]]:
        """Return |Y - Ŷ|²/σ² of every record, (n_channels, n_bins) each."""
        return [
            np.abs(item.measured - reading) ** 2 / item.noise_power
            for item, reading in zip(self.records, self.predict(cell), strict=True)
        ]

    def predict(self, cell: CellModel) -> list[Complex]:
        """Return the predicted spectra of every record, (n_channels, n_bins) each.

        Effects of sensors cost next to nothing after others.
        """
        return self._predicted(self.solved(cell), cell)

    def _predicted(self, solved: Solved, cell: CellModel) -> list[Complex]:
        return self._with_whitened_rest(
            self._error_covariances(solved, cell), self.outputs(cell, solved.readings)
        )


def _pose_number(pose: NDArray[np.float64], poses: Sequence[NDArray[np.float64]]) -> int | None:
    """Return which of some poses a pose is, the first one that is near; None for none."""
    near = (n for n, other in enumerate(poses) if np.abs(other - pose).max() < SAME_POSE_RAD)
    return next(near, None)


def _seen(cell: CellModel, item: RecordSpectra, system: PoseSystem, motion: Complex) -> Complex:
    """Return what the sensors read of a deflection while the motors stand still."""
    omega = item.omega.ravel()
    still = np.zeros((system.rigid.shape[1], len(omega)), dtype=complex)
    raw = system.reading(omega, motion, still, still)
    return cell.seen(item.omega[:, 1], hann(raw.reshape(len(raw), -1, 3)))
