"""`ama plan`: plan a self-excitation and see what it will do, before anything moves."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.option_groups import grouped, Wish
from autonomous_modal_analysis.options import Json


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('plan')(grouped(plan))


def plan(
    wish: Wish,
    robot: Annotated[
        str, typer.Argument(help='Robot of config/robots, or its folder.')
    ] = 'irb6660_205_190',
    pose_deg: Annotated[
        str | None,
        typer.Option(help='Controller angles j1,j2,... in degrees, or the name of a pose.'),
    ] = None,
    sensors: Annotated[str, typer.Option(help='Sensor layout of the robot.')] = 'sensors',
    approach_from: Annotated[
        str | None,
        typer.Option(
            help='Plan one slow move instead: from this pose, named or in degrees, to the start.'
        ),
    ] = None,
    rapid: Annotated[
        Path | None, typer.Option(help='Write the plan as a RAPID module to load by hand.')
    ] = None,
    json: Json = False,
) -> None:
    """Plan a random motion of all joints that keeps every limit, and forecast what it shows.

    The same seed gives the same plan, and the plan's hash is what an operator releases. A plan
    starts at its own start pose only; --approach-from plans the way there.
    """
    import autonomous_modal_analysis as ama
    from autonomous_modal_analysis.plan_view import show_plan
    from autonomous_modal_analysis.terminal import MESSAGES, print_json
    from structural_model.robot_files import load_layout

    made = ama.plan(
        robot,
        pose_deg,
        approach_from=approach_from,
        layout=load_layout(robot, sensors),
        **wish.values(),
    )
    if rapid is not None:
        made.save_rapid(rapid)
        MESSAGES.print(f'written: {rapid}', soft_wrap=True)
    if json:
        print_json(made.to_dict())
    else:
        show_plan(made.plan, made.model)
