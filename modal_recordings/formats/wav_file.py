"""WAV files: shares of full scale, at the rate of their header."""

from pathlib import Path
import struct
from typing import Any
import warnings

import numpy as np
from numpy.typing import NDArray
from scipy.io import wavfile

from modal_core.errors import RecordingError
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays

FULL_SCALE = {'i2': 2.0**15, 'i4': 2.0**31, 'u1': 2.0**7, 'i8': 2.0**63}


class Scaled:
    """Samples of a sound card over full scale, -1 to 1."""

    def __init__(self, samples: NDArray[Any]) -> None:
        self._samples = samples
        self.shape: tuple[int, ...] = samples.shape
        self.dtype: np.dtype[np.generic] = np.dtype(np.float64)
        self._full = FULL_SCALE.get(samples.dtype.str[1:], 1.0)
        self._zero = self._full if samples.dtype.kind == 'u' else 0.0

    def __getitem__(self, key: Any, /) -> NDArray[np.float64]:
        """Return a part."""
        return (np.asarray(self._samples[key], dtype=np.float64) - self._zero) / self._full


def read(path: Path) -> NamedArrays:
    """Return the channels of a WAV file; what full scale is must be said, ``--unit '50 m/s^2'``.

    Raises
    ------
    RecordingError
        Damaged, truncated, or of a compressed kind.
    """
    with warnings.catch_warnings():
        warnings.simplefilter('error', wavfile.WavFileWarning)
        # Chunks beside the samples are no concern of ours.
        warnings.filterwarnings('ignore', message='Chunk .non-data. not understood')
        try:
            rate_hz, samples = wavfile.read(path, mmap=_mapped(path))
        except (ValueError, wavfile.WavFileWarning, OSError, EOFError, struct.error, TypeError,
                ArithmeticError, MemoryError, UnboundLocalError) as error:  # fmt: skip
            # A header that says nonsense leaves the reader of SciPy without its own variables.
            raise RecordingError(
                'damaged or truncated WAV file', where=path, found=str(error)
            ) from error
    array = NamedArray('samples', Scaled(samples), sample_rate_hz=float(rate_hz))
    return NamedArrays((array,), calibrated=False)


def _mapped(path: Path) -> bool:
    """Tell whether the samples can be mapped: 24 bits are unpacked by reading."""
    with path.open('rb') as file:
        head = file.read(4096)
    place = head.find(b'fmt ')
    bits = int.from_bytes(head[place + 22 : place + 24], 'little') if place >= 0 else 0
    return bits in (8, 16, 32, 64)
