"""Each mode of the first recording through all others: its frequency and damping in each."""

from collections.abc import Sequence
from dataclasses import dataclass

from modal_core.mode import Mode, ModeSet
from oma_identifier.compare import ModeChange, ModeComparison


@dataclass(frozen=True, slots=True)
class CoursePoint:
    """A mode in one recording.

    Parameters
    ----------
    recording : int
        Number of the recording, 0: the first.
    mode : Mode
        There.
    change : ModeChange or None
        From the first; None of the first itself.
    """

    recording: int
    mode: Mode
    change: ModeChange | None = None


def mode_courses(
    modes: ModeSet, comparisons: Sequence[ModeComparison]
) -> list[tuple[CoursePoint, ...]]:
    """Return the course of each mode of the first recording, by frequency.

    Parameters
    ----------
    modes : ModeSet
        Of the first.
    comparisons : sequence of ModeComparison
        Of the first with each other recording, in their order.
    """
    courses = []
    for mode in modes:
        points = [CoursePoint(0, mode)]
        for number, found in enumerate(comparisons, start=1):
            points += [
                CoursePoint(number, change.second, change)
                for change in found.changes
                if change.first is mode
            ]
        courses.append(tuple(points))
    return courses
