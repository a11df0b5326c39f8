"""Numbers that a file stores packed, as the CF conventions have it for NetCDF and HDF5.

References
----------
.. [1] CF conventions 1.11, sections 2.5.1 (missing data) and 8.1 (packed data),
   https://cfconventions.org
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_recordings.formats.named_arrays import Values

SCALE, OFFSET = 'scale_factor', 'add_offset'
MISSING = ('_FillValue', 'missing_value')
NEVER_WRITTEN = 9.969209968386869e36
"""What the NetCDF library puts where a program has written nothing."""


class Packed:
    """Values as they are meant: scaled, moved, and NaN where nothing was measured."""

    def __init__(
        self, values: Values, scale: float, offset: float, missing: tuple[float, ...]
    ) -> None:
        self._values, self._scale, self._offset, self._missing = values, scale, offset, missing
        self.shape: tuple[int, ...] = values.shape
        self.dtype: np.dtype[np.generic] = np.dtype(np.float64)

    def __getitem__(self, key: Any, /) -> NDArray[np.float64]:
        """Return a part."""
        stored = np.asarray(self._values[key])
        found = np.asarray(stored * self._scale + self._offset, dtype=np.float64)
        with np.errstate(all='ignore'):
            # As the file holds it: a single precision number is none of double precision.
            gone = np.array(self._missing).astype(stored.dtype)
        for value in gone:
            found[stored == value] = np.nan
        return found


def unpacked(values: Values, attributes: Mapping[str, Any]) -> Values:
    """Return values as the attributes of their variable say they are meant."""
    scale, offset = (_number(attributes.get(name)) for name in (SCALE, OFFSET))
    told = (_number(attributes.get(name)) for name in MISSING)
    missing = [value for value in told if value is not None]
    if values.dtype.kind == 'f':
        missing.append(NEVER_WRITTEN)
    if scale is None and offset is None and not missing:
        return values
    return Packed(values, 1.0 if scale is None else scale, offset or 0.0, tuple(missing))


def _number(value: Any) -> float | None:
    found = np.asarray(value)
    return float(found.ravel()[0]) if found.size == 1 and found.dtype.kind in 'fiu' else None
