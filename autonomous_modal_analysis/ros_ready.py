"""Whether what nodes need is installed: ROS, and the messages of this version."""

from importlib import import_module

from autonomous_modal_analysis.missing import explain, INSTALL_MESSAGES, MESSAGES, MissingError
from modal_recordings.messages import message_fields


def require_ros() -> None:
    """Refuse what starts nodes, or is one, where they cannot run.

    Raises
    ------
    MissingError
        ROS is not installed, or the messages are not or are those of another version.
    """
    try:
        import_module('rclpy')
        installed = import_module(f'{MESSAGES}.msg')
        if installed.__file__ is None:
            raise ImportError('only their definitions are here', name=MESSAGES)
    except ImportError as error:
        raise explain(error) or error from error
    for name, fields in message_fields().items():
        message = getattr(installed, name, None)
        found = tuple(message.get_fields_and_field_types()) if message else ()
        if found != fields:
            other = sorted(set(found) ^ set(fields)) or fields
            raise MissingError(
                'the messages oma_msgs that are installed are those of another version',
                where=f'{MESSAGES}/{name}' if message else MESSAGES,
                found=f'differing fields {", ".join(other)}' if message else f'no {name}',
                advice=INSTALL_MESSAGES,
            )
