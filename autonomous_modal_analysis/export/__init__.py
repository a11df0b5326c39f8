"""Results as files of other programs: UFF, MATLAB, NetCDF, Parquet, CSV.

In come modes and, where it is known, where their channels are, samples on one clock, or a table;
out goes one file, whole or not at all. The ending of its name says which kind.
"""

from autonomous_modal_analysis.export.arm_modes import export_arm_modes
from autonomous_modal_analysis.export.export import ENDINGS, export_modes
from autonomous_modal_analysis.export.exported import Exported
from autonomous_modal_analysis.export.samples import export_samples, ExportedSamples
from autonomous_modal_analysis.export.table import Table
from autonomous_modal_analysis.export.table_files import export_table, TABLE_ENDINGS
from autonomous_modal_analysis.export.write_by_ending import check_endings, ending_of

__all__ = [
    'ENDINGS',
    'TABLE_ENDINGS',
    'Exported',
    'ExportedSamples',
    'Table',
    'check_endings',
    'ending_of',
    'export_arm_modes',
    'export_modes',
    'export_samples',
    'export_table',
]
