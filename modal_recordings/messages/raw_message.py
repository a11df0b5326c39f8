"""What every recording of messages yields before decoding."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple, Protocol

from modal_recordings.messages.attachment import Attachment


class RawMessage(NamedTuple):
    """One serialised message.

    Parameters
    ----------
    topic, message_type : str
        As recorded; the type in ROS 2 form (``package/msg/Name``).
    log_time_ns : int [ns]
        When it was recorded.
    data : bytes
        As serialised.
    """

    topic: str
    message_type: str
    log_time_ns: int
    data: bytes


@dataclass(frozen=True, slots=True)
class TopicEntry:
    """A topic named in a recording.

    Parameters
    ----------
    name, message_type : str
        As recorded; the type in ROS 2 form.
    definition : str
        Message definition stored with it (ros2msg), empty when there is none.
    n_messages : int or None
        As the file's own index says.
    encoding : str
        Of its messages; empty or ``cdr`` for those of ROS 2.
    """

    name: str
    message_type: str
    definition: str = ''
    n_messages: int | None = None
    encoding: str = ''


# Log time [ns], topic and type, and data of a message: less to make than a ``RawMessage``.
Kept = tuple[int, tuple[str, str], bytes]
# Of files that are read message by message.
AT_ONCE = 1000


def one_by_one(bunches: Iterable[list[Kept]]) -> Iterator[RawMessage]:
    """Yield the messages of bunches."""
    for bunch in bunches:
        for log_time_ns, (topic, message_type), data in bunch:
            yield RawMessage(topic, message_type, log_time_ns, data)


def bunched(messages: Iterable[RawMessage]) -> Iterator[list[Kept]]:
    """Yield messages in bunches."""
    kept = ((log_ns, (topic, kind), data) for topic, kind, log_ns, data in messages)
    while bunch := list(islice(kept, AT_ONCE)):
        yield bunch


class MessageFile(Protocol):
    """A file or folder of serialised messages."""

    kind: str
    ros1: bool

    def topics(self) -> tuple[TopicEntry, ...]:
        """Return the topics it names."""

    def messages(self, topics: frozenset[str] | None = None) -> Iterator[RawMessage]:
        """Yield the messages of these topics (None: all) in log order."""

    def bunches(self, topics: frozenset[str] | None = None) -> Iterator[list[Kept]]:
        """Yield the same, many at once."""

    def attachments(self) -> tuple[Attachment, ...]:
        """Return the files it carries."""

    def damage(self) -> tuple[str, ...]:
        """Return what the last full pass could not read."""
