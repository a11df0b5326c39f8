"""Identification of a stretch of samples: bands, poles, selection, modes."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from modal_core.errors import IdentificationError
from modal_core.quality import DataQuality
from modal_core.samples import Samples
from modal_core.work.progress import Progress
from oma_identifier.covariance import plan_bands
from oma_identifier.identify_bands import band_sources, identify_bands
from oma_identifier.motion import never, PeakTest
from oma_identifier.moving_lines import MovingLine, with_moving, without_moving
from oma_identifier.one_kind import of_one_kind
from oma_identifier.one_thread import one_thread
from oma_identifier.refine_found import line_tester, refine_found
from oma_identifier.refinement import adopt_refined
from oma_identifier.result import result_of, WindowResult
from oma_identifier.selection import (
    BandSelector,
    Identified,
    line_evidence,
    up_to,
    without_explained,
    without_moments,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import peaks_hz, singular_value_spectrum, SpectralPeaks

FIRST_ROWS = 1000
SEEN_BEYOND = 2.0
"""Times the highest frequency asked for, up to which modes of a record are identified as well:
their tails reach below.  Of four modes none was refined without the strong ones of the octave
above, three with those of half an octave, and all with all of them."""


def identify_samples(
    samples: Samples,
    settings: IdentificationSettings | None = None,
    progress: Progress | None = None,
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
    progress: Progress | None = None,
    *,
    is_compared: bool = False,
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
    is_compared : bool
        Whether other parts of the record are identified as well, to tell whether modes move.

    Raises
    ------
    IdentificationError
        The parts are too short for the band asked for.
    """
    for part in parts:
        check_samples(part)
    parts, moving = _without_moving(parts)
    longest, selector, highest_hz = parts[0], BandSelector(), settings.max_frequency_hz
    if highest_hz is not None and settings.refines_record:
        settings = replace(settings, max_frequency_hz=SEEN_BEYOND * highest_hz)
    with one_thread():
        sources = band_sources(parts, settings, progress)
        test_line, peaks = line_tester(longest), SpectralPeaks(longest)
        found = identify_bands(
            sources,
            longest.channels,
            settings,
            test_line,
            explains,
            peaks,
            selector,
            peaks_hz(longest),
        )
        # Where there is no line for sure there is nothing to explain a mode by.
        evidence = line_evidence(longest, found) if len(found.sure_lines_hz) else None
        found = without_explained(found, evidence)
        if settings.refines_record:
            found = refine_found(
                parts,
                found,
                sources,
                settings,
                explains,
                partial(adopt_refined, is_compared=is_compared),
                selector=selector,
                tries_unsure=True,
            )
            found = without_explained(found, evidence)
        found = without_moments(found, peaks)
    found = with_moving(found, moving)
    return found if highest_hz is None else up_to(found, highest_hz)


def _without_moving(parts: Sequence[Samples]) -> tuple[list[Samples], list[MovingLine]]:
    """Return the parts without lines that move with a speed, and those of the longest part.

    No pole is where such a line is: it smears over a band, and looks like modes there.
    """
    with one_thread():
        freed = [without_moving(part) for part in parts]
    return [part for part, _ in freed], [line for _, lines in freed[:1] for line in lines]


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
    if not (data[:FIRST_ROWS] != data[:1]).any() and not (data != data[:1]).any():
        raise IdentificationError('no channel moves', expected='responses to some excitation')
