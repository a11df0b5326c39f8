"""What the command line shows: results on standard output, progress and messages beside it."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
import json
import math
import threading
import time

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.segment import Segment
from rich.table import Table

from modal_core.words.printable import printable


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
StageCallback = Callable[[float, str], None]
"""Takes the fraction of all work done, 0..1, and what is being done."""
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
    with stages_bar(text) as show:
        yield lambda fraction: show(fraction, '')


@contextmanager
def stages_bar(text: str) -> Iterator[StageCallback]:
    """Show a bar for long work in stages; yield a function of the fraction done and the stage.

    Without a terminal a line at each stage, and now and then, takes its place.
    """
    if not MESSAGES.is_terminal:
        with _progress_lines(text) as say:
            yield say
        return
    columns = (
        TextColumn('{task.description}'),
        BarColumn(),
        TextColumn('{task.percentage:>3.0f} %'),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    # The time left follows from all that was done: a stage of seconds says nothing of minutes.
    bar = Progress(*columns, console=MESSAGES, transient=True, speed_estimate_period=math.inf)
    with bar as progress:
        task = progress.add_task(escape(text), total=1.0)

        def show(fraction: float, stage: str) -> None:
            words = escape(_with_stage(text, stage))
            progress.update(task, completed=min(max(fraction, 0.0), 1.0), description=words)

        yield show


def _with_stage(text: str, stage: str) -> str:
    return f'{text}, {stage}' if stage else text


@contextmanager
def _progress_lines(text: str) -> Iterator[StageCallback]:
    """Say at each stage and every ten seconds how far long work is, for logs.

    Also where the work itself tells nothing for so long: a bar moves its clock, too.
    """
    lines, ended = _ProgressLines(text, time.monotonic()), threading.Event()

    def watch() -> None:
        while not ended.wait(0.25 * LINE_EVERY_S):
            lines.say(lines.done, lines.stage)

    watching = threading.Thread(target=watch, daemon=True)
    watching.start()
    try:
        yield lines.say
    finally:
        ended.set()
        watching.join()


class _ProgressLines:
    """What was said last of long work, and when."""

    def __init__(self, text: str, start_s: float) -> None:
        self._text, self._start_s, self._said_s = text, start_s, start_s
        self._lock = threading.Lock()
        self.done, self.stage, self._whole_s = 0.0, '', 0.0

    def say(self, fraction: float, stage: str) -> None:
        """Take how far it is; print it where the stage is another or ten seconds are over."""
        with self._lock:
            now_s, is_new = time.monotonic(), stage != self.stage
            took_s, done = now_s - self._start_s, min(max(fraction, 0.0), 1.0)
            # Where nothing new is told the estimate stands, and runs down.
            if done != self.done or is_new:
                self._whole_s = took_s / done if done > LEAST_DONE else 0.0
            self.done, self.stage = done, stage
            if now_s - self._said_s < LINE_EVERY_S and not is_new:
                return
            self._said_s, left_s = now_s, self._whole_s - took_s
            left = f', about {left_s:.0f} s left' if left_s >= 0.0 else ''
            line = f'{100.0 * self.done:.0f} % after {took_s:.0f} s{left}'
            MESSAGES.print(escape(f'{_with_stage(self._text, stage)}: {line}'), soft_wrap=True)


def print_json(value: object) -> None:
    """Write one JSON value on standard output, as strict JSON."""
    OUTPUT.out(json.dumps(value, allow_nan=False, indent=2))
