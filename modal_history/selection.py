"""Which results of a history are asked for."""

from dataclasses import dataclass
from datetime import datetime, UTC

from modal_core.errors import SettingsError
from modal_core.measurements import NANOSECONDS_PER_SECOND

FIRST_NS, LAST_NS = -(2**63), 2**63 - 1


@dataclass(frozen=True, slots=True)
class Selection:
    """Windows and modes of one robot.

    Parameters
    ----------
    robot : str
        Ids are counted robot by robot.
    ids : tuple of int
        Modes; empty: all.
    since_ns, until_ns : int [ns]
        Windows that end in this time.
    whole : bool
        Whole recordings in place of their windows.
    """

    robot: str
    ids: tuple[int, ...] = ()
    since_ns: int = FIRST_NS
    until_ns: int = LAST_NS
    whole: bool = False

    def where(self) -> tuple[str, list[object]]:
        """Return the condition on tables ``window`` and ``run``, and its values."""
        words = 'run.robot = ? AND window.end_ns BETWEEN ? AND ? AND (window.number < 0) = ?'
        return words, [self.robot, self.since_ns, self.until_ns, self.whole]


def time_ns(text: str, where: str = '') -> int:
    """Return a date or time of ISO 8601 in nanoseconds since 1970; UTC where no zone is given.

    Raises
    ------
    SettingsError
        It is none.
    """
    try:
        found = datetime.fromisoformat(text)
        aware = found if found.tzinfo else found.replace(tzinfo=UTC)
        return round(aware.timestamp() * 1e6) * (NANOSECONDS_PER_SECOND // 1_000_000)
    except (ValueError, OverflowError) as error:
        raise SettingsError(
            'not a time', where=where, found=text, expected='2026-05-31 or 2026-05-31T14:00+02:00'
        ) from error


def time_text(ns: int) -> str:
    """Return a time as ISO 8601 in UTC, to the second."""
    try:
        found = datetime.fromtimestamp(ns // NANOSECONDS_PER_SECOND, UTC)
    except (ValueError, OverflowError, OSError):
        return f'{ns / NANOSECONDS_PER_SECOND:.0f} s'
    return found.strftime('%Y-%m-%dT%H:%M:%SZ')
