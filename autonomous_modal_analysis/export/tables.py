"""Tables of modes and lines, one row each: CSV and Parquet."""

import csv
from pathlib import Path

import numpy as np

from autonomous_modal_analysis.api.optional import optional
from autonomous_modal_analysis.export.exported import Exported
from autonomous_modal_analysis.results import plain
from modal_core.mode import MODE_FIELDS


def write_csv(path: Path, exported: Exported) -> None:
    """Write a CSV file (RFC 4180); an unknown number is left empty."""
    columns = _columns(exported)
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(columns)
        writer.writerows(zip(*(map(plain, column) for column in columns.values()), strict=True))


def write_parquet(path: Path, exported: Exported) -> None:
    """Write a Parquet file.

    Raises
    ------
    ModalAnalysisError
        pandas or pyarrow is not installed.
    """
    optional('pyarrow')
    table = optional('pandas').DataFrame(_columns(exported))
    table.attrs = dict(exported.about)
    table.to_parquet(path, engine='pyarrow')


def _columns(exported: Exported) -> dict[str, list[object]]:
    """Return every quantity by name, entries of shapes by channel in two parts."""
    modes = exported.listed
    columns: dict[str, list[object]] = {
        item.column: [getattr(mode, item.name) for mode in modes]
        for item in MODE_FIELDS
        if item.single
    }
    for row, name in enumerate(exported.modes.channel_names):
        entries = np.array([mode.shape[row] for mode in modes], dtype=complex)
        columns[f'shape_real.{name}'] = entries.real.tolist()
        columns[f'shape_imag.{name}'] = entries.imag.tolist()
    return columns
