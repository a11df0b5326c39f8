"""One implementation of each chart.

In come arrays, tables of poles and sets of modes.  For a still picture out goes SVG; for a chart
that moves (zoom, hover, turn) out goes the data that the script of its name in ``static/`` draws.
"""

from modal_reports.charts import svg
from modal_reports.charts.bars import Bar, bar_chart
from modal_reports.charts.channel_spectra import channel_spectra_data, ChannelSpectra
from modal_reports.charts.compared_spectra import compared_spectra_data, ComparedSpectrum
from modal_reports.charts.complexity import complexity_plot
from modal_reports.charts.courses import course_plot, Mark
from modal_reports.charts.curves import Axis, Curves, curves_data, Trace
from modal_reports.charts.damping_plane import damping_plane, PlacedMode
from modal_reports.charts.geometry import (
    Geometry,
    interpolate_displacements,
    sensor_displacements,
)
from modal_reports.charts.heat import heat_map
from modal_reports.charts.lines import LARGE, SMALL, spectrum_plot
from modal_reports.charts.marks import error_mark, meter
from modal_reports.charts.mode_shapes import mode_shapes_data, OtherShape
from modal_reports.charts.over_state import over_state, StatePoint
from modal_reports.charts.spectrogram import Spectrogram, spectrogram_data, SpeedSpectra
from modal_reports.charts.stabilisation import (
    pooled,
    Spectrum,
    stabilisation_data,
    STATUS_WORDS,
)
from modal_reports.charts.tracks import Strip, tracks_data

__all__ = [
    'LARGE',
    'SMALL',
    'STATUS_WORDS',
    'Axis',
    'Bar',
    'ChannelSpectra',
    'ComparedSpectrum',
    'Curves',
    'Geometry',
    'Mark',
    'OtherShape',
    'PlacedMode',
    'Spectrogram',
    'Spectrum',
    'SpeedSpectra',
    'StatePoint',
    'Strip',
    'Trace',
    'bar_chart',
    'channel_spectra_data',
    'compared_spectra_data',
    'complexity_plot',
    'course_plot',
    'curves_data',
    'damping_plane',
    'error_mark',
    'heat_map',
    'interpolate_displacements',
    'meter',
    'mode_shapes_data',
    'over_state',
    'pooled',
    'sensor_displacements',
    'spectrogram_data',
    'spectrum_plot',
    'stabilisation_data',
    'svg',
    'tracks_data',
]
