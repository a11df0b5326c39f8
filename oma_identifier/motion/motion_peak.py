"""Whether a peak of the responses is one of the joints' own motion, and no mode.

Near one frequency a rigid arm reads its joints' accelerations times constants, in phase with
them.  A mode cannot be written so: across its peak the phase turns by half a circle.  The
responses along the shape of a peak are therefore fitted by the joint accelerations times one real
gain each and one phase for all, which also covers a delay of the joint states.  No model of the
arm is needed; where one took rigid motion out, what its own error may leave is no mode either.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from modal_core.numbers.indicators import rotate_to_real
from modal_core.samples import Samples
from oma_identifier.motion.joint_motion import JointMotion
from oma_identifier.motion.thresholds import MOTION


def is_motion(
    measured: Samples,
    left: Samples,
    motion: JointMotion,
    frequency_hz: float,
    width_hz: float,
    shape: NDArray[np.complex128],
) -> bool:
    """Tell whether the motion of the joints alone makes a peak.

    Parameters
    ----------
    measured, left : Samples
        One window before and after removal of rigid motion; the same where none was removed.
    motion : JointMotion
        Of all joints in it.
    frequency_hz, width_hz : float [Hz]
        Place and half-power half-width of the peak.
    shape : (n_channels,) complex array [m/s²]
        Its direction.
    """
    if frequency_hz * motion.period_ns * 1e-9 > MOTION.highest:
        return False
    duration_s = left.duration_s
    reach = max(MOTION.fewest_lines, round(MOTION.half_widths * width_hz * duration_s))
    middle = round(frequency_hz * duration_s)
    lines = np.arange(max(1, middle - reach), middle + reach + 1)
    along = rotate_to_real((shape / np.linalg.norm(shape))[:, None])[:, 0].real
    joints = _transform(motion, lines / duration_s, duration_s)
    after = _response(left, along)[lines]
    if _explained(after, joints) > MOTION.explained:
        return True
    if measured is left:
        return False
    before = _response(measured, along)[lines]
    faint = np.sum(np.abs(after) ** 2) < MOTION.model_error * np.sum(np.abs(before) ** 2)
    return bool(faint) and _explained(before, joints) > MOTION.explained


def _response(samples: Samples, along: NDArray[np.float64]) -> NDArray[np.complex128]:
    signal = np.concatenate([part @ along for part in samples.stretches()])
    taper = _taper(np.arange(len(signal), dtype=float) / len(signal))
    lines = rfft((signal - signal.mean()) * taper) / samples.sample_rate_hz
    return np.asarray(lines, dtype=complex)


def _transform(
    motion: JointMotion, frequency_hz: NDArray[np.float64], duration_s: float
) -> NDArray[np.complex128]:
    """Return the Fourier transform of the joint accelerations under the same taper."""
    period_s = motion.period_ns * 1e-9
    time = motion.origin_ns * 1e-9 + period_s * np.arange(len(motion.acceleration), dtype=float)
    tapered = motion.acceleration * _taper(time / duration_s)[:, None]
    lines = np.exp(-2j * np.pi * np.outer(frequency_hz, time)) @ (tapered * period_s)
    return np.asarray(lines, dtype=complex)


def _taper(place: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.sin(np.pi * np.clip(place, 0.0, 1.0)) ** 2)


def _explained(response: NDArray[np.complex128], joints: NDArray[np.complex128]) -> float:
    """Return the share of the power that real gains with a common phase explain."""
    power = float(np.sum(np.abs(response) ** 2))
    if power == 0.0:
        return 1.0
    stacked = np.concatenate([joints.real, joints.imag])
    left, values, _ = np.linalg.svd(stacked, full_matrices=False)
    basis = left[:, values > 1e-6 * max(values[0], 1e-300)]
    turned = -1j * response
    both = np.column_stack(
        [
            np.concatenate([response.real, response.imag]),
            np.concatenate([turned.real, turned.imag]),
        ]
    )
    inside = basis.T @ both
    # The best phase is the leading direction of the two quadratures.
    return float(np.linalg.eigvalsh(inside.T @ inside)[-1] / power)
