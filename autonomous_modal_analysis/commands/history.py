"""`ama history`: results of months, in one file."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.console.options import Json

HistoryPath = Annotated[
    Path,
    typer.Argument(
        help='File that `ama identify --history` or the node `modal_history` wrote.',
        show_default=False,
    ),
]
RobotOf = Annotated[
    str | None, typer.Option('--robot', help='Whose.', show_default='the only one there is')
]
Since = Annotated[
    str | None, typer.Option(help='Windows from this date or time on (ISO 8601, else UTC).')
]
Until = Annotated[str | None, typer.Option(help='Windows up to this date or time.')]
Whole = Annotated[
    bool, typer.Option('--whole', help='Whole recordings in place of their windows.')
]


def register(app: typer.Typer) -> None:
    """Add the command and its own."""
    group = typer.Typer(
        help='Results of months in one file: runs, trends of modes, tables for other programs.',
        no_args_is_help=True,
    )
    group.command('list')(list_runs)
    for command in (trends, alarms, export, prune):
        group.command(command.__name__)(command)
    app.add_typer(group, name='history')


def list_runs(history: HistoryPath, json: Json = False) -> None:
    """List what a history holds: runs of the same robot, tool, settings and recording."""
    import autonomous_modal_analysis as ama
    from autonomous_modal_analysis.console.terminal import print_json

    found = ama.history(history)
    if json:
        print_json(found.to_dict())
    else:
        _show(found)


def trends(
    history: HistoryPath,
    robot: RobotOf = None,
    mode: Annotated[
        list[int] | None, typer.Option(help='Id of a mode; may be given more than once.')
    ] = None,
    since: Since = None,
    until: Until = None,
    whole: Whole = False,
    json: Json = False,
) -> None:
    """Show how modes moved: one row each, every estimate with --json.

    Ids are those of the history, which last over runs; ± is the scatter of single windows.
    """
    import autonomous_modal_analysis as ama
    from autonomous_modal_analysis.console.terminal import print_json

    found = ama.history(history).trends(robot, mode or (), since, until, whole)
    if json:
        print_json(found.to_dict())
    else:
        _show(found)


def alarms(
    history: HistoryPath,
    robot: Annotated[str | None, typer.Option(help='Whose.', show_default='all')] = None,
    acknowledge: Annotated[
        list[int] | None,
        typer.Option(help='Take note of the alarm of this number; may be given more than once.'),
    ] = None,
    baseline_days: Annotated[
        float,
        typer.Option(min=0.01, max=3650.0, help='How long the usual is learnt \\[days].'),
    ] = 7.0,
    false_a_month: Annotated[
        float,
        typer.Option(min=1e-6, max=100.0, help='How many alarms a month may be false.'),
    ] = 0.1,
    model: Annotated[
        str | None,
        typer.Option(
            help='Robot, its folder or its model file: which part has changed.',
            show_default='the shipped robot of that name',
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Show modes that changed beyond chance, pose, load and temperature, and since when.

    New alarms are kept in the history until they are acknowledged; what is acknowledged is usual
    from then on.
    """
    import autonomous_modal_analysis as ama
    from autonomous_modal_analysis.console.terminal import print_json
    from modal_history.alarm import acknowledge as take_note

    for number in acknowledge or ():
        take_note(history, number)
    found = ama.history(history).alarms(
        robot, baseline_days=baseline_days, false_a_month=false_a_month, model=model, keep=True
    )
    if json:
        print_json(found.to_dict())
    else:
        _show(found)


def export(
    history: HistoryPath,
    file: Annotated[
        Path,
        typer.Argument(help='.csv, .parquet, .mat or .nc, one row per mode.', show_default=False),
    ],
    robot: RobotOf = None,
    since: Since = None,
    until: Until = None,
    whole: Whole = False,
) -> None:
    """Write modes with their shapes into a table for other programs."""
    import autonomous_modal_analysis as ama
    from autonomous_modal_analysis.console.terminal import MESSAGES

    n_rows = ama.history(history).export(file, robot, since, until, whole)
    MESSAGES.print(f'written: {file}, {n_rows} rows', soft_wrap=True, markup=False)


def prune(
    history: HistoryPath,
    before: Annotated[
        str | None,
        typer.Option(
            help='Remove windows that end before this date or time.',
            show_default='compact the file only',
        ),
    ] = None,
    only_shapes: Annotated[
        bool, typer.Option('--only-shapes', help='Remove their mode shapes alone.')
    ] = False,
) -> None:
    """Remove what is old, and give its room back to the disk; ids of modes stay."""
    from autonomous_modal_analysis.console.terminal import MESSAGES
    from modal_history.pruning import prune as pruned
    from modal_history.selection import time_ns

    limit = None if before is None else time_ns(before, '--before')
    found = pruned(history, limit, only_shapes)
    what = f'{found.n_shapes} windows lost their shapes' if only_shapes else ''
    MESSAGES.print(
        f'{what or f"{found.n_windows} windows removed"}; the file has'
        f' {found.bytes_after / 1e6:.3g} MB, before {found.bytes_before / 1e6:.3g} MB',
        soft_wrap=True,
    )


def _show(found: object) -> None:
    from autonomous_modal_analysis.console.terminal import OUTPUT

    OUTPUT.print(repr(found), soft_wrap=True, markup=False)
