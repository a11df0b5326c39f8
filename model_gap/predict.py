"""What a setup says the sensors read, for the motion that was recorded."""

from collections.abc import Sequence
import dataclasses
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from model_gap.doubt import certain, Doubt, doubt_of
from model_gap.driven import driven_motion
from model_gap.joint_path import joint_path, JointPath, static_twist, STEPS_PER_S
from model_gap.joint_vector import joint_vector
from model_gap.laws import Follow
from model_gap.pose_system import pose_arm, pose_system, PoseArm, PoseSystem, with_channels
from model_gap.ripple import ripple_force
from model_gap.setup import HeldTorque, JointForce, Setup
from model_gap.spectra import hann, RecordSpectra
from model_gap.step_torque import step_torque
from model_gap.tone import best_motion, follow, rows_of, tone_motions
from model_gap.torque_spectra import force_spectra, whole_force
from model_gap.weighting import Rows, Weighting
from structural_model import FlexibleJointModel, ModelSpec

Complex = NDArray[np.complex128]
SAME_POSE_RAD = 2e-3


@dataclass(frozen=True)
class RecordState:
    """Motor motion and deflection of one record under a setup, on bins and their neighbours.

    Parameters
    ----------
    omega : (3 n_bins,) array [rad/s]
        Flattened triples.
    acceleration, shift : (n_joints, 3 n_bins) complex array
        Motor motion behind the inputs' steps.
    deflection : (n_dof, 3 n_bins) complex array
        Of the flexible degrees of freedom.
    """

    omega: NDArray[np.float64]
    acceleration: Complex
    shift: Complex
    deflection: Complex


