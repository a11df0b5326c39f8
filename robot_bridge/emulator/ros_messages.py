"""What the emulated cell publishes, as ROS messages."""

from array import array
from collections.abc import Iterator, Mapping, Sequence

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Imu

from modal_core.channel import Channel
from oma_msgs.msg import AccelerationBlock, ModalParameters, Mode
from robot_bridge.emulator.cell import SensorBlock
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
NANOSECONDS = 1_000_000_000
LARGEST_BLOCK_BYTES = 64_000
UNKNOWN = [-1.0, *[0.0] * 8]


def stamp(time_ns: int) -> Time:
    """Return a time as a message."""
    sec, nanosec = divmod(time_ns, NANOSECONDS)
    return Time(sec=sec, nanosec=nanosec)


def block_messages(
    block: SensorBlock, names: Sequence[str], rate_hz: float, start_ns: int
) -> Iterator[AccelerationBlock]:
    """Return a block as one or more messages that stay below the size of a datagram."""
    largest = max(LARGEST_BLOCK_BYTES // (4 * len(names)), 1)
    for first in range(0, len(block.acceleration), largest):
        rows = np.ascontiguousarray(block.acceleration[first : first + largest])
        message = AccelerationBlock(
            first_index=block.first_index + first,
            n_samples=len(rows),
            sample_rate_hz=rate_hz,
            channel_names=list(names),
        )
        # The first row is the end of the first step.
        time_s = (block.first_index + first + 1) / rate_hz
        message.header.stamp = stamp(start_ns + round(time_s * NANOSECONDS))
        message.header.frame_id = 'abb_emulator'
        message.acceleration = array('f', rows.tobytes())
        yield message


def imu_messages(
    block: SensorBlock, columns: slice, frame_id: str, rate_hz: float, start_ns: int
) -> Iterator[Imu]:
    """Return one message per sample: three accelerations, then three angular velocities."""
    for row, values in enumerate(block.acceleration[:, columns].astype(float).tolist()):
        message = Imu(orientation_covariance=UNKNOWN)
        time_s = (block.first_index + row + 1) / rate_hz
        message.header.stamp = stamp(start_ns + round(time_s * NANOSECONDS))
        message.header.frame_id = frame_id
        force, turn = message.linear_acceleration, message.angular_velocity
        force.x, force.y, force.z, turn.x, turn.y, turn.z = values
        yield message


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


def status_message(
    name: str, code: str, warn: bool, values: Mapping[str, object]
) -> DiagnosticStatus:
    """Return one diagnostic with its figures as text."""
    return DiagnosticStatus(
        name=name,
        level=DiagnosticStatus.WARN if warn else DiagnosticStatus.OK,
        message=code,
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )
