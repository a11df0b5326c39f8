"""Derivatives of the prediction by all numbers, as real rows weighted by the noise."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from model_gap.equivalent_gain import closed_transfer, equivalent_gain
from model_gap.hypothesis import Hypothesis
from model_gap.joint_vector import joint_spring, joint_vector
from model_gap.laws import Follow
from model_gap.predict import Predictor
from model_gap.setup import Setup
from model_gap.spectra import Complex, hann
from model_gap.weighting import Rows

Array = NDArray[np.float64]
Complex64 = NDArray[np.complex64]
TOLERANCE_STEP = 0.05
EFFECT_STEP = 0.002


def effect_columns(hypothesis: Hypothesis, predictor: Predictor, base: Rows) -> Rows:
    """Return derivatives by the inner parameters, in prior standard deviations, as rows.

    Where a parameter changes no torque law, nonlinear torques are held.  What changes the arm is
    differentiated as tolerances are: a spring's change and its tolerance must look alike.
    """
    tolerant = hypothesis.tolerant
    now = hypothesis.add_effects(tolerant)
    held = predictor.hold(now).held if _mixed(hypothesis) else now.held
    slow = [
        effect.amplitude_dependent
        for effect in hypothesis.effects
        for _ in effect.parameters(hypothesis.scene)
    ]
    setups, steps = [], []
    for number, scale in enumerate(hypothesis.prior_scale):
        inner = hypothesis.inner.copy()
        step = EFFECT_STEP * scale
        item = hypothesis.parameters[number]
        if item.inner(item.high) - inner[number] < step:
            step = -step
        inner[number] += step
        moved = hypothesis.moved(hypothesis.tolerance_values, inner).add_effects(tolerant)
        if not slow[number]:
            moved = replace(moved, forces=(), held=held)
        setups.append(moved)
        steps.append(step / scale)
    stepped = [setup for setup, waits in zip(setups, slow, strict=True) if waits]
    waiting = iter(predictor.predict_many(stepped) if stepped else [])
    arm: _ArmDerivative | None = None
    columns = []
    for setup, waits, step in zip(setups, slow, steps, strict=True):
        if waits or setup.spec == now.spec:
            spectra = next(waiting) if waits else predictor.predict(setup)
            columns.append((predictor.weighting.rows(spectra) - base) / np.float32(step))
            continue
        if arm is None:
            arm = _ArmDerivative(now, predictor)
        changes = predictor.seen_changes(arm.solved, arm.changes(setup, step))
        columns.append(predictor.weighting.rows(changes))
    return np.array(columns, dtype=np.float32).reshape(len(columns), len(base))


def _mixed(hypothesis: Hypothesis) -> bool:
    """Return whether torques in time stand beside effects that can do without."""
    return len({effect.amplitude_dependent for effect in hypothesis.effects}) > 1


def tolerance_columns(hypothesis: Hypothesis, predictor: Predictor) -> Rows:
    """Return derivatives by the tolerances, per prior standard deviation, as rows.

    To first order a changed arm is the present one under the force (dB a + dP q) -
    (dM x'' + dC x' + dK x), so that one transfer per record serves all tolerances.  Nonlinear
    torques follow the changed motion as equivalent springs and dampers would, but where the drive
    they act in is changed: there they are stepped anew.  What rings on after the record is held.

    References
    ----------
    Fox and Kapoor (1968), doi:10.2514/3.5008, for the direct method of sensitivities.
    """
    tolerant = hypothesis.tolerant
    setup = hypothesis.add_effects(tolerant)
    arm = _ArmDerivative(setup, predictor)
    systems, states, readings = arm.solved.systems, arm.solved.states, arm.solved.readings
    heavier = [
        replace(
            predictor.model, spec=hypothesis.add_effects(item.apply(tolerant, TOLERANCE_STEP)).spec
        )
        for item in hypothesis.tolerances
        if item.kind == 'spec'
    ]
    model = predictor.arm(setup.spec)
    pushes = iter(predictor.local_torques.of_changed_load(setup, heavier, model, systems))
    gains = [number for number, item in enumerate(hypothesis.tolerances) if item.kind == 'gain']
    lawful = {force.joint for force in setup.forces}
    base = predictor.rows(setup) if lawful else None
    columns = []
    for number, item in enumerate(hypothesis.tolerances):
        if base is not None and item.joint in lawful:
            moved = hypothesis.add_effects(item.apply(tolerant, TOLERANCE_STEP))
            stepped = predictor.rows(moved) - base
            columns.append(stepped / np.float32(TOLERANCE_STEP))
            continue
        if item.kind == 'gain':
            changes = [np.zeros_like(reading) for reading in readings]
            for change, reading in zip(changes, readings, strict=True):
                row = gains.index(number)
                change[row] = reading[row] * item.sigma
        else:
            moved = hypothesis.add_effects(item.apply(tolerant, TOLERANCE_STEP))
            if item.kind == 'position':
                other = predictor.readings(predictor.sensors_moved(moved, systems), states)
                changes = [
                    (new - old) / TOLERANCE_STEP for new, old in zip(other, readings, strict=True)
                ]
            else:
                springs = item.kind == 'spring'
                push = None if springs else next(pushes, None)
                changes = arm.changes(moved, TOLERANCE_STEP, springs, push)
        columns.append(predictor.weighting.rows(predictor.seen_changes(arm.solved, changes)))
    return np.array(columns, dtype=np.float32)


class _ArmDerivative:
    """First-order change of the readings when the arm changes, by the direct method."""

    def __init__(self, setup: Setup, predictor: Predictor) -> None:
        self.predictor = predictor
        self.solved = predictor.solved(setup)
        systems, states = self.solved.systems, self.solved.states
        self.base = predictor.arms(setup.spec)
        names = systems[0].dof_names
        joints = tuple(dict.fromkeys(item.joint for item in setup.forces))
        places = np.array([joint_vector(predictor.model, joint, names) for joint in joints]).T
        self.setup, self.joints, self.places = setup, joints, places
        self.of_spring = {item.joint for item in setup.forces if item.law.of_spring}
        self.torques: list[Complex] = []
        follows = [  # torques on a measured twist stay when the arm changes
            all(
                predictor.local_torques.followed(item) is Follow.PREDICTED
                for item in setup.forces
                if item.joint == joint
            )
            for joint in joints
        ]
        self.open: list[Complex64] = []
        self.transfers: list[Complex64] = []
        for number, (state, group) in enumerate(zip(states, predictor.groups, strict=True)):
            system = systems[group]
            transfer: Complex = system.transfer(state.omega)
            self.open.append(transfer.astype(np.complex64))
            if joints:
                force = self.solved.torques.forces[number]
                torques = -np.linalg.lstsq(places.astype(complex), force)[0]
                self.torques.append(np.asarray(torques, dtype=complex))
                gains = [
                    equivalent_gain(torque, place @ state.deflection, state.omega) * waits
                    for torque, place, waits in zip(torques, places.T, follows, strict=True)
                ]
                transfer = closed_transfer(transfer, system, state.omega, places, gains)
            self.transfers.append(transfer.astype(np.complex64))

    def changes(
        self,
        moved: Setup,
        step: float,
        springs_only: bool = False,
        pushes: Sequence[Complex] | None = None,
    ) -> list[Complex]:
        """Return the change of the readings per prior standard deviation, one per record.

        Parameters
        ----------
        moved : Setup
            Not far away.
        step : float
            How far, in prior standard deviations.
        springs_only : bool
            Mass and inputs are those of the base.
        pushes : sequence of (n_dof, 3 n_bins) array or None
            Change of nonlinear torques, per record.
        """
        arms = self.predictor.arms(moved.spec, 1 if springs_only else None)
        stronger = [self._stronger(joint, moved) for joint in self.joints]
        found = []
        for index, (state, transfer, group) in enumerate(
            zip(self.solved.states, self.transfers, self.predictor.groups, strict=True)
        ):
            arm = arms[0 if springs_only else group]
            base = self.base[0 if springs_only else group]
            stiffness, damping = arm.K - base.K, arm.C - base.C
            force = -(stiffness @ state.deflection) - damping @ (
                1j * state.omega * state.deflection
            )
            if not springs_only:
                force += (arm.M - base.M) @ (state.omega**2 * state.deflection)
                force += (arm.inertia_input - base.inertia_input) @ state.acceleration
                force += (arm.shift_input - base.shift_input) @ state.shift
            if any(stronger):
                force -= (self.places * stronger) @ self.torques[index]
            change = _through(transfer, force / step)
            if pushes is not None:  # as the torques themselves say: no loop is to be closed
                change = change + _through(self.open[index], pushes[index] / step)
            found.append(hann(change.reshape(len(change), -1, 3).astype(complex)))
        return found

    def _stronger(self, joint: str, moved: Setup) -> float:
        """Return by which share a torque grows because the joint's spring does."""
        if joint not in self.of_spring:
            return 0.0
        now = joint_spring(self.setup.spec, joint).stiffness
        return joint_spring(moved.spec, joint).stiffness / now - 1.0


def _through(transfer: Complex64, force: Complex) -> Complex64:
    """Return readings under a force on few degrees of freedom."""
    small = force.astype(np.complex64)
    rows = np.flatnonzero(np.abs(small).max(axis=1) > 0.0)
    return np.asarray(np.einsum('cnb,nb->cb', transfer[:, rows], small[rows]))
