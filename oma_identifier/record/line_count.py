"""Lines counted over the windows of a record."""

from collections.abc import Iterable

from modal_core.mode import Mode
from oma_identifier.selection import is_same_line


class LineCount:
    """Counts in how many windows each line was."""

    def __init__(self) -> None:
        self._counted: list[tuple[Mode, int]] = []
        self._n_windows = 0

    def add(self, lines: Iterable[Mode]) -> None:
        """Add the lines of one window."""
        self._n_windows += 1
        for line in lines:
            for index, (known, n_windows) in enumerate(self._counted):
                if _same(known, line):
                    self._counted[index] = known, n_windows + 1
                    break
            else:
                self._counted.append((line, 1))

    def usual(self, known: Iterable[Mode]) -> list[Mode]:
        """Return the lines of most windows that are not among known ones."""
        known = tuple(known)
        return [
            line
            for line, n_windows in self._counted
            if 2 * n_windows >= self._n_windows and not any(_same(line, other) for other in known)
        ]


def _same(first: Mode, second: Mode) -> bool:
    return is_same_line(first.frequency_hz, second.frequency_hz)
