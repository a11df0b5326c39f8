"""`ama robot`: a robot's folder from a URDF."""

from pathlib import Path
from typing import Annotated

import typer

from modal_core.errors import ModelError


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('robot')(robot)


def robot(
    urdf: Annotated[
        Path, typer.Argument(help='URDF; a xacro has to be expanded first.', show_default=False)
    ],
    out: Annotated[
        Path, typer.Option(help='Folder for robot.urdf, model.yaml and sensors.yaml.')
    ] = Path('robot'),
    tip: Annotated[
        str | None,
        typer.Option(
            help='Last link of the arm; without it where the moving joints branch or end.'
        ),
    ] = None,
    lowest_hz: Annotated[
        float | None,
        typer.Option(
            help='Lowest natural frequency at the home pose, if it is known: all stiffnesses are'
            ' scaled to it.'
        ),
    ] = None,
) -> None:
    """Make a robot of a URDF: its arm, and a guess of what no URDF says.

    Stiffness, damping, limits of acceleration, a home pose and places of sensors are guessed, and
    told. `ama model` shows its modes, `ama gap` corrects them by a campaign.
    """
    from autonomous_modal_analysis.console.terminal import OUTPUT
    from modal_core.files.atomic_file import atomic_path
    from structural_model import first_robot

    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise ModelError('there is something already', where=out, advice='name another folder')
    made = first_robot(urdf, tip, lowest_hz)
    for name, content in made.files.items():
        with atomic_path(out / name) as path:
            path.write_bytes(content)
    arm = made.arm
    OUTPUT.print(
        f'{len(arm.joints)} joints from {arm.base} to {arm.tip}: {", ".join(arm.joints)}',
        soft_wrap=True,
        markup=False,
    )
    if arm.standing:
        OUTPUT.print(
            f'standing still at zero: {", ".join(arm.standing)}', soft_wrap=True, markup=False
        )
    for text in made.guessed:
        OUTPUT.print(f'guessed: {text}', soft_wrap=True, markup=False)
    OUTPUT.print(f'written: {", ".join(str(out / name) for name in made.files)}', markup=False)
    OUTPUT.print(
        f'next: ama model {out}, ama campaign {out}, ama gap campaign --model {out}', markup=False
    )
