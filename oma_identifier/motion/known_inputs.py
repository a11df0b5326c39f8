"""The joint accelerations as known inputs beside the responses."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from oma_identifier.motion.joint_motion import JointMotion
from oma_identifier.time_axis import interpolate


def with_inputs(samples: Samples, motion: JointMotion | None, n_joints: int) -> Samples:
    """Return the samples with the accelerations of the joints as known inputs [rad/s²].

    NaN where no joint states cover the samples and fit them.
    """
    if motion is None:
        known = np.full((len(samples.acceleration), n_joints), np.nan)
    else:
        known = at_samples(motion.acceleration, motion, samples)
    return replace(samples, known=known)


def at_samples(
    values: NDArray[np.float64], motion: JointMotion, samples: Samples
) -> NDArray[np.float64]:
    """Return values at the joints' instants at those of the samples."""
    step_ns = NANOSECONDS_PER_SECOND / samples.sample_rate_hz
    place = (np.arange(len(samples.acceleration)) * step_ns - motion.origin_ns) / motion.period_ns
    cutoff = min(1.0, motion.period_ns / step_ns)
    return interpolate(values, np.clip(place, 0.0, len(values) - 1.0), cutoff)
