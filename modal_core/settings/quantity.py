"""What a field of a result is, written once beside it: words, unit and range.

Files and messages are written and read by it, and the documents' table is made from it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, Field, field, fields, MISSING
import math
from typing import Any, get_type_hints

import numpy as np
from numpy.typing import NDArray

SCALARS = (float, int, bool)
# The largest entry of a shape is 1; the fourth powers that a MAC is made of stay numbers.
SMALLEST_LARGEST, LARGEST_ENTRY = 1e-12, 1e12


@dataclass(frozen=True, slots=True)
class Quantity:
    """One field of a dataclass of results.

    Parameters
    ----------
    name, text, unit : str
        What it is called and what it means; a pure number has no unit.
    kind : type
        float, int or bool; complex for an array with an entry per channel.
    low, high : float
        Range; of an array that of its parts.
    default : value
        Where it is not known; MISSING: it always is.
    single : bool
        Whether a table of results has a column for it.
    """

    name: str
    text: str
    unit: str
    kind: type
    low: float
    high: float
    default: Any
    single: bool

    @property
    def keys(self) -> tuple[str, ...]:
        """Names in files and messages: a complex one has two parts."""
        if self.kind is complex:
            return f'{self.name}_real', f'{self.name}_imag'
        return (self.name,)

    @property
    def column(self) -> str:
        """Name of a column, which tells the unit."""
        told = not self.unit or self.unit.lower() in self.name.split('_')
        return self.name if told else f'{self.name}_{self.unit}'

    def write(self, value: Any) -> dict[str, Any]:
        """Return a value by the names of files and messages."""
        if self.kind is not complex:
            return {self.name: value}
        parts = (None, None) if value is None else (np.real(value), np.imag(value))
        return dict(zip(self.keys, parts, strict=True))

    def read(self, values: Mapping[str, Any], n_channels: int) -> Any:
        """Return a value as it was written.

        Raises
        ------
        ValueError, TypeError, OverflowError
            It is not what can be written.
        """
        found = [values.get(key) for key in self.keys]
        if self.kind is complex:
            return self._array(found, n_channels)
        if self.kind is bool:
            return self.default if found[0] is None else bool(found[0])
        return self._number(found[0])

    def _number(self, found: Any) -> float | int:
        value = math.nan if found is None or isinstance(found, bool | str) else float(found)
        unknown = self.kind is float and self.default is not MISSING
        if unknown and (found is None or (isinstance(found, float) and math.isnan(found))):
            return math.nan
        if not (math.isfinite(value) and self.low <= value <= self.high):
            raise ValueError(f'{self.name} {found}, expected {self.low:g} to {self.high:g}')
        return self.kind(value)  # type: ignore[no-any-return]

    def _array(self, parts: list[Any], n_channels: int) -> NDArray[np.complex128] | None:
        """Return complex entries, NaN where both parts are: points that were not seen."""
        known = [part for part in parts if part is not None and len(part)]
        if not known and self.default is None:
            return None
        real, imaginary = (np.asarray(part, dtype=float) for part in parts)
        if real.shape != (n_channels,) or imaginary.shape != (n_channels,):
            raise ValueError(f'no {self.name} of {n_channels} channels')
        if not np.array_equal(np.isnan(real), np.isnan(imaginary)):
            raise ValueError(f'{self.name} not finite')
        both = np.concatenate([real, imaginary])
        size = np.nan_to_num(np.abs(both))
        if (size > LARGEST_ENTRY).any() or (both < self.low).any():
            raise ValueError(f'{self.name} not finite, or below {self.low:g}')
        if self.default is MISSING and not (size > SMALLEST_LARGEST).any():
            raise ValueError(f'{self.name} is zero')
        return np.asarray(real + 1j * imaginary)


def quantity(
    text: str,
    unit: str = '',
    low: float = -math.inf,
    high: float = math.inf,
    default: Any = MISSING,
    single: bool = True,
) -> Any:
    """Return a dataclass field that is a quantity; see :class:`Quantity`."""
    words = {'text': text, 'unit': unit, 'low': low, 'high': high, 'single': single}
    return field(default=default, metadata=words)


def quantities_of(owner: type) -> Iterator[Quantity]:
    """Yield the quantities of a dataclass, in order."""
    hints = get_type_hints(owner)
    for item in fields(owner):
        yield _quantity(item, hints[item.name])


def _quantity(item: Field[Any], hint: Any) -> Quantity:
    kind = hint if hint in SCALARS else complex
    words = {**item.metadata, 'single': item.metadata['single'] and kind is not complex}
    return Quantity(item.name, kind=kind, default=item.default, **words)
