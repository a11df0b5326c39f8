"""Modes as files of other programs: UFF, MATLAB, NetCDF, Parquet, CSV.

In come modes and, where it is known, where their channels are; out goes one file, whole or not at
all. The ending of its name says which kind.
"""

from autonomous_modal_analysis.export.export import export_modes, KINDS
from autonomous_modal_analysis.export.exported import Exported

__all__ = ['KINDS', 'Exported', 'export_modes']
