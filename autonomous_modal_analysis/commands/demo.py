"""`ama demo`: the whole loop on an emulated arm."""

from pathlib import Path
from typing import Annotated

import typer

EXIT_NOT_FOUND = 1
ROBOT = 'irb6660_205_190'


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('demo')(demo)


def demo(
    out: Annotated[Path, typer.Option(help='Folder for recording, results and report.')] = Path(
        'ama_demo'
    ),
    robot: Annotated[str, typer.Option(help='Robot of config/robots, or its folder.')] = ROBOT,
    pose: Annotated[
        str | None, typer.Option(help='Named pose of the arm; else the first of its file.')
    ] = None,
    seed: Annotated[int, typer.Option(help='Seed of the motion and of the sensor noise.')] = 1,
) -> None:
    """Let an emulated ABB arm shake itself, identify it live, and compare with its true modes.

    Emulator, bridge, planner and identifier run as processes of their own in an own ROS domain.
    Exit status 1 if a mode in the excited band is missed, or if its frequency is off by more than
    1 % and more than three of its own standard deviations.
    """
    from autonomous_modal_analysis.ros_ready import require_ros

    require_ros()
    from autonomous_modal_analysis.comparison import compare, show_comparison
    from autonomous_modal_analysis.demonstration import DemoSettings
    from autonomous_modal_analysis.demonstration_node import run_demo
    from autonomous_modal_analysis.terminal import progress_bar
    from modal_core.errors import ModelError
    from structural_model.robot_files import load_robot

    poses = load_robot(robot).poses_controller_rad
    chosen = next(iter(poses)) if pose is None else pose
    if chosen not in poses:
        raise ModelError('no such pose', where=robot, found=pose, expected=', '.join(poses))
    settings = DemoSettings(folder=out, robot=robot, pose=chosen, seed=seed)
    with progress_bar('emulated arm shaking itself') as progress:
        run = run_demo(settings, progress)
    comparison = compare(settings, run)
    show_comparison(comparison)
    if comparison.failures:
        raise typer.Exit(EXIT_NOT_FOUND)
