"""Pictures for the documents: one file that follows the reader's theme, light or dark."""

from html import escape
import io
import re
from typing import Any

from benchmarks.results import write_picture
from examples.paper.output import KEEPER, say
from modal_reports import palette

COLOURS = tuple(light for light, _ in palette.SERIES)
GREY, PALE = palette.on_white('faint'), palette.on_white('unphysical')
INK, SOFT, RULE = (palette.on_white(role) for role in ('ink', 'soft', 'rule'))
STYLE = {
    'font.size': 9,
    'text.color': INK,
    'axes.labelcolor': INK,
    'axes.edgecolor': SOFT,
    'xtick.color': SOFT,
    'ytick.color': SOFT,
    'xtick.labelcolor': INK,
    'ytick.labelcolor': INK,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.grid': True,
    'grid.color': RULE,
    'axes.axisbelow': True,
    'axes.titlesize': 9,
    'axes.titlelocation': 'left',
    'axes.facecolor': 'none',
    'figure.facecolor': 'none',
    'legend.frameon': False,
    'svg.fonttype': 'none',
}
FONTS = "system-ui, -apple-system, 'Segoe UI', 'DejaVu Sans', sans-serif"


def panels(n_rows: int, n_columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    """Return a figure and its axes, in the style all pictures share."""
    import matplotlib

    matplotlib.use('agg')
    from matplotlib import pyplot

    matplotlib.rcParams.update(STYLE)
    return pyplot.subplots(n_rows, n_columns, figsize=size, layout='constrained', squeeze=False)


def save(figure: Any, name: str, title: str) -> None:
    """Write a picture beside the tables; the same figures give the same bytes."""
    import matplotlib
    from matplotlib import pyplot

    written = io.StringIO()
    if not KEEPER.checks:
        with matplotlib.rc_context({'svg.hashsalt': name}):
            figure.savefig(written, format='svg', metadata={'Date': None, 'Creator': None})
        path = write_picture(f'paper_{name}', themed(written.getvalue(), title), [title])
        say(f'drawn: {path}\n')
    pyplot.close(figure)


def themed(svg: str, title: str) -> str:
    """Return a drawing that stands in a page: its colours follow the theme, its size the page.

    Parameters
    ----------
    svg : str
        As matplotlib writes it, in the light colours of the palette.
    title : str
        Said to readers who hear the page.
    """
    body = svg[svg.index('<svg') :]
    box = re.search(r'viewBox="([^"]+)"', body)
    if box is None:
        raise ValueError('not a drawing: no viewBox')
    body = body[body.index('>') + 1 :]
    body = re.sub(r'<metadata>.*?</metadata>', '', body, flags=re.DOTALL)
    # Names of groups that nothing refers to would meet those of other pictures of the page.
    body = re.sub(r'<g id="[^"]*">', '<g>', body)
    body = re.sub(r'<!--.*?-->', '', body, flags=re.DOTALL)
    # Places need no more digits; what is written stays as it is.
    body = re.sub(r'<[^>]*>', lambda tag: re.sub(r'(\d+\.\d\d)\d+', r'\1', tag.group()), body)
    body = re.sub(r'(font: [^;\"]*?px )[^;\"]*', rf'\1{FONTS}', body)
    # Black is matplotlib's own; on a dark ground nobody would see it.
    body = body.replace(palette.BLACK, INK)
    colours = dict((*palette.ROLES.values(), *palette.SERIES))
    used = [light for light in colours if light in body]
    for light in used:
        body = body.replace(light, f'var(--c{light[1:]}, {light})')
    dark = ''.join(f'--c{light[1:]}: {colours[light]};' for light in used)
    style = (
        f'@media screen and (prefers-color-scheme: dark) '
        f'{{svg.drawn:not([data-theme="light"] *) {{{dark}}}}} '
        f'@media screen {{[data-theme="dark"] svg.drawn {{{dark}}}}}'
    )
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f'class="drawn" viewBox="{box.group(1)}" width="100%" role="img" '
        f'aria-label="{escape(title)}">'
    )
    return f'{head}<style>{style}</style>{body}'
