"""Recordings that are one and the same: held out, one would agree with itself, noise and all."""

from collections.abc import Iterable
from hashlib import blake2b
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError


def refuse_copies(
    recordings: Iterable[tuple[str, Iterable[NDArray[np.float64]]]], folder: Path
) -> None:
    """Refuse a campaign that holds the samples of one recording twice.

    Noise makes samples differ: recordings of one motion at one pose are never equal to the bit.

    Parameters
    ----------
    recordings : iterable of (name, arrays)
        Samples of every recording.
    folder : Path
        Of the campaign, for the error.

    Raises
    ------
    RecordingError
        Two recordings have the same samples.
    """
    seen: dict[bytes, str] = {}
    for name, arrays in recordings:
        summed = blake2b()
        for values in arrays:
            summed.update(np.ascontiguousarray(values).data)
        digest = summed.digest()
        if (first := seen.get(digest)) is not None:
            raise RecordingError(
                'two recordings with the same samples',
                where=folder,
                found=f'{first} and {name}',
                expected='each recording once',
                advice='leave one out, or record the pose again',
            )
        seen[digest] = name
