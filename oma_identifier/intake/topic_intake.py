"""Raw messages of all subscribed topics to measurements, with a count of what was refused."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from modal_core.errors import MessageError
from modal_core.measurements import (
    JointSamples,
    Measurement,
    SampleBlock,
    StampedSamples,
)
from modal_recordings.messages import decode
from oma_identifier.intake.thresholds import INTAKE


def in_order(measurements: Sequence[Measurement]) -> list[Measurement]:
    """Return batches of several topics side by side, in slices of a fifth of a second.

    The order within each topic stays.
    """
    by_topic: dict[str, list[Measurement]] = {}
    for measurement in measurements:
        for part in _slices(measurement):
            topic = 'joints' if isinstance(part, JointSamples) else part.source
            by_topic.setdefault(topic, []).append(part)
    keyed = [
        (reached, part)
        for parts in by_topic.values()
        for reached, part in zip(_reached([_stamp(part) for part in parts]), parts, strict=True)
    ]
    keyed.sort(key=lambda item: item[0])
    return [part for _, part in keyed]


def _stamp(part: Measurement) -> int:
    return part.stamp_ns if isinstance(part, SampleBlock) else int(part.stamp_ns[0])


def _reached(stamps: Sequence[int]) -> list[int]:
    """Return how far a topic has come at each of its stamps; single wild ones do not count."""
    usual = sorted(stamps)[len(stamps) // 2]
    first = next(stamp for stamp in stamps if abs(stamp - usual) <= INTAKE.wild_ns)
    reached = []
    for stamp in stamps:
        first = max(first, stamp) if abs(stamp - usual) <= INTAKE.wild_ns else first
        reached.append(first)
    return reached


def _slices(measurement: Measurement) -> list[Measurement]:
    if not isinstance(measurement, StampedSamples):
        return [measurement]
    stamps = measurement.stamp_ns
    edges = [0, *(np.flatnonzero(np.diff(stamps // INTAKE.slice_ns)) + 1).tolist(), len(stamps)]
    if len(edges) > 2 + len(stamps) // 4:
        return [measurement]
    turn = measurement.angular_velocity
    return [
        replace(
            measurement,
            stamp_ns=stamps[start:stop],
            acceleration=measurement.acceleration[start:stop],
            angular_velocity=None if turn is None else turn[start:stop],
        )
        for start, stop in pairwise(edges)
    ]


@dataclass
class TopicIntake:
    """Decodes batches and keeps counts per topic.

    Parameters
    ----------
    n_messages, n_refused : dict of str to int
        By topic.
    last_refusal : dict of str to str
        Why the newest refused message of a topic was refused.
    """

    n_messages: dict[str, int] = field(default_factory=dict)
    n_refused: dict[str, int] = field(default_factory=dict)
    last_refusal: dict[str, str] = field(default_factory=dict)

    def decode(
        self, raws: Sequence[bytes], message_type: str, topic: str
    ) -> tuple[Measurement, ...]:
        """Return the measurements of a batch of one topic."""
        if not raws:
            return ()
        self.n_messages[topic] = self.n_messages.get(topic, 0) + len(raws)
        batch = decode(raws, message_type, topic)
        if batch.refused:
            self._refuse(topic, batch.refused)
        return batch.measurements

    def _refuse(self, topic: str, errors: Sequence[MessageError]) -> None:
        self.n_refused[topic] = self.n_refused.get(topic, 0) + len(errors)
        self.last_refusal[topic] = str(errors[-1])
