"""Read a rosbag2 folder: several files in a row, also when its metadata is missing."""

from collections.abc import Iterator, Sequence
from pathlib import Path
import re

from modal_core.errors import RecordingError, SettingsError
from modal_core.files.real_path import real_path
from modal_core.files.small_file import read_text
from modal_core.files.yaml_file import parse_yaml
from modal_recordings.containers.bag_file import BagFile
from modal_recordings.containers.mcap_file import McapFile
from modal_recordings.messages import (
    Attachment,
    Kept,
    MessageFile,
    one_by_one,
    RawMessage,
    TopicEntry,
)

LARGEST_METADATA_BYTES = 4_000_000
"""A thousand topics, or ten thousand files."""


class FileSequence:
    """Several files of one recording, read one after the other.

    Parameters
    ----------
    files : sequence of MessageFile
        In the order they were recorded.
    lost : tuple of str
        What could not be opened.
    """

    kind = 'rosbag2'
    ros1 = False

    def __init__(self, files: Sequence[MessageFile], lost: tuple[str, ...] = ()) -> None:
        self.files = tuple(files)
        self.lost = lost

    def topics(self) -> tuple[TopicEntry, ...]:
        """Return the topics of all files, counts added."""
        entries: dict[str, TopicEntry] = {}
        for file in self.files:
            for entry in file.topics():
                before = entries.get(entry.name)
                n_messages = (entry.n_messages or 0) + (before.n_messages or 0 if before else 0)
                entries[entry.name] = TopicEntry(
                    entry.name, entry.message_type, entry.definition, n_messages, entry.encoding
                )
        return tuple(entries[name] for name in sorted(entries))

    def messages(self, topics: frozenset[str] | None = None) -> Iterator[RawMessage]:
        """Yield the messages of all files."""
        return one_by_one(self.bunches(topics))

    def bunches(self, topics: frozenset[str] | None = None) -> Iterator[list[Kept]]:
        """Yield the same, many at once."""
        for file in self.files:
            yield from file.bunches(topics)

    def attachments(self) -> tuple[Attachment, ...]:
        """Return the files that the first file with any carries."""
        return next(filter(None, (file.attachments() for file in self.files)), ())

    def damage(self) -> tuple[str, ...]:
        """Return what the last full pass could not read."""
        return (*self.lost, *(statement for file in self.files for statement in file.damage()))


def open_folder(path: Path) -> MessageFile:
    """Open a rosbag2 folder.

    Raises
    ------
    RecordingError
        No recording in it, or none that can be opened.
    """
    kinds: tuple[tuple[str, type[McapFile] | type[BagFile]], ...] = (
        ('*.mcap', McapFile),
        ('*.db3', BagFile),
    )
    whole = (path / 'metadata.yaml').exists()
    for pattern, kind in kinds:
        parts = sorted(
            (part for part in path.glob(pattern) if _inside(part, path)), key=_natural_order
        )
        if not parts:
            continue
        if whole and kind is BagFile:
            break
        return _open_parts(parts, kind)
    if whole:
        _check_metadata(path / 'metadata.yaml')
        return BagFile(path)
    raise RecordingError(
        'no recording in this folder',
        where=path,
        expected='metadata.yaml with .mcap or .db3 files',
    )


def _check_metadata(path: Path) -> None:
    """Refuse metadata that would keep the reader of bags busy for hours."""
    try:
        parse_yaml(read_text(path, LARGEST_METADATA_BYTES), path, LARGEST_METADATA_BYTES)
    except SettingsError as error:
        raise RecordingError(
            error.what, where=error.where, found=error.found, expected=error.expected
        ) from error


def _open_parts(parts: Sequence[Path], kind: type[McapFile] | type[BagFile]) -> FileSequence:
    files: list[MessageFile] = []
    errors: list[RecordingError] = []
    for part in parts:
        try:
            files.append(kind(part))
        except RecordingError as error:
            errors.append(error)
    if not files:
        raise errors[0]
    return FileSequence(files, tuple(str(error) for error in errors))


def _inside(part: Path, folder: Path) -> bool:
    """Refuse links that lead out of the folder."""
    return real_path(part).is_relative_to(real_path(folder))


def _natural_order(path: Path) -> tuple[object, ...]:
    return tuple(int(word) if word.isdigit() else word for word in re.split(r'(\d+)', path.name))
