"""What the command line shows: results on standard output, progress and messages beside it."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
import json
import time

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.segment import Segment
from rich.table import Table

from modal_core.printable import printable


class PlainConsole(Console):
    """Shows what others wrote as letters: only rich's own styles steer the terminal."""

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Yield the pieces of what is shown, steering characters in their words escaped."""
        for piece in super().render(renderable, options):
            if piece.control or piece.text.isprintable():
                yield piece
            else:
                lines = piece.text.split('\n')
                yield Segment('\n'.join(printable(line) for line in lines), piece.style)


# Programs read standard output; people also look at standard error.
OUTPUT = PlainConsole(highlight=False)
MESSAGES = PlainConsole(stderr=True, highlight=False)

ProgressCallback = Callable[[float], None]
LINE_EVERY_S = 10.0
"""Chosen: a log of an hour has 360 lines, and nobody thinks that the work has died."""
LEAST_DONE = 0.02
"""From this part on the time that is left is told: of less it would be a guess."""


def narrow_table(title: str) -> Table:
    """Return an empty table without frame and margins, so that many columns fit 80 letters.

    Parameters
    ----------
    title : str
        Of letters only: names that others wrote are escaped by the caller.
    """
    return Table(
        title=title, title_justify='left', box=SIMPLE_HEAD, padding=(0, 0), show_edge=False
    )


def no_progress(_: float) -> None:
    """Tell nobody how much is done."""


@contextmanager
def progress_bar(text: str) -> Iterator[ProgressCallback]:
    """Show a bar for long work; yield a function that takes the fraction done, 0..1.

    Without a terminal a line now and then takes its place.
    """
    if not MESSAGES.is_terminal:
        yield _progress_lines(text)
        return
    columns = (
        TextColumn('{task.description}'),
        BarColumn(),
        TextColumn('{task.percentage:>3.0f} %'),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=MESSAGES, transient=True) as progress:
        task = progress.add_task(escape(text), total=1.0)

        def show(fraction: float) -> None:
            progress.update(task, completed=min(max(fraction, 0.0), 1.0))

        yield show


def _progress_lines(text: str) -> ProgressCallback:
    """Return what says every ten seconds how far long work is, for logs."""
    start_s = said_s = time.monotonic()

    def say(fraction: float) -> None:
        nonlocal said_s
        now_s = time.monotonic()
        if now_s - said_s < LINE_EVERY_S:
            return
        said_s = now_s
        done, took_s = min(max(fraction, 0.0), 1.0), now_s - start_s
        left = f', about {took_s / done - took_s:.0f} s left' if done > LEAST_DONE else ''
        line = f'{text}: {100.0 * done:.0f} % after {took_s:.0f} s{left}'
        MESSAGES.print(escape(line), soft_wrap=True)

    return say


def print_json(value: object) -> None:
    """Write one JSON value on standard output, as strict JSON."""
    OUTPUT.out(json.dumps(value, allow_nan=False, indent=2))
