"""A file or folder of ROS messages as a recording."""

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from copy import deepcopy
from functools import cached_property
import heapq
from operator import attrgetter
from pathlib import Path

from modal_core.errors import RecordingError
from modal_core.measurements import Measurement, NANOSECONDS_PER_SECOND
from modal_core.spindle_speed import SpindleSpeed
from modal_recordings.contents import RecordingInfo, summarise, why_unusable
from modal_recordings.mark import cut, high_stretch, mark_pieces, Stretch
from modal_recordings.messages import (
    Attachment,
    decode,
    first_stamp,
    log_times_mislead,
    MessageFile,
    RawMessage,
    side_by_side,
    USABLE_TYPES,
)
from modal_recordings.spindle_speed import (
    speed_of_channel,
    speed_of_topic,
    speed_topic,
    without_channel,
)

BATCH_NS = NANOSECONDS_PER_SECOND // 4
LARGEST_BATCH_BYTES = 16_000_000
TOGETHER = 64
"""Messages of one topic that are decoded at once where stamps tell the order: a third of a second
of a sensor at 200 Hz."""


class MessageRecording:
    """Measurements out of recorded messages.

    Parameters
    ----------
    path : Path
        File or folder.
    file : MessageFile
        Its messages.
    topics : sequence of str or None
        Only these; None: every topic of a usable type.
    to_look : bool
        Open it also when it has no usable topic, to see what it is.
    mark : str or None
        Channel that is high while the robot moves; only that part is yielded.
    spindle : str or None
        Topic or channel of the spindle's speed; None: the usual topic, where it is there.

    Raises
    ------
    RecordingError
        A topic that is not there or of no use, or no usable topic at all; lists the usable ones.

    Attributes
    ----------
    fraction_read : float
        How much of its messages the last pass has read, 0..1.
    """

    def __init__(
        self,
        path: Path,
        file: MessageFile,
        topics: Sequence[str] | None = None,
        to_look: bool = False,
        mark: str | None = None,
        spindle: str | None = None,
    ) -> None:
        self.path = path
        self.kind = file.kind
        self.file = file
        self.entries = file.topics()
        self.fraction_read = 0.0
        self.left_out: tuple[str, ...] = ()
        self._mark = mark
        self._spindle = spindle
        self._stretch: Stretch | None = None
        self.n_refused: dict[str, int] = {}
        self.refused: dict[str, str] = {}
        self._speed_topic = speed_topic(self.entries, spindle)
        usable = {entry.name for entry in self.entries if not why_unusable(entry)}
        self.selected = frozenset(usable if topics is None else self._select(topics, usable))
        if not (self.selected or (to_look and self.entries)):
            raise RecordingError(
                'no usable topic',
                where=path,
                found=self._there(),
                expected=', '.join(USABLE_TYPES),
            )

    def _there(self) -> str:
        """Return what the file has instead of usable topics, and what of it cannot be read."""
        shown = ', '.join(f'{each.name} ({each.message_type})' for each in self.entries[:10])
        return '; '.join((shown or 'no topics', *self.file.damage()))

    def info(self) -> RecordingInfo:
        """Return what the recording holds; reads it once from end to end."""
        return summarise(
            self,
            path=str(self.path),
            kind=self.kind,
            entries=self.entries,
            damage=None,
            notes=(),
        )

    def measurements(self) -> Iterator[Measurement]:
        """Yield measurements in log order, in batches of a quarter of a second per topic.

        Where the first batch holds far more by the stamps of its samples, topics come side by side
        by these instead.

        Raises
        ------
        RecordingError
            The channel that should mark the motion does not.
        """
        if not self._mark:
            yield from self._all()
            return
        if self._stretch is None:
            pieces = mark_pieces(self._all, self._mark)
            self._stretch = high_stretch(pieces, self._mark, self.path)
        for item in self._all():
            part = cut(item, self._stretch, self._mark)
            if part is not None:
                yield part

    def spindle_speed(self) -> SpindleSpeed | None:
        """Return the speed of the spindle; None where it was not recorded.

        Raises
        ------
        RecordingError
            The topic or channel that is asked for is not there.
        """
        if self._speed_topic is not None:
            return speed_of_topic(self.file, self._speed_topic)
        if self._spindle is None:
            return None
        return speed_of_channel(self._read, self._spindle, self.path)

    def _all(self) -> Iterator[Measurement]:
        if self._spindle is None or self._speed_topic is not None:
            return self._read()
        return without_channel(self._read(), self._spindle)

    def _read(self) -> Iterator[Measurement]:
        is_copied = self._is_copied
        self.n_refused = {}
        self.refused = {}
        if is_copied:
            yield from side_by_side([self._of_topic(*each) for each in self._readers()])
            return
        for batch in self.raw_batches():
            yield from self._decoded(batch)

    @cached_property
    def _is_copied(self) -> bool:
        """Whether log times are those of a program that wrote the file anew."""
        with closing(self.raw_batches()) as batches:
            return log_times_mislead(self._decoded(next(batches, {})))

    def _readers(self) -> list[tuple[str, MessageFile]]:
        """Return each topic with a reader of its own, so that little is held of any."""
        return [
            (topic, deepcopy(self.file) if number else self.file)
            for number, topic in enumerate(sorted(self.selected))
        ]

    def _of_topic(self, topic: str, file: MessageFile) -> Iterator[Measurement]:
        """Yield the measurements of one topic, some messages at once."""
        n_read = 0
        n_expected = max(
            1, sum(each.n_messages or 0 for each in self.entries if each.name == topic)
        )
        for bunch in file.bunches(frozenset({topic})):
            for start in range(0, len(bunch), TOGETHER):
                some = bunch[start : start + TOGETHER]
                yield from self._decoded({some[0][1]: [data for _, _, data in some]})
            n_read += len(bunch)
            self.fraction_read = min(1.0, n_read / n_expected)

    def _stamped(self, topic: str, file: MessageFile) -> Iterator[RawMessage]:
        """Yield the messages of one topic, logged when they were stamped."""
        reached_ns = 0
        for raw in file.messages(frozenset({topic})):
            found = decode([raw.data], raw.message_type, topic, ros1=self.file.ros1)
            for each in found.measurements[:1]:
                reached_ns = max(reached_ns, first_stamp(each))
            yield raw._replace(log_time_ns=reached_ns)

    def _decoded(self, batch: dict[tuple[str, str], list[bytes]]) -> list[Measurement]:
        measurements: list[Measurement] = []
        for (topic, message_type), raws in batch.items():
            found = decode(raws, message_type, topic, ros1=self.file.ros1)
            if found.refused:
                self.n_refused[topic] = self.n_refused.get(topic, 0) + len(found.refused)
                self.refused.setdefault(topic, str(found.refused[0]))
            measurements += found.measurements
        return measurements

    def messages(self) -> Iterator[RawMessage]:
        """Yield the serialised messages of the selected topics in log order, for replay.

        Where log times mislead, see :meth:`measurements`, by the stamps within.
        """
        if not self._is_copied:
            return self.file.messages(self.selected)
        topics = [self._stamped(*each) for each in self._readers()]
        return heapq.merge(*topics, key=attrgetter('log_time_ns'))

    def attachments(self) -> tuple[Attachment, ...]:
        """Return the files it carries: its robot, its sensors, the software that wrote it."""
        return self.file.attachments()

    def damage(self) -> tuple[str, ...]:
        """Return what the last pass over the messages lost, one statement each."""
        refused = tuple(
            f'{topic}: {count} messages refused, the first because {self.refused[topic]}'
            for topic, count in sorted(self.n_refused.items())
        )
        return (*self.file.damage(), *refused)

    def raw_batches(self) -> Generator[dict[tuple[str, str], list[bytes]], None, None]:
        """Yield raw messages by topic and type, a quarter of a second of log time at once."""
        batch: dict[tuple[str, str], list[bytes]] = {}
        end_ns = n_bytes = n_read = 0
        selected = (entry for entry in self.entries if entry.name in self.selected)
        n_expected = max(1, sum(entry.n_messages or 0 for entry in selected))
        for bunch in self.file.bunches(self.selected):
            for log_time_ns, kind, data in bunch:
                if log_time_ns >= end_ns or n_bytes > LARGEST_BATCH_BYTES:
                    self.fraction_read = min(1.0, n_read / n_expected)
                    if batch:
                        yield batch
                    batch, n_bytes = {}, 0
                    end_ns = log_time_ns + BATCH_NS
                if kind in batch:
                    batch[kind].append(data)
                else:
                    batch[kind] = [data]
                n_bytes += len(data)
            n_read += len(bunch)
        self.fraction_read = min(1.0, n_read / n_expected)
        if batch:
            yield batch

    def _select(self, topics: Sequence[str], usable: set[str]) -> set[str]:
        entries = {entry.name: entry for entry in self.entries}
        selected = set()
        for topic in topics:
            name = topic if topic in entries else f'/{topic.lstrip("/")}'
            if name not in entries:
                raise RecordingError(
                    'no such topic',
                    where=self.path,
                    found=topic,
                    expected=f'one of {", ".join(sorted(usable)) or "none usable"}',
                )
            reason = why_unusable(entries[name])
            if reason:
                raise RecordingError(
                    f'topic cannot be used: {reason}',
                    where=f'{self.path}: {name}',
                    found=entries[name].message_type,
                    expected=', '.join(USABLE_TYPES),
                )
            selected.add(name)
        return selected
