"""What the nodes of every room share: quality of service, parameters, diagnostics, times."""

from collections.abc import Mapping
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from modal_core.measurements import NANOSECONDS_PER_SECOND

# The last value, also for those who come late.
LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


def parameter_descriptor(
    text: str,
    default: Any = None,
    span: tuple[float, float] | None = None,
    read_only: bool = False,
) -> ParameterDescriptor:
    """Return the descriptor of a parameter; ``span`` is the allowed range of a number.

    A ``default`` that is an int makes it a range of whole numbers, a float one of numbers.
    """
    descriptor = ParameterDescriptor(description=text, read_only=read_only)
    if span is None or isinstance(default, bool) or not isinstance(default, int | float):
        return descriptor
    low, high = span
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
