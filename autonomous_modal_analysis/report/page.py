"""One HTML file that shows a whole identification."""

import math
from pathlib import Path
from typing import Any

from autonomous_modal_analysis.identified.chosen_poles import FORMAT
from autonomous_modal_analysis.identified.mode_tracks import mode_tracks
from autonomous_modal_analysis.identified.results import plain
from autonomous_modal_analysis.report.content import ReportContent
from autonomous_modal_analysis.report.mode_rows import mode_rows
from autonomous_modal_analysis.report.still_pictures import (
    complexity,
    damping_over_frequency,
    mac_map,
)
from autonomous_modal_analysis.report.tables import channels_table, modes_table
from autonomous_modal_analysis.report.words import facts, headline
from modal_core.files.atomic_file import write_text
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_reports import (
    capital,
    channel_spectra_data,
    count,
    mode_shapes_data,
    Page,
    quality_words,
    render,
    SCATTERED,
    SCATTERED_MEANS,
    spectrogram_data,
    stabilisation_data,
    Strip,
    tracks_data,
)
from oma_identifier.covariance import AnalysedBand

TEMPLATE = Path(__file__).parent / 'templates' / 'modal.html.j2'


def write_report(path: Path, content: ReportContent) -> None:
    """Write the report, whole or not at all.

    Parameters
    ----------
    path : Path
        An .html file.
    content : ReportContent
        What it says.
    """
    write_text(path, render_report(content))


def render_report(content: ReportContent) -> str:
    """Return the report as one HTML document.

    Parameters
    ----------
    content : ReportContent
        What it says.  Names in it may come from anywhere: they are only ever shown as text.
    """
    identification = content.identification
    rows, known = mode_rows(content), content.truth is not None
    tracks = mode_tracks(identification.windows)
    charts = _charts(content)
    values = {
        'content': content,
        'spectrogram': charts['spectrogram'],
        'headline': headline(content),
        'facts': facts(content),
        'modes': modes_table(rows, known=known),
        'truth_known': known,
        'scattered': any(row.scattered for row in rows),
        'scattered_words': f'{capital(SCATTERED)}: {SCATTERED_MEANS}.',
        'mac': mac_map(identification.modes),
        'complexity': complexity(identification.modes),
        'damping': damping_over_frequency(identification.modes),
        'quality': quality_words(identification.quality),
        'channels': channels_table(identification.quality.channels),
        'poor_windows': _poor_windows(content),
        'settings': [
            *settings_rows(identification.band, 'band.'),
            *settings_rows(identification.settings),
        ],
        'moving': [track for track in tracks if track.moves_with_pose],
        'capital': capital,
        'count': count,
    }
    page = Page('Modal analysis report', content.title, TEMPLATE, values, charts)
    return render(page)


def settings_rows(settings: object, prefix: str = '') -> list[tuple[str, str]]:
    """Return the settings as (name, value), nested names joined by dots."""
    values: Any = plain(settings)
    rows: list[tuple[str, str]] = []
    if not isinstance(values, dict):
        return rows
    for key, value in values.items():
        name = f'{prefix}{key}'
        if isinstance(value, dict):
            rows += settings_rows(value, f'{name}.')
        else:
            rows.append((name, _value_words(value)))
    return rows


def _value_words(value: object) -> str:
    if value is None:
        return 'automatic'
    if isinstance(value, bool):
        return 'yes' if value else 'no'
    if isinstance(value, float):
        return f'{value:.6g}'
    if isinstance(value, list):
        return ', '.join(_value_words(item) for item in value) or 'none'
    return str(value)


def _charts(content: ReportContent) -> dict[str, object]:
    identification = content.identification
    modes, geometry = identification.modes, content.geometry
    true = {id(true.mode): true for true in content.truth or () if true.mode is not None}
    strips = (
        Strip(mode, true[id(mode)].frequency_hz, true[id(mode)].damping_ratio)
        if id(mode) in true
        else Strip(mode)
        for mode in modes
    )
    lines = (*modes, *identification.harmonics)
    pick = {'format': FORMAT, 'recording': content.recording}
    return {
        'stabilisation': stabilisation_data(content.poles, content.spectrum, lines, pick),
        'mode_shapes': mode_shapes_data(modes, geometry, content.displacements),
        'tracks': tracks_data(identification.windows, strips),
        'channel_spectra': channel_spectra_data(content.spectra),
        'spectrogram': spectrogram_data(
            content.spectrogram, identification.windows, _shown_hz(identification.band)
        ),
    }


def _shown_hz(band: AnalysedBand | None) -> tuple[float, float]:
    return (band.low_hz, band.high_hz) if band is not None else (0.0, math.inf)


def _poor_windows(content: ReportContent) -> list[dict[str, object]]:
    windows = content.identification.windows
    return [
        {
            'index': window.index,
            'start_s': (window.start_ns - windows[0].start_ns) / NANOSECONDS_PER_SECOND,
            'end_s': (window.end_ns - windows[0].start_ns) / NANOSECONDS_PER_SECOND,
            'words': ' '.join(quality_words(window.quality)),
        }
        for window in windows
        if not window.quality.identifiable or window.quality.flags
    ]
