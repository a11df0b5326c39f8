"""The response of a recording to the known motion of its motors, on neighbouring bins."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Band, Complex, GapRecord, record_spectra, RecordSpectra
from model_gap.cell import CellModel
from model_gap.modes.thresholds import LIMITS
from model_gap.predict import driven_motion

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DrivenResponse:
    """Spectra of motors and sensors.

    Parameters
    ----------
    omega : (n_bins, 3) array [rad/s]
        Neighbouring bins, each with its own neighbours.
    acceleration, shift : (n_joints, n_bins, 3) complex array
        Of the motors, rectangular window.
    response : (n_channels, n_bins) complex array
        Hann window.
    noise_power : (n_channels, n_bins) array
        Of the response, as far as it is known.
    channels : (n_channels,) array of int
        Which of all channels these are.
    """

    omega: Array
    acceleration: Complex
    shift: Complex
    response: Complex
    noise_power: Array
    channels: NDArray[np.intp]


def driven_response(
    record: GapRecord, band: Band, cell: CellModel, lines_hz: Sequence[float]
) -> DrivenResponse:
    """Return the response of a recording in a band.

    Parameters
    ----------
    record : GapRecord
        Sensors and motors.
    band : Band
        Whose bins are all taken.
    cell : CellModel
        What is known to stand before the motors and behind the arm: delays.
    lines_hz : sequence of float [Hz]
        Of machines; the bins around them are left out.

    Raises
    ------
    RecordingError
        The sensors are too slow for the band.
    """
    item = record_spectra(record, band, target_bins=len(record.acceleration))
    width = LIMITS.near_bins * record.sample_rate_hz / len(record.acceleration)
    near = [np.abs(item.frequency_hz - line) <= width for line in lines_hz]
    bins = np.flatnonzero(~np.any([np.zeros(len(item.omega), dtype=bool), *near], axis=0))
    own = record.recorded[item.measured[record.recorded].any(axis=1)]
    motion = driven_motion(item, cell)
    acceleration, shift = (
        values.reshape(item.motor_acceleration.shape)[:, bins]
        for values in (motion.acceleration, motion.shift)
    )
    return DrivenResponse(
        omega=item.omega[bins],
        acceleration=acceleration,
        shift=shift,
        response=_before_sensors(item, cell, own)[:, bins],
        noise_power=item.noise_power[np.ix_(own, bins)],
        channels=own,
    )


def _before_sensors(item: RecordSpectra, cell: CellModel, own: NDArray[np.intp]) -> Complex:
    """Return what sensors read less what depends on frequency in them: delays, their mounts."""
    omega, measured = item.omega[:, 1], item.measured[own]
    if not cell.outputs:
        return measured
    through = np.zeros((len(omega), len(own), len(own)), dtype=complex)
    for column, channel in enumerate(own):
        alone = np.zeros(item.measured.shape, dtype=complex)
        alone[channel] = 1.0
        through[:, :, column] = cell.seen(omega, alone)[own].T
    before = np.linalg.solve(through, measured.T[:, :, None])
    return np.asarray((through[len(omega) // 2] @ before)[:, :, 0].T)
