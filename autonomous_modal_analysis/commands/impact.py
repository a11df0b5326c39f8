"""`ama impact`: modes and their masses from taps of an instrumented hammer."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.console.options import Channels, Export, Json, SampleRate, Unit


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('impact')(impact)


def impact(
    recordings: Annotated[
        list[Path],
        typer.Argument(
            help='Tables with a force channel in N, one per point hit or place of the sensors; '
            'where each tap has a file, those of one point are joined.',
            show_default=False,
        ),
    ],
    at: Annotated[
        list[str] | None,
        typer.Option(
            help='Channel at the point hit, once for all recordings or once each, - before it '
            'where the hammer struck against it; else what the force is called behind an @.'
        ),
    ] = None,
    force: Annotated[
        str | None, typer.Option(help='Name of the force channel; else the one in N.')
    ] = None,
    min_frequency_hz: Annotated[
        float | None, typer.Option(help='Low end of the band; else two spectral lines.')
    ] = None,
    max_frequency_hz: Annotated[
        float | None, typer.Option(help='High end; else where the force has lost 20 dB.')
    ] = None,
    segment_s: Annotated[
        float | None, typer.Option(help='Length used of each tap; else up to the next.')
    ] = None,
    window_end: Annotated[
        float,
        typer.Option(help='Exponential window falls to this share; 1: none, none is needed.'),
    ] = 1.0,
    sample_rate_hz: SampleRate = None,
    unit: Unit = None,
    channels: Channels = None,
    out: Annotated[
        Path | None,
        typer.Option(help='Folder for modes.json, modes.csv, frf.uff and report.html.'),
    ] = None,
    export: Export = None,
    json: Json = False,
) -> None:
    """Find modes, shapes and modal masses from taps of an instrumented hammer.

    Taps are found and judged: a double hit, a clipped, weak or strange tap is left out and named.
    """
    from autonomous_modal_analysis.api.impact import impact as tap_test
    from autonomous_modal_analysis.console.options import channel_names
    from autonomous_modal_analysis.console.terminal import print_json
    from autonomous_modal_analysis.export import check_endings, ENDINGS
    from autonomous_modal_analysis.tap_report import FILES, show_tap_test
    from autonomous_modal_analysis.views.output import export_each, show_written

    check_endings(export or (), ENDINGS)
    result = tap_test(
        recordings,
        at=at[0] if at and len(at) == 1 else at,
        force=force,
        sample_rate_hz=sample_rate_hz,
        unit=unit,
        channels=channel_names(channels),
        min_frequency_hz=min_frequency_hz,
        max_frequency_hz=max_frequency_hz,
        segment_s=segment_s,
        window_end=window_end,
    )
    if json:
        print_json(result.to_dict())
    else:
        show_tap_test(result.found, result.name)
    if out is not None:
        result.save(out)
        show_written(out, FILES)
    export_each(export, result.export)
