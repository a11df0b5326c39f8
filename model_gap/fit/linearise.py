"""Derivatives of the prediction by all numbers, as real rows weighted by the noise."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Complex, Rows
from model_gap.cell import CellModel, plain_joint
from model_gap.fit.arm_derivative import ArmDerivative
from model_gap.fit.thresholds import FIT
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor, Solved

Array = NDArray[np.float64]
# Columns that one process works out at once, where torques are stepped for each.
AT_ONCE = 8


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

    arm: ArmDerivative | None = None
    columns = []
    for cell, waits, step in zip(cells, slow, steps, strict=True):
        if waits or cell.spec == now.spec or _turned(cell, now) or freed(cell):
            spectra = next(waiting) if waits else predictor.predict(cell)
            columns.append((predictor.weighting.rows(spectra) - base) / np.float32(step))
            continue
        if arm is None:
            arm = ArmDerivative(now, predictor)
        (change,) = arm.changes([cell], step)
        changes = predictor.seen_changes(arm.solved, change)
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
    arm = ArmDerivative(cell, predictor)
    solved, tolerances = arm.solved, hypothesis.tolerances
    local = predictor.local_torques
    anew = {plain_joint(force.joint) for force in cell.forces if not local.is_predicted(force)}
    turned = any(item.kind == 'pose' for item in tolerances)
    base = predictor.rows(cell) if anew or turned else np.zeros(0, dtype=np.float32)
    gains = [number for number, item in enumerate(tolerances) if item.kind == 'gain']

    def moved(number: int) -> CellModel:
        return hypothesis.add_effects(tolerances[number].apply(tolerant, FIT.tolerance_step))

    def is_anew(number: int) -> bool:
        item = tolerances[number]
        return item.kind == 'pose' or item.joint in anew

    def of_gain(number: int) -> list[Complex]:
        changes = [np.zeros_like(reading) for reading in solved.readings]
        for change, reading in zip(changes, solved.readings, strict=True):
            row = gains.index(number)
            change[row] = reading[row] * tolerances[number].sigma
        return changes

    def some(numbers: Sequence[int]) -> list[Rows]:
        """Return some of the columns, those of one kind at once."""
        of_kind = {
            'spring': partial(arm.changes, step=FIT.tolerance_step, springs_only=True),
            'spec': partial(arm.changes, step=FIT.tolerance_step),
            'sensor': partial(_sensor_changes, solved, predictor),
        }
        changes: dict[int, list[Complex]] = {}
        for kind, changes_of in of_kind.items():
            own = [n for n in numbers if tolerances[n].kind == kind and not is_anew(n)]
            if own:
                changes |= zip(own, changes_of([moved(number) for number in own]), strict=True)
        columns = []
        for number in numbers:
            if is_anew(number):
                rows = predictor.rows(moved(number))
                columns.append((rows - base) / np.float32(FIT.tolerance_step))
                continue
            change = changes[number] if number in changes else of_gain(number)
            columns.append(predictor.weighting.rows(predictor.seen_changes(solved, change)))
        return columns

    numbers = range(len(tolerances))
    if not cell.forces:  # it is done before others could begin
        return np.array(some(numbers), dtype=np.float32)
    parts = [numbers[first : first + AT_ONCE] for first in numbers[::AT_ONCE]]
    found = side_by_side(some, parts)
    return np.array([column for part in found for column in part], dtype=np.float32)


def _sensor_changes(
    solved: Solved, predictor: Predictor, cells: Sequence[CellModel]
) -> list[list[Complex]]:
    """Return the change of the readings where sensors are moved, per cell and record."""
    cell = solved.cell
    places = [
        (number, row)
        for number, moved in enumerate(cells)
        for row, channel in enumerate(moved.channels)
        if channel != cell.channels[row]
    ]
    channels = tuple(cells[number].channels[row] for number, row in places)
    systems = predictor.sensors_moved(replace(cell, channels=channels), solved.systems)
    found: list[list[Complex]] = [[] for _ in cells]
    readings = predictor.posed.readings(systems, solved.states)
    for old, new in zip(solved.readings, readings, strict=True):
        changes = np.zeros((len(cells), *old.shape), dtype=complex)
        for (number, row), reading in zip(places, new, strict=True):
            changes[number, row] = (reading - old[row]) / FIT.tolerance_step
        for own, change in zip(found, changes, strict=True):
            own.append(change)
    return found
