"""Modes and lines as a table, one row each."""

import numpy as np

from autonomous_modal_analysis.export.exported import Exported
from autonomous_modal_analysis.export.table import Table
from modal_core.mode import MODE_FIELDS


def table_of_modes(exported: Exported) -> Table:
    """Return every quantity by name, entries of shapes by channel in two parts."""
    modes = exported.listed
    fields = [item for item in MODE_FIELDS if item.single]
    kinds: dict[str, type] = {item.column: item.kind for item in fields}
    columns: list[list[object]] = [[getattr(mode, item.name) for mode in modes] for item in fields]
    for row, name in enumerate(exported.modes.channel_names):
        entries = np.array([mode.shape[row] for mode in modes], dtype=complex)
        kinds |= {f'shape_real.{name}': float, f'shape_imag.{name}': float}
        columns += [entries.real.tolist(), entries.imag.tolist()]
    return Table(kinds, [columns], exported.about)
