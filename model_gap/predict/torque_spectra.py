"""Torques in time as forces on the compared bins."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import RecordSpectra
from model_gap.cell import PoseSystem
from model_gap.predict.joint_path import JointPath
from model_gap.predict.ring_out import end_force

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class SteppedTorque:
    """A torque in one joint of one record.

    Parameters
    ----------
    path : JointPath
        What it was stepped along.
    torque : (n_steps,) array [N m]
        Of the law.
    force : (n_dof, 3 n_bins) complex array
        On the deflections, ``whole_force``.
    """

    path: JointPath
    torque: Array
    force: Complex


def force_spectra(torque: Array, path: JointPath, item: RecordSpectra) -> Complex:
    """Return the force on the degrees of freedom on a record's bins, (n_dof, 3 n_bins)."""
    spectrum = _at_points(np.fft.rfft(torque - torque.mean()), len(torque))
    inside = item.places < len(spectrum)
    found = np.zeros(len(item.places), dtype=complex)
    scale = np.sqrt(len(item.record.acceleration)) / len(torque)
    found[inside] = spectrum[item.places[inside]] * scale
    return np.asarray(-path.vector[:, None] * found)


def sum_of_forces(stepped: Sequence[SteppedTorque]) -> Complex:
    """Return what torques of one record do together; of at least one."""
    return np.asarray(sum((item.force for item in stepped[1:]), stepped[0].force))


def long_spectrum(torque: Array, item: RecordSpectra) -> Complex:
    """Return a torque on the frequencies of a record's long motion, in units of its spectra."""
    omega = item.long_motion[0]
    found = np.zeros(len(omega), dtype=complex)
    spectrum = _at_points(np.fft.rfft(torque, 2 * len(torque)), 2 * len(torque))
    keep = min(len(found), len(spectrum))
    scale = len(item.record.motor_acceleration) / len(torque)
    found[:keep] = spectrum[:keep] * scale
    return found


def _at_points(spectrum: Complex, count: int) -> Complex:
    """Return the spectrum of values at the steps from that of means over the steps after them."""
    return np.asarray(spectrum / _mean_over_step(len(spectrum), count))


@lru_cache(maxsize=16)
def _mean_over_step(size: int, count: int) -> Complex:
    turn = np.arange(size) / count
    return np.asarray(np.sinc(turn) * np.exp(1j * np.pi * turn))


def whole_force(
    torque: Array, path: JointPath, item: RecordSpectra, system: PoseSystem
) -> Complex:
    """Return ``force_spectra`` less what the torque leaves ringing at the record's end."""
    period_s = 1.0 / path.steps_per_s
    return force_spectra(torque, path, item) + end_force(
        -torque, period_s, path.vector, item, system
    )
