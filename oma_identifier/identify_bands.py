"""Bands of a record: their covariances, the poles in them, the modes among these."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.samples import Samples
from modal_core.work.progress import Progress
from oma_identifier.covariance import Band, Decimation, plan_bands, WhenFull
from oma_identifier.motion import never, PeakTest
from oma_identifier.selection import BandSelector, Identified, join_bands, LineTest
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import SpectralPeaks
from oma_identifier.subspace import BandCovariance, BandStream


def band_sources(
    parts: Sequence[Samples],
    settings: IdentificationSettings,
    progress: Progress | None = None,
) -> list[BandCovariance | None]:
    """Return the covariances of every band, None where a band has too little data.

    Parameters
    ----------
    parts : sequence of Samples
        Stretches of one record; bands are planned for the length of all together.
    settings : IdentificationSettings
        Band and block rows.
    progress : callable or None
        Called with the share of the work done.
    """
    duration_s = sum(part.duration_s for part in parts)
    bands = plan_bands(parts[0].sample_rate_hz, duration_s, settings)
    rows, sources = taken(parts), []
    for done, band in enumerate(bands):
        sources.append(band_source(band, rows, duration_s, settings))
        if progress is not None:
            progress((done + 1) / len(bands))
    return sources


def bands_without_lines(
    sources: Sequence[BandCovariance | None],
    freed: Sequence[Samples],
    lines_hz: NDArray[np.float64],
    settings: IdentificationSettings,
) -> list[BandCovariance | None]:
    """Return the covariances once more, those of bands that see lines from samples without them.

    Parameters
    ----------
    sources : sequence of BandCovariance or None
        Of the samples with the lines.
    freed : sequence of Samples
        The same stretches without them.
    lines_hz : (n_lines,) array [Hz]
        Where the lines are.
    settings : IdentificationSettings
        As for the first time.
    """
    rows = taken(freed)
    duration_s = sum(part.duration_s for part in freed)
    return [
        band_source(source.band, rows, duration_s, settings)
        if source is not None and source.band.sees(lines_hz).any()
        else source
        for source in sources
    ]


def taken(parts: Sequence[Samples]) -> list[Decimation]:
    """Return stretches of one record, each to be decimated once for all bands."""
    rows = [Decimation() for _ in parts]
    for each, part in zip(rows, parts, strict=True):
        each.take(part.acceleration)
    return rows


def band_source(
    band: Band, parts: Sequence[Decimation], duration_s: float, settings: IdentificationSettings
) -> BandCovariance | None:
    """Return the covariances of one band, None where it has too little data."""
    # As many blocks in each part as allow for what an interrupted one loses.
    stream = BandStream(band, settings, duration_s / len(parts), WhenFull.JOIN)
    for rows in parts:
        stream.interrupt()
        stream.add(rows)
    return stream.result()


def identify_bands(
    sources: Sequence[BandCovariance | None],
    channels: Sequence[Channel],
    settings: IdentificationSettings,
    test_line: LineTest,
    explains: PeakTest = never,
    peaks: SpectralPeaks | None = None,
    selector: BandSelector | None = None,
    narrow_hz: Sequence[float] = (),
) -> Identified:
    """Solve every band, select the modes and sort out the harmonics.

    Parameters
    ----------
    sources : sequence of BandCovariance or None
        None where a band has too little data.
    channels : sequence of Channel
        Of the covariances.
    settings : IdentificationSettings
        Orders and limits.
    test_line : callable
        As for :func:`join_bands`.
    explains : callable
        Tells a peak that motion of the robot explains from a mode.
    peaks : SpectralPeaks or None
        Of the samples behind the covariances, where they are at hand.
    selector : BandSelector or None
        Knows what it selected before from the same covariances; None: nothing.
    narrow_hz : sequence of float [Hz]
        As for :func:`join_bands`.
    """
    selector = selector or BandSelector()
    selections = [
        selection
        for source in sources
        if source is not None
        for selection in selector.select(source, settings, peaks)
    ]
    return join_bands(selections, channels, settings.method, test_line, explains, narrow_hz)
