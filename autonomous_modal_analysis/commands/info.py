"""`ama info`: what a recording holds and what the identifier would use."""

from pathlib import Path
from typing import Annotated, TYPE_CHECKING

import typer

from autonomous_modal_analysis.console.option_groups import grouped, Source
from autonomous_modal_analysis.console.options import ExportSamples, Json

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.recording import Recording
    from modal_recordings.contents import TopicSummary


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('info')(grouped(info))


def info(
    source: Source,
    json: Json = False,
    export: ExportSamples = None,
    attachments: Annotated[
        Path | None,
        typer.Option(
            help='Folder that gets the files the recording carries: robot.urdf, model.yaml,'
            ' sensors.yaml, software.txt; --robot takes it.'
        ),
    ] = None,
) -> None:
    """Show topics, channels, rates and gaps of a recording, and what would be used of it."""
    from rich.box import SIMPLE_HEAD
    from rich.markup import escape
    from rich.table import Table

    from autonomous_modal_analysis.api.recording import listed
    from autonomous_modal_analysis.console.terminal import MESSAGES, OUTPUT, print_json
    from autonomous_modal_analysis.views.output import show_exported

    recording = source.open(to_look=True)
    for file in export or ():
        left_out = recording.export(file)
        if left_out:
            words = f'left out, flat, clipped or with samples lost: {", ".join(left_out)}'
            MESSAGES.print(escape(words), soft_wrap=True)
        show_exported(file)
    if attachments is not None:
        _save_attachments(recording, attachments)
    found = recording.info
    if json:
        print_json(recording.to_dict())
        return
    extent = f'{found.duration_s:.3f} s' if found.end_ns else f'{found.n_messages} messages'
    OUTPUT.print(f'{escape(found.path)}: {found.kind}, {extent}', soft_wrap=True)
    table = Table(box=SIMPLE_HEAD, padding=(0, 0))
    for heading in ('topic', 'type', 'samples', 'rate Hz', 'jitter ms', 'gaps', 'used'):
        table.add_column(heading, overflow='fold', no_wrap=heading == 'rate Hz')
    for entry in sorted(found.topics, key=lambda topic: not topic.usable):
        table.add_row(
            escape(entry.name),
            escape(entry.message_type.rsplit('/', 1)[-1]),
            *_counted(entry),
            escape(listed(entry.channels)) if entry.usable else f'no: {escape(entry.reason)}',
        )
    OUTPUT.print(table)
    for note in found.notes:
        OUTPUT.print(f'note: {escape(note)}', soft_wrap=True)
    for statement in found.damage:
        OUTPUT.print(f'[yellow]damaged[/]: {escape(statement)}', soft_wrap=True)
    for event in recording.bridge_events:
        OUTPUT.print(f'bridge: {escape(event)}', soft_wrap=True)
    _show_attachments(recording)
    OUTPUT.print(f'the identifier would use {len(found.channels)} channels')


def _show_attachments(recording: 'Recording') -> None:
    from rich.markup import escape

    from autonomous_modal_analysis.console.terminal import OUTPUT
    from modal_recordings.messages import attached_software

    for attachment in recording.attachments:
        said = f'{attachment.name}, {attachment.n_bytes} bytes'
        if attachment.problem:
            said += f': not read, {attachment.problem}'
        OUTPUT.print(f'carries: {escape(said)}', soft_wrap=True)
    if software := attached_software(recording.attachments):
        OUTPUT.print(f'written by: {escape(software)}', soft_wrap=True)


def _save_attachments(recording: 'Recording', folder: Path) -> None:
    from autonomous_modal_analysis.console.terminal import MESSAGES
    from autonomous_modal_analysis.views.output import show_exported

    written = recording.save_attachments(folder)
    for file in written:
        show_exported(file)
    if not written:
        MESSAGES.print('the recording carries no files')


def _counted(entry: 'TopicSummary') -> tuple[str, ...]:
    """Return samples, rate, jitter and gaps; nothing of a topic whose messages are not read."""
    if not entry.usable:
        return ('',) * 4
    return (
        str(entry.n_samples),
        f'{entry.measured_rate_hz or entry.declared_rate_hz:.6g}',
        f'{1e3 * entry.jitter_std_s:.3g}',
        str(entry.n_gaps),
    )
