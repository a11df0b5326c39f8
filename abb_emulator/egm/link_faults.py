"""Faults of the network between controller and sensor."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class LinkFault:
    """What one direction of the link does to its packets; zeros do nothing.

    Parameters
    ----------
    random : numpy.random.Generator
        Decides which packets.
    drop, duplicate, reorder : float
        Fraction of the packets lost, sent twice, or overtaken by the next one.
    delay_s : float [s]
        Added to every packet.
    """

    random: np.random.Generator
    drop: float = 0.0
    duplicate: float = 0.0
    reorder: float = 0.0
    delay_s: float = 0.0
    _late: list[tuple[float, bytes]] = field(default_factory=list)
    _overtaken: list[bytes] = field(default_factory=list)

    def clear(self) -> None:
        """Make the link faultless; what is under way still arrives."""
        self.drop = self.duplicate = self.reorder = self.delay_s = 0.0

    def carry(self, data: bytes, now_s: float) -> list[bytes]:
        """Take one packet and return what arrives now."""
        ready = self.due(now_s)
        if self._hit(self.drop):
            return ready
        copies = [data, data] if self._hit(self.duplicate) else [data]
        if self.delay_s > 0.0:
            self._late.extend((now_s + self.delay_s, copy) for copy in copies)
            return ready
        if not self._overtaken and self._hit(self.reorder):
            self._overtaken += copies
            return ready
        ready += copies + self._overtaken
        self._overtaken = []
        return ready

    def due(self, now_s: float) -> list[bytes]:
        """Return delayed packets whose time has come."""
        ready = [data for due_s, data in self._late if due_s <= now_s]
        if ready:
            self._late = [item for item in self._late if item[0] > now_s]
        return ready

    def _hit(self, fraction: float) -> bool:
        return fraction > 0.0 and self.random.random() < fraction


class LinkFaults:
    """Both directions of the link.

    Parameters
    ----------
    random : numpy.random.Generator
        Decides which packets.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self.robot = LinkFault(random)
        self.sensor = LinkFault(random)

    def clear(self) -> None:
        """Make both directions faultless."""
        self.robot.clear()
        self.sensor.clear()
