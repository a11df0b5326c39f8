"""How far joints travel in a recording, and what that leaves in it for a linear model.

An arm that travels moves by x = x₁ + x₂ + x₃ + …, x₁ the linear response about the mean pose.  Of
recordings x₂ is taken out (``linearised``), so that x₃ is what stays of the travel: its power in
units of the noise is what it adds to χ.  Of a way s it grows as s², its power as s⁴.

Measured on healthy arms of an independent simulator that sway by three sines of 0.1 to 0.4 Hz, χ
as told (with 1 of noise) and as found with tolerances fitted, means over four or eight
recordings: two axes ±0.6° 1.2 of 1.2, ±1.1° 3.7 of 7.4; a SCARA ±1.1° 1.0 of 1.0, ±2.3° 1.6 of 1.3
to 2.0, ±3.4° 4.4 of 4.1; six axes ±0.6° 1.3 of 0.9 to 1.1, ±1.1° 20 of 10.
"""

from dataclasses import dataclass
import itertools

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import (
    Band,
    CAMPAIGN,
    Complex,
    GapRecord,
    hann,
    record_spectra,
    RecordSpectra,
)
from model_gap.cell import CellModel, pose_system
from model_gap.predict.linearised import third_order
from structural_model import FlexibleJointModel

Array = NDArray[np.float64]
# Bins that say enough of a mean.
BINS = 80
# Places on the way, evenly in time, where the response is looked at.
PLACES = 24
# [rad] or [m] to either side: on so short a way no response of an arm changes so much.
SHORT = 5e-4


@dataclass(frozen=True)
class Changing:
    """What the travel of the joints in one record makes of it.

    Parameters
    ----------
    travel : (n_joints,) array [rad]
        From end to end, shaking left out.
    misfit, worst_misfit : float
        What it adds to χ: of all data, and of the band with most.
    """

    travel: Array
    misfit: float = 0.0
    worst_misfit: float = 0.0


def changing(
    record: GapRecord, model: FlexibleJointModel, cell: CellModel, band: Band
) -> Changing:
    """Return what the travel of a record's joints leaves in it for a linear model.

    Parameters
    ----------
    record : GapRecord
        As measured.
    model : FlexibleJointModel
        Gives kinematics.
    cell : CellModel
        The arm and its sensors.
    band : Band
        What is compared.
    """
    slow = slow_shift(record, band.low_hz)
    if np.abs(slow).max() < SHORT:
        return Changing(np.ptp(slow, axis=0))
    item = record_spectra(record, band, BINS)
    system = pose_system(model, record.pose, cell.channels)
    extra = third_order(record, model, cell, system, band.high_hz)
    spectrum = np.fft.rfft(extra, axis=0).T / np.sqrt(len(extra))
    moved = hann(spectrum[:, item.places.reshape(-1, 3)])
    misfit = item.squares(moved)[record.recorded]
    bands = [
        float(misfit[:, inside].mean())
        for low, high in itertools.pairwise(CAMPAIGN.band_edges_hz)
        if (inside := (item.frequency_hz >= low) & (item.frequency_hz < high)).any()
    ]
    return Changing(np.ptp(slow, axis=0), float(misfit.mean()), max(bands))


def slow_shift(record: GapRecord, low_hz: float) -> Array:
    """Return the way less the shaking: means over a period of the lowest frequency compared."""
    seconds = len(record.motor_shift) / record.sample_rate_hz
    parts = np.array_split(record.motor_shift, max(2, round(seconds * low_hz)))
    return np.array([part.mean(axis=0) for part in parts])


def response_change(
    record: GapRecord, model: FlexibleJointModel, cell: CellModel, band: Band
) -> float:
    """Return by what share of itself the response changes on the way, root mean square."""
    slow = slow_shift(record, band.low_hz)
    places = slow[np.unique(np.linspace(0, len(slow) - 1, PLACES).astype(int))]
    item = record_spectra(record, band, BINS)
    middle = _response(item, model, cell, record.pose)
    changes = [
        np.abs(_response(item, model, cell, record.pose + shift) - middle) ** 2 for shift in places
    ]
    return float(np.sqrt(np.sum(np.mean(changes, axis=0)) / np.sum(np.abs(middle) ** 2)))


def _response(
    item: RecordSpectra, model: FlexibleJointModel, cell: CellModel, pose: Array
) -> Complex:
    """Return what an arm about a pose reads of a motion, as if it went on and on."""
    system, omega = pose_system(model, pose, cell.channels), item.omega[:, 1]
    acceleration, shift = hann(item.motor_acceleration), hann(item.motor_shift)
    deflection = system.deflection(omega, system.force(acceleration, shift))
    return system.reading(omega, deflection, acceleration, shift)
