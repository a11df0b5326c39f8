"""What happened to the measurements since the start."""

from collections import Counter
from dataclasses import dataclass, field


@dataclass
class BufferCounters:
    """What happened since the start.

    Parameters
    ----------
    n_segments : int
        Stretches of data without interruption.
    n_rejected : int
        Measurements of no known channel, malformed, or from too many sources.
    reasons : dict of str to int
        Why a new segment was begun, and why measurements were rejected or set aside.
    texts : dict of str to str
        What was found and what to do, for the reasons that say so.
    """

    n_segments: int = 0
    n_rejected: int = 0
    reasons: dict[str, int] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)

    def note(self, reason: str, count: int = 1, text: str = '') -> None:
        """Count occurrences."""
        self.reasons[reason] = self.reasons.get(reason, 0) + count
        if text:
            self.texts[reason] = text

    def collect(self, set_aside: 'Counter[str]') -> None:
        """Take over what a source has counted."""
        for reason, count in set_aside.items():
            self.note(reason, count)
        set_aside.clear()

    def describe(self, reason: str) -> str:
        """Return one line on a reason."""
        text = self.texts.get(reason)
        return f'{self.reasons[reason]} times' + (f': {text}' if text else '')
