"""Tables as CSV, Parquet, MATLAB and NetCDF files."""

from collections.abc import Callable
import csv
import json
from pathlib import Path
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from autonomous_modal_analysis.api.optional import optional
from autonomous_modal_analysis.export.netcdf import add_texts, netcdf
from autonomous_modal_analysis.export.table import Table, unit_of
from autonomous_modal_analysis.export.write_by_ending import write_by_ending
from autonomous_modal_analysis.identified.results import plain


def export_table(path: Path, table: Table) -> None:
    """Write a table into a file of the kind its ending says, whole or not at all.

    Raises
    ------
    SettingsError
        No such kind, or one that holds no tables.
    ModalAnalysisError
        A library that it needs is not installed.
    OSError
        It cannot be written.
    """
    write_by_ending(path, TABLE_WRITERS, table)


def write_csv(path: Path, table: Table) -> None:
    """Write a CSV file (RFC 4180), a part at a time; an unknown number is left empty."""
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(table.kinds)
        for part in table.parts:
            writer.writerows(zip(*(map(plain, column) for column in part), strict=True))


def write_parquet(path: Path, table: Table) -> None:
    """Write a Parquet file, a part at a time; an unknown number is null.

    Raises
    ------
    ModalAnalysisError
        pyarrow is not installed.
    """
    arrow, parquet = optional('pyarrow'), optional('pyarrow.parquet')
    kinds = {str: arrow.string(), int: arrow.int64(), float: arrow.float64(), bool: arrow.bool_()}
    # As pandas keeps what a table says of itself (DataFrame.attrs).
    about = {'PANDAS_ATTRS': json.dumps(dict(table.about))}
    columns = [(name, kinds[kind]) for name, kind in table.kinds.items()]
    schema = arrow.schema(columns, metadata=about)
    with parquet.ParquetWriter(path, schema, compression='zstd') as writer:
        for part in table.parts:
            arrays = [
                arrow.array(column, type=kind, from_pandas=True)
                for column, (_, kind) in zip(part, columns, strict=True)
            ]
            writer.write_table(arrow.table(arrays, schema=schema))


def write_matlab(path: Path, table: Table) -> None:
    """Write a MATLAB 5 file: a column each, its name with _ for what MATLAB does not take."""
    content: dict[str, Any] = {}
    for name, column in table.columns().items():
        own = _variable(name, content)
        kind = table.kinds[name]
        content[own] = np.array(column, object) if kind is str else _numbers(column)
    content['column_names'] = np.array(list(table.kinds), object)
    content['column_units'] = np.array(list(map(unit_of, table.kinds)), object)
    content['about'] = dict(table.about)
    with path.open('wb') as file:
        savemat(file, content, oned_as='column')


def write_netcdf(path: Path, table: Table) -> None:
    """Write a NetCDF 3 file with the dimension ``row``; texts are rows of letters."""
    with netcdf(path, table.about) as file:
        columns = table.columns()
        file.createDimension('row', len(next(iter(columns.values()), [])))
        for name, column in columns.items():
            own = name.replace('/', '_')
            if table.kinds[name] is str:
                add_texts(file, own, 'row', column)
                continue
            variable = file.createVariable(own, 'd', ('row',))
            variable[:] = _numbers(column)
            variable.units = unit_of(name)


def _numbers(column: list[Any]) -> NDArray[np.float64]:
    """Return numbers of any kind, NaN where one is not known."""
    return np.array([np.nan if value is None else value for value in column], dtype=float)


def _variable(name: str, taken: dict[str, Any]) -> str:
    """Return a name of a variable of MATLAB that is not taken yet."""
    word = re.sub(r'\W', '_', name, flags=re.ASCII)
    word = word if word[:1].isalpha() else f'x{word}'
    while word in taken:
        word += '_'
    return word


TABLE_WRITERS: dict[str, Callable[[Path, Table], None]] = {
    '.mat': write_matlab,
    '.nc': write_netcdf,
    '.parquet': write_parquet,
    '.csv': write_csv,
}
TABLE_ENDINGS = tuple(TABLE_WRITERS)
