"""Which kind of file an ending means for modes."""

from collections.abc import Callable
from pathlib import Path

from autonomous_modal_analysis.export.arrays import write_matlab, write_netcdf
from autonomous_modal_analysis.export.exported import Exported
from autonomous_modal_analysis.export.table_files import write_csv, write_parquet
from autonomous_modal_analysis.export.tables import table_of_modes
from autonomous_modal_analysis.export.universal import write_universal
from autonomous_modal_analysis.export.write_by_ending import write_by_ending

WRITERS: dict[str, Callable[[Path, Exported], None]] = {
    '.uff': write_universal,
    '.unv': write_universal,
    '.mat': write_matlab,
    '.nc': write_netcdf,
    '.parquet': lambda path, exported: write_parquet(path, table_of_modes(exported)),
    '.csv': lambda path, exported: write_csv(path, table_of_modes(exported)),
}
ENDINGS = tuple(WRITERS)


def export_modes(path: Path, exported: Exported) -> None:
    """Write modes into a file of the kind its ending says, whole or not at all.

    Raises
    ------
    SettingsError
        No such kind.
    ModalAnalysisError
        A library that it needs is not installed.
    OSError
        It cannot be written.
    """
    write_by_ending(path, WRITERS, exported)
