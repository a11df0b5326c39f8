"""The joint accelerations as known inputs beside the responses."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.errors import IdentificationError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from oma_identifier.motion.joint_motion import JointMotion
from oma_identifier.time_axis import interpolate

PREFIX = 'joint acceleration '


def with_inputs(samples: Samples, motion: JointMotion | None) -> Samples:
    """Return the samples with a column per joint more, its acceleration [rad/s²].

    Raises
    ------
    IdentificationError
        No joint states cover the samples.
    """
    if motion is None:
        raise IdentificationError(
            "csi needs the joints' motion",
            found='no joint states that cover the window and fit its responses',
            advice='use ssi_cov, or record joint states',
        )
    accelerations = at_samples(motion.acceleration, motion, samples)
    names = (Channel(f'{PREFIX}{joint}') for joint in range(accelerations.shape[1]))
    return replace(
        samples,
        acceleration=np.concatenate([samples.acceleration, accelerations], axis=1),
        channels=(*samples.channels, *names),
    )


def split_inputs(samples: Samples) -> tuple[Samples, NDArray[np.float64] | None]:
    """Return responses and inputs; None when there are none."""
    known = np.array([name.startswith(PREFIX) for name in samples.channel_names])
    if not known.any():
        return samples, None
    channels = tuple(c for c, other in zip(samples.channels, known, strict=True) if not other)
    inputs = samples.widened(columns=np.flatnonzero(known))
    responses = samples.acceleration[:, ~known]
    return replace(samples, acceleration=responses, channels=channels), inputs


def at_samples(
    values: NDArray[np.float64], motion: JointMotion, samples: Samples
) -> NDArray[np.float64]:
    """Return values at the joints' instants at those of the samples."""
    step_ns = NANOSECONDS_PER_SECOND / samples.sample_rate_hz
    place = (np.arange(len(samples.acceleration)) * step_ns - motion.origin_ns) / motion.period_ns
    cutoff = min(1.0, motion.period_ns / step_ns)
    return interpolate(values, np.clip(place, 0.0, len(values) - 1.0), cutoff)
