"""Modes and samples as files of other programs: UFF, MATLAB, NetCDF, Parquet, CSV.

In come modes and, where it is known, where their channels are, or samples on one clock; out goes
one file, whole or not at all. The ending of its name says which kind.
"""

from autonomous_modal_analysis.export.export import ENDINGS, export_modes, KINDS
from autonomous_modal_analysis.export.exported import Exported
from autonomous_modal_analysis.export.samples import export_samples, ExportedSamples

__all__ = ['ENDINGS', 'KINDS', 'Exported', 'ExportedSamples', 'export_modes', 'export_samples']
