"""Tables in files of other programs, read back with libraries that did not write them."""

import csv
import math
from pathlib import Path
from typing import Any

import pytest
from scipy.io import loadmat, netcdf_file


def rows_of(file: Path) -> list[dict[str, Any]]:
    """Return the rows of a table by the names of its columns."""
    if file.suffix == '.csv':
        with file.open(encoding='utf-8', newline='') as text:
            return list(csv.DictReader(text))
    if file.suffix == '.parquet':
        pytest.importorskip('pyarrow')
        return pytest.importorskip('pandas').read_parquet(file).to_dict('records')
    columns = _matlab(file) if file.suffix == '.mat' else _netcdf(file)
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def number(cell: Any) -> float:
    """Return a number of a table; NaN where none is known."""
    return math.nan if cell in ('', None) else float(cell)


def _matlab(file: Path) -> dict[str, list[Any]]:
    content = loadmat(file)
    own = [name for name in content if not name.startswith(('__', 'column_', 'about'))]
    names = [str(name.item()) for name in content['column_names'].ravel()]
    assert len(own) == len(names)
    return {
        name: [str(value.item()) if value.size else '' for value in content[variable].ravel()]
        if content[variable].dtype == object
        else content[variable].ravel().tolist()
        for name, variable in zip(names, own, strict=True)
    }


def _netcdf(file: Path) -> dict[str, list[Any]]:
    with netcdf_file(file, mmap=False) as content:
        return {
            name: [b''.join(row).decode().strip() for row in variable[:]]
            if variable.typecode() == 'c'
            else variable[:].tolist()
            for name, variable in content.variables.items()
        }
