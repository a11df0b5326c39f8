"""`ama identify`: the modes of a recording."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.options import (
    channel_names,
    Channels,
    Hop,
    Json,
    LayoutPath,
    MaxFrequency,
    Method,
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
    app.command('identify')(identify)


def identify(
    recording: RecordingPath,
    window_s: WindowLength = 60.0,
    hop_s: Hop = None,
    min_frequency_hz: MinFrequency = None,
    max_frequency_hz: MaxFrequency = None,
    method: Method = 'ssi_cov',
    topic: Topics = None,
    layout: LayoutPath = None,
    robot: Annotated[
        str | None,
        typer.Option(
            help='Robot by name or folder: its rigid motion and drive lines, predicted from joint '
            'states, are taken out; its sensors.yaml is the layout unless --layout names another.'
        ),
    ] = None,
    sample_rate_hz: SampleRate = None,
    unit: Unit = None,
    channels: Channels = None,
    out: Annotated[
        Path | None, typer.Option(help='Folder for modes.json, modes.csv and report.html.')
    ] = None,
    json: Json = False,
) -> None:
    """Identify natural frequencies, damping ratios and mode shapes of a recording.

    No setting is required: band, model orders, references and the choice of modes follow from
    the data.
    """
    from autonomous_modal_analysis.identification import identify_recording
    from autonomous_modal_analysis.output import (
        show_damage,
        show_identification,
        write_results,
    )
    from autonomous_modal_analysis.results import identification_json
    from autonomous_modal_analysis.terminal import print_json, progress_bar
    from oma_identifier.settings import IdentificationSettings
    from recordings.open_recording import open_recording
    from structural_model.robot_files import load_layout, load_robot

    settings = IdentificationSettings(
        window_s=window_s,
        hop_s=hop_s,
        min_frequency_hz=min_frequency_hz,
        max_frequency_hz=max_frequency_hz,
        method=method,
    )
    model = load_robot(robot) if robot else None
    sensors = load_layout(robot) if robot and layout is None else read_layout(layout)
    if model is not None and sensors is not None:
        sensors.check_links(model.link_names, model.robot_name)
    source = open_recording(
        recording,
        sample_rate_hz=sample_rate_hz,
        unit=unit,
        channels=channel_names(channels),
        topics=tuple(topic) if topic else None,
    )
    with progress_bar(f'identifying {recording.name}') as progress:
        found = identify_recording(source, settings, sensors, progress, model)
    show_damage(found.identification.damage)
    if json:
        print_json(identification_json(found.identification))
    else:
        show_identification(found, recording.name)
    if out is not None:
        write_results(out, found, recording.name)
