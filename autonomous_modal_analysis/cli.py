"""The command line `ama`."""

import atexit
from contextlib import suppress
import gc
import signal
import sys
from typing import Annotated, NoReturn

from rich.markup import escape
import typer

from autonomous_modal_analysis.commands import (
    batch,
    campaign,
    compare,
    demo,
    gap,
    history,
    identify,
    impact,
    info,
    lobes,
    merge,
    model,
    operate,
    plan,
    replay,
    robot,
    up,
    watch,
)
from autonomous_modal_analysis.commands import (
    map as modal_map,
)
from autonomous_modal_analysis.console.signals import prepare_signals
from autonomous_modal_analysis.console.streams import prepare_streams, silence
from autonomous_modal_analysis.console.terminal import MESSAGES, OUTPUT
from modal_core.errors import ModalAnalysisError
from modal_core.files.version import suite_version
from modal_core.words.reasons import say_reasons

EXIT_BAD_INPUT = 2

app = typer.Typer(
    name='ama',
    help='Find how a robot vibrates: natural frequencies, damping ratios and mode shapes.',
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode='rich',
)
for command in (
    demo,
    identify,
    batch,
    compare,
    merge,
    impact,
    lobes,
    info,
    replay,
    plan,
    robot,
    model,
    up,
    watch,
    operate,
    campaign,
    gap,
    history,
    modal_map,
):
    command.register(app)


def _show_version(wanted: bool) -> None:
    if wanted:
        OUTPUT.print(f'ama {suite_version()}')
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option('--version', callback=_show_version, is_eager=True, help='Say which.')
    ] = False,
    verbose: Annotated[
        bool,
        typer.Option(
            '--verbose', '-v', help='Say why a mode, a band, a window or an effect is turned down.'
        ),
    ] = False,
) -> None:
    """Take options that stand before the command."""
    if verbose:
        say_reasons(lambda line: MESSAGES.print(escape(line), style='dim', soft_wrap=True))


def main() -> None:
    """Run the command line; what a user can put right is one line and exit status 2."""
    # Collecting the garbage of numerical libraries would hold up the end by a second.
    atexit.register(gc.freeze)
    prepare_signals()
    prepare_streams()
    try:
        _run()
    except ModalAnalysisError as error:
        _complain(str(error))
    except BrokenPipeError:
        silence(sys.stdout)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)
    except OSError as error:
        # A disk that is full or a folder that may not be written to; files appear whole or not.
        _complain(_file_trouble(error))
    finally:
        # A signal from here on ends the process, whose result stands.
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def _run() -> None:
    try:
        app()
    finally:
        # What cannot be written is said here, not by the interpreter on its way out.
        sys.stdout.flush()


def _complain(line: str) -> NoReturn:
    with suppress(OSError):
        MESSAGES.print(f'[bold red]error[/]: {escape(line)}', soft_wrap=True)
        sys.stderr.flush()
    try:
        sys.stdout.flush()
    except OSError:
        silence(sys.stdout)
    sys.exit(EXIT_BAD_INPUT)


def _file_trouble(error: OSError) -> str:
    place = f'{error.filename}: ' if error.filename else ''
    return f'{place}{error.strerror or error}'


if __name__ == '__main__':
    main()
