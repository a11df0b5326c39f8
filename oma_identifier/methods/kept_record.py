"""The samples of a record, for methods that have no covariances to keep instead."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import IdentificationError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples

MOST_BYTES = 256 * 2**20


class KeptRecord:
    """Joins windows that overlap to one stretch of samples, in bounded memory.

    Parameters
    ----------
    method : str
        Named in errors.
    """

    def __init__(self, method: str) -> None:
        self._method = method
        self._parts: list[NDArray[np.floating]] = []
        self._first: Samples | None = None
        self._end_ns = 0
        self._n_bytes = 0
        self._refusal: str | None = None

    def add(self, samples: Samples) -> None:
        """Add what is new in a window."""
        if self._refusal is not None:
            return
        new = self._new_rows(samples)
        self._n_bytes += new.nbytes
        if self._n_bytes > MOST_BYTES:
            self._refuse(f'more than {MOST_BYTES >> 20} MB of samples')
        if self._refusal is None:
            self._parts.append(new.copy())
            self._end_ns = samples.end_ns

    def _new_rows(self, samples: Samples) -> NDArray[np.floating]:
        if self._first is None:
            self._first = replace(samples, acceleration=samples.acceleration[:0].copy())
            return samples.acceleration
        rate_hz = samples.sample_rate_hz
        same = samples.channels == self._first.channels and rate_hz == self._first.sample_rate_hz
        first = round((self._end_ns - samples.start_ns) * rate_hz / NANOSECONDS_PER_SECOND)
        if not same or first < 0:
            self._refuse('channels that come or go' if not same else 'a gap in the record')
        return samples.acceleration[max(first, 0) :]

    def _refuse(self, found: str) -> None:
        self._refusal, self._parts = found, []

    def samples(self) -> Samples:
        """Return the whole record.

        Raises
        ------
        IdentificationError
            Nothing was added, or the windows do not join, or are too many to keep.
        """
        if self._refusal is not None:
            raise IdentificationError(
                f'{self._method} cannot identify this record as one',
                found=self._refusal,
                expected='one stretch of samples',
                advice='use ssi_cov, or shorten the record',
            )
        if self._first is None:
            raise IdentificationError(
                'nothing to identify', expected='at least one window that can be identified'
            )
        return replace(self._first, acceleration=np.concatenate(self._parts))
