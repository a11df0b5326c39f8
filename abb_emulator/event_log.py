"""The event log of the emulated controller."""

from collections import deque
from dataclasses import dataclass

# Bounds the memory; how many a controller keeps is not known here.
MOST_EVENTS = 200
"""Kept; the oldest give way, as in a controller's own log."""
INFORMATION, WARNING, ERROR = 1, 2, 3
# What a controller's own numbers are for; every other event of the emulator has USER_EVENT.
MOTORS_OFF, MOTORS_ON, MANUAL, AUTOMATIC = 10010, 10011, 10015, 10017
POINTER_RESET, PROGRAM_STARTED, PROGRAM_STOPPED = 10002, 10151, 10125
EMERGENCY_STOP, USER_EVENT = 10013, 80001


@dataclass(frozen=True, slots=True)
class Event:
    """One entry.

    Parameters
    ----------
    number : int
        Running number, from 1.
    time_s : float [s]
        Controller clock.
    kind : int
        ``INFORMATION``, ``WARNING`` or ``ERROR``.
    code : int
        Number of the event text.
    title : str
        What happened.
    """

    number: int
    time_s: float
    kind: int
    code: int
    title: str


class EventLog:
    """The last events, oldest first."""

    def __init__(self) -> None:
        self._events: deque[Event] = deque(maxlen=MOST_EVENTS)
        self.n_events = 0

    def add(
        self, time_s: float, title: str, code: int = USER_EVENT, kind: int = INFORMATION
    ) -> None:
        """Write an entry."""
        self.n_events += 1
        self._events.append(Event(self.n_events, time_s, kind, code, title))

    @property
    def events(self) -> tuple[Event, ...]:
        """Every entry that is kept, oldest first."""
        return tuple(self._events)

    @property
    def titles(self) -> list[str]:
        """What happened, oldest first."""
        return [event.title for event in tuple(self._events)]
