"""Identification of a stretch of samples: bands, poles, selection, modes."""

from collections.abc import Callable, Sequence
from dataclasses import replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.errors import IdentificationError
from modal_core.mode import ModeSet
from modal_core.poles import PoleStatus
from modal_core.quality import DataQuality
from modal_core.samples import Samples
from modal_core.window import Pose
from oma_identifier.covariance import Band, Decimation, plan_bands, WhenFull
from oma_identifier.motion import never, PeakTest
from oma_identifier.one_kind import of_one_kind
from oma_identifier.one_thread import one_thread
from oma_identifier.refinement import adopt_refined, Adopted
from oma_identifier.result import WindowResult
from oma_identifier.selection import (
    BandSelector,
    Identified,
    join_bands,
    line_evidence,
    LineTest,
    NewModeTest,
    renumbered,
    SAME_LINE,
    without_doubtful,
    without_explained,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import (
    Line,
    line_at,
    singular_value_spectrum,
    SingularValueSpectrum,
    SpectralPeaks,
    without_lines,
)
from oma_identifier.subspace import BandCovariance, BandStream

FEW_ROWS = 1000
LEAST_PART = 0.25
"""Length of a part over that of the longest for its spectra to be used: the bias that leakage
gives narrow modes goes by one over the length."""
NO_MODE = 'no mode stands out from the noise'
ONLY_LINES = 'only harmonics: no mode stands out beside them'
Adopt = Callable[[Samples, ModeSet, ModeSet, Sequence[Samples]], Adopted]


def identify_samples(
    samples: Samples,
    settings: IdentificationSettings | None = None,
    progress: Callable[[float], None] | None = None,
    explains: PeakTest = never,
) -> WindowResult:
    """Identify the modes of one uniformly sampled stretch.

    Parameters
    ----------
    samples : Samples
        Responses to excitation that nobody measured; at least some tens of periods.
    settings : IdentificationSettings or None
        None: the defaults.
    progress : callable or None
        Called with the share of the work done.
    explains : callable
        Tells a peak that motion of the robot explains from a mode.

    Returns
    -------
    WindowResult
        Without modes, and saying why, when the stretch cannot be identified.

    Raises
    ------
    IdentificationError
        The stretch is too short for the band asked for.
    """
    settings = settings or IdentificationSettings()
    samples = of_one_kind(samples)
    found = identify_parts([samples], settings, explains, progress)
    highest_hz = plan_bands(samples.sample_rate_hz, samples.duration_s, settings)[0].high_hz
    spectrum = singular_value_spectrum(samples, highest_hz)
    return result_of(found, spectrum, DataQuality(), (samples.start_ns, samples.end_ns))


def identify_parts(
    parts: Sequence[Samples],
    settings: IdentificationSettings,
    explains: PeakTest = never,
    progress: Callable[[float], None] | None = None,
) -> Identified:
    """Identify the modes of a record, of which stretches may be missing.

    Whether something is a line or a peak is asked of the longest part, which tells most.

    Parameters
    ----------
    parts : sequence of Samples
        Stretches between gaps, of the same channels and rate, the longest first.
    settings : IdentificationSettings
        Band, orders and limits; bands are planned for the length of all parts together.
    explains : callable
        Tells a peak that motion of the robot explains from a mode.
    progress : callable or None
        Called with the share of the work done.

    Raises
    ------
    IdentificationError
        The parts are too short for the band asked for.
    """
    for part in parts:
        check_samples(part)
    longest, selector = parts[0], BandSelector()
    with one_thread():
        sources = _sources(parts, settings, progress)
        test_line, peaks = line_tester(longest), SpectralPeaks(longest)
        found = identify_bands(
            sources, longest.channels, settings, test_line, explains, peaks, selector
        )
        evidence = line_evidence(longest, found)
        found = without_explained(found, evidence)
        if settings.refines_record:
            found = refine_found(parts, found, sources, settings, explains, selector=selector)
            found = without_explained(found, evidence)
    return found


def _sources(
    parts: Sequence[Samples],
    settings: IdentificationSettings,
    progress: Callable[[float], None] | None = None,
) -> list[BandCovariance | None]:
    duration_s = sum(part.duration_s for part in parts)
    bands = plan_bands(parts[0].sample_rate_hz, duration_s, settings)
    rows = [Decimation() for _ in parts]
    for each, part in zip(rows, parts, strict=True):
        each.take(part.acceleration)
    sources = []
    for done, band in enumerate(bands):
        sources.append(_source(band, rows, duration_s, settings))
        if progress is not None:
            progress((done + 1) / len(bands))
    return sources


def _source(
    band: Band, parts: Sequence[Decimation], duration_s: float, settings: IdentificationSettings
) -> BandCovariance | None:
    # As many blocks in each part as allow for what an interrupted one loses.
    stream = BandStream(band, settings, duration_s / len(parts), WhenFull.JOIN)
    for rows in parts:
        stream.interrupt()
        stream.add(rows)
    return stream.result()


def line_tester(samples: Samples, removed: ModeSet | None = None) -> LineTest:
    """Return a test for lines of samples, which knows the lines removed from them.

    What a line that wavers leaves behind is an image of it still.
    """

    def test(frequency_hz: float, weight: NDArray[np.complex128] | None) -> Line | None:
        for line in removed or ():
            if math.isclose(line.frequency_hz, frequency_hz, rel_tol=SAME_LINE):
                return Line(line.frequency_hz, line.shape, 0.0)
        return line_at(samples, frequency_hz, weight)

    return test


def refine_found(
    parts: Sequence[Samples],
    found: Identified,
    sources: Sequence[BandCovariance | None],
    settings: IdentificationSettings,
    explains: PeakTest = never,
    adopt: Adopt = adopt_refined,
    selector: BandSelector | None = None,
) -> Identified:
    """Return what was found more precisely, at more cost.

    Modes under a line are biased by it: the bands that see one are identified once more without
    it.  Then the modes are refined by maximum likelihood.

    Parameters
    ----------
    parts : sequence of Samples
        What the modes were identified from, the longest first.
    found : Identified
        Of these.
    sources : sequence of BandCovariance or None
        What it was found in.
    settings : IdentificationSettings
        As for the first identification.
    explains : callable
        As for :func:`identify_bands`.
    adopt : callable
        Refines the modes of samples with lines.
    selector : BandSelector or None
        As for :func:`identify_bands`.
    """
    if len(found.harmonics):
        lines_hz = found.harmonics.frequency_hz
        parts = [without_lines(part, tuple(lines_hz)) for part in parts]
        rows = [Decimation() for _ in parts]
        for each, part in zip(rows, parts, strict=True):
            each.take(part.acceleration)
        duration_s = sum(part.duration_s for part in parts)
        freed = [
            _source(source.band, rows, duration_s, settings)
            if source is not None and source.band.sees(lines_hz).any()
            else source
            for source in sources
        ]
        test_line, peaks = line_tester(parts[0], found.harmonics), SpectralPeaks(parts[0])
        again = identify_bands(
            freed, parts[0].channels, settings, test_line, explains, peaks, selector
        )
        images = found.poles.chosen(found.poles.status == PoleStatus.HARMONIC)
        found = replace(
            again,
            harmonics=found.harmonics,
            poles=again.poles.joined(images),
            is_undecided=found.is_undecided,
        )
    adopted = without_doubtful(
        adopt(parts[0], found.modes, found.harmonics, _long(parts)),
        NewModeTest(parts[0], settings, found.harmonics, explains),
    )
    return replace(found, modes=adopted.modes, poles=renumbered(found.poles, adopted.origin))


def _long(parts: Sequence[Samples]) -> list[Samples]:
    """Return the further parts that a likelihood of spectra may use."""
    least_s = LEAST_PART * parts[0].duration_s
    return [part for part in parts[1:] if part.duration_s >= least_s]


def check_samples(samples: Samples) -> None:
    """Refuse samples that break the contract of :class:`Samples`.

    Raises
    ------
    IdentificationError
        Naming the channel that is not finite, or that nothing moves.
    """
    data = samples.acceleration
    # A sum over time is finite when all its samples are, and costs one pass.
    with np.errstate(invalid='ignore', over='ignore'):
        finite = np.isfinite(sum(np.ones(len(part)) @ part for part in samples.stretches()))
    if not finite.all():
        name = samples.channel_names[int(np.argmin(finite))]
        raise IdentificationError('not finite', where=name, expected='finite samples')
    if not (data[:FEW_ROWS] != data[:1]).any() and not (data != data[:1]).any():
        raise IdentificationError('no channel moves', expected='responses to some excitation')


def result_of(
    found: Identified,
    spectrum: SingularValueSpectrum,
    quality: DataQuality,
    span_ns: tuple[int, int],
    index: int = -1,
    pose: Pose | None = None,
) -> WindowResult:
    """Return what was found in a window, or in a whole recording, with what is in doubt of it."""
    return WindowResult(
        index=index,
        start_ns=span_ns[0],
        end_ns=span_ns[1],
        modes=found.modes,
        harmonics=found.harmonics,
        poles=found.poles,
        spectrum=spectrum,
        quality=_explained(quality, found),
        pose=pose,
    )


def _explained(quality: DataQuality, found: Identified) -> DataQuality:
    """Return the quality with what is in doubt, and why there is no mode when there is none."""
    if found.is_undecided:
        quality = replace(quality, flags=(*quality.flags, 'line_or_mode'))
    if len(found.modes) or not quality.identifiable:
        return quality
    reason = ONLY_LINES if len(found.harmonics) else NO_MODE
    return replace(quality, identifiable=False, reason=reason)


def identify_bands(
    sources: Sequence[BandCovariance | None],
    channels: Sequence[Channel],
    settings: IdentificationSettings,
    test_line: LineTest,
    explains: PeakTest = never,
    peaks: SpectralPeaks | None = None,
    selector: BandSelector | None = None,
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
    """
    selector = selector or BandSelector()
    selected = (
        selector.select(source, settings, peaks) for source in sources if source is not None
    )
    selections = [selection for selection in selected if selection is not None]
    return join_bands(selections, channels, settings.method, test_line, explains)
