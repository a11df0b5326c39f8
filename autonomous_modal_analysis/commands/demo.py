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
    impact: Annotated[
        bool,
        typer.Option('--impact', help='Tap the arm with a hammer instead; needs no ROS.'),
    ] = False,
    milling: Annotated[
        bool,
        typer.Option('--milling', help='Let the arm mill while it is identified; needs no ROS.'),
    ] = False,
) -> None:
    """Let an emulated ABB arm shake itself, identify it live, and compare with its true modes.

    Emulator, bridge, planner and identifier run as processes of their own in an own ROS domain.
    Exit status 1 if a mode in the excited band is missed, or if its frequency is off by more than
    1 % and more than three of its own standard deviations.
    """
    from autonomous_modal_analysis.ros_ready import require_ros

    if impact:
        _tap(out, robot, pose, seed)
        return
    if milling:
        _mill(out, robot, pose, seed)
        return
    require_ros()
    from autonomous_modal_analysis.console.terminal import progress_bar
    from autonomous_modal_analysis.demos.demo_verdict import judge_demo, show_verdict
    from autonomous_modal_analysis.demos.demonstration import DemoSettings
    from autonomous_modal_analysis.demos.demonstration_node import run_demo

    settings = DemoSettings(folder=out, robot=robot, pose=_chosen(robot, pose), seed=seed)
    with progress_bar('emulated arm shaking itself') as progress:
        run = run_demo(settings, progress)
    verdict = judge_demo(settings, run)
    show_verdict(verdict)
    if verdict.failures:
        raise typer.Exit(EXIT_NOT_FOUND)


def _tap(out: Path, robot: str, pose: str | None, seed: int) -> None:
    from autonomous_modal_analysis.demos.tap_demo import show_tap_demo, tap_demo

    demo = tap_demo(out, robot, _chosen(robot, pose), seed)
    show_tap_demo(demo)
    if demo.missed_hz:
        raise typer.Exit(EXIT_NOT_FOUND)


def _mill(out: Path, robot: str, pose: str | None, seed: int) -> None:
    from autonomous_modal_analysis.console.terminal import stages_bar
    from autonomous_modal_analysis.demos.milling_demo import milling_demo, show_milling_demo

    with stages_bar('emulated arm milling') as progress:
        demo = milling_demo(out, robot, _chosen(robot, pose), seed, progress)
    show_milling_demo(demo, out)
    if demo.missed_hz or demo.lines_as_modes_hz:
        raise typer.Exit(EXIT_NOT_FOUND)


def _chosen(robot: str, pose: str | None) -> str:
    """Return the pose asked for, or the robot's first."""
    from modal_core.errors import ModelError
    from structural_model.robot_files import load_robot

    poses = load_robot(robot).poses_controller_rad
    if not poses:
        raise ModelError('no named pose', where=robot, expected='one in its model.yaml')
    chosen = next(iter(poses)) if pose is None else pose
    if chosen not in poses:
        raise ModelError('no such pose', where=robot, found=pose, expected=', '.join(poses))
    return chosen
