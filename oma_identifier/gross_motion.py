"""Large motion of the joints when no model can predict what it does to the sensors.

The readings of a rigid arm are then only known in size: joint acceleration times an arm's length,
and gravity turned by the joint's angle.  Where that is as large as what was measured, a peak of
the spectrum may be the motion's own; no mode is reported there.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from modal_core.samples import Samples
from oma_identifier.joint_motion import JointMotion
from oma_identifier.rigid_motion import power_at, STANDS_OUT

GROSS_RAD = 0.1
"""Range of a joint in a window that self-excitation stays far below."""
LEVER_M = 2.0
GRAVITY_M_S2 = 9.81


def is_gross(motion: JointMotion) -> bool:
    """Tell whether a joint travels far."""
    return bool(np.ptp(motion.position, axis=0).max() > GROSS_RAD)


def explained_by_motion(
    samples: Samples,
    motion: JointMotion,
    frequency_hz: float,
    width_hz: float,
    shape: NDArray[np.complex128],
) -> bool:
    """Tell whether a peak is no larger than rigid motion may be.

    Parameters
    ----------
    samples : Samples
        One window.
    motion : JointMotion
        Of all joints in it.
    frequency_hz, width_hz : float [Hz]
        Place and half-power half-width of the peak.
    shape : (n_channels,) complex array [m/s²]
        Its direction.
    """
    rate = 1e9 / motion.period_ns
    if frequency_hz > 0.4 * rate:
        return False
    length = min(len(motion.acceleration), max(64, round(4.0 * rate / max(width_hz, 1e-3))))
    frequency, density = welch(motion.acceleration, rate, nperseg=length, axis=0)
    near = np.abs(frequency - frequency_hz) <= max(width_hz, rate / length)
    reach = LEVER_M + GRAVITY_M_S2 / (2.0 * np.pi * frequency_hz) ** 2
    # All sensors may move together, each with one of its three axes.
    n_sensors = max(1.0, len(shape) / 3.0)
    rigid = n_sensors * reach**2 * float(density[near].sum(axis=1).mean())
    unit = shape.conj() / np.linalg.norm(shape)
    return power_at(samples, frequency_hz, width_hz, unit) < STANDS_OUT * rigid
