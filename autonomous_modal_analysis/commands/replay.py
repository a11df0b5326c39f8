"""`ama replay`: a recording through the live identifier."""

from typing import Annotated

import typer

from autonomous_modal_analysis.option_groups import grouped, Identifier, Playing, Source
from autonomous_modal_analysis.options import Json


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('replay')(grouped(replay))


def replay(
    source: Source,
    identifier: Identifier,
    playing: Playing,
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
    from autonomous_modal_analysis.message_view_node import WindowView
    from autonomous_modal_analysis.plan_record import recorded_edge_hz
    from autonomous_modal_analysis.replay_session_node import play_only, ReplaySettings
    from autonomous_modal_analysis.replay_session_node import replay as run
    from autonomous_modal_analysis.terminal import MESSAGES, print_json, progress_bar
    from oma_identifier.covariance import below_edge

    # Opened and built here too: what is wrong is said before any node starts.
    recording = source.open()
    info = recording.info
    settings = below_edge(identifier.settings, recorded_edge_hz(recording.source))
    identifier.sensors()
    played = playing.settings
    played_s = max(info.duration_s - played.start_offset_s, 0.0) / played.rate
    session = ReplaySettings(
        replay_parameters={**source.parameters(), **playing.parameters()},
        identifier_parameters={
            **identifier.parameters(),
            'max_frequency_hz': settings.max_frequency_hz or 0.0,
        },
        duration_s=0.0 if played.loop else played_s,
    )
    view = WindowView(json=json)
    with progress_bar(f'playing {source.recording.name}') as progress:
        if only_play:
            play_only(session, progress)
            return
        run(session, view.take, progress)
    if json:
        print_json({'windows': view.windows})
    else:
        MESSAGES.print(f'{len(view.windows)} windows')
    if view.n_skipped:
        MESSAGES.print(
            f'[yellow]note[/]: {view.n_skipped} windows were skipped: this computer cannot'
            f' identify them at rate {played.rate:g}; lower --rate'
        )
