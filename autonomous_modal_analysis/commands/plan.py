"""`ama plan`: plan a self-excitation and see what it will do, before anything moves."""

from pathlib import Path
from typing import Annotated, Any

import typer

from autonomous_modal_analysis.options import Json


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('plan')(plan)


def plan(
    robot: Annotated[
        str, typer.Argument(help='Robot of config/robots, or its folder.')
    ] = 'irb6660_205_190',
    pose_deg: Annotated[
        str | None,
        typer.Option(help='Controller angles j1,j2,... in degrees, or the name of a pose.'),
    ] = None,
    signal: Annotated[
        str | None, typer.Option(help='band_limited_noise (EGM) or random_pulses (RAPID).')
    ] = None,
    seed: Annotated[int | None, typer.Option(help='Seed of all random numbers.')] = None,
    duration_s: Annotated[float | None, typer.Option(help='Length of the motion.')] = None,
    request: Annotated[
        Path | None, typer.Option(help='YAML file with any fields of a plan request.')
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
    from dataclasses import replace

    from autonomous_modal_analysis.plan_view import plan_json, show_plan
    from autonomous_modal_analysis.pose import parse_pose
    from autonomous_modal_analysis.terminal import MESSAGES, print_json
    from excitation_planner.planner import plan_excitation
    from excitation_planner.rapid import rapid_module
    from excitation_planner.request import PlanRequest
    from modal_core.atomic_file import write_text
    from modal_core.yaml_file import load_yaml
    from structural_model.robot_files import load_layout, load_robot

    arm = load_robot(robot)
    wish = PlanRequest.from_mapping(load_yaml(request), str(request)) if request else PlanRequest()
    given = {'signal': signal, 'seed': seed, 'duration_s': duration_s}
    changes: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if pose_deg is not None or not wish.start_position:
        changes['start_position'] = tuple(float(angle) for angle in parse_pose(arm, pose_deg))
    if approach_from is not None:
        here = tuple(float(angle) for angle in parse_pose(arm, approach_from))
        changes |= {'signal': 'approach', 'approach_from': here}
    made = plan_excitation(arm, load_layout(robot, sensors), replace(wish, **changes))
    if rapid is not None:
        write_text(rapid, rapid_module(made, arm))
        MESSAGES.print(f'written: {rapid}', soft_wrap=True)
    if json:
        print_json(plan_json(made, arm))
    else:
        show_plan(made, arm)
