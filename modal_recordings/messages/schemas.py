"""Message definitions, without ROS: the standard ones from rosbags, ours from their .msg files."""

from functools import cache, lru_cache
from pathlib import Path

from rosbags.typesys import get_types_from_msg, get_typestore, Stores, TypesysError
from rosbags.typesys.store import Typestore

from modal_core.errors import RecordingError

PACKAGE = 'oma_msgs'
# An install copies oma_msgs/msg to this folder (setup.py); a source tree has the original.
SHIPPED = 'oma_msgs_definitions'
SEPARATOR = '=' * 80


@cache
def typestore() -> Typestore:
    """Return the types of ROS 2 Jazzy and of oma_msgs.

    Raises
    ------
    RecordingError
        The .msg files of oma_msgs are missing.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    types = {}
    for file in sorted(definitions_folder().glob('*.msg')):
        text = file.read_text(encoding='utf-8')
        types.update(get_types_from_msg(text, f'{PACKAGE}/msg/{file.stem}'))
    store.register(types)
    return store


@lru_cache(maxsize=256)
def definition(message_type: str) -> str:
    """Return the full definition of a message type in ros2msg form.

    Raises
    ------
    RecordingError
        Unknown type.
    """
    try:
        return typestore().generate_msgdef(message_type, ros_version=2)[0]
    except (TypesysError, KeyError) as error:
        raise RecordingError('unknown message type', found=message_type) from error


def differing_field(message_type: str, stored: str) -> str:
    """Compare the fields of a stored definition of a message of oma_msgs with ours.

    Returns
    -------
    str
        The first field that differs, as ``found ... expected ...``; empty when they agree.
    """
    # The file says it all: to know all types of ROS 2 takes longer than to read a short record.
    file = definitions_folder() / f'{message_type.rsplit("/", maxsplit=1)[-1]}.msg'
    ours, theirs = _fields(file.read_text(encoding='utf-8')), _fields(stored)
    for mine, other in zip(ours, theirs, strict=False):
        if mine != other:
            return f'found "{other}", expected "{mine}"'
    if len(ours) != len(theirs):
        longer = ours if len(ours) > len(theirs) else theirs
        verb = 'missing' if longer is ours else 'unexpected'
        return f'{verb} "{longer[min(len(ours), len(theirs))]}"'
    return ''


def message_fields() -> dict[str, tuple[str, ...]]:
    """Return the names of the fields of each message of oma_msgs, as this version defines them."""
    return {
        file.stem: tuple(line.split()[1] for line in _fields(file.read_text(encoding='utf-8')))
        for file in sorted(definitions_folder().glob('*.msg'))
    }


def definitions_folder() -> Path:
    """Return the folder of the oma_msgs .msg files: shipped with this room, or beside it.

    Never the installed package oma_msgs: its folder ``msg`` holds code, perhaps of other messages.

    Raises
    ------
    RecordingError
        It is nowhere to be found.
    """
    room = Path(__file__).resolve().parents[1]
    places = (room / SHIPPED, room.parent / PACKAGE / 'msg')
    for place in places:
        if any(place.glob('*.msg')):
            return place
    raise RecordingError(
        'message definitions not found',
        where=PACKAGE,
        expected=places[0],
        advice='the installation is incomplete: install the suite again',
    )


def _fields(text: str) -> list[str]:
    main = text.split(SEPARATOR, maxsplit=1)[0]
    lines = (line.split('#', maxsplit=1)[0] for line in main.splitlines())
    return [' '.join(line.split()) for line in lines if line.strip() and '=' not in line]
