"""The common grid of one uninterrupted stretch of data, and the rows on it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from oma_identifier.intake.source import Source
from oma_identifier.intake.source_rows import CutRows, SourceRows
from oma_identifier.intake.thresholds import INTAKE
from oma_identifier.time_axis import longest_filled, TIME_AXIS

STRETCH_S = 1.0
FEWEST_ROWS = 256


@dataclass
class Segment:
    """Turns ordered samples into stretches of grid rows.

    Parameters
    ----------
    start_ns : int [ns]
        Time of row 0.
    sample_rate_hz : float [Hz]
        Rate of the grid.
    reference : Source
        Its clock is the grid's when it counts its samples.
    window_rows, hop_rows : int
        Length of a window, and from one to the next.
    due_ns : int [ns]
        Before samples of this time there is no next stretch; as of the last question.
    """

    start_ns: int
    sample_rate_hz: float
    reference: Source
    window_rows: int
    hop_rows: int
    n_rows: int = 0
    rows: dict[str, SourceRows] = field(default_factory=dict)
    next_window: int = 0
    drift_ns: float = 0.0
    due_ns: int = 0

    @property
    def step_ns(self) -> float:
        """Step of the grid [ns]."""
        return NANOSECONDS_PER_SECOND / self.sample_rate_hz

    def time_ns(self, row: int) -> int:
        """Return the time of a row [ns]."""
        return self.start_ns + round(self.drift_ns + row * self.step_ns)

    def label_ns(self, row: int) -> int:
        """Return the time of a row by the grid's own clock [ns]."""
        return self.start_ns + round(row * self.step_ns)

    @property
    def next_end(self) -> int:
        """Row just after the next stretch: a round number, or the end of the next window."""
        stretch = max(FEWEST_ROWS, round(STRETCH_S * self.sample_rate_hz))
        end = (self.n_rows // stretch + 1) * stretch
        window_end = self.next_window * self.hop_rows + self.window_rows
        return min(end, window_end) if window_end > self.n_rows else end

    def ready(self, sources: Sequence[Source], *, closing: bool) -> bool:
        """Tell whether the samples of the next stretch are there."""
        end_ns = self.time_ns(self.next_end)
        if closing:
            return self.rows_left(sources) >= self.next_end - self.n_rows
        newest = max(source.stream.newest_ns for source in sources)
        # Samples may come late by a second; only the end of a window is not kept waiting, as
        # long as nothing has ever come out of order.
        due_ns = end_ns + TIME_AXIS.reorder_ns
        if not any(source.stream.disordered for source in sources):
            window_end = self.next_window * self.hop_rows + self.window_rows
            due_ns = max(end_ns, min(due_ns, self.time_ns(window_end)))
        self.due_ns = due_ns
        if newest < due_ns:
            return False
        return all(
            (
                source.stream.newest_ns >= due_ns + source.margin_ns(self.step_ns)
                and not source.awaits(end_ns, self.step_ns)
            )
            or source.stream.newest_ns < newest - INTAKE.wait_ns - source.margin_ns(self.step_ns)
            for source in sources
        )

    def rows_left(self, sources: Sequence[Source]) -> int:
        """Return the rows that can still be made of the samples there are."""
        newest = max(source.stream.newest_ns for source in sources)
        live = [
            source.stream.newest_ns
            for source in sources
            if source.stream.newest_ns > newest - INTAKE.wait_ns
        ]
        end_ns = min(live) + self.step_ns / 2.0
        return max(0, math.floor((end_ns - self.time_ns(self.n_rows)) / self.step_ns) + 1)

    def advance(self, sources: Sequence[Source], end: int) -> NDArray[np.bool_]:
        """Make the rows up to ``end``; returns where no source has a sample, (n_rows,) array."""
        self._follow_reference(end)
        n_rows = end - self.n_rows
        start = self.time_ns(self.n_rows)
        silent = np.ones(n_rows, dtype=bool)
        for source in sources:
            rows = source.on_grid(start, n_rows, self.step_ns)
            self._rows_of(source).append(rows)
            silent &= rows.lost
        self.n_rows = end
        for source in sources:
            keep = source.margin_ns(self.step_ns) + round(200 * source.period_ns)
            keep += longest_filled(source.period_ns) * round(source.period_ns)
            source.stream.forget(self.time_ns(end) - keep)
            source.stream.sealed_ns = self.time_ns(end)
        return silent

    def _rows_of(self, source: Source) -> SourceRows:
        """Return the rows of a source, lost ones where there were none yet."""
        if source.name not in self.rows:
            first_row = self.next_window * self.hop_rows
            n_channels = len(source.channels)
            rows = SourceRows(first_row, n_channels, self.window_rows, source.stream.dtype)
            self.rows[source.name] = rows
        self.rows[source.name].reach(self.n_rows)
        return self.rows[source.name]

    def cut(self, source: Source, rows: range) -> CutRows:
        """Return the rows of a source in a window."""
        return self._rows_of(source).cut(rows)

    def _follow_reference(self, end: int) -> None:
        """Lead the grid along the clock of a reference that counts its samples."""
        if self.reference.clock is None:
            return
        start, stop = self.time_ns(self.n_rows), self.time_ns(end)
        stamps = self.reference.stream.samples().stamp_ns
        first, last = np.searchsorted(stamps, [start - self.step_ns / 2, stop])
        if last - first < 2:
            return
        beside = (stamps[first:last] - start) / self.step_ns
        offset = _middle(beside - np.rint(beside))
        if abs(offset) < 0.45:
            self.drift_ns += offset * self.step_ns

    def forget(self) -> None:
        """Drop rows before the next window."""
        for rows in self.rows.values():
            rows.forget(self.next_window * self.hop_rows)


def _middle(values: NDArray[np.float64]) -> float:
    """Return the median, of an even number the upper one."""
    place = len(values) // 2
    return float(np.partition(values, place)[place])
