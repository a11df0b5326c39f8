"""The EGM wire format: proto2 messages built at run time in a private descriptor pool.

Field and message names are not on the wire, so the package name here is our own: two libraries
that both register ``egm.proto`` in the process-wide pool collide, and an own pool with an own
package cannot.  All ``repeated double`` are unpacked, as proto2 has it, and presence is explicit:
a zero ``seqno`` is still sent, which strict receivers insist on.

References
----------
ABB application manual Externally Guided Motion, 3HAC073318-001.
"""

from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import Message

PACKAGE = 'autonomous_modal_analysis.egm'
LARGEST_DATAGRAM_BYTES = 65535
MAX_JOINTS = 6

MESSAGE_TYPE_DATA = 2
MESSAGE_TYPE_CORRECTION = 3
MOTORS_ON, MOTORS_OFF = 1, 2
MCI_UNDEFINED, MCI_ERROR, MCI_STOPPED, MCI_RUNNING = 0, 1, 2, 3
RAPID_UNDEFINED, RAPID_STOPPED, RAPID_RUNNING = 0, 1, 2

_Field = descriptor_pb2.FieldDescriptorProto
_SCALARS = {
    'double': _Field.TYPE_DOUBLE,
    'uint32': _Field.TYPE_UINT32,
    'uint64': _Field.TYPE_UINT64,
    'bool': _Field.TYPE_BOOL,
}
_LABELS = {
    '': _Field.LABEL_OPTIONAL,
    'required': _Field.LABEL_REQUIRED,
    'repeated': _Field.LABEL_REPEATED,
}

_ENUMS = {
    'MessageType': ('UNDEFINED', 'COMMAND', 'DATA', 'CORRECTION', 'PATH_CORRECTION'),
    'MotorStateType': ('UNDEFINED', 'ON', 'OFF'),
    'MciStateType': ('UNDEFINED', 'ERROR', 'STOPPED', 'RUNNING'),
    'RapidStateType': ('UNDEFINED', 'STOPPED', 'RUNNING'),
}

# message: {field: (number, type, label)}
_MESSAGES: dict[str, dict[str, tuple[int, str, str]]] = {
    'EgmHeader': {
        'seqno': (1, 'uint32', ''),
        'tm': (2, 'uint32', ''),
        'mtype': (3, 'MessageType', ''),
    },
    'EgmCartesian': {axis: (i, 'double', 'required') for i, axis in enumerate('xyz', 1)},
    'EgmQuaternion': {f'u{i}': (i + 1, 'double', 'required') for i in range(4)},
    'EgmEuler': {axis: (i, 'double', 'required') for i, axis in enumerate('xyz', 1)},
    'EgmClock': {'sec': (1, 'uint64', 'required'), 'usec': (2, 'uint64', 'required')},
    'EgmPose': {
        'pos': (1, 'EgmCartesian', ''),
        'orient': (2, 'EgmQuaternion', ''),
        'euler': (3, 'EgmEuler', ''),
    },
    'EgmCartesianSpeed': {'value': (1, 'double', 'repeated')},
    'EgmJoints': {'joints': (1, 'double', 'repeated')},
    'EgmPlanned': {
        'joints': (1, 'EgmJoints', ''),
        'cartesian': (2, 'EgmPose', ''),
        'externalJoints': (3, 'EgmJoints', ''),
        'time': (4, 'EgmClock', ''),
    },
    'EgmSpeedRef': {
        'joints': (1, 'EgmJoints', ''),
        'cartesians': (2, 'EgmCartesianSpeed', ''),
        'externalJoints': (3, 'EgmJoints', ''),
    },
    'EgmFeedBack': {
        'joints': (1, 'EgmJoints', ''),
        'cartesian': (2, 'EgmPose', ''),
        'externalJoints': (3, 'EgmJoints', ''),
        'time': (4, 'EgmClock', ''),
    },
    'EgmMotorState': {'state': (1, 'MotorStateType', 'required')},
    'EgmMCIState': {'state': (1, 'MciStateType', 'required')},
    'EgmRapidCtrlExecState': {'state': (1, 'RapidStateType', 'required')},
    'EgmTestSignals': {'signals': (1, 'double', 'repeated')},
    'EgmRobot': {
        'header': (1, 'EgmHeader', ''),
        'feedBack': (2, 'EgmFeedBack', ''),
        'planned': (3, 'EgmPlanned', ''),
        'motorState': (4, 'EgmMotorState', ''),
        'mciState': (5, 'EgmMCIState', ''),
        'mciConvergenceMet': (6, 'bool', ''),
        'testSignals': (7, 'EgmTestSignals', ''),
        'rapidExecState': (8, 'EgmRapidCtrlExecState', ''),
        # measuredForce = 9 differs between RobotWare 6 and 7: never read, never sent.
        'utilizationRate': (10, 'double', ''),
        'moveIndex': (11, 'uint32', ''),
    },
    'EgmSensor': {
        'header': (1, 'EgmHeader', ''),
        'planned': (2, 'EgmPlanned', ''),
        'speedRef': (3, 'EgmSpeedRef', ''),
    },
}


def file_descriptor() -> descriptor_pb2.FileDescriptorProto:
    """Return the messages as a protobuf file descriptor, for logs that carry their schema."""
    file = descriptor_pb2.FileDescriptorProto(
        name=f'{PACKAGE}.proto', package=PACKAGE, syntax='proto2'
    )
    for name, values in _ENUMS.items():
        enum = file.enum_type.add(name=name)
        for number, value in enumerate(values):
            # Enum values share the scope of the package, hence the prefix.
            enum.value.add(name=f'{name}_{value}', number=number)
    for name, fields in _MESSAGES.items():
        message = file.message_type.add(name=name)
        for field_name, (number, kind, label) in fields.items():
            field = message.field.add(name=field_name, number=number, label=_LABELS[label])
            if kind in _SCALARS:
                field.type = _SCALARS[kind]
            else:
                field.type = _Field.TYPE_ENUM if kind in _ENUMS else _Field.TYPE_MESSAGE
                field.type_name = f'.{PACKAGE}.{kind}'
    return file


def _build() -> dict[str, type[Message]]:
    pool = descriptor_pool.DescriptorPool()
    pool.AddSerializedFile(file_descriptor().SerializeToString())
    make: Any = getattr(message_factory, 'GetMessageClass', None)
    if make is None:  # protobuf 3.21, the one of Ubuntu 24.04
        factory: Any = message_factory.MessageFactory(pool)
        make = factory.GetPrototype
    return {name: make(pool.FindMessageTypeByName(f'{PACKAGE}.{name}')) for name in _MESSAGES}


_CLASSES = _build()
# Any: the classes exist at run time only.
EgmRobot: Any = _CLASSES['EgmRobot']
EgmSensor: Any = _CLASSES['EgmSensor']
