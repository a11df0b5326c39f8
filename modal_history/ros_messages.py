"""Windows out of the identifier's messages."""

import math
from typing import Any

import numpy as np

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode, MODE_KEYS, ModeSet
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.window import Pose
from modal_history.kept import KeptWindow
from oma_msgs.msg import ChannelQuality as ChannelQualityMessage
from oma_msgs.msg import DataQuality as DataQualityMessage
from oma_msgs.msg import ModalParameters
from oma_msgs.msg import Mode as ModeMessage


def kept_window(
    message: ModalParameters, temperature_c: float = math.nan, load_kg: float = math.nan
) -> KeptWindow:
    """Return what is kept of a window.

    Raises
    ------
    ValueError, TypeError, OverflowError
        Nothing that an identifier sends.
    """
    start_ns = _nanoseconds(message.window_start)
    names = tuple(message.channel_names)
    modes = tuple(_mode(each, len(names)) for each in message.modes)
    return KeptWindow(
        index=message.window_index,
        start_ns=start_ns,
        end_ns=start_ns + _nanoseconds(message.window_length),
        modes=ModeSet(modes, names, message.method),
        quality=_quality(message.data_quality),
        pose=_pose(message),
        temperature_c=temperature_c,
        load_kg=load_kg,
    )


def _mode(message: ModeMessage, n_channels: int) -> Mode:
    there = message.get_fields_and_field_types()
    return Mode.from_values(
        {key: getattr(message, key) for key in MODE_KEYS if key in there}, n_channels
    )


def _quality(message: DataQualityMessage) -> DataQuality:
    return DataQuality(
        identifiable=message.identifiable,
        reason=message.reason,
        flags=tuple(message.flags),
        channels=tuple(map(_channel, message.channels)),
    )


def _channel(message: ChannelQualityMessage) -> ChannelQuality:
    told = {name: getattr(message, name) for name in message.get_fields_and_field_types()}
    return ChannelQuality(**{**told, 'flags': tuple(message.flags)})


def _pose(message: ModalParameters) -> Pose | None:
    position, spread = np.array(message.joint_positions), np.array(message.joint_position_ranges)
    names = tuple(message.joint_names)
    if not names or not len(names) == len(position) == len(spread):
        return None
    return Pose(names, position, spread)


def _nanoseconds(message: Any) -> int:
    return int(message.sec) * NANOSECONDS_PER_SECOND + int(message.nanosec)
