"""Samples of several channels on one uniform time grid."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.errors import LayoutError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.spindle_speed import SpindleSpeed

ROWS_AT_ONCE = 8192


@dataclass(frozen=True, slots=True)
class Samples:
    """A uniformly sampled stretch of responses.

    Parameters
    ----------
    acceleration : (n_samples, n_channels) array [m/s²]
        Finite everywhere; in single precision where the source sends no more.  Sums over many
        samples need double precision: :meth:`widened`.
    sample_rate_hz : float [Hz]
        Rate of the grid.
    channels : tuple of Channel
        One per column.
    start_ns : int [ns]
        Time of the first row.
    known : (n_samples, n_inputs) array or None
        What is known to drive the structure, for a robot the accelerations of its joints
        [rad/s²]; NaN where it is not known after all.
    speed : SpindleSpeed or None
        Of the spindle, at its own times; None where it is not measured.
    """

    acceleration: NDArray[np.float64] | NDArray[np.float32]
    sample_rate_hz: float
    channels: tuple[Channel, ...]
    start_ns: int = 0
    known: NDArray[np.float64] | NDArray[np.float32] | None = None
    speed: SpindleSpeed | None = None

    @property
    def duration_s(self) -> float:
        """Length of the stretch, samples over rate [s]."""
        return len(self.acceleration) / self.sample_rate_hz

    @property
    def end_ns(self) -> int:
        """Time just after the last row [ns]."""
        return self.start_ns + round(self.duration_s * NANOSECONDS_PER_SECOND)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(channel.name for channel in self.channels)

    def widened(
        self,
        rows: slice = slice(None),
        columns: slice | NDArray[np.integer] | Sequence[int] = slice(None),
    ) -> NDArray[np.float64]:
        """Return some samples in double precision, copied where they are held in single."""
        return np.asarray(self.acceleration[rows, columns], dtype=np.float64)

    def stretches(self) -> Iterator[NDArray[np.float64]]:
        """Yield all samples in double precision, some rows at a time."""
        for first in range(0, len(self.acceleration), ROWS_AT_ONCE):
            yield self.widened(slice(first, first + ROWS_AT_ONCE))

    def part(self, rows: slice) -> 'Samples':
        """Return some rows, not copied."""
        known = None if self.known is None else self.known[rows]
        first = rows.indices(len(self.acceleration))[0]
        since_ns = self.start_ns + round(first / self.sample_rate_hz * NANOSECONDS_PER_SECOND)
        return replace(self, acceleration=self.acceleration[rows], known=known, start_ns=since_ns)

    def select(self, names: Sequence[str]) -> 'Samples':
        """Return the named channels, in that order.

        Raises
        ------
        LayoutError
            A name is not among the channels.
        """
        have = self.channel_names
        for name in names:
            if name not in have:
                raise LayoutError('unknown channel', found=name, expected=', '.join(have))
        columns = [have.index(name) for name in names]
        return Samples(
            acceleration=self.acceleration[:, columns],
            sample_rate_hz=self.sample_rate_hz,
            channels=tuple(self.channels[column] for column in columns),
            start_ns=self.start_ns,
            known=self.known,
            speed=self.speed,
        )