@dataclass
class Predictor:
    """Predict the spectra of records under any setup.

    Parameters
    ----------
    model : FlexibleJointModel
        Gives kinematics; its spec is replaced by the setup's.
    records : sequence of RecordSpectra
        What to predict.
    steps_per_s : float [Hz]
        Of nonlinear torques; fewer than usual are for numbers that are still far off.
    hanging : bool
        Linear about how the arm hangs in its springs, not about the motors' angles.
    """

    model: FlexibleJointModel
    records: Sequence[RecordSpectra]
    steps_per_s: float = STEPS_PER_S
    hanging: bool = True
    groups: tuple[int, ...] = field(init=False)
    poses: list[NDArray[np.float64]] = field(init=False)
    _kept: '_Kept | None' = field(init=False, default=None)
    _model: FlexibleJointModel | None = field(init=False, default=None)
    _systems: tuple[ModelSpec, tuple[Channel, ...], list[PoseSystem]] | None = field(
        init=False, default=None
    )
    _tones: list[NDArray[np.float64]] = field(init=False, default_factory=list)
    _errors: list['_Errors'] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        """Group the records: those of one pose share one linear system."""
        groups, self.poses = [], []
        for item in self.records:
            pose = item.record.pose
            known = [
                index
                for index, other in enumerate(self.poses)
                if np.abs(other - pose).max() < SAME_POSE_RAD
            ]
            if not known:
                self.poses.append(pose)
            groups.append(known[0] if known else len(self.poses) - 1)
        self.groups = tuple(groups)

    @cached_property
    def weighting(self) -> Weighting:
        """How spectra become rows, and what was measured as rows."""
        return Weighting.of(self.records)

    def rows(self, setup: Setup) -> Rows:
        """Return the prediction as rows."""
        return self.weighting.rows(self.predict(setup))

    def systems(self, spec: ModelSpec, channels: tuple[Channel, ...]) -> list[PoseSystem]:
        """Linearise at every pose; what was asked for last is remembered."""
        known = self._systems
        if known is None or known[:2] != (spec, channels):
            model = self._arm(spec)
            found = [pose_system(model, pose, channels, self.hanging) for pose in self.poses]
            known = self._systems = (spec, channels, found)
        return known[2]

    def arms(self, spec: ModelSpec, most: int | None = None) -> list[PoseArm]:
        """Return the matrices at every pose, or at the first few."""
        model = self._arm(spec)
        return [pose_arm(model, pose, self.hanging) for pose in self.poses[:most]]

    def _arm(self, spec: ModelSpec) -> FlexibleJointModel:
        """Return the arm, the last one again if it is the same."""
        if self._model is None or self._model.spec != spec:
            self._model = dataclasses.replace(self.model, spec=spec)
        return self._model

    def sensors_moved(self, setup: Setup, systems: Sequence[PoseSystem]) -> list[PoseSystem]:
        """Return the systems with the channels of a setup, dynamics unchanged."""
        model = dataclasses.replace(self.model, spec=setup.spec)
        return [
            with_channels(system, model, pose, setup.channels, self.hanging)
            for system, pose in zip(systems, self.poses, strict=True)
        ]

    def states(
        self,
        setup: Setup,
        systems: Sequence[PoseSystem],
        forces: Sequence[Complex] | None = None,
    ) -> list[RecordState]:
        """Return the states of all records; ``forces`` replaces the nonlinear ones."""
        return self.states_and_forces(setup, systems, forces)[0]

    def states_and_forces(
        self,
        setup: Setup,
        systems: Sequence[PoseSystem],
        forces: Sequence[Complex] | None = None,
    ) -> tuple[list[RecordState], list[Complex]]:
        """Return the states and the nonlinear forces that belong to them, (n_dof, 3 n_bins)."""
        if forces is None:
            forces = self._local_forces(setup, systems)
        states = []
        for index, (item, group) in enumerate(zip(self.records, self.groups, strict=True)):
            omega = item.omega.ravel()
            motion = driven_motion(item, setup)
            system = systems[group]
            force = system.force(motion.acceleration, motion.shift)
            for ripple in setup.ripples:
                force = force + ripple_force(ripple, item, self.model, setup.spec, system)
            for torque in setup.held:
                rows = [system.dof_names.index(name) for name in torque.dof_names]
                force[rows] += torque.spectra[index]
            if forces:
                force = force + forces[index]
            ringing = system.end_state(motion.tail, item.coarse_period_s)
            deflection = system.deflection(omega, force, ringing * item.end_scale)
            states.append(RecordState(omega, motion.acceleration, motion.shift, deflection))
        if setup.tones:
            states = self._with_tones(setup, systems, states)
        return states, list(forces)

    def _with_tones(
        self, setup: Setup, systems: Sequence[PoseSystem], states: Sequence[RecordState]
    ) -> list[RecordState]:
        """Add to every record the tones that fit what is left of it best."""
        found, self._tones = [], []
        readings = self.outputs(setup, self.readings(systems, states))
        for item, group, state, reading in zip(
            self.records, self.groups, states, readings, strict=True
        ):
            seen = partial(_seen, setup, item, systems[group])
            kinds = tone_motions(setup.tones, item, systems[group], self.model)
            rest = item.measured - reading
            motion, patterns = best_motion(setup.tones, kinds, item, seen, rest)
            self._tones.append(patterns)
            found.append(dataclasses.replace(state, deflection=state.deflection + motion))
        return found

    def less_tones(
        self, setup: Setup, changes: Sequence[Complex], doubts: Sequence[Doubt] = ()
    ) -> list[Complex]:
        """Return changes of the readings less what the free tones of a setup would follow.

        ``doubts`` scale the changes as they do the residual.

        Golub and Pereyra (1973), doi:10.1137/0710036, as simplified by Kaufman (1975),
        doi:10.1007/BF01932995: numbers that are free in every record are eliminated.
        """
        changes = self.certain(doubts, changes)
        if not setup.tones:
            return list(changes)
        found = []
        for item, patterns, change in zip(self.records, self._tones, changes, strict=True):
            rows = rows_of(change, item)
            rows = rows - follow(patterns, rows) @ patterns
            half = len(rows) // 2
            scaled = (rows[:half] + 1j * rows[half:]).reshape(change.shape)
            found.append(scaled * np.sqrt(item.noise_power))
        return found

    def _local_forces(self, setup: Setup, systems: Sequence[PoseSystem]) -> list[Complex]:
        self._errors = []
        return self.local_forces([setup], systems)[0] if setup.forces else []

    def local_forces(
        self, setups: Sequence[Setup], systems: Sequence[PoseSystem]
    ) -> list[list[Complex]]:
        """Return the nonlinear forces of several setups with one arm and one motion.

        Returns
        -------
        list of list of (n_dof, 3 n_bins) complex array
            Per setup, per record.
        """
        model = dataclasses.replace(self.model, spec=setups[0].spec)
        paths: dict[tuple[str, int, Follow], JointPath] = {}
        found: list[list[Complex]] = [[0.0j] * len(self.records) for _ in setups]  # type: ignore[list-item]
        self._errors = [_Errors() for _ in setups]
        for pushes, errors, setup in zip(found, self._errors, setups, strict=True):
            for force in setup.forces:
                follow = self.followed(force)
                for index, (item, group) in enumerate(zip(self.records, self.groups, strict=True)):
                    system = systems[group]
                    key = (force.joint, index, follow)
                    if key not in paths:
                        paths[key] = joint_path(
                            model, force.joint, item, system, setup, self.steps_per_s, follow
                        )
                    path = paths[key]
                    torque = step_torque(path, force)
                    pushes[index] = pushes[index] + whole_force(torque, path, item, system)
                    if path.noisy is not None:
                        noisy = step_torque(path.with_noise(), force)
                        place = force_spectra(noisy - torque, path, item)
                        error = path.vector @ place / (path.vector @ path.vector)
                        errors[force.joint, index] = hann(error.reshape(-1, 3))
        return found

    def doubts(
        self, setup: Setup, systems: Sequence[PoseSystem], errors: '_Errors | None' = None
    ) -> tuple[Doubt, ...]:
        """Return the doubt of every record; nothing where no torque sees a measured twist."""
        if errors is None:  # of the torques stepped last
            errors = self._errors[0] if self._errors else _Errors()
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
                responses.append(setup.seen(omega, systems[group].response(omega, place)))
                samples.append(errors[joint, index])
            found.append(doubt_of(responses, samples, item))
        return tuple(found)

    def certain(self, doubts: Sequence[Doubt], changes: Sequence[Complex]) -> list[Complex]:
        """Return changes of the readings scaled as ``doubts`` scale residuals."""
        if not doubts:
            return list(changes)
        count = sum(item.measured.size for item in self.records)
        growth = np.exp(0.5 * sum(item.log_det for item in doubts) / count)
        return [
            growth * certain(change, doubt, item)
            for change, doubt, item in zip(changes, doubts, self.records, strict=True)
        ]

    def _doubted(self, doubts: Sequence[Doubt], readings: list[Complex]) -> list[Complex]:
        """Return readings such that what is measured beyond them is scaled by the doubts."""
        if not doubts:
            return readings
        measured = [item.measured for item in self.records]
        rest = [one - two for one, two in zip(measured, readings, strict=True)]
        return [one - two for one, two in zip(measured, self.certain(doubts, rest), strict=True)]

    def followed(self, force: JointForce) -> Follow:
        """Return which twist a torque sees."""
        first = self.steps_per_s < STEPS_PER_S
        return force.law.sees_first if first else force.law.sees

    def hold(self, setup: Setup) -> Setup:
        """Return a setup whose nonlinear torques stay as they are now, whatever changes."""
        if not setup.forces:
            return setup
        systems = self.systems(setup.spec, setup.channels)
        held = []
        for force in setup.forces:
            alone = dataclasses.replace(setup, forces=(force,))
            (pushes,) = self.local_forces([alone], systems)
            held.append(HeldTorque(systems[0].dof_names, tuple(pushes)))
        return dataclasses.replace(setup, forces=(), held=(*setup.held, *held))

    def preload_pushes(
        self, setup: Setup, systems: Sequence[PoseSystem], moved: Sequence[Setup]
    ) -> list[list[Complex]]:
        """Return how the torques change when gravity loads the joints as in other setups.

        Returns
        -------
        list of list of (n_dof, 3 n_bins) complex array
            Per moved setup, per record; no lists when no torque depends on the load.
        """
        found: list[list[Complex]] = [[0.0j] * len(self.records) for _ in moved]  # type: ignore[list-item]
        base = dataclasses.replace(self.model, spec=setup.spec)
        models = [dataclasses.replace(self.model, spec=item.spec) for item in moved]
        preloaded = [force for force in setup.forces if force.law.preloaded]
        for force in preloaded:
            vector = joint_vector(base, force.joint, systems[0].dof_names)
            twists = [
                [static_twist(model, vector, pose) for pose in self.poses] for model in models
            ]
            for index, (item, group) in enumerate(zip(self.records, self.groups, strict=True)):
                system, follow = systems[group], self.followed(force)
                path = joint_path(base, force.joint, item, system, setup, self.steps_per_s, follow)
                torque = step_torque(path, force)
                for pushes, row in zip(found, twists, strict=True):
                    loaded = dataclasses.replace(path, static_twist=row[group])
                    change = step_torque(loaded, force) - torque
                    pushes[index] = pushes[index] + whole_force(change, path, item, system)
        return found if preloaded else []

    def predict_many(self, setups: Sequence[Setup]) -> list[list[Complex]]:
        """Predict several setups; if only nonlinear forces differ, their paths are shared."""
        same = all(
            item.spec == setups[0].spec
            and item.channels == setups[0].channels
            and item.inputs == setups[0].inputs
            and item.ripples == setups[0].ripples
            and item.held == setups[0].held
            for item in setups
        )
        if not same or not any(item.forces for item in setups):
            return [self.predict(item) for item in setups]
        systems = self.systems(setups[0].spec, setups[0].channels)
        found = []
        pushes = self.local_forces(setups, systems)
        for setup, forces, errors in zip(setups, pushes, self._errors, strict=True):
            states = self.states(setup, systems, forces if setup.forces else [])
            readings = self.outputs(setup, self.readings(systems, states))
            found.append(self._doubted(self.doubts(setup, systems, errors), readings))
        return found

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

    def outputs(self, setup: Setup, readings: Sequence[Complex]) -> list[Complex]:
        """Apply the outputs' steps."""
        return [
            setup.seen(item.omega[:, 1], reading)
            for item, reading in zip(self.records, readings, strict=True)
        ]

    def squares(self, setup: Setup) -> list[NDArray[np.float64]]:
        """Return |Y - Ŷ|²/σ² of every record, (n_channels, n_bins) each."""
        return [
            np.abs(item.measured - reading) ** 2 / item.noise_power
            for item, reading in zip(self.records, self.predict(setup), strict=True)
        ]

    def predict(self, setup: Setup) -> list[Complex]:
        """Return the predicted spectra of every record, (n_channels, n_bins) each.

        The last arms and motions are remembered: effects of sensors cost next to nothing.
        """
        kept = self._kept
        if (
            kept is None
            or kept.setup.spec is not setup.spec
            or (kept.setup.channels is not setup.channels)
        ):
            systems = self.systems(setup.spec, setup.channels)
            kept = None
        else:
            systems = kept.systems
        if kept is None or not _same_motion(kept.setup, setup):
            readings = self.readings(systems, self.states(setup, systems))
            errors = self._errors[0] if setup.forces else _Errors()
            kept = self._kept = _Kept(setup, systems, readings, errors)
        doubts = self.doubts(setup, systems, kept.errors)
        return self._doubted(doubts, self.outputs(setup, kept.readings))


class _Errors(dict[tuple[str, int], Complex]):
    """Sample errors of torques on the compared bins, by joint and record."""


def _seen(setup: Setup, item: RecordSpectra, system: PoseSystem, motion: Complex) -> Complex:
    """Return what the sensors read of a deflection while the motors stand still."""
    omega = item.omega.ravel()
    still = np.zeros((system.rigid.shape[1], len(omega)), dtype=complex)
    raw = system.reading(omega, motion, still, still)
    return setup.seen(item.omega[:, 1], hann(raw.reshape(len(raw), -1, 3)))


@dataclass(frozen=True)
class _Kept:
    setup: Setup
    systems: list[PoseSystem]
    readings: list[Complex]
    errors: _Errors


def _same_motion(one: Setup, other: Setup) -> bool:
    if one.tones and one.outputs != other.outputs:
        return False  # tones follow what sensors read
    return (one.inputs, one.forces, one.ripples, one.held, one.tones) == (
        other.inputs,
        other.forces,
        other.ripples,
        other.held,
        other.tones,
    )
