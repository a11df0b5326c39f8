"""What a map says, as ROS messages."""

from array import array
from collections.abc import Sequence
import math
from typing import TypeVar

from builtin_interfaces.msg import Time
import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import Header

from machining.lobes import Lobes
from oma_msgs.msg import Mode, PredictedModes, StabilityLimit
from workspace_map.arm import Arm
from workspace_map.live import ModesHere

Array = NDArray[np.float64]
Said = TypeVar('Said', PredictedModes, StabilityLimit)


def modes_message(arm: Arm, here: ModesHere) -> PredictedModes:
    """Return the modes at a pose."""
    found, tool = here.predicted, arm.tool
    message = PredictedModes(
        robot_name=arm.model.robot_name,
        known=True,
        channel_names=[channel.name for channel in arm.channels],
        tool_link=tool.link,
        tool_shape=_doubles(found.tool_shapes.T),
        tool_shape_std=_doubles(found.tool_shape_std.T),
        modal_mass_kg=_doubles(found.modal_mass_kg),
        modal_mass_std_kg=_doubles(found.modal_mass_std_kg),
    )
    message.tool_position = np.array(tool.position_m, dtype=float)
    message.modes = [_mode(here, row) for row in range(len(found))]
    return message


def limit_message(found: Lobes) -> StabilityLimit:
    """Return the limits of a cut at a pose."""
    chart, risk = found.charts[0], found.settings.risk
    limit = chart.limit
    safe = np.full(len(limit.speed_rpm), np.nan)
    if chart.sample is not None:
        safe = chart.safe_depth_m(risk)
    message = StabilityLimit(known=True, feed_deg=float(chart.feed_deg), risk=float(risk))
    message.spindle_speed_rpm = _doubles(limit.speed_rpm)
    message.limit_m = _doubles(limit.depth_m)
    message.safe_depth_m = _doubles(safe)
    best = found.proposals[0] if found.proposals else None
    message.proposed_speed_rpm = math.nan if best is None else float(best.speed_rpm)
    message.proposed_depth_m = math.nan if best is None else float(best.depth_m)
    return message


def placed(message: Said, header: Header, names: Sequence[str], position: Array) -> Said:
    """Return a message with the pose it is of."""
    message.header = header
    message.joint_names = list(names)
    message.joint_positions = _doubles(position)
    return message


def header_of(stamp: Time, frame: str) -> Header:
    """Return a header."""
    return Header(stamp=stamp, frame_id=frame)


def _mode(here: ModesHere, row: int) -> Mode:
    """Return one mode; its largest channel is 1, as an identified mode's."""
    found = here.predicted
    shape = found.channel_shapes[:, row]
    largest = shape[np.argmax(np.abs(shape))] if len(shape) else 1.0
    return Mode(
        id=int(here.ids[row]),
        frequency_hz=float(found.frequency_hz[row]),
        frequency_std_hz=float(found.frequency_std_hz[row]),
        damping_ratio=float(found.damping_ratio[row]),
        damping_ratio_std=float(found.damping_ratio_std[row]),
        shape_real=_doubles(shape / (largest or 1.0)),
        shape_imag=_doubles(np.zeros(len(shape))),
        mac_loss=math.nan,
        mac_loss_std=math.nan,
        mpc=1.0,
        mpd=0.0,
    )


def _doubles(values: Array) -> 'array[float]':
    return array('d', np.ascontiguousarray(values, dtype=np.float64).tobytes())
