"""What the still pictures share: the element, rounded places, text that is only ever text."""

from collections.abc import Iterable

from markupsafe import escape, Markup


def svg(size: tuple[int, int], label: str, parts: Iterable[str], kind: str = '') -> Markup:
    """Return a picture.

    Parameters
    ----------
    size : (width, height)
        In its own units; about a CSS pixel.
    label : str
        Said to readers who hear the page.
    parts : iterable of str
        Elements; numbers and escaped text only.
    kind : str
        Class names.
    """
    classes = f' class="{escape(kind)}"' if kind else ''
    return Markup(  # noqa: S704  numbers and escaped text only
        f'<svg{classes} width="{size[0]}" height="{size[1]}" '
        f'viewBox="0 0 {size[0]} {size[1]}" role="img" '
        f'aria-label="{escape(label)}">{"".join(parts)}</svg>'
    )


def text(x: float, y: float, words: str, kind: str = 'tick', anchor: str = 'start') -> str:
    """Return words at a place."""
    return (
        f'<text class="{escape(kind)}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">'
        f'{escape(words)}</text>'
    )


def line(kind: str, start: tuple[float, float], end: tuple[float, float]) -> str:
    """Return a straight line."""
    (x1, y1), (x2, y2) = start, end
    return (
        f'<line class="{escape(kind)}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'
    )


def rectangle(kind: str, x: float, y: float, width: float, height: float) -> str:
    """Return a filled rectangle."""
    return (
        f'<rect class="{escape(kind)}" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" '
        f'height="{height:.1f}"/>'
    )


def circle(kind: str, x: float, y: float, radius: float, title: str = '') -> str:
    """Return a circle; the title shows when it is pointed at."""
    inside = f'<title>{escape(title)}</title>' if title else ''
    place = f'cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}"'
    return f'<circle class="{escape(kind)}" {place}>{inside}</circle>'


def polyline(kind: str, points: Iterable[tuple[float, float]]) -> str:
    """Return a line through points."""
    places = ' '.join(f'{x:.1f},{y:.1f}' for x, y in points)
    return f'<polyline class="{escape(kind)}" points="{places}"/>'


def polygon(kind: str, points: Iterable[tuple[float, float]]) -> str:
    """Return a filled figure."""
    places = ' '.join(f'{x:.1f},{y:.1f}' for x, y in points)
    return f'<polygon class="{escape(kind)}" points="{places}"/>'
