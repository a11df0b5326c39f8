"""Results as ROS messages.

What comes in is decoded in batches by `modal_recordings/decode.py`.
"""

import array
from typing import Any

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import AccelStamped, AccelWithCovarianceStamped
import numpy as np
from sensor_msgs.msg import Imu, JointState

from modal_core.errors import MessageError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_core.nodes.ros_messages import stamp
from modal_core.quality import ChannelQuality, DataQuality
from modal_recordings.messages import ACCEL, ACCEL_WITH_COVARIANCE, BLOCK, IMU, JOINT_STATE
from oma_identifier.result import WindowResult
from oma_identifier.tracking import PredictedMode, Prediction
from oma_msgs.msg import (
    AccelerationBlock,
    ModalParameters,
    PredictedModes,
    StabilisationDiagram,
)
from oma_msgs.msg import (
    ChannelQuality as ChannelQualityMessage,
)
from oma_msgs.msg import (
    DataQuality as DataQualityMessage,
)
from oma_msgs.msg import (
    Mode as ModeMessage,
)

MOST_MODES = 500
MESSAGE_CLASSES = {
    IMU: Imu,
    ACCEL: AccelStamped,
    ACCEL_WITH_COVARIANCE: AccelWithCovarianceStamped,
    BLOCK: AccelerationBlock,
    JOINT_STATE: JointState,
}


def modal_parameters(result: WindowResult, base_frame: str, n_skipped: int) -> ModalParameters:
    """Return the modes of a window; lines of machines follow them, marked as harmonic."""
    message = ModalParameters()
    message.header.stamp = stamp(result.end_ns)
    message.header.frame_id = base_frame
    message.window_index = max(0, result.index)
    message.window_start = stamp(result.start_ns)
    seconds, nanoseconds = divmod(result.end_ns - result.start_ns, NANOSECONDS_PER_SECOND)
    message.window_length = Duration(sec=seconds, nanosec=nanoseconds)
    message.method = result.modes.method
    if result.pose is not None:
        message.joint_names = list(result.pose.joint_names)
        message.joint_positions = _doubles(result.pose.position)
        message.joint_position_ranges = _doubles(result.pose.position_range)
    message.channel_names = list(result.modes.channel_names)
    message.modes = [mode_message(mode) for mode in (*result.modes, *result.harmonics)]
    message.data_quality = quality_message(result.quality, n_skipped)
    return message


def prediction_from(message: PredictedModes) -> Prediction:
    """Return the modes that a map expects at a pose; none where it does not know it.

    Raises
    ------
    MessageError
        Naming the field that is too long, not finite, or does not fit the others.
    """
    joints = np.array(message.joint_positions, dtype=float)
    names = tuple(message.joint_names)
    if len(joints) != len(names) or not np.isfinite(joints).all():
        raise MessageError('not a pose', where='PredictedModes.joint_positions', found=len(joints))
    if len(message.modes) > MOST_MODES:
        raise MessageError(
            'too long', where='PredictedModes.modes', found=len(message.modes), expected=MOST_MODES
        )
    channels = tuple(message.channel_names)
    modes = [_predicted(mode, len(channels)) for mode in message.modes]
    return Prediction(names, joints, channels, tuple(modes))


def _predicted(mode: ModeMessage, n_channels: int) -> PredictedMode:
    shape = np.array(mode.shape_real, dtype=float)
    numbers = np.array([mode.frequency_hz, mode.frequency_std_hz])
    if len(shape) != n_channels or not np.isfinite([*shape, *numbers]).all():
        raise MessageError('not a mode', where='PredictedModes.modes', found=f'id {mode.id}')
    if not (numbers > 0.0).all() or not mode.id:
        raise MessageError('not a mode', where='PredictedModes.modes', found=f'id {mode.id}')
    return PredictedMode(mode.id, numbers[0], numbers[1] / numbers[0], shape)


def mode_message(mode: Mode) -> ModeMessage:
    """Return one mode."""
    values, kinds = mode.values(), ModeMessage.get_fields_and_field_types()
    return ModeMessage(**{name: _sent(values[name], kind) for name, kind in kinds.items()})


def _sent(value: Any, kind: str) -> Any:
    """Return a value of a mode as its message takes it; an array that is not known is empty."""
    if kind == 'sequence<double>':
        return _doubles(np.empty(0) if value is None else value)
    return {'double': float, 'uint32': int, 'boolean': bool}[kind](value)


def quality_message(quality: DataQuality, n_skipped: int) -> DataQualityMessage:
    """Return the health of a window."""
    return DataQualityMessage(
        identifiable=quality.identifiable,
        reason=quality.reason,
        flags=list(quality.flags),
        n_windows_skipped=n_skipped,
        channels=[_channel_quality(channel) for channel in quality.channels],
    )


def _channel_quality(channel: ChannelQuality) -> ChannelQualityMessage:
    return ChannelQualityMessage(
        name=channel.name,
        n_interpolated=int(channel.n_interpolated),
        n_lost=int(channel.n_lost),
        n_duplicates=int(channel.n_duplicates),
        n_reordered=int(channel.n_reordered),
        measured_rate_hz=float(channel.measured_rate_hz),
        jitter_std_s=float(channel.jitter_std_s),
        rms=float(channel.rms),
        kurtosis=float(channel.kurtosis),
        noise_rms=float(channel.noise_rms),
        excluded=bool(channel.excluded),
        flags=list(channel.flags),
    )


def stabilisation_diagram(result: WindowResult, base_frame: str) -> StabilisationDiagram:
    """Return all poles of a window and the spectrum behind them."""
    message = StabilisationDiagram()
    message.header.stamp = stamp(result.end_ns)
    message.header.frame_id = base_frame
    message.window_index = max(0, result.index)
    poles, spectrum = result.poles, result.spectrum
    message.model_order = array.array('H', poles.model_order.astype(np.uint16).tobytes())
    message.frequency_hz = _doubles(poles.frequency_hz)
    message.damping_ratio = _doubles(poles.damping_ratio)
    message.status = array.array('B', poles.status.astype(np.uint8).tobytes())
    ids = [0, *(mode.id for mode in result.modes)]
    numbered = [ids[row] if 0 <= row < len(ids) else 0 for row in poles.mode_id.tolist()]
    message.mode_id = array.array('I', numbered)
    message.spectrum_frequency_hz = _doubles(spectrum.frequency_hz)
    message.spectrum_singular_value = _doubles(spectrum.singular_value.ravel())
    shape = spectrum.singular_value.shape
    message.spectrum_n_values = int(shape[1]) if len(shape) == 2 else 0
    return message


def _doubles(values: np.ndarray) -> 'array.array[float]':
    return array.array('d', np.ascontiguousarray(values, dtype=np.float64).tobytes())
