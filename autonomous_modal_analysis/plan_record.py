"""A plan as a message in a recording, without ROS: what was played, beside what came of it."""

from typing import Any

import numpy as np

from excitation_planner.plan import ExcitationPlan
from modal_core.measurements import NANOSECONDS_PER_SECOND
from recordings.message_recording import MessageRecording
from recordings.raw_message import RawMessage
from recordings.schemas import typestore

PLAN = 'oma_msgs/msg/ExcitationPlan'
PLAN_TOPIC = '/excitation_planner/excitation_plan'


def plan_message(plan: ExcitationPlan, time_ns: int) -> RawMessage:
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
    for message in recording.file.messages(frozenset({PLAN_TOPIC})):
        plan: Any = typestore().deserialize_cdr(message.data, PLAN)
        return str(plan.plan_hash)
    return ''
