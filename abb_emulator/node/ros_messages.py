"""What the emulated cell publishes, as ROS messages."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from oma_msgs.msg import ModalParameters, Mode
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


def truth_message(
    model: FlexibleJointModel, pose: Array, channels: Sequence[Channel], rate_hz: float
) -> ModalParameters:
    """Return the true modes of a pose, at every channel, below half the sample rate."""
    found = model.damped_modes(pose, channels)
    message = ModalParameters(
        method='truth',
        channel_names=[channel.name for channel in channels],
        joint_names=list(model.joint_names),
        joint_positions=pose.tolist(),
    )
    message.data_quality.identifiable = True
    for index in np.flatnonzero(found.frequency_hz < rate_hz / 2.0):
        # Accelerations go with the displacement shape times s², one complex factor.
        shape = found.channel_shapes[:, index]
        shape = shape / shape[np.argmax(np.abs(shape))]
        message.modes.append(
            Mode(
                id=int(index) + 1,
                frequency_hz=float(found.frequency_hz[index]),
                frequency_std_hz=0.0,
                damping_ratio=float(found.damping_ratio[index]),
                damping_ratio_std=0.0,
                shape_real=shape.real.tolist(),
                shape_imag=shape.imag.tolist(),
                mpc=1.0,
                mpd=0.0,
            )
        )
    return message
