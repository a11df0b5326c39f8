"""A plan as a message in a recording, without ROS: what was played, beside what came of it."""

from collections.abc import Iterator
from typing import Any, TYPE_CHECKING

import numpy as np

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_recordings.message_recording import MessageRecording
from modal_recordings.messages import differing_field, RawMessage, typestore
from modal_recordings.open_recording import Recording
from oma_identifier.covariance import sharp_edge_hz

if TYPE_CHECKING:
    # The planner brings the robot's model with it, which reading a recording does without.
    from excitation_planner.plan import ExcitationPlan

PLAN = 'oma_msgs/msg/ExcitationPlan'
PLAN_TOPIC = '/excitation_planner/excitation_plan'


def plan_message(plan: 'ExcitationPlan', time_ns: int) -> RawMessage:
    """Return the serialised message of a plan, as the planner publishes it."""
    types = typestore().types
    seconds, nanoseconds = divmod(time_ns, NANOSECONDS_PER_SECOND)
    stamp = types['builtin_interfaces/msg/Time'](sec=seconds, nanosec=nanoseconds)
    fields: dict[str, Any] = {
        'header': types['std_msgs/msg/Header'](stamp=stamp, frame_id=''),
        'joint_names': list(plan.joint_names),
        'n_samples': plan.n_samples,
    }
    kind: Any = types[PLAN]
    for name in kind.__dataclass_fields__:
        if name in fields or name.startswith('__'):
            continue
        value = getattr(plan, name)
        fields[name] = np.ravel(value) if isinstance(value, np.ndarray) else value
    return RawMessage(
        PLAN_TOPIC, PLAN, time_ns, bytes(typestore().serialize_cdr(kind(**fields), PLAN))
    )


def recorded_plan_hash(recording: MessageRecording) -> str:
    """Return the hash of the plan a recording holds; empty without one."""
    return next((str(plan.plan_hash) for plan in _plans(recording)), '')


def recorded_robot_name(recording: Recording) -> str:
    """Return the robot that the plans in a recording are for; empty without one, or of several."""
    if not isinstance(recording, MessageRecording):
        return ''
    names = {str(plan.robot_name) for plan in _plans(recording)}
    return names.pop() if len(names) == 1 else ''


def recorded_edge_hz(recording: Recording) -> float | None:
    """Return where the excitation of the plans in a recording ends, the highest of several.

    None where there is no plan, or one whose excitation does not end at an edge.
    """
    if not isinstance(recording, MessageRecording):
        return None
    highest_hz = None
    for plan in _plans(recording):
        edge_hz = sharp_edge_hz(str(plan.signal), float(plan.band_high_hz))
        if edge_hz is None:
            return None
        highest_hz = max(edge_hz, highest_hz or 0.0)
    return highest_hz


def _plans(recording: MessageRecording) -> Iterator[Any]:
    """Yield the plans of a recording, on whatever topic; none of another definition."""
    topics = frozenset(
        entry.name
        for entry in recording.entries
        if entry.message_type == PLAN
        and not (entry.definition and differing_field(PLAN, entry.definition))
    )
    if not topics:
        return
    for message in recording.file.messages(topics):
        yield typestore().deserialize_cdr(message.data, PLAN)
