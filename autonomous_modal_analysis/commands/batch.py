"""`ama batch`: many recordings at once."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.console.option_groups import grouped, Identifier, Reading
from autonomous_modal_analysis.console.options import Json
from autonomous_modal_analysis.identified.keeping import Keeping

EXIT_SOME_FAILED = 1


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('batch')(grouped(batch))


def batch(
    recordings: Annotated[
        list[Path],
        typer.Argument(help='Recordings, as of `ama identify`.', show_default=False),
    ],
    out: Annotated[
        Path, typer.Option(help='Folder for the manifest and a folder of results per recording.')
    ],
    reading: Reading,
    identifier: Identifier,
    keeping: Keeping,
    resume: Annotated[
        bool,
        typer.Option(
            '--resume', help='Go on: what is done, unchanged and asked the same is not done again.'
        ),
    ] = False,
    workers: Annotated[
        int | None,
        typer.Option(help='Processes on this machine.', show_default='one per processor'),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            help='Address of a Dask scheduler (tls://host:8786) whose workers share the files.',
            show_default='processes on this machine',
        ),
    ] = None,
    export: Annotated[
        list[str] | None,
        typer.Option(
            help='Ending of a file of another program with the modes of each recording, beside'
            ' its results: .uff, .mat, .nc, .parquet or .csv; may be given more than once.',
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Identify many recordings, each into a folder of its own, with a manifest of all.

    A recording that cannot be identified is a row of the manifest, not the end. A batch that was
    stopped goes on with --resume. The exit status is 1 when recordings failed.
    """
    from autonomous_modal_analysis.batch.manifest import NAME, TABLE
    from autonomous_modal_analysis.batch.run import BatchRequest, run_batch
    from autonomous_modal_analysis.batch.table import failures, headline
    from autonomous_modal_analysis.console.terminal import (
        MESSAGES,
        OUTPUT,
        print_json,
        progress_bar,
    )
    from autonomous_modal_analysis.views.output import show_written

    request = BatchRequest(
        recordings=tuple(recordings),
        out=out,
        reading=reading,
        identifier=identifier,
        keeping=keeping,
        resume=resume,
        scheduler=scheduler,
        n_workers=workers,
        endings=tuple(export or ()),
    )
    with progress_bar(f'identifying {len(recordings)} recordings') as progress:
        rows = run_batch(request, progress)
    if json:
        print_json({'recordings': [row.values() for row in rows]})
    else:
        OUTPUT.print(headline(rows))
        for line in failures(rows):
            MESSAGES.print(line, soft_wrap=True, markup=False)
    show_written(out, (NAME, TABLE))
    if any(row.error for row in rows):
        raise typer.Exit(EXIT_SOME_FAILED)
