"""Updates of the page, and what a browser that comes late is told."""

from collections import deque
from dataclasses import dataclass
import json

from modal_core.words.printable import printable_values

MOST_ROWS = {'track': 500, 'log': 300}
"""Rows kept of what grows: windows of the trends (some 1 MB at ten modes), lines of the log."""
LONGEST_TEXT = 1000
"""Letters of a name or a sentence from elsewhere; what may be a megabyte goes to every browser."""


@dataclass(frozen=True, slots=True)
class Update:
    """One screen's content, or one more row of it.

    Parameters
    ----------
    kind : str
        What it is of; rows are of the kinds in ``MOST_ROWS``.
    data : str
        JSON.
    """

    kind: str
    data: str

    @classmethod
    def of(cls, kind: str, value: object) -> 'Update':
        """Return an update of plain values; numbers that are not finite are refused."""
        shown = printable_values(value, LONGEST_TEXT)
        return cls(kind, json.dumps(shown, allow_nan=False, separators=(',', ':')))

    @property
    def text(self) -> str:
        """Message to a browser."""
        return f'{{"kind":"{self.kind}","data":{self.data}}}'


class Board:
    """Keeps the last content of every screen."""

    def __init__(self) -> None:
        self._last: dict[str, Update] = {}
        self._rows = {kind: deque[str](maxlen=most) for kind, most in MOST_ROWS.items()}

    def take(self, update: Update) -> bool:
        """Keep an update; return whether it says anything new."""
        if update.kind in self._rows:
            self._rows[update.kind].append(update.data)
            return True
        before = self._last.get(update.kind)
        self._last[update.kind] = update
        return update != before

    def all(self) -> list[str]:
        """Return the messages that tell a browser everything; rows as ``tracks`` and ``logs``."""
        rows = [
            Update(f'{kind}s', f'[{",".join(data)}]').text for kind, data in self._rows.items()
        ]
        return [*(update.text for update in self._last.values()), *rows]
