"""Torques in time as forces on the compared bins."""

import numpy as np
from numpy.typing import NDArray

from model_gap.joint_path import JointPath
from model_gap.pose_system import PoseSystem
from model_gap.ring_out import end_force
from model_gap.ripple import bins_of
from model_gap.spectra import RecordSpectra

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def force_spectra(torque: Array, path: JointPath, item: RecordSpectra) -> Complex:
    """Return the force on the degrees of freedom on a record's bins, (n_dof, 3 n_bins)."""
    count, steps = len(item.record.acceleration), len(torque)
    spectrum = np.fft.rfft(torque - torque.mean())
    turn = np.arange(len(spectrum)) / steps
    spectrum /= np.sinc(turn) * np.exp(1j * np.pi * turn)  # means over steps, to points in time
    places = bins_of(item)
    inside = places < len(spectrum)
    found = np.zeros(len(places), dtype=complex)
    found[inside] = spectrum[places[inside]] * (np.sqrt(count) / steps)
    return np.asarray(-path.vector[:, None] * found)


def whole_force(
    torque: Array, path: JointPath, item: RecordSpectra, system: PoseSystem
) -> Complex:
    """Return ``force_spectra`` less what the torque leaves ringing at the record's end."""
    period_s = 1.0 / path.steps_per_s
    return force_spectra(torque, path, item) + end_force(
        -torque, period_s, path.vector, item, system
    )
