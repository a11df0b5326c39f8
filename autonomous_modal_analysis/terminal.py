"""What the command line shows: results on standard output, progress and messages beside it."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
import json
import math

from rich.console import Console, ConsoleOptions, RenderableType
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.segment import Segment
from rich.table import Table

from modal_core.mode import Mode
from modal_core.printable import printable
from modal_reports import (
    DAMPING,
    fixed,
    FREQUENCY,
    mark,
    MPC,
    MPD,
    SCATTERED,
    SCATTERED_MEANS,
)


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


def no_progress(_: float) -> None:
    """Tell nobody how much is done."""


@contextmanager
def progress_bar(text: str) -> Iterator[ProgressCallback]:
    """Show a bar for long work; yield a function that takes the fraction done, 0..1."""
    columns = (
        TextColumn('{task.description}'),
        BarColumn(),
        TextColumn('{task.percentage:>3.0f} %'),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns, console=MESSAGES, transient=True, disable=not MESSAGES.is_terminal
    ) as progress:
        task = progress.add_task(escape(text), total=1.0)

        def show(fraction: float) -> None:
            progress.update(task, completed=min(max(fraction, 0.0), 1.0))

        yield show


def print_json(value: object) -> None:
    """Write one JSON value on standard output, as strict JSON."""
    OUTPUT.out(json.dumps(value, allow_nan=False, indent=2))


def modes_table(modes: Sequence[Mode], title: str, notes: Sequence[str] = ()) -> Table:
    """Return a table of modes, and of lines marked as harmonic, for people, by frequency.

    Parameters
    ----------
    modes : sequence of Mode
        In any order.
    title : str
        Above the table.
    notes : sequence of str
        One per mode, where there is something to say of each.
    """
    table = Table(title=escape(title), title_justify='left')
    for heading in ('mode', FREQUENCY.label, DAMPING.label, MPC.label, MPD.label, ''):
        table.add_column(heading, justify='right')
    rows = zip(modes, notes or [''] * len(modes), strict=True)
    for mode, note in sorted(rows, key=lambda row: row[0].frequency_hz):
        table.add_row(
            str(mode.id) if mode.id else '',
            FREQUENCY.number(mode.frequency_hz, mode.frequency_std_hz),
            '' if mode.harmonic else DAMPING.number(mode.damping_ratio, mode.damping_ratio_std),
            fixed(mode.mpc, 3),
            fixed(math.degrees(mode.mpd), 1),
            ', '.join(filter(None, (note, mark(mode)))),
        )
    if any(mark(mode) == SCATTERED for mode in modes):
        table.caption = f'{SCATTERED}: {SCATTERED_MEANS}'
        table.caption_justify = 'left'
    return table
