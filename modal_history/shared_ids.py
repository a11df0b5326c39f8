"""Ids of modes that last over the runs of a robot.

Each robot has one tracker, fed with every window that is kept.  Its memory is in the file and
written together with the window: two programs that write in turn go on where the other was.
"""

from dataclasses import replace
import json
import zlib

from modal_core.errors import SettingsError
from modal_core.mode import ModeSet
from modal_history.history_file import HistoryFile
from modal_history.kept import KeptWindow
from oma_identifier.tracking import ModeTracker

LARGEST_STATE = 100_000_000


class SharedIds:
    """The tracker of every robot of a history.

    Parameters
    ----------
    file : HistoryFile
        Open for writing.
    """

    def __init__(self, file: HistoryFile) -> None:
        self._file = file
        self._known: dict[str, tuple[int, ModeTracker]] = {}

    def forget(self) -> None:
        """Read the memory anew: what was learnt has not been written."""
        self._known.clear()

    def link(self, robot: str, window: KeptWindow) -> ModeSet:
        """Return a window's modes with the ids of the robot; lines of machines keep 0."""
        tracker = self._tracker(robot)
        modes = [mode for mode in window.modes if not mode.harmonic]
        lines = [replace(mode, id=0) for mode in window.modes if mode.harmonic]
        found = replace(window.modes, modes=tuple(modes))
        if window.is_whole:
            linked = tracker.label(found)
        elif modes:
            linked = tracker.update(found, window.pose).modes
        else:
            # Nothing was heard: no mode is lost by that.
            linked = found
        return replace(linked, modes=(*linked.modes, *lines))

    def save(self, robot: str) -> None:
        """Write the memory, in the transaction that writes the windows."""
        n, tracker = self._known[robot]
        state = zlib.compress(json.dumps(tracker.to_json()).encode(), 1)
        self._file.rows.execute('REPLACE INTO tracker VALUES (?, ?, ?)', (robot, n + 1, state))
        self._known[robot] = (n + 1, tracker)

    def _tracker(self, robot: str) -> ModeTracker:
        """Return the tracker as the file has it: another program may have written since."""
        rows = self._file.rows.execute('SELECT n, state FROM tracker WHERE robot = ?', (robot,))
        n, state = rows.fetchone() or (0, None)
        if robot not in self._known or self._known[robot][0] != n:
            self._known[robot] = (n, ModeTracker() if state is None else self._read(state))
        return self._known[robot][1]

    def _read(self, state: bytes) -> ModeTracker:
        try:
            text = zlib.decompressobj().decompress(state, LARGEST_STATE)
            return ModeTracker.from_json(json.loads(text))
        except (zlib.error, TypeError, ValueError, SettingsError) as error:
            raise self._file.damaged(f'memory of modes: {error}') from error
