"""`ama model`: what the structural model says of a pose."""

from typing import Annotated

import typer

from autonomous_modal_analysis.console.options import Export, Json, POSE_HELP, Serial


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('model')(model)


def model(
    robot: Annotated[str, typer.Argument(help='Robot of config/robots, or its folder.')],
    pose_deg: Annotated[
        str | None,
        typer.Option(help=POSE_HELP),
    ] = None,
    serial: Serial = False,
    max_frequency_hz: Annotated[float, typer.Option(min=0.01, help='Highest mode shown.')] = 200.0,
    sensors: Annotated[str, typer.Option(help='Sensor layout of the robot.')] = 'sensors',
    sensitivity: Annotated[
        bool, typer.Option('--sensitivity', help='Add the dynamic sensitivity coefficients.')
    ] = False,
    step_deg: Annotated[
        float, typer.Option(min=0.01, max=30.0, help='Joint step of the sensitivity.')
    ] = 5.0,
    export: Export = None,
    json: Json = False,
) -> None:
    """Show natural frequencies, damping ratios and mode shapes of a robot in one pose."""
    import autonomous_modal_analysis as ama
    from autonomous_modal_analysis.console.terminal import print_json
    from autonomous_modal_analysis.export import check_endings, ENDINGS
    from autonomous_modal_analysis.views.model_view import show_model
    from autonomous_modal_analysis.views.output import export_each
    from structural_model.robot_files import load_layout

    check_endings(export or (), ENDINGS)
    seen = ama.model(
        robot,
        pose_deg,
        serial=serial,
        max_frequency_hz=max_frequency_hz,
        layout=load_layout(robot, sensors),
        step_deg=step_deg if sensitivity else None,
    )
    if json:
        print_json(seen.to_dict())
    else:
        show_model(seen)
    export_each(export, seen.export)
