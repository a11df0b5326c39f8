"""The one kit every HTML report is made of: page, palette, charts, tables, words.

A report comes in as a template with values (`Page`) and goes out as one HTML file that opens
offline (`render`).  Colours are in `palette`, and nowhere else; numbers with their deviation are
written by `with_sigma`, or by a `Quantity` that knows its unit; each chart has one
implementation in `charts`.  The kit knows `modal_core` only.
"""

from modal_reports.charts import (
    Bar,
    bar_chart,
    error_mark,
    Geometry,
    heat_map,
    interpolate_displacements,
    LARGE,
    meter,
    mode_shapes_data,
    pooled,
    sensor_displacements,
    SMALL,
    Spectrum,
    spectrum_plot,
    stabilisation_data,
    Strip,
    svg,
    tracks_data,
)
from modal_reports.health_words import channel_words, flag_words, quality_words
from modal_reports.mode_words import HARMONIC, mark, SCATTERED, SCATTERED_MEANS
from modal_reports.numbers import (
    deviation_text,
    fixed,
    Number,
    percent,
    significant,
    UNKNOWN,
    value_text,
    with_sigma,
)
from modal_reports.page import embedded_json, Page, render
from modal_reports.palette import HeatScale
from modal_reports.quantities import (
    DAMPING,
    FREQUENCY,
    MAC,
    MPC,
    MPD,
    PHASE,
    Quantity,
)
from modal_reports.tables import (
    Cell,
    heading,
    measured,
    number,
    Row,
    Table,
    tags,
    text,
    value_and_sigma,
)
from modal_reports.words import capital, count, duration, listed

__all__ = [
    'DAMPING',
    'FREQUENCY',
    'HARMONIC',
    'LARGE',
    'MAC',
    'MPC',
    'MPD',
    'PHASE',
    'SCATTERED',
    'SCATTERED_MEANS',
    'SMALL',
    'UNKNOWN',
    'Bar',
    'Cell',
    'Geometry',
    'HeatScale',
    'Number',
    'Page',
    'Quantity',
    'Row',
    'Spectrum',
    'Strip',
    'Table',
    'bar_chart',
    'capital',
    'channel_words',
    'count',
    'deviation_text',
    'duration',
    'embedded_json',
    'error_mark',
    'fixed',
    'flag_words',
    'heading',
    'heat_map',
    'interpolate_displacements',
    'listed',
    'mark',
    'measured',
    'meter',
    'mode_shapes_data',
    'number',
    'percent',
    'pooled',
    'quality_words',
    'render',
    'sensor_displacements',
    'significant',
    'spectrum_plot',
    'stabilisation_data',
    'svg',
    'tags',
    'text',
    'tracks_data',
    'value_and_sigma',
    'value_text',
    'with_sigma',
]
