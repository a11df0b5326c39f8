"""Which sources keep one time: those that most samples agree with lead, the others stay apart.

A source whose clock is an hour off has a time of its own.  It must neither make the others look
late nor be put beside them.
"""

from collections.abc import Sequence

from oma_identifier.intake.source import Source
from oma_identifier.intake.thresholds import INTAKE

APART = 'clock_apart'


class LeadingClock:
    """Follows which sources keep the time that most samples agree with.

    Attributes
    ----------
    leading : set of str
        Names of the sources that keep it.
    now_ns : int or None [ns]
        That time: the newest sample of a leading source.
    newly_apart : list of str
        Sources found to keep another time at the last look, not before.
    """

    def __init__(self) -> None:
        self.leading: set[str] = set()
        self.now_ns: int | None = None
        self.newly_apart: list[str] = []
        self._began: dict[str, int] = {}
        self._looked: dict[str, int] = {}
        self._weight: dict[str, int] = {}

    def note(self, source: Source, n_samples: int) -> bool:
        """Take note of samples that a source has taken in; tells whether to look who leads."""
        began, newest, name = source.stream.first_ns, source.stream.newest_ns, source.name
        if began is None or source.stream.jumped:
            return False
        self._weight[name] = self._weight.get(name, 0) + n_samples * len(source.channels)
        if self._began.get(name) != began:
            self._began[name] = self._looked[name] = began
            self._place(name, newest)
        if name in self.leading:
            self.now_ns = newest if self.now_ns is None else max(self.now_ns, newest)
        return not self.leading or newest - self._looked[name] >= INTAKE.together_ns

    def _place(self, name: str, newest_ns: int) -> None:
        """Put a source that begins, or whose clock jumped, where its time is."""
        if self.now_ns is None or abs(newest_ns - self.now_ns) <= INTAKE.together_ns:
            self.leading.add(name)
        else:
            self.leading.discard(name)

    def look(self, sources: Sequence[Source]) -> bool:
        """Find out who leads; tells whether none of those who led before does.

        Samples since the last look count, times their channels; those who lead stay unless
        others clearly outweigh them.
        """
        begun = [source for source in sources if source.stream.first_ns is not None]
        if not begun:
            return False
        before = self.leading
        groups = _groups(begun)
        best = max(groups, key=self._weighed)
        self.leading = {source.name for source in best}
        self.now_ns = max(source.stream.newest_ns for source in best)
        self.newly_apart = []
        for source in begun:
            if source.name in self.leading:
                source.flags.discard(APART)
            elif self._weight.get(source.name):
                if APART not in source.flags:
                    self.newly_apart.append(source.name)
                source.flags.add(APART)
                source.stream.forget(source.stream.newest_ns - INTAKE.together_ns)
        self._looked = {source.name: source.stream.newest_ns for source in begun}
        self._weight = {}
        return bool(before) and not before & self.leading

    def _weighed(self, group: Sequence[Source]) -> float:
        weight = sum(self._weight.get(source.name, 0) for source in group)
        leads = any(source.name in self.leading for source in group)
        return weight * (INTAKE.leader_stays if leads else 1.0)


def _groups(sources: Sequence[Source]) -> list[list[Source]]:
    """Return sources that keep one time, from the earliest to the latest."""
    ordered = sorted(sources, key=lambda source: source.stream.newest_ns)
    groups = [[ordered[0]]]
    for source in ordered[1:]:
        if source.stream.newest_ns - groups[-1][-1].stream.newest_ns > INTAKE.together_ns:
            groups.append([])
        groups[-1].append(source)
    return groups
