"""What the nodes of every room share: quality of service, parameters, diagnostics, times."""

from collections.abc import Iterable, Mapping
import time
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.settings.near_names import refuse_unknown
from modal_core.settings.node_parameter import is_of_ros, NodeParameter

LISTS: dict[type | None, Parameter.Type] = {
    str: Parameter.Type.STRING_ARRAY,
    float: Parameter.Type.DOUBLE_ARRAY,
}
# The last value, also for those who come late.
LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
# Of an identifier, none left out where they come faster than they are taken.
RESULTS = QoSProfile(
    depth=100,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


def declare_parameters(node: Node, parameters: Iterable[NodeParameter]) -> None:
    """Declare a node's parameters, and refuse what it was given that is none of them.

    Parameters
    ----------
    node : Node
        It declares nothing else.
    parameters : iterable of NodeParameter
        All it has.

    Raises
    ------
    SettingsError
        A parameter file or ``-p`` names another parameter: ROS would pass over it in silence.
    ParameterException
        A value of another type, or out of range.
    """
    known = tuple(parameters)
    # rclpy has no public word for "given, but not declared".
    given: Mapping[str, Any] = node._parameter_overrides
    refuse_unknown(
        (name for name in given if not is_of_ros(name)),
        [item.name for item in known],
        what='unknown parameter',
        where=node.get_fully_qualified_name(),
    )
    for item in known:
        # An empty list has no type on the wire: its type is declared, not a value.
        empty = item.default == ()
        default = list(item.default) if item.many else item.default
        node.declare_parameter(
            item.name, LISTS[item.kind] if empty else default, _descriptor(item)
        )


def parameter_mapping(node: Node, parameters: Iterable[NodeParameter]) -> dict[str, Any]:
    """Return the values of a node's parameters; a list that is not set is empty."""
    found = {}
    for item in parameters:
        value = node.get_parameter_or(item.name, Parameter(item.name)).value
        found[item.name] = [] if value is None else value
    return found


def _descriptor(item: NodeParameter) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(description=item.text, read_only=item.read_only)
    default = item.default
    if item.span is None or isinstance(default, bool) or not isinstance(default, int | float):
        return descriptor
    low, high = item.span
    descriptor.additional_constraints = f'{low:g} to {high:g}'
    if isinstance(default, int):
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    else:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high))
        ]
    return descriptor


def diagnostic(
    name: str,
    code: str,
    level: bytes = DiagnosticStatus.OK,
    values: Mapping[str, object] | None = None,
    hardware_id: str = '',
) -> DiagnosticStatus:
    """Return one diagnostic with its figures as text."""
    return DiagnosticStatus(
        name=name,
        level=level,
        message=code,
        hardware_id=hardware_id,
        values=[KeyValue(key=key, value=str(value)) for key, value in (values or {}).items()],
    )


def stamp(time_ns: int) -> Time:
    """Return a time [ns] as a message."""
    sec, nanosec = divmod(time_ns, NANOSECONDS_PER_SECOND)
    return Time(sec=sec, nanosec=nanosec)


def heard_s(info: Mapping[str, Any]) -> float:
    """Return when a message was received, on this machine's steady clock [s].

    A process that stood still takes late what waited for it: by this it is as old as it is.

    Parameters
    ----------
    info : mapping
        That came with the message.
    """
    age_s = (time.time_ns() - info['received_timestamp']) / NANOSECONDS_PER_SECOND
    return time.monotonic() - max(age_s, 0.0)
