"""`ama model`: what the structural model says of a pose."""

from typing import Annotated

import typer

from autonomous_modal_analysis.options import Json


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('model')(model)


def model(
    robot: Annotated[str, typer.Argument(help='Robot of config/robots, or its folder.')],
    pose_deg: Annotated[
        str | None,
        typer.Option(help='Controller angles j1,j2,... in degrees, or the name of a pose.'),
    ] = None,
    max_frequency_hz: Annotated[float, typer.Option(min=0.01, help='Highest mode shown.')] = 200.0,
    sensors: Annotated[str, typer.Option(help='Sensor layout of the robot.')] = 'sensors',
    sensitivity: Annotated[
        bool, typer.Option('--sensitivity', help='Add the dynamic sensitivity coefficients.')
    ] = False,
    step_deg: Annotated[
        float, typer.Option(min=0.01, max=30.0, help='Joint step of the sensitivity.')
    ] = 5.0,
    json: Json = False,
) -> None:
    """Show natural frequencies, damping ratios and mode shapes of a robot in one pose."""
    import numpy as np
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from autonomous_modal_analysis.pose import parse_pose
    from autonomous_modal_analysis.results import plain
    from autonomous_modal_analysis.terminal import OUTPUT, print_json
    from excitation_planner.sensitivity import sensitivity_table
    from structural_model.robot_files import load_layout, load_robot

    arm = load_robot(robot)
    layout = load_layout(robot, sensors)
    q = parse_pose(arm, pose_deg)
    modes = arm.damped_modes(q, layout.channels)
    shown = modes.frequency_hz <= max_frequency_hz
    coefficients = None
    if sensitivity:
        coefficients = sensitivity_table(arm, q, np.deg2rad(step_deg), max_frequency_hz)
    if json:
        value: dict[str, object] = {
            'robot': arm.robot_name,
            'pose_deg': np.rad2deg(arm.to_controller(q)),
            'frequencies_hz': modes.frequency_hz[shown],
            'damping_ratios': modes.damping_ratio[shown],
            'channels': [channel.name for channel in layout.channels],
            'shapes': {
                'real': modes.channel_shapes.real[:, shown].T,
                'imag': modes.channel_shapes.imag[:, shown].T,
            },
        }
        if coefficients is not None:
            value['sensitivity'] = coefficients
        print_json(plain(value))
        return
    pose = np.rad2deg(arm.to_controller(q)).round(2).tolist()
    OUTPUT.print(f'{arm.robot_name} at {pose} deg', soft_wrap=True, markup=False)
    table = Table(box=SIMPLE_HEAD, padding=(0, 0))
    for heading in ('mode', 'Hz', 'damping %'):
        table.add_column(heading, justify='right', no_wrap=True)
    names = arm.joint_names if coefficients is not None else ()
    for name in names:
        table.add_column(name, justify='right', no_wrap=True)
    for number in range(int(shown.sum())):
        row = [
            str(number + 1),
            f'{modes.frequency_hz[number]:.2f}',
            f'{100 * modes.damping_ratio[number]:.2f}',
        ]
        if coefficients is not None and number < len(coefficients.actual):
            row += [
                f'{100 * actual:.1f}/{100 * predicted:.1f}'
                for actual, predicted in zip(
                    coefficients.actual[number], coefficients.predicted[number], strict=True
                )
            ]
        table.add_row(*row)
    OUTPUT.print(table)
    if coefficients is not None:
        OUTPUT.print(
            f'change of frequency [%] for a joint step of {step_deg:g} deg:'
            ' from the model at both poses / predicted from the shapes at this one'
        )
