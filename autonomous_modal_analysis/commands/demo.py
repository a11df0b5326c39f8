"""`ama demo`: the whole loop on an emulated arm."""

from pathlib import Path
from typing import Annotated

import typer

EXIT_NOT_FOUND = 1


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('demo')(demo)


def demo(
    out: Annotated[Path, typer.Option(help='Folder for recording, results and report.')] = Path(
        'ama_demo'
    ),
    pose: Annotated[str, typer.Option(help='Named pose of the arm.')] = 'P1',
    seed: Annotated[int, typer.Option(help='Seed of the motion and of the sensor noise.')] = 1,
) -> None:
    """Let an emulated ABB arm shake itself, identify it live, and compare with its true modes.

    Emulator, bridge, planner and identifier run as processes of their own in an own ROS domain.
    Exit status 1 if a mode in the excited band is missed, or if its frequency is off by more than
    1 % and more than three of its own standard deviations.
    """
    from autonomous_modal_analysis.comparison import compare, show_comparison
    from autonomous_modal_analysis.demonstration import DemoSettings
    from autonomous_modal_analysis.demonstration_node import run_demo
    from autonomous_modal_analysis.terminal import progress_bar

    settings = DemoSettings(folder=out, pose=pose, seed=seed)
    with progress_bar('emulated arm shaking itself') as progress:
        run = run_demo(settings, progress)
    comparison = compare(settings, run)
    show_comparison(comparison)
    if comparison.failures:
        raise typer.Exit(EXIT_NOT_FOUND)
