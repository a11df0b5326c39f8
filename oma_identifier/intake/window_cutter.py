"""Windows cut from a segment one after the other, kept until they are asked for."""

from collections.abc import Iterator, Sequence
import math

from modal_core.channel import SensorLayout
from modal_core.window import Window
from oma_identifier.intake.joint_track import JointTrack
from oma_identifier.intake.segment import Segment
from oma_identifier.intake.source import Source
from oma_identifier.intake.thresholds import INTAKE
from oma_identifier.intake.window_cut import cut_window
from oma_identifier.one_thread import one_thread


class WindowCutter:
    """Cuts windows as soon as their rows are there.

    Parameters
    ----------
    layout : SensorLayout or None
        The channels to expect; None: whatever arrives.
    joints : JointTrack
        Where the robot was.

    Attributes
    ----------
    n_windows : int
        Windows cut so far; the index of the next.
    """

    def __init__(self, layout: SensorLayout | None, joints: JointTrack) -> None:
        self.layout = layout
        self.joints = joints
        self.n_windows = 0
        self._flags: tuple[str, ...] = ()
        self._ready: list[Window] = []

    def flag(self, reason: str) -> None:
        """Flag the next window: why a segment ended before it."""
        self._flags = tuple(dict.fromkeys((*self._flags, reason)))

    def cut(self, segment: Segment, sources: Sequence[Source]) -> None:
        """Cut the windows whose rows are complete."""
        while segment.next_window * segment.hop_rows + segment.window_rows <= segment.n_rows:
            first = segment.next_window * segment.hop_rows
            self._cut(segment, sources, range(first, first + segment.window_rows), self._flags)
            segment.next_window += 1
            segment.forget()

    def cut_rest(self, segment: Segment, sources: Sequence[Source]) -> None:
        """Cut what is left of a segment as a partial window, where that is worth one."""
        first = segment.next_window * segment.hop_rows
        covered = 0
        if segment.next_window:
            covered = first - segment.hop_rows + segment.window_rows
        least = max(2, math.ceil(INTAKE.shortest_partial * segment.window_rows))
        is_new = segment.n_rows - covered > segment.sample_rate_hz
        if segment.n_rows - first >= least and (is_new or not segment.next_window):
            rows = range(first, segment.n_rows)
            self._cut(segment, sources, rows, (*self._flags, 'partial'))

    def _cut(
        self, segment: Segment, sources: Sequence[Source], rows: range, flags: tuple[str, ...]
    ) -> None:
        with one_thread():
            window = cut_window(
                index=self.n_windows,
                segment=segment,
                sources=sources,
                rows=rows,
                layout=self.layout,
                joints=self.joints,
                flags=flags,
            )
        self.n_windows += 1
        self._flags = ()
        self._ready.append(window)

    def windows(self) -> Iterator[Window]:
        """Yield the windows that are complete."""
        while self._ready:
            yield self._ready.pop(0)
