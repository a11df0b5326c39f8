"""`ama operate`: a person previews, releases, holds to run."""

from typing import Annotated

import typer

from autonomous_modal_analysis.console.options import Namespace

EXIT_LEFT = 1


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('operate')(operate)


def operate(
    namespace: Namespace = '',
    release: Annotated[
        str,
        typer.Option(
            help='Release the plan whose hash begins with these characters (8 or more), without'
            ' asking.',
            show_default=False,
        ),
    ] = '',
    robot: Annotated[
        str | None,
        typer.Option(
            help='Folder of the robot, for the preview.', show_default="the plan's robot"
        ),
    ] = None,
    joy: Annotated[
        bool,
        typer.Option('--joy', help='Hold a button of a joystick (sensor_msgs/Joy), not a key.'),
    ] = False,
    joy_topic: Annotated[str, typer.Option(help='Topic of the joystick.')] = 'joy',
    button: Annotated[int, typer.Option(min=0, help='Number of its deadman button.')] = 4,
) -> None:
    """Show the plan in hand, release it by its hash, and run it while a key is held down.

    Works beside `ama up`, and beside a bridge to a real controller. The arm moves only while the
    SPACE bar (or the button) is held; what is wrong is told with the next step. This is not a
    safety function: guards, enabling device and emergency stop stay in charge. Exit status 1 if
    the plan was not played to its end.
    """
    from autonomous_modal_analysis.ros_ready import require_ros

    require_ros()
    from autonomous_modal_analysis.console.options import check_namespace
    from autonomous_modal_analysis.operating.cell_node import cell_view
    from autonomous_modal_analysis.operating.holding import ButtonHolding, kept, space_bar
    from autonomous_modal_analysis.operating.keyboard import check_terminal
    from autonomous_modal_analysis.operating.panel import LeftError, Panel
    from autonomous_modal_analysis.operating.terminal_person import TerminalPerson

    check_namespace(namespace)
    if not joy:
        check_terminal()
    person = TerminalPerson(robot)
    with cell_view(namespace) as cell:
        held = ButtonHolding(cell.button(joy_topic, button), button) if joy else None
        try:
            Panel(cell, person, kept(held) if held else space_bar, release).run()
        except LeftError as error:
            person.tell(str(error))
            raise typer.Exit(EXIT_LEFT) from error
