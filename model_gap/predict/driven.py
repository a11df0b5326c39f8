"""The motors' motion behind what changes it: a late command, a servo that lags."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import RecordSpectra, tail_of
from model_gap.cell import CellModel
from model_gap.predict.ripple import transform_at

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class DrivenMotion:
    """Motor motion of one record, as it drives the arm.

    Parameters
    ----------
    acceleration, shift : (n_joints, 3 n_bins) complex array
        On the record's flattened triples.
    tail : (n_block, n_blocks, 2 n_joints) array [rad/s²], [rad]
        As ``RecordSpectra.tail``.
    """

    acceleration: Complex
    shift: Complex
    tail: NDArray[np.float64]


def driven_motion(item: RecordSpectra, cell: CellModel) -> DrivenMotion:
    """Return the motion of a record behind the inputs' steps.

    They act on the motion in time, which starts at rest: what a delay moves past the end of the
    record does not come in again at its start.
    """
    if not cell.inputs:
        joints = len(item.motor_acceleration)
        return DrivenMotion(
            item.motor_acceleration.reshape(joints, -1),
            item.motor_shift.reshape(joints, -1),
            item.tail,
        )
    record = item.record
    count = len(record.motor_acceleration)
    acceleration, shift = (
        np.fft.irfft(spectrum, 2 * count, axis=1)[:, :count]
        for spectrum in cell.driven(*item.whole_motion)
    )
    return DrivenMotion(
        np.array([transform_at(row, item) for row in acceleration]),
        np.array([transform_at(row, item) for row in shift]),
        tail_of(acceleration.T, shift.T, record.sample_rate_hz),
    )
