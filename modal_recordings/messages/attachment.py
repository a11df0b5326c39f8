"""Files that travel inside a recording: the robot, its sensors, the software that wrote it."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from modal_core.channel import LAYOUT_FILE, SensorLayout
from modal_core.errors import RecordingError, SettingsError
from modal_core.files.atomic_file import atomic_path
from modal_core.files.yaml_file import parse_yaml
from modal_core.layouts.shipped_layouts import PLAIN_NAME

SOFTWARE = 'software.txt'
LARGEST_BYTES = 5_000_000
"""As long as a URDF may be; beyond, an attachment is named and not read."""
MEDIA_TYPES = {'.urdf': 'application/xml', '.yaml': 'application/yaml', '.txt': 'text/plain'}
LONGEST_LINE = 200
"""Letters that are shown of what a writer says of itself; this software's 32 are all of it."""


@dataclass(frozen=True, slots=True)
class Attachment:
    """A file inside a recording.

    Parameters
    ----------
    name, media_type : str
        As the recording says; an untrusted one may say anything.
    n_bytes : int
        Its size.
    data : bytes
        Its content; empty where there is a problem.
    problem : str
        Why it is not read; empty when it is.
    """

    name: str
    media_type: str
    n_bytes: int
    data: bytes = b''
    problem: str = ''


def media_type(name: str) -> str:
    """Return the media type of a file by its ending."""
    return MEDIA_TYPES.get(Path(name).suffix, 'application/octet-stream')


def attached(attachments: Iterable[Attachment], name: str) -> bytes | None:
    """Return the content of the first attachment of a name that was read; None without one."""
    return next(
        (each.data for each in attachments if each.name == name and not each.problem), None
    )


def attached_software(attachments: Iterable[Attachment]) -> str:
    """Return which software wrote a recording, in one line; empty where it does not say."""
    text = (attached(attachments, SOFTWARE) or b'').decode('utf-8', errors='replace')
    return ' '.join(text.split())[:LONGEST_LINE]


def attached_layout(attachments: Iterable[Attachment], where: str) -> SensorLayout | None:
    """Return the sensor layout that a recording carries; None without one.

    Raises
    ------
    SettingsError, LayoutError
        It is no YAML in UTF-8, or no layout.
    """
    data = attached(attachments, LAYOUT_FILE)
    if data is None:
        return None
    place = f'{where}: {LAYOUT_FILE}'
    return SensorLayout.from_mapping(parse_yaml(as_text(data, place), place), place)


def as_text(data: bytes, where: str) -> str:
    """Return the text of an attachment.

    Raises
    ------
    SettingsError
        It is not UTF-8.
    """
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        raise SettingsError('not UTF-8', where=where) from error


def save_attachments(attachments: Iterable[Attachment], folder: Path, where: object) -> list[Path]:
    """Write what a recording carries into a folder, each under its name; nothing is replaced.

    Returns
    -------
    list of Path
        What was written: of several of one name the first.

    Raises
    ------
    RecordingError
        One cannot be read, or has a name that is no plain file name, or that is there already;
        then none is written.
    OSError
        The folder cannot be written to.
    """
    chosen: dict[str, Attachment] = {}
    for each in attachments:
        chosen.setdefault(each.name, each)
    for each in chosen.values():
        if each.problem:
            raise RecordingError(f'attachment {each.problem}', where=where, found=each.name[:100])
        if not PLAIN_NAME.fullmatch(each.name):
            raise RecordingError(
                'attachment without a plain file name', where=where, found=repr(each.name[:100])
            )
        if (folder / each.name).exists():
            raise RecordingError('is there already', where=folder / each.name)
    for each in chosen.values():
        with atomic_path(folder / each.name) as path:
            path.write_bytes(each.data)
    return [folder / name for name in chosen]
