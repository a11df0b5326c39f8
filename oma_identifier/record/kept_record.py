"""The samples of a record, in bounded memory: beyond it at ever lower rates."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from oma_identifier.covariance import COVARIANCE, Decimator, STEP

VALUES_AT_ONCE = 2**20
"""Of a window that are taken over: more would be held twice, beside what is kept."""


@dataclass(slots=True)
class _Part:
    """Samples without a gap; what comes passes one decimation stage after the other."""

    sample_rate_hz: float
    start_ns: int
    end_ns: int
    rows: list[NDArray[np.float32]] = field(default_factory=list)
    stages: list[Decimator] = field(default_factory=list)

    def add(self, rows: NDArray[np.floating]) -> None:
        for stage in self.stages:
            rows = stage.decimate(rows)
        self.rows.append(rows.astype(np.float32))

    def thin(self) -> None:
        """Decimate what is kept, and what will come."""
        stage = Decimator(STEP, COVARIANCE.upper_undecimated)
        # Its first value belongs to the middle of its taps.
        delay_s = 0.5 * (len(stage.taps) - 1) / self.sample_rate_hz
        self.start_ns += round(delay_s * NANOSECONDS_PER_SECOND)
        self.stages.append(stage)
        self.sample_rate_hz /= STEP
        self.rows = [stage.decimate(rows).astype(np.float32) for rows in self.rows]

    @property
    def n_bytes(self) -> int:
        return sum(rows.nbytes for rows in self.rows)


class KeptRecord:
    """Joins windows of the same channels and rate, which may overlap, to stretches between gaps.

    Kept is single precision, about the first sample: gravity would cost most of its digits.

    Parameters
    ----------
    like : Samples
        The first window.
    most_bytes : int
        Where there are more samples, all are decimated by four.
    """

    def __init__(self, like: Samples, most_bytes: int) -> None:
        self._n_known = 0 if like.known is None else like.known.shape[1]
        self._like = replace(like, acceleration=like.acceleration[:0].copy(), known=None)
        known = np.zeros(self._n_known, dtype=like.acceleration.dtype)
        self._offset = np.append(like.acceleration[0], known)
        self._most_bytes = most_bytes
        self._parts: list[_Part] = []
        self._n_stages = 0

    @property
    def is_decimated(self) -> bool:
        """Whether the samples are kept at a lower rate than they came with."""
        return self._n_stages > 0

    @property
    def sample_rate_hz(self) -> float:
        """At which samples are kept [Hz]."""
        return float(self._like.sample_rate_hz / STEP**self._n_stages)

    def fits(self, samples: Samples) -> bool:
        """Tell whether samples are of the same channels and rate."""
        like = self._like
        same = like.sample_rate_hz == samples.sample_rate_hz
        return same and like.channels == samples.channels

    def add(self, samples: Samples) -> float:
        """Add what is new in a window; return how long that is [s]."""
        rate_hz, first = samples.sample_rate_hz, 0
        part = self._parts[-1] if self._parts else None
        if part is not None and samples.start_ns <= part.end_ns:
            first = round((part.end_ns - samples.start_ns) * rate_hz / NANOSECONDS_PER_SECOND)
        else:
            part = _Part(rate_hz, samples.start_ns, samples.start_ns)
            for _ in range(self._n_stages):
                part.thin()
            self._parts.append(part)
        new = samples.acceleration[first:]
        if len(new) == 0:
            return 0.0
        at_once = max(1, VALUES_AT_ONCE // new.shape[1])
        for begin in range(0, len(new), at_once):
            rows = slice(first + begin, first + begin + at_once)
            part.add(self._rows(samples, rows) - self._offset)
            self._make_room()
        part.end_ns = samples.end_ns
        return len(new) / rate_hz

    def _rows(self, samples: Samples, rows: slice) -> NDArray[np.floating]:
        """Return some rows, beside them their known inputs; NaN where these are missing."""
        if not self._n_known:
            return samples.acceleration[rows]
        responses = samples.acceleration[rows]
        known = np.full((len(responses), self._n_known), np.nan)
        if samples.known is not None and samples.known.shape[1] == self._n_known:
            known = samples.known[rows]
        return np.concatenate([responses, known], axis=1)

    def _make_room(self) -> None:
        while sum(each.n_bytes for each in self._parts) > self._most_bytes:
            for each in self._parts:
                each.thin()
            self._n_stages += 1

    def parts(self) -> list[Samples]:
        """Return the stretches between gaps, the longest first."""
        for part in self._parts:
            part.rows = [np.concatenate(part.rows)]
        found = [
            replace(
                self._like,
                acceleration=part.rows[0][:, : len(self._like.channels)],
                known=part.rows[0][:, len(self._like.channels) :] if self._n_known else None,
                sample_rate_hz=self.sample_rate_hz,
                start_ns=part.start_ns,
            )
            for part in self._parts
            if len(part.rows[0])
        ]
        return sorted(found, key=_length)


def _length(samples: Samples) -> int:
    return -len(samples.acceleration)
