"""A table: columns by name, with kinds and units, in one part or in many."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

UNITS = {
    'hz': 'Hz', 's': 's', 'ns': 'ns', 'm': 'm', 'kg': 'kg', 'n': 'N', 'c': 'degC', 'rpm': '1/min',
    'rad': 'rad', 'deg': 'deg', 'rad_s': 'rad/s', 'deg_s': 'deg/s', 'rad_s2': 'rad/s^2',
    'm_s2': 'm/s^2',
}  # fmt: skip
"""What the ends of names mean, as NetCDF and other programs write it."""
LONGEST_END = max(end.count('_') + 1 for end in UNITS)
Column = Sequence[Any] | NDArray[Any]


def unit_of(name: str) -> str:
    """Return the unit that the name of a column ends in; 1 where it ends in none."""
    words = name.partition('.')[0].split('_')
    ends = ('_'.join(words[-count:]) for count in range(LONGEST_END, 0, -1) if count < len(words))
    return next((UNITS[end] for end in ends if end in UNITS), '1')


@dataclass(frozen=True)
class Table:
    """Columns of one length.

    Parameters
    ----------
    kinds : mapping of str to type
        Names of the columns with their units at the end (``frequency_hz``, ``axis_deg.axis_1``),
        and what they hold: str, int, float or bool.
    parts : iterable of sequence of column
        Rows a few at a time, so that a table larger than the memory can be written: in each
        part one sequence per column, all of one length.  A number that is not known is NaN or
        None.
    about : mapping of str to str
        Where it comes from, version of the software and the like.
    """

    kinds: Mapping[str, type]
    parts: Iterable[Sequence[Column]]
    about: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, columns: Mapping[str, Column], about: Mapping[str, str]) -> 'Table':
        """Return the table of columns that are all there."""
        kinds = {name: _kind(column) for name, column in columns.items()}
        return cls(kinds, [list(columns.values())], about)

    def columns(self) -> dict[str, list[Any]]:
        """Return all rows by column, for files that are written at once."""
        found: dict[str, list[Any]] = {name: [] for name in self.kinds}
        for part in self.parts:
            for name, column in zip(found, part, strict=True):
                found[name] += column
        return found


def _kind(column: Column) -> type:
    """Return what a column holds; of one without a value it is numbers."""
    if isinstance(column, np.ndarray):
        return {'b': bool, 'i': int, 'u': int, 'f': float}.get(column.dtype.kind, str)
    known = [value for value in column if value is not None]
    for kind, matches in ((bool, bool | np.bool_), (int, Integral), (float, Real)):
        if all(isinstance(value, matches) for value in known):
            # A number that is not known has no place among whole ones.
            return kind if known and len(known) == len(column) else float
    return str
