"""A recording as serialised messages with the times they are due; no clock in it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
import re

from modal_core.errors import SettingsError
from modal_core.measurements import JointSamples, Measurement, NANOSECONDS_PER_SECOND, SampleBlock
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.messages import encode, RawMessage, small_blocks
from modal_recordings.open_recording import Recording
from robot_bridge.playback_settings import PlaybackSettings

BLOCK_TOPIC, JOINT_TOPIC = 'acceleration_block', '/joint_states'
TOPIC = re.compile(r'[~/]?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*')


@dataclass(frozen=True, slots=True)
class DueMessage:
    """A message and when it is due.

    Parameters
    ----------
    due_s : float [s]
        After the beginning of playback.
    recorded_ns : int [ns]
        Log time in the recording.
    topic, message_type : str
        Where and what to publish.
    data : bytes
        Serialised, with its original stamps.
    """

    due_s: float
    recorded_ns: int
    topic: str
    message_type: str
    data: bytes


def parse_remap(entries: list[str]) -> dict[str, str]:
    """Return the mapping of ``old:=new`` entries.

    Raises
    ------
    SettingsError
        An entry is not of that form.
    """
    mapping = {}
    for entry in entries:
        if not entry:
            continue
        old, mark, new = entry.partition(':=')
        if not mark or not old or not TOPIC.fullmatch(new):
            raise SettingsError('bad remap', where='remap', found=entry, expected='old:=new')
        mapping[old] = new
    return mapping


class Playback:
    """Messages of one recording in the order and at the times they were recorded.

    Parameters
    ----------
    recording : Recording
        What to play.
    settings : PlaybackSettings
        How.
    """

    def __init__(self, recording: Recording, settings: PlaybackSettings) -> None:
        self.recording, self.settings = recording, settings
        self.n_loops = 0

    def messages(self) -> Iterator[DueMessage]:
        """Yield the messages; without end when looping."""
        settings = self.settings
        begin_s = 0.0
        while True:
            first_ns, last_s, found = None, 0.0, False
            for raw in raw_messages(self.recording):
                if first_ns is None:
                    first_ns = raw.log_time_ns
                offset_s = (raw.log_time_ns - first_ns) / NANOSECONDS_PER_SECOND
                if offset_s < settings.start_offset_s:
                    continue
                found = True
                # Log times that run backwards are due at once.
                last_s = max(last_s, (offset_s - settings.start_offset_s) / settings.rate)
                yield DueMessage(
                    begin_s + last_s,
                    raw.log_time_ns,
                    (settings.remap or {}).get(raw.topic, raw.topic),
                    raw.message_type,
                    raw.data,
                )
            self.n_loops += 1
            if not settings.loop or not found:
                return
            begin_s += last_s


def raw_messages(recording: Recording) -> Iterator[RawMessage]:
    """Yield a recording as serialised ROS 2 messages; other kinds are converted."""
    if not isinstance(recording, ArrayRecording) and not recording.file.ros1:
        yield from recording.messages()
        return
    for measurement in recording.measurements():
        parts: Iterable[Measurement] = (measurement,)
        if isinstance(measurement, SampleBlock):
            parts = small_blocks(measurement)
        for part in parts:
            yield from encode(part, _topic(measurement))


def _topic(measurement: Measurement) -> str:
    if isinstance(measurement, SampleBlock):
        return measurement.source if measurement.source.startswith('/') else BLOCK_TOPIC
    if isinstance(measurement, JointSamples):
        return JOINT_TOPIC
    if measurement.source.startswith('/'):
        return measurement.source
    return 'accel/' + re.sub(r'[^A-Za-z0-9_]', '_', measurement.source)
