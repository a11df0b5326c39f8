"""Alarms of a history: found once, kept until somebody acknowledges them.

What is acknowledged is the new usual: the baseline of that mode begins anew where the change
began.
"""

from dataclasses import astuple, dataclass
import math
from pathlib import Path
import time

from modal_core.errors import SettingsError
from modal_history.alarm.part import Part
from modal_history.alarm.watch import Change
from modal_history.history_file import HistoryFile
from modal_history.selection import time_text

COLUMNS = 'mode, raised_ns, since_ns, share, share_std, surprise, bound, kind'


@dataclass(frozen=True, slots=True)
class Alarm:
    """A change that was found.

    Parameters
    ----------
    number : int
        Of the alarm, to acknowledge it by; 0: not kept yet.
    robot : str
        Whose mode.
    change : Change
        What changed, since when, how sure.
    acknowledged_ns : int [ns] or None
        When somebody took note.
    part : Part or None
        Which part of the robot it goes back to; None where no model is known.
    """

    number: int
    robot: str
    change: Change
    acknowledged_ns: int | None = None
    part: Part | None = None

    @property
    def is_open(self) -> bool:
        """Whether nobody has taken note."""
        return self.acknowledged_ns is None

    def words(self) -> str:
        """Say what changed, since when, how sure."""
        of = f'{self.robot}, ' if self.robot else ''
        part = f'; {self.part.words()}' if self.part is not None else ''
        return f'{of}{self.change.words()}; since {time_text(self.change.since_ns)}{part}'


def alarms_of(file: HistoryFile) -> tuple[Alarm, ...]:
    """Return the alarms that are kept, in the order they were raised.

    Raises
    ------
    HistoryError
        The file is damaged.
    """
    with file.told():
        if not file.columns('alarm'):
            return ()
        rows = file.rows.execute(
            f'SELECT id, robot, acknowledged_ns, part, {COLUMNS} FROM alarm ORDER BY raised_ns, id'
        ).fetchall()
    try:
        return tuple(_alarm(*row) for row in rows)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise file.damaged(error) from error


def _alarm(
    number: int, robot: str, acknowledged_ns: int | None, part: str, *change: object
) -> Alarm:
    values = [math.nan if value is None else value for value in change]
    known = Part.from_json(part) if part else None
    return Alarm(number, robot, Change(*values), acknowledged_ns, known)  # type: ignore[arg-type]


def keep_alarms(path: Path, found: tuple[Alarm, ...]) -> None:
    """Keep alarms that a check found; one that is open for a mode stays, and learns its part.

    Raises
    ------
    HistoryError
        The file cannot be written.
    """
    file = HistoryFile(path, write=True)
    try:
        with file.change():
            there = {(a.robot, a.change.id) for a in alarms_of(file) if a.is_open}
            for alarm in found:
                part = alarm.part.to_json() if alarm.part is not None else ''
                if alarm.number:
                    file.rows.execute(
                        'UPDATE alarm SET part = ? WHERE id = ?', (part, alarm.number)
                    )
                elif (alarm.robot, alarm.change.id) not in there:
                    change = [None if v != v else v for v in astuple(alarm.change)]
                    file.rows.execute(
                        f'INSERT INTO alarm (robot, part, {COLUMNS})'
                        ' VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)',
                        (alarm.robot, part, *change),
                    )
    finally:
        file.close()


def acknowledge(path: Path, number: int) -> None:
    """Take note of an alarm: its mode's baseline begins anew where the change began.

    Raises
    ------
    SettingsError
        There is no such open alarm.
    HistoryError
        The file cannot be written.
    """
    HistoryFile(path).close()
    file = HistoryFile(path, write=True)
    try:
        with file.change():
            cursor = file.rows.execute(
                'UPDATE alarm SET acknowledged_ns = ? WHERE id = ? AND acknowledged_ns IS NULL',
                (time.time_ns(), number),
            )
            if not cursor.rowcount:
                there = ', '.join(str(a.number) for a in alarms_of(file) if a.is_open)
                raise SettingsError(
                    'no such open alarm',
                    where=path,
                    found=number,
                    expected=there or 'none is open',
                )
    finally:
        file.close()
