"""What a recording holds, and what of it the identifier would use."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Gap:
    """A stretch of time without samples.

    Parameters
    ----------
    start_ns, end_ns : int [ns]
        Last sample before and first sample after.
    n_lost : int
        Samples that would have fitted in between.
    """

    start_ns: int
    end_ns: int
    n_lost: int


@dataclass(frozen=True, slots=True)
class TopicSummary:
    """One topic, or the table of an array file.

    Parameters
    ----------
    name, message_type : str
        As recorded.
    n_messages : int
        Readable messages.
    usable : bool
        The identifier would use it.
    reason : str
        Why not; empty when usable.
    channels : tuple of str
        Channels or joints it carries.
    n_samples : int
        Samples per channel.
    declared_rate_hz, measured_rate_hz : float [Hz]
        Declared rate (0: none) and rate of the stamps (0: unknown).
    jitter_std_s : float [s]
        Scatter of the steps between stamps.
    gaps : tuple of Gap
        The longest ones first, at most a hundred.
    n_gaps : int
        How many there are.
    n_duplicates, n_backwards : int
        Stamps that repeat the one before, and that run backwards.
    n_refused : int
        Messages that break their contract.
    start_ns, end_ns : int [ns]
        First and last header stamp.
    """

    name: str
    message_type: str
    n_messages: int
    usable: bool
    reason: str = ''
    channels: tuple[str, ...] = ()
    n_samples: int = 0
    declared_rate_hz: float = 0.0
    measured_rate_hz: float = 0.0
    jitter_std_s: float = 0.0
    gaps: tuple[Gap, ...] = ()
    n_gaps: int = 0
    n_duplicates: int = 0
    n_backwards: int = 0
    n_refused: int = 0
    start_ns: int = 0
    end_ns: int = 0


@dataclass(frozen=True, slots=True)
class RecordingInfo:
    """A recording at a glance.

    Parameters
    ----------
    path : str
        File or folder.
    kind : str
        ``mcap``, ``rosbag2``, ``rosbag1``, ``npy`` or ``csv``.
    topics : tuple of TopicSummary
        In order of name.
    n_messages : int
        Readable messages (rows of an array).
    start_ns, end_ns : int [ns]
        Earliest and latest header stamp of usable topics.
    damage : tuple of str
        What is lost, one statement each; empty for a sound file.
    notes : tuple of str
        What was assumed.
    """

    path: str
    kind: str
    topics: tuple[TopicSummary, ...]
    n_messages: int
    start_ns: int = 0
    end_ns: int = 0
    damage: tuple[str, ...] = ()
    notes: tuple[str, ...] = field(default=())

    @property
    def duration_s(self) -> float:
        """Time from the first to the last stamp [s]."""
        return max(0, self.end_ns - self.start_ns) * 1e-9

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels the identifier would use."""
        from modal_recordings.messages import JOINT_STATE

        return tuple(
            name
            for topic in self.topics
            if topic.usable and topic.message_type != JOINT_STATE
            for name in topic.channels
        )
