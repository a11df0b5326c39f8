"""What a setup says the sensors read, for the motion that was recorded."""

from collections.abc import Sequence
import dataclasses
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from model_gap.joint_law import JointLaw
from model_gap.joint_vector import joint_vector
from model_gap.pose_system import pose_arm, pose_system, PoseArm, PoseSystem, with_channels
from model_gap.ripple import ripple_force
from model_gap.setup import HeldTorque, JointForce, Setup
from model_gap.spectra import hann, RecordSpectra
from model_gap.time_domain import (
    force_spectra,
    joint_path,
    JointPath,
    static_twist,
    step_torques,
    STEPS_PER_S,
)
from model_gap.tone import add_tones
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
        Of nonlinear torques.
    """

    model: FlexibleJointModel
    records: Sequence[RecordSpectra]
    steps_per_s: float = STEPS_PER_S
    groups: tuple[int, ...] = field(init=False)
    poses: list[NDArray[np.float64]] = field(init=False)
    _kept: '_Kept | None' = field(init=False, default=None)

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

    def systems(self, spec: ModelSpec, channels: tuple[Channel, ...]) -> list[PoseSystem]:
        """Linearise at every pose."""
        model = dataclasses.replace(self.model, spec=spec)
        return [pose_system(model, pose, channels) for pose in self.poses]

    def arms(self, spec: ModelSpec, most: int | None = None) -> list[PoseArm]:
        """Return the matrices at every pose, or at the first few."""
        model = dataclasses.replace(self.model, spec=spec)
        return [pose_arm(model, pose) for pose in self.poses[:most]]

    def sensors_moved(self, setup: Setup, systems: Sequence[PoseSystem]) -> list[PoseSystem]:
        """Return the systems with the channels of a setup, dynamics unchanged."""
        model = dataclasses.replace(self.model, spec=setup.spec)
        return [
            with_channels(system, model, pose, setup.channels)
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
            acceleration = item.motor_acceleration.reshape(len(item.motor_acceleration), -1)
            shift = item.motor_shift.reshape(len(item.motor_shift), -1)
            for step in setup.inputs:
                acceleration, shift = step(omega, acceleration), step(omega, shift)
            system = systems[group]
            force = system.force(acceleration, shift)
            for ripple in setup.ripples:
                force = force + ripple_force(ripple, item, self.model, setup.spec, system)
            for torque in setup.held:
                place = joint_vector(self.model, torque.joint, system.dof_names)
                force = force + np.outer(place, torque.spectra[index])
            if forces:
                force = force + forces[index]
            ringing = system.end_state(item.tail, item.coarse_period_s)
            deflection = system.deflection(omega, force, ringing * item.end_scale)
            states.append(RecordState(omega, acceleration, shift, deflection))
        return states, list(forces)

    def _local_forces(self, setup: Setup, systems: Sequence[PoseSystem]) -> list[Complex]:
        return self.local_forces([setup], systems)[0] if setup.forces else []

    def local_forces(
        self, setups: Sequence[Setup], systems: Sequence[PoseSystem]
    ) -> list[list[Complex]]:
        """Return the nonlinear forces of several setups with one arm, all stepped together.

        Returns
        -------
        list of list of (n_dof, 3 n_bins) complex array
            Per setup, per record.
        """
        model = dataclasses.replace(self.model, spec=setups[0].spec)
        paths: dict[tuple[str, int], JointPath] = {}
        lanes: dict[type[JointLaw], list[tuple[int, int, JointForce]]] = {}
        for number, setup in enumerate(setups):
            for force in setup.forces:
                for index, item in enumerate(self.records):
                    key = (force.joint, index)
                    if key not in paths:
                        system = systems[self.groups[index]]
                        paths[key] = joint_path(
                            model, force.joint, item, system, setup, self.steps_per_s
                        )
                    lanes.setdefault(force.law, []).append((number, index, force))
        found: list[list[Complex]] = [[0.0j] * len(self.records) for _ in setups]  # type: ignore[list-item]
        for entries in lanes.values():
            chosen = [paths[force.joint, index] for _, index, force in entries]
            torques = step_torques(chosen, [force for _, _, force in entries])
            for (number, index, _), path, torque in zip(entries, chosen, torques, strict=True):
                found[number][index] = found[number][index] + force_spectra(
                    torque, path, self.records[index]
                )
        return found

    def hold(self, setup: Setup) -> Setup:
        """Return a setup whose nonlinear torques stay as they are now, whatever changes."""
        if not setup.forces:
            return setup
        systems = self.systems(setup.spec, setup.channels)
        model = dataclasses.replace(self.model, spec=setup.spec)
        held = []
        for force in setup.forces:
            alone = dataclasses.replace(setup, forces=(force,))
            (pushes,) = self.local_forces([alone], systems)
            vector = joint_vector(model, force.joint, systems[0].dof_names)
            spectra = tuple(vector @ push / (vector @ vector) for push in pushes)
            held.append(HeldTorque(force.joint, spectra))
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
            paths = []
            for index, item in enumerate(self.records):
                group = self.groups[index]
                path = joint_path(base, force.joint, item, systems[group], setup, self.steps_per_s)
                paths.append(path)
                paths += [dataclasses.replace(path, static_twist=row[group]) for row in twists]
            torques = step_torques(paths, [force] * len(paths))
            for index, item in enumerate(self.records):
                start = index * (len(moved) + 1)
                for number in range(len(moved)):
                    change = torques[start + 1 + number] - torques[start]
                    found[number][index] = found[number][index] + force_spectra(
                        change, paths[start], item
                    )
        return found if preloaded else []

    def predict_many(self, setups: Sequence[Setup]) -> list[list[Complex]]:
        """Predict several setups; if only nonlinear forces differ, they are stepped at once."""
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
        for setup, forces in zip(setups, self.local_forces(setups, systems), strict=True):
            states = self.states(setup, systems, forces if setup.forces else [])
            readings = self.outputs(setup, self.readings(systems, states))
            if setup.tones:
                readings = add_tones(
                    setup.tones, self.records, self.groups, systems, self.model, readings
                )
            found.append(readings)
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
        found = []
        for item, reading in zip(self.records, readings, strict=True):
            for step in setup.outputs:
                reading = step(item.omega[:, 1], reading)
            found.append(reading)
        return found

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
            self._kept = _Kept(setup, systems, readings)
        else:
            readings = kept.readings
        found = self.outputs(setup, readings)
        if setup.tones:
            found = add_tones(setup.tones, self.records, self.groups, systems, self.model, found)
        return found


@dataclass(frozen=True)
class _Kept:
    setup: Setup
    systems: list[PoseSystem]
    readings: list[Complex]


def _same_motion(one: Setup, other: Setup) -> bool:
    return (one.inputs, one.forces, one.ripples, one.held) == (
        other.inputs,
        other.forces,
        other.ripples,
        other.held,
    )
