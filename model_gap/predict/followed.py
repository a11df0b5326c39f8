"""The twist of a joint as measured: what a torque law is tried on when it follows the recording.

Play makes the motion of an arm chaotic: nothing predicts it for longer than some seconds, however
well the arm is known.  The law is then evaluated on the twist that the sensors tell of, and only
below a few hertz, where accelerations tell little, on the predicted one.  Other laws are tried
like this before they are fitted: what they say of the measured twist is nearly linear in their
parameters, however far off those are.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
import scipy.fft

from model_gap.campaign import HANN_POWER, RecordSpectra, smoothed
from model_gap.cell import CellModel, PoseSystem
from model_gap.laws import Follow
from model_gap.predict.thresholds import PREDICTION

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
PARTING_1_S = np.array(PREDICTION.parting_1_s)


def predicted_share(s: Complex) -> Complex:
    """Return L(s), the share of the predicted twist; 1 - L falls as s³ below the parting."""
    return np.asarray(1.0 - np.prod(s[..., None] / (s[..., None] + PARTING_1_S), axis=-1))


def measured_share(omega: Array, follow: Follow) -> Complex:
    """Return the share of the measured twist, (n,)."""
    if follow is Follow.PARTED:
        return 1.0 - predicted_share(np.asarray(1j * omega))
    ratio = (omega / PREDICTION.least_1_s) ** 8
    return np.asarray(ratio / (1.0 + ratio) + 0j)


def parting_residues() -> Array:
    """Return ρ_i of L(s) = Σ ρ_i / (s + a_i)."""
    a = PARTING_1_S
    gaps = a - a[:, None] + np.eye(len(a))  # a_j - a_i
    return np.asarray(a**3 / np.prod(gaps, axis=1))


def free_torques(
    item: RecordSpectra, system: PoseSystem, places: Sequence[Array], cell: CellModel
) -> tuple[Complex, Array]:
    """Return the torques that explain best what the sensors read, and their noise power.

    Both (n_places, n), on the frequencies of ``item.long_motion``, in units of its spectra.

    Parameters
    ----------
    item : RecordSpectra
        The record.
    system : PoseSystem
        The arm at its pose.
    places : sequence of (n_dof,) array
        Twist per deflection; the arm feels the negative of the torque.
    cell : CellModel
        Gives the steps before the motors and behind the sensors.
    """
    record = item.record
    count = len(record.acceleration)
    omega, *motion = item.long_motion
    acceleration, shift = cell.driven(omega, *motion)
    deflection = system.deflection(omega, system.force(acceleration, shift))
    readings = system.reading(omega, deflection, acceleration, shift)
    paths = np.array([system.response(omega, -place) for place in places])
    own = record.recorded
    readings = cell.seen(omega, readings)[own]
    paths = np.array([cell.seen(omega, path)[own] for path in paths])
    # In single precision, far finer than the noise.
    linear = scipy.fft.irfft(readings.astype(np.complex64), 2 * count)[:, :count]
    read = record.acceleration[:, own]
    rest = (read - read.mean(axis=0)).T.astype(np.float32) - linear
    fade = min(count, round(PREDICTION.fade_s * record.sample_rate_hz))
    rest[:, count - fade :] *= 0.5 + 0.5 * np.cos(np.pi * np.arange(fade) / fade)
    measured = scipy.fft.rfft(rest, 2 * count)[:, : len(omega)]
    bins = item.omega[:, 1]
    noise = (
        count
        / HANN_POWER
        * np.array([np.interp(omega, bins, power) for power in item.noise_power[own]])
    )
    weighted = paths.conj() / noise
    gram = np.einsum('pcb,qcb->bpq', weighted, paths)
    pull = np.einsum('pcb,cb->bp', weighted, measured)
    size = len(places)
    sure = np.einsum('bpp->bp', gram).real
    # Prior power of every torque: what its estimate has beyond the noise, frequency by frequency.
    alone = np.abs(pull / np.maximum(sure, 1e-300)) ** 2
    power = smoothed(alone - 1.0 / np.maximum(sure, 1e-300), np.arange(len(alone)))
    gram += np.eye(size) / np.maximum(power, 1e-3 * alone.max(axis=0) * 1e-9)[:, :, None]
    spread = np.linalg.inv(gram)
    torques = np.einsum('bpq,bq->pb', spread, pull)
    return torques, np.einsum('bpp->pb', spread).real
