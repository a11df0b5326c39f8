"""`ama plan`: plan a self-excitation and see what it will do, before anything moves."""

from typing import Annotated

import typer

from autonomous_modal_analysis.console.option_groups import grouped, Program, Wish
from autonomous_modal_analysis.console.options import Json, POSE_HELP, Serial


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('plan')(grouped(plan))


def plan(
    wish: Wish,
    program: Program,
    robot: Annotated[
        str, typer.Argument(help='Robot of config/robots, or its folder.')
    ] = 'irb6660_205_190',
    pose_deg: Annotated[
        str | None,
        typer.Option(help=POSE_HELP),
    ] = None,
    serial: Serial = False,
    sensors: Annotated[str, typer.Option(help='Sensor layout of the robot.')] = 'sensors',
    approach_from: Annotated[
        str | None,
        typer.Option(
            help='Plan one slow move instead, from this pose (as --pose-deg) to the start.'
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Plan a random motion of all joints that keeps every limit, and forecast what it shows.

    The same seed gives the same plan, and the plan's hash is what an operator releases. A plan
    starts at its own start pose only; --approach-from plans the way there.
    """
    import autonomous_modal_analysis as ama
    from autonomous_modal_analysis.console.terminal import MESSAGES, print_json
    from autonomous_modal_analysis.views.plan_view import show_plan
    from structural_model.robot_files import load_layout

    made = ama.plan(
        robot,
        pose_deg,
        serial=serial,
        approach_from=approach_from,
        layout=load_layout(robot, sensors),
        **wish.values(),
    )
    if program.rapid is not None:
        made.save_rapid(program.rapid, program.options)
        MESSAGES.print(f'written: {program.rapid}', soft_wrap=True)
    if json:
        print_json(made.to_dict())
    else:
        show_plan(made.plan, made.model)
