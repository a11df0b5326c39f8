"""`ama replay`: a recording through the live identifier."""

from typing import Annotated

import typer

from autonomous_modal_analysis.options import (
    Hop,
    Json,
    LayoutPath,
    MaxFrequency,
    MinFrequency,
    read_layout,
    RecordingPath,
    SampleRate,
    Topics,
    Unit,
    WindowLength,
)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('replay')(replay)


def replay(
    recording: RecordingPath,
    rate: Annotated[float, typer.Option(help='1: as recorded; 10: ten times as fast.')] = 1.0,
    start_offset_s: Annotated[float, typer.Option(help='Skip this much at the beginning.')] = 0.0,
    loop: Annotated[bool, typer.Option('--loop', help='Begin again at the end.')] = False,
    remap: Annotated[
        list[str] | None, typer.Option(help='old:=new topic; may be given more than once.')
    ] = None,
    only_play: Annotated[
        bool,
        typer.Option('--only-play', help='Play into the ROS domain of this shell, no identifier.'),
    ] = False,
    window_s: WindowLength = 60.0,
    hop_s: Hop = None,
    min_frequency_hz: MinFrequency = None,
    max_frequency_hz: MaxFrequency = None,
    topic: Topics = None,
    layout: LayoutPath = None,
    sample_rate_hz: SampleRate = None,
    unit: Unit = None,
    json: Json = False,
) -> None:
    """Play a recording through the identifier node and show each window's modes.

    The recording keeps its own stamps, so the modes are those of `ama identify`, window by window.
    """
    from autonomous_modal_analysis.message_view_node import WindowView
    from autonomous_modal_analysis.replay_session_node import (
        play_only,
        ReplaySettings,
    )
    from autonomous_modal_analysis.replay_session_node import (
        replay as run,
    )
    from autonomous_modal_analysis.terminal import MESSAGES, print_json, progress_bar
    from modal_core.errors import SettingsError
    from oma_identifier.settings import IdentificationSettings
    from recordings.open_recording import open_recording

    # Opened here too: what is wrong with it is said before any node starts.
    info = open_recording(
        recording, sample_rate_hz=sample_rate_hz, unit=unit, topics=tuple(topic) if topic else None
    ).info()
    IdentificationSettings(
        window_s=window_s,
        hop_s=hop_s,
        min_frequency_hz=min_frequency_hz,
        max_frequency_hz=max_frequency_hz,
    )
    read_layout(layout)
    if not 0.0 < rate <= 1000.0:
        raise SettingsError('out of range', where='--rate', found=rate, expected='above 0 to 1000')
    settings = ReplaySettings(
        recording=recording.resolve(),
        replay_parameters={
            'rate': rate,
            'start_offset_s': start_offset_s,
            'loop': loop,
            'remap': remap or [''],
            'topics': topic or [''],
            'sample_rate_hz': sample_rate_hz or 0.0,
            'unit': unit or '',
        },
        identifier_parameters={
            'window_s': window_s,
            'hop_s': hop_s or 0.0,
            'min_frequency_hz': min_frequency_hz or 0.0,
            'max_frequency_hz': max_frequency_hz or 0.0,
            'layout_file': str(layout.resolve()) if layout else '',
        },
        duration_s=0.0 if loop else max(info.duration_s - start_offset_s, 0.0) / rate,
    )
    view = WindowView(json=json)
    with progress_bar(f'playing {recording.name}') as progress:
        if only_play:
            play_only(settings, progress)
            return
        run(settings, view.take, progress)
    if json:
        print_json({'windows': view.windows})
    else:
        MESSAGES.print(f'{len(view.windows)} windows')
    if view.n_skipped:
        MESSAGES.print(
            f'[yellow]note[/]: {view.n_skipped} windows were skipped: this computer cannot'
            f' identify them at rate {rate:g}; lower --rate'
        )
