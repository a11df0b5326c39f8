"""The columns of a table that are its joint states."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import JointSamples
from modal_recordings.tables.array_columns import table_headings, without_columns
from modal_recordings.tables.array_options import ArrayOptions
from modal_recordings.tables.array_table import ArrayTable
from modal_recordings.tables.heading import Heading
from modal_recordings.tables.joint_headings import joint_columns_of, JointColumn, JointColumns

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointRows:
    """Joint states beside responses, row by row.

    Parameters
    ----------
    table : ArrayTable
        Of all columns.
    names : tuple of str
        Of the joints.
    columns : JointColumns
        Which columns they are.
    """

    table: ArrayTable
    names: tuple[str, ...]
    columns: JointColumns

    def samples(self, stamp_ns: NDArray[np.int64], rows: slice = slice(None)) -> JointSamples:
        """Return those of some rows, which were taken at these times."""
        values = self.table.values[rows]

        def of(columns: tuple[JointColumn, ...]) -> Array:
            if not columns:
                return np.full((len(values), len(self.names)), np.nan)
            factors = np.array([it.factor for it in columns])
            return np.asarray(values[:, [it.column for it in columns]] * factors, dtype=float)

        position, velocity, effort = map(
            of, (self.columns.position, self.columns.velocity, self.columns.effort)
        )
        return JointSamples(stamp_ns, self.names, position, velocity, effort)


def joints_apart(
    path: Path, table: ArrayTable, options: ArrayOptions, joint_names: Sequence[str]
) -> tuple[ArrayTable, ArrayOptions, JointRows | None]:
    """Return table and options without the columns of the joints, and these; None without any.

    Raises
    ------
    RecordingError
        Two sets of columns tell the same of the joints.

    See Also
    --------
    joint_columns_of : How columns of joints are called.
    """
    headings = [it or Heading('') for it in table_headings(path, table, options)]
    columns = joint_columns_of(path, headings, joint_names)
    if columns is None:
        return table, options, None
    rest, options = without_columns(table, options, {it.column for it in columns.all})
    return rest, options, JointRows(table, tuple(joint_names), columns)
