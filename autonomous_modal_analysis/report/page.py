"""One HTML file that shows a whole identification and needs nothing else to open."""

import base64
import hashlib
import json
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from autonomous_modal_analysis.mode_marks import SCATTERED, SCATTERED_MEANS
from autonomous_modal_analysis.mode_tracks import mode_tracks
from autonomous_modal_analysis.report.content import ReportContent
from autonomous_modal_analysis.report.number_text import fixed
from autonomous_modal_analysis.report.payload import payload
from autonomous_modal_analysis.report.tables import channel_rows, mode_rows
from autonomous_modal_analysis.report.words import count, facts, headline, quality_words
from autonomous_modal_analysis.results import plain
from modal_core.atomic_file import write_text
from modal_core.measurements import NANOSECONDS_PER_SECOND

HERE = Path(__file__).parent
SCRIPTS = (
    'vendor/uPlot.iife.min.js',
    'static/common.js',
    'static/stabilisation.js',
    'static/mode_shapes.js',
    'static/tracks.js',
    'static/report.js',
)
STYLES = ('vendor/uPlot.min.css', 'static/report.css')


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

    Returns
    -------
    str
        HTML without any reference to a network; its content security policy admits only the
        scripts and styles inside, by their hashes.
    """
    script = _script()
    style = '\n'.join(_asset(name) for name in STYLES)
    environment = Environment(
        loader=FileSystemLoader(HERE / 'templates'),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template('report.html.j2').render(
        content=content,
        headline=headline(content),
        facts=facts(content),
        rows=mode_rows(content),
        truth_known=content.truth is not None,
        scattered=SCATTERED,
        scattered_means=SCATTERED_MEANS,
        quality=quality_words(content.identification.quality),
        channels=channel_rows(content.identification.quality.channels),
        poor_windows=_poor_windows(content),
        settings=[
            *settings_rows(content.identification.band, 'band.'),
            *settings_rows(content.identification.settings),
        ],
        tracks=mode_tracks(content.identification.windows),
        fixed=fixed,
        count=count,
        script=Markup(script),  # noqa: S704 - our own files, read from the package
        style=Markup(style),  # noqa: S704
        script_hash=_hash(script),
        style_hash=_hash(style),
        data=Markup(embedded_json(payload(content))),  # noqa: S704 - escaped there
    )


def embedded_json(value: object) -> str:
    """Return JSON that cannot end or escape the element it sits in."""
    text = json.dumps(value, allow_nan=False, ensure_ascii=True, separators=(',', ':'))
    for character in '<>&':
        text = text.replace(character, f'\\u{ord(character):04x}')
    return text


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


def _script() -> str:
    licence = _asset('vendor/uPlot-LICENSE.txt').replace('*/', '* /')
    return '\n'.join((f'/* uPlot:\n{licence}\n*/', *(_asset(name) for name in SCRIPTS)))


def _asset(name: str) -> str:
    # The hash must be of what a browser reads: HTML turns carriage returns into line feeds.
    return HERE.joinpath(name).read_text(encoding='utf-8').replace('\r\n', '\n').strip('\n')


def _hash(text: str) -> str:
    digest = hashlib.sha256(text.encode('utf-8')).digest()
    return f'sha256-{base64.b64encode(digest).decode("ascii")}'
