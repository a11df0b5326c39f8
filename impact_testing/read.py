"""Recordings of taps from files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from impact_testing.measuring_chain import check_measured
from impact_testing.record import AGAINST, ImpactRecord, Run
from modal_core.channel import Channel
from modal_core.errors import RecordingError
from modal_core.measurements import SampleBlock, StampedSamples
from modal_core.samples import Samples
from modal_core.units import DISPLACEMENT, TIMES_DERIVED
from modal_recordings.force_column import open_with_force


def read_impact(
    path: str | Path,
    hit: str | None = None,
    force: str | None = None,
    sample_rate_hz: float | None = None,
    unit: str | None = None,
    channels: Sequence[str] | None = None,
) -> ImpactRecord:
    """Read a recording of taps on one point; times may begin anew for each tap.

    Parameters
    ----------
    path : path
        A table, one column of which is a force.
    hit : str or None
        The channel at the point that was hit, ``-`` before it where the hammer struck against it;
        None: what the force's name says behind an @ (``hammer@elbow.x``), or the channel of the
        same name.
    force, sample_rate_hz, unit, channels
        See :func:`modal_recordings.force_column.open_with_force`.

    Raises
    ------
    RecordingError
        No force, channels whose motion is none, or values that are no measurement.
    """
    found = open_with_force(path, force, sample_rate_hz, unit, channels, in_runs=True)
    recording = found.responses
    rows = np.concatenate(
        [
            np.asarray(block.acceleration)
            for block in recording.measurements()
            if isinstance(block, SampleBlock | StampedSamples)
        ]
    )
    check_measured(
        path,
        np.column_stack([found.force_n, rows]),
        (found.name, *recording.channel_names),
        ('N', *recording.units),
    )
    measured = tuple(
        Channel(name, unit=si)
        for name, si in zip(recording.channel_names, recording.units, strict=True)
    )
    for channel in measured:
        if TIMES_DERIVED.get(channel.unit) is None or not channel.is_straight:
            raise RecordingError(
                'a channel that measures no motion along a line',
                where=path,
                found=f'{channel.name} [{channel.unit}]',
                expected=f'accelerations, velocities or displacements [{DISPLACEMENT}]',
                advice='leave it out with --channels, - in its place',
            )
    samples = Samples(rows, recording.sample_rate_hz, measured, recording.start_ns)
    point = _hit(found.name, recording.channel_names) if hit is None else hit
    name, ends = Path(path).stem, (*found.begins[1:], len(rows))
    runs = tuple(Run(name, *rows_of) for rows_of in zip(found.begins, ends, strict=True))
    return ImpactRecord(found.force_n, samples, point, name, runs, found.without_unit)


def _hit(force: str, names: Sequence[str]) -> str:
    told = force.rpartition('@')[2] if '@' in force else force
    return told if '@' in force or told.removeprefix(AGAINST) in names else ''
