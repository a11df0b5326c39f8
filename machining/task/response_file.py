"""A measured frequency response at the tool, as a table."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from machining.cut_settings import KINDS
from modal_core.errors import SettingsError
from modal_core.files.small_file import read_text

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
LARGEST_BYTES = 50_000_000
FEWEST_LINES = 8
AXES = 'xyz'


@dataclass(frozen=True, slots=True)
class ToolResponse:
    """Receptance at the tool.

    Parameters
    ----------
    frequency_hz : (n_lines,) array [Hz]
        Rising.
    receptance : (n_lines, 3, 3) array [m/N]
        Displacement along the second axis per force along the third.
    """

    frequency_hz: Real
    receptance: Complex

    def turned(self, axes: Real) -> 'ToolResponse':
        """Return the response in other axes: unit vectors as rows, in the present ones."""
        return ToolResponse(self.frequency_hz, axes @ self.receptance @ axes.T)


def read_response(path: str | Path, kind: str = 'receptance') -> ToolResponse:
    """Read a table with columns frequency_hz, xx_real, xx_imag, xy_real, ... zz_imag.

    What has no column is taken as 0; of a cross term one of xy and yx is enough (reciprocity).

    Parameters
    ----------
    path : path
        CSV; the first row names the columns.
    kind : str
        ``receptance`` [m/N], ``mobility`` [m/(N s)] or ``accelerance`` [m/(N s²)].

    Raises
    ------
    SettingsError
        It is no such table.
    """
    if kind not in KINDS:
        raise SettingsError('unknown kind of response', found=kind, expected=', '.join(KINDS))
    path = Path(path)
    head, _, rest = read_text(path, LARGEST_BYTES).lstrip().partition('\n')
    names = [name.strip() for name in head.split(',')]
    terms = {f'{i}{j}' for i in AXES for j in AXES}
    known = {'frequency_hz', *(f'{term}_{part}' for term in terms for part in ('real', 'imag'))}
    wrong = [name for name in names if name not in known]
    if wrong or len(set(names)) != len(names) or names[0] != 'frequency_hz':
        raise SettingsError(
            'no table of a response',
            where=path,
            found=head[:80],
            expected='frequency_hz, xx_real, xx_imag, ...',
        )
    table = _table(rest, len(names), path)
    columns = dict(zip(names, table.T, strict=True))
    frequency_hz = columns['frequency_hz']
    if not (np.diff(frequency_hz) > 0.0).all() or frequency_hz[0] <= 0.0:
        raise SettingsError('frequencies do not rise from above 0', where=path)
    order = KINDS.index(kind)
    response = _terms(columns, path) / (2j * np.pi * frequency_hz[:, None, None]) ** order
    return ToolResponse(frequency_hz, response)


def _table(rest: str, n_columns: int, path: Path) -> Real:
    rows = [line.split(',') for line in rest.splitlines() if line.strip()]
    if len(rows) < FEWEST_LINES:
        raise SettingsError('too few lines', where=path, found=len(rows), expected='>= 8')
    try:
        table = np.array(rows, float)
    except ValueError as error:
        raise SettingsError('a row without numbers, or of another length', where=path) from error
    if table.shape[1] != n_columns or not np.isfinite(table).all():
        raise SettingsError('a row without numbers, or of another length', where=path)
    return table


def _terms(columns: dict[str, Real], path: Path) -> Complex:
    made = np.zeros((len(columns['frequency_hz']), 3, 3), complex)
    given = np.zeros((3, 3), bool)
    for i, one in enumerate(AXES):
        for j, other in enumerate(AXES):
            parts = [columns.get(f'{one}{other}_{part}') for part in ('real', 'imag')]
            if parts[0] is not None and parts[1] is not None:
                made[:, i, j], given[i, j] = parts[0] + 1j * parts[1], True
            elif parts != [None, None]:
                raise SettingsError('one part only', where=path, found=f'{one}{other}')
    if not given.any():
        raise SettingsError('no term of a response', where=path)
    lent = given.T & ~given
    return np.where(lent, made.transpose(0, 2, 1), made)
