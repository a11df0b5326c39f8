"""`ama replay`: a recording through the live identifier."""

from typing import Annotated, Any

import typer

from autonomous_modal_analysis.console.option_groups import grouped, Identifier, Playing, Source
from autonomous_modal_analysis.console.options import Json
from autonomous_modal_analysis.identified.keeping import Keeping


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('replay')(grouped(replay))


def replay(
    source: Source,
    identifier: Identifier,
    playing: Playing,
    keeping: Keeping,
    only_play: Annotated[
        bool,
        typer.Option('--only-play', help='Play into the ROS domain of this shell, no identifier.'),
    ] = False,
    json: Json = False,
) -> None:
    """Play a recording through the identifier node and show each window's modes.

    The recording keeps its own stamps, so the modes are those of `ama identify`, window by window.
    """
    from autonomous_modal_analysis.ros_ready import require_ros

    require_ros()
    from autonomous_modal_analysis.console.terminal import (
        MESSAGES,
        OUTPUT,
        print_json,
        progress_bar,
    )
    from autonomous_modal_analysis.identified.joint_sliding import slid_in
    from autonomous_modal_analysis.identified.plan_record import (
        recorded_edge_hz,
        recorded_robot_name,
    )
    from autonomous_modal_analysis.identified.results import plain
    from autonomous_modal_analysis.live.replay_session_node import play_only, ReplaySettings
    from autonomous_modal_analysis.live.replay_session_node import replay as run
    from autonomous_modal_analysis.views.message_view_node import WindowView
    from autonomous_modal_analysis.views.output import show_kept
    from modal_history.kept import KeptWindow
    from modal_history.ros_messages import kept_window
    from modal_recordings.of_robot import as_on_arm
    from oma_identifier.covariance import below_edge

    # Opened and built here too: what is wrong is said before any node starts.
    recording = source.open()
    info = recording.info
    settings = below_edge(identifier.settings, recorded_edge_hz(recording.source))
    robot = identifier.motion()
    identifier.sensors()
    played = playing.settings
    played_s = max(info.duration_s - played.start_offset_s, 0.0) / played.rate
    joint_names = robot.joint_names if robot is not None else ()
    known = identifier.parameters()
    session = ReplaySettings(
        replay_parameters={
            **source.parameters(),
            **playing.parameters(),
            'joint_names': list(joint_names) or [''],
            'layout_file': known['layout_file'],
        },
        identifier_parameters={
            **known,
            'max_frequency_hz': settings.max_frequency_hz or 0.0,
        },
        duration_s=0.0 if played.loop else played_s,
    )
    shift_ns = keeping.shift_ns(info.start_ns, recording.name) if keeping.history else 0
    view = WindowView(json=json)
    kept: list[KeptWindow] = []

    def take(message: Any) -> None:
        view.take(message)
        if keeping.history is not None:
            kept.append(kept_window(message))

    with progress_bar(f'playing {source.recording.name}') as progress:
        if only_play:
            play_only(session, progress)
            return
        run(session, take, progress)
    from_ns = info.start_ns + round(1e9 * played.start_offset_s)
    slid = slid_in(as_on_arm(recording.source, joint_names).measurements(), robot, from_ns)
    if json:
        print_json({'windows': view.windows, **({'sliding': plain(slid)} if slid else {})})
    else:
        MESSAGES.print(f'{len(view.windows)} windows')
        if slid is not None:
            OUTPUT.print(slid.words(), soft_wrap=True, markup=False)
    if view.n_skipped:
        MESSAGES.print(
            f'[yellow]note[/]: {view.n_skipped} windows were skipped: this computer cannot'
            f' identify them at rate {played.rate:g}; lower --rate'
        )
    if keeping.history is not None:
        name = identifier.robot or recorded_robot_name(recording.source)
        told = keeping.circumstances(name, settings, source.recording)
        show_kept(keeping.history, keeping.add_kept(told, kept, shift_ns))
