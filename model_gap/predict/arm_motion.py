"""How the arm moves in every record: by its motors, known torques, and tones that fit the rest."""

from collections.abc import Sequence
import dataclasses
from functools import partial

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex, hann, RecordSpectra
from model_gap.cell import CellModel, PoseSystem
from model_gap.predict.driven import driven_motion
from model_gap.predict.local_torques import Torques
from model_gap.predict.posed_records import PosedRecords
from model_gap.predict.ripple import ripple_force
from model_gap.predict.solved import RecordState, Solved
from model_gap.predict.tone import best_motion, tone_motions


def arm_motion(
    posed: PosedRecords, cell: CellModel, systems: list[PoseSystem], torques: Torques
) -> Solved:
    """Solve for the motion of the arm under a cell.

    Parameters
    ----------
    posed : PosedRecords
        What was recorded.
    cell : CellModel
        Inputs, forces and outputs.
    systems : list of PoseSystem
        The arm of the cell, per pose.
    torques : Torques
        The nonlinear torques of the cell.
    """
    states = [
        _state(posed, index, cell, systems[group], torques)
        for index, group in enumerate(posed.groups)
    ]
    patterns: list[NDArray[np.float64]] = []
    if cell.tones:
        states, patterns = _with_tones(posed, cell, systems, states)
    readings = posed.readings(systems, states)
    return Solved(cell, systems, torques, states, readings, patterns)


def _state(
    posed: PosedRecords, index: int, cell: CellModel, system: PoseSystem, torques: Torques
) -> RecordState:
    """Return the motion of one record, without tones."""
    item = posed.records[index]
    omega = item.omega.ravel()
    motion = driven_motion(item, cell)
    force = system.force(motion.acceleration, motion.shift)
    for ripple in cell.ripples:
        force = force + ripple_force(ripple, item, posed.model, cell.spec, system)
    for torque in cell.held:
        rows = [system.dof_names.index(name) for name in torque.dof_names]
        force[rows] += torque.spectra[index]
    if torques.forces:
        force = force + torques.forces[index]
    ringing = system.end_state(motion.tail, 1.0 / item.record.sample_rate_hz) * item.end_scale
    deflection = system.deflection(omega, force, ringing)
    shift, speed = ((system.shapes @ modal).real for modal in (ringing, system.poles * ringing))
    return RecordState(omega, motion.acceleration, motion.shift, deflection, shift, speed)


def _with_tones(
    posed: PosedRecords,
    cell: CellModel,
    systems: Sequence[PoseSystem],
    states: Sequence[RecordState],
) -> tuple[list[RecordState], list[NDArray[np.float64]]]:
    """Add to every record the tones that fit what is left of it best."""
    found, patterns = [], []
    readings = posed.outputs(cell, posed.readings(systems, states))
    for item, group, state, reading in zip(
        posed.records, posed.groups, states, readings, strict=True
    ):
        seen = partial(_seen, cell, item, systems[group])
        kinds = tone_motions(cell.tones, item, systems[group], posed.model)
        rest = item.measured - reading
        motion, own = best_motion(cell.tones, kinds, item, seen, rest)
        patterns.append(own)
        found.append(dataclasses.replace(state, deflection=state.deflection + motion))
    return found, patterns


def _seen(cell: CellModel, item: RecordSpectra, system: PoseSystem, motion: Complex) -> Complex:
    """Return what the sensors read of a deflection while the motors stand still."""
    omega = item.omega.ravel()
    still = np.zeros((system.rigid.shape[1], len(omega)), dtype=complex)
    raw = system.reading(omega, motion, still, still)
    return cell.seen(item.omega[:, 1], hann(raw.reshape(len(raw), -1, 3)))
