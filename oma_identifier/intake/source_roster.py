"""Who sends: sources by name, each channel once, and what is not used."""

from modal_core.channel import Channel, SensorLayout
from modal_core.measurements import SampleBlock, StampedSamples
from oma_identifier.intake.buffer_counters import BufferCounters
from oma_identifier.intake.make_source import make_source
from oma_identifier.intake.source import Source
from oma_identifier.intake.thresholds import INTAKE


class SourceRoster:
    """The sources that send, and the channels that have been met.

    Parameters
    ----------
    layout : SensorLayout or None
        The channels to expect; None: whatever arrives.
    counters : BufferCounters
        Told what is not used.
    gyroscopes : bool
        Use the angular velocities of an Imu.

    Attributes
    ----------
    sources : dict
        By name: a topic, with channels or frame where several share it.
    met : set of str
        Names of sources whose messages are confirmed.
    seen : dict
        Channel by name.
    """

    def __init__(
        self, layout: SensorLayout | None, counters: BufferCounters, *, gyroscopes: bool = False
    ) -> None:
        self._layout, self._counters, self._gyroscopes = layout, counters, gyroscopes
        self.sources: dict[str, Source] = {}
        self.met: set[str] = set()
        self.seen: dict[str, Channel] = {}
        self._ignored: set[str] = set()

    @property
    def confirmed(self) -> list[Source]:
        """The sources whose channels have been met, in order of their first message."""
        return [source for key, source in self.sources.items() if key in self.met]

    def clear(self) -> None:
        """Forget who sent; the channels that were seen stay."""
        self.sources.clear()
        self._ignored.clear()
        self.met.clear()

    def source_of(self, measurement: StampedSamples | SampleBlock) -> Source | None:
        """Return who sent a measurement; None for one that is not used."""
        key = self._key_of(measurement)
        source = self.sources.get(key)
        if source is not None or key in self._ignored:
            return source if source is not None and source.sends(measurement) else None
        source = make_source(measurement, self._layout, gyroscopes=self._gyroscopes)
        if source is not None:
            source.name = key
            if self._has_room():
                self.sources[key] = source
                return source
        self._ignore(key, 'not_in_layout' if source is None else 'too_many_sources')
        return None

    def _key_of(self, measurement: StampedSamples | SampleBlock) -> str:
        """Return what a source is known by: several may share a topic.

        Channels tell recorders apart, in whatever order they come; frames tell sensors apart.
        """
        topic = key = measurement.source
        if isinstance(measurement, SampleBlock):
            key = f'{topic} {" ".join(measurement.channel_names)}'
            if key not in self.sources:
                same = (n for n, one in self.sources.items() if one.sends(measurement))
                return next((name for name in same if name.split()[0] == topic), key)
        elif key in self.sources and not self.sources[key].sends(measurement):
            key = f'{topic} frame {measurement.frame_id}'
        return key

    def _has_room(self) -> bool:
        """Make room for another source: one that nothing confirmed goes first."""
        if len(self.sources) < INTAKE.most_sources:
            return True
        waiting = next((name for name, one in self.sources.items() if one.is_waiting), None)
        if waiting is None:
            return False
        gone = self.sources.pop(waiting)
        gone.flush(alone=False)
        self._counters.collect(gone.set_aside)
        return True

    def _ignore(self, key: str, reason: str, text: str = '') -> None:
        self._counters.n_rejected += 1
        self._counters.note(reason, text=text)
        if len(self._ignored) < INTAKE.most_sources:
            self._ignored.add(key)

    def meet(self) -> None:
        """Take in the channels of sources whose messages are confirmed, each channel once."""
        for key, source in list(self.sources.items()):
            names = source.names
            if source.stream.first_ns is None or key in self.met:
                continue
            twice = [met for met in self.met if names & self.sources[met].names]
            if twice:
                del self.sources[key]
                text = f'{key} is not used: {twice[0]} sends channels of the same names'
                self._ignore(key, 'channel_sent_twice', text)
                continue
            self.met.add(key)
            self.seen.update({channel.name: channel for channel in source.channels})
