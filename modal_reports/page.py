"""The page every report is: one HTML file that needs nothing else to open."""

import base64
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
import hashlib
import json
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from modal_core.words.printable import printable_values
from modal_reports import palette

HERE = Path(__file__).parent
SCRIPTS = (
    'vendor/uPlot.iife.min.js',
    'static/common.js',
    'static/gif.js',
    'static/stabilisation.js',
    'static/mode_shapes.js',
    'static/tracks.js',
    'static/channel_spectra.js',
    'static/spectrogram.js',
    'static/compared_spectra.js',
    'static/curves.js',
    'static/page.js',
)
REPORT = HERE / 'static/report.js'
"""Draws the charts of a page that holds its data."""


@dataclass(frozen=True, slots=True)
class Page:
    """A report before it is written.

    Parameters
    ----------
    kind : str
        What sort of report it is; above the title.
    title : str
        What it is about.  Names in it, as in all values, may come from anywhere: they are only
        ever shown as text.
    template : Path
        A Jinja template that extends ``page.html.j2`` and fills its blocks.
    values : mapping of str to object
        For the template.
    charts : mapping of str to object
        Data of the charts that move, by the name in their element's ``data-chart``:
        ``stabilisation``, ``mode_shapes``, ``tracks``, ``channel_spectra``,
        ``spectrogram``, ``compared_spectra``, ``curves``; of several of a
        kind, a list, and the element's ``data-of`` says which.  Without any the page has no
        script.
    styles : tuple of Path
        Style sheets of this report alone.
    """

    kind: str
    title: str
    template: Path
    values: Mapping[str, object]
    charts: Mapping[str, object] | None = None
    styles: tuple[Path, ...] = ()


def render(page: Page) -> str:
    """Return the page as one HTML document.

    Parameters
    ----------
    page : Page
        What it says.

    Returns
    -------
    str
        HTML without any reference to a network; its content security policy admits only the
        scripts and styles inside, by their hashes.
    """
    script = kit_script([REPORT]) if page.charts else ''
    style = kit_style(page.styles, moves=bool(page.charts))
    environment = Environment(
        loader=FileSystemLoader([page.template.parent, HERE / 'templates']),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_legible,
    )
    return environment.get_template(page.template.name).render(
        **page.values,
        kind=page.kind,
        title=page.title,
        style=Markup(style),  # noqa: S704 - our own files, read from the package
        style_source=_hash(style),
        script=Markup(script),  # noqa: S704
        script_source=_hash(script) if script else Markup("'none'"),
        data=Markup(embedded_json(page.charts or {})),  # noqa: S704 - escaped there
    )


def _legible(value: object) -> object:
    """Return text of others without what steers or hides; our own markup has none of it."""
    return value if isinstance(value, Markup) else printable_values(value)


def embedded_json(value: object) -> str:
    """Return JSON that cannot end or escape the element it sits in."""
    shown = printable_values(value)
    text = json.dumps(shown, allow_nan=False, ensure_ascii=True, separators=(',', ':'))
    for character in '<>&':
        text = text.replace(character, f'\\u{ord(character):04x}')
    return text


def kit_script(own: Iterable[Path] = ()) -> str:
    """Return the script of all charts, and behind it the page's own files."""
    licence = _text(HERE / 'vendor/uPlot-LICENSE.txt').replace('*/', '* /')
    kit = [_text(HERE / name) for name in SCRIPTS]
    return '\n'.join((f'/* uPlot:\n{licence}\n*/', *kit, *map(_text, own)))


def kit_style(own: Iterable[Path] = (), *, moves: bool = True) -> str:
    """Return the style sheet of all pages, and behind it the page's own files.

    Parameters
    ----------
    own : iterable of Path
        Of this page alone.
    moves : bool
        With what charts that move need.
    """
    vendor = [HERE / 'vendor/uPlot.min.css'] if moves else []
    files = [*vendor, HERE / 'static/page.css', HERE / 'static/charts.css', *own]
    return '\n'.join((palette.style_sheet(), *map(_text, files)))


def _text(path: Path) -> str:
    # The hash must be of what a browser reads: HTML turns carriage returns into line feeds.
    return path.read_text(encoding='utf-8').replace('\r\n', '\n').strip('\n')


def _hash(text: str) -> Markup:
    digest = hashlib.sha256(text.encode('utf-8')).digest()
    return Markup(f"'sha256-{base64.b64encode(digest).decode('ascii')}'")  # noqa: S704 - no names
