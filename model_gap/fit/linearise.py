"""Derivatives of the prediction by all numbers, as real rows weighted by the noise."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Complex, hann, Rows
from model_gap.cell import CellModel, joint_spring, plain_joint
from model_gap.fit.thresholds import FIT
from model_gap.hypothesis import Hypothesis
from model_gap.predict import ArmChange, Predictor, stacked, static_twist

Array = NDArray[np.float64]
Complex64 = NDArray[np.complex64]


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
    cells, steps = [], []
    for number, scale in enumerate(hypothesis.prior_scale):
        inner = hypothesis.inner.copy()
        step = FIT.effect_step * scale
        item = hypothesis.parameters[number]
        if item.inner(item.high) - inner[number] < step:
            step = -step
        inner[number] += step
        moved = hypothesis.moved(hypothesis.tolerance_values, inner).add_effects(tolerant)
        if not slow[number]:
            moved = replace(moved, forces=(), held=held)
        cells.append(moved)
        steps.append(step / scale)
    stepped = [cell for cell, waits in zip(cells, slow, strict=True) if waits]
    waiting = iter(predictor.predict_many(stepped) if stepped else [])
    n_dof = predictor.arm(now.spec).n_dof

    def freed(cell: CellModel) -> bool:
        """Return whether the step gives way where nothing did: there is no change of matrices."""
        return predictor.arm(cell.spec).n_dof != n_dof

    arm: _ArmDerivative | None = None
    columns = []
    for cell, waits, step in zip(cells, slow, steps, strict=True):
        if waits or cell.spec == now.spec or _turned(cell, now) or freed(cell):
            spectra = next(waiting) if waits else predictor.predict(cell)
            columns.append((predictor.weighting.rows(spectra) - base) / np.float32(step))
            continue
        if arm is None:
            arm = _ArmDerivative(now, predictor)
        changes = predictor.seen_changes(arm.solved, arm.changes(cell, step))
        columns.append(predictor.weighting.rows(changes))
    return np.array(columns, dtype=np.float32).reshape(len(columns), len(base))


def _turned(one: CellModel, other: CellModel) -> bool:
    """Return whether joints stand otherwise: what sensors see then changes with the arm."""
    return [item.offset_rad for item in one.spec.joints] != [
        item.offset_rad for item in other.spec.joints
    ]


def _mixed(hypothesis: Hypothesis) -> bool:
    """Return whether torques in time stand beside effects that can do without."""
    return len({effect.amplitude_dependent for effect in hypothesis.effects}) > 1


def tolerance_columns(hypothesis: Hypothesis, predictor: Predictor) -> Rows:
    """Return derivatives by the tolerances, per prior standard deviation, as rows.

    To first order a changed arm is the present one under the force (dB a + dP q) -
    (dM x'' + dC x' + dK x), so that one transfer per record serves all tolerances.  Torques are
    stepped again along the twist that this force changes; those that see a measured twist stay,
    and where their drive is changed all is predicted anew.  What rings on after the record is
    held as it is: x and x' at the end, times the changed masses and dampers.

    An equivalent spring and damper (Caughey 1963, doi:10.1121/1.1918794) is no derivative: with
    it fits of a stop came to rest far from the most probable values, with half the deviation.

    References
    ----------
    Fox and Kapoor (1968), doi:10.2514/3.5008, for the direct method of sensitivities.
    """
    tolerant = hypothesis.tolerant
    cell = hypothesis.add_effects(tolerant)
    arm = _ArmDerivative(cell, predictor)
    solved, tolerances = arm.solved, hypothesis.tolerances
    local = predictor.local_torques
    anew = {plain_joint(force.joint) for force in cell.forces if not local.is_predicted(force)}
    turned = any(item.kind == 'pose' for item in tolerances)
    base = predictor.rows(cell) if anew or turned else np.zeros(0, dtype=np.float32)
    gains = [number for number, item in enumerate(tolerances) if item.kind == 'gain']

    def column(number: int) -> Rows:
        item = tolerances[number]
        if item.kind == 'gain':
            changes = [np.zeros_like(reading) for reading in solved.readings]
            for change, reading in zip(changes, solved.readings, strict=True):
                row = gains.index(number)
                change[row] = reading[row] * item.sigma
            return predictor.weighting.rows(predictor.seen_changes(solved, changes))
        moved = hypothesis.add_effects(item.apply(tolerant, FIT.tolerance_step))
        if item.joint in anew or item.kind == 'pose':
            return (predictor.rows(moved) - base) / np.float32(FIT.tolerance_step)
        if item.kind == 'sensor':
            systems = predictor.sensors_moved(moved, solved.systems)
            readings = predictor.posed.readings(systems, solved.states)
            changes = [
                (new - old) / FIT.tolerance_step
                for new, old in zip(readings, solved.readings, strict=True)
            ]
        else:
            changes = arm.changes(moved, FIT.tolerance_step, item.kind == 'spring')
        return predictor.weighting.rows(predictor.seen_changes(solved, changes))

    numbers = range(len(tolerances))
    if cell.forces:  # else it is done before others could begin
        return np.array(side_by_side(column, numbers), dtype=np.float32)
    return np.array([column(number) for number in numbers], dtype=np.float32)


class _ArmDerivative:
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
            stacked(
                state.omega,
                state.deflection,
                state.acceleration,
                state.shift,
                (state.end_shift, state.end_speed),
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
                shared[key] = systems[key[0]].transfer(state.omega)
        self.transfers = [shared[key] for key in keys]

    def changes(self, moved: CellModel, step: float, springs_only: bool = False) -> list[Complex]:
        """Return the change of the readings per prior standard deviation, one per record.

        Parameters
        ----------
        moved : CellModel
            Not far away.
        step : float
            How far, in prior standard deviations.
        springs_only : bool
            Mass and inputs are those of the base, the same change at all poses; not of an arm
            that hangs far in its springs, and elsewhere in others.
        """
        springs_only = springs_only and not self.hangs_far
        arms = self.predictor.arms(moved.spec, 1 if springs_only else None)
        changes = [ArmChange.between(one, two) for one, two in zip(self.base, arms, strict=False)]
        twists = self._twists_at_rest(moved)
        found = []
        for motion, transfer, following, group in zip(
            self.motions, self.transfers, self.following, self.predictor.groups, strict=True
        ):
            arm = changes[0 if springs_only else group]
            force = arm.force(motion)
            for number, torque in enumerate(following):
                stiffness = joint_spring(moved.spec, torque.law.joint).stiffness
                # Of two poses that count as one each record has its own twist: only what changes.
                heavier = twists[group][number] - self.at_rest[group][number]
                force += torque.push(arm, stiffness, heavier)
            change = _through(transfer, force / np.float32(step))
            found.append(hann(change.reshape(len(change), -1, 3).astype(complex)))
        if self.hangs_far:
            turned = self.predictor.sensors_moved(moved, self.solved.systems)
            readings = self.predictor.posed.readings(turned, self.solved.states)
            for moving, new, old in zip(found, readings, self.solved.readings, strict=True):
                moving += (new - old) / step
        return found

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


def _through(transfer: Complex64, force: Complex64) -> Complex64:
    """Return readings under a force on few degrees of freedom."""
    rows = np.flatnonzero(force.any(axis=1))
    return np.asarray(np.einsum('cnb,nb->cb', transfer[:, rows], force[rows]))
