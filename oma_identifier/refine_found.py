"""What was found in a record, found more precisely: without its lines, by maximum likelihood."""

from collections.abc import Callable, Sequence
from dataclasses import replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.poles import PoleStatus
from modal_core.samples import Samples
from oma_identifier.identify_bands import bands_without_lines, identify_bands
from oma_identifier.motion import never, PeakTest
from oma_identifier.refinement import adopt_refined, Adopted
from oma_identifier.selection import (
    BandSelector,
    candidates_among,
    Identified,
    line_reach,
    LineTest,
    NewModeTest,
    renumbered,
    SELECTION,
    with_forced,
    without_doubtful,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import Line, line_at, SpectralPeaks, without_lines
from oma_identifier.subspace import BandCovariance

LEAST_PART = 0.25
"""Length of a part over that of the longest for its spectra to be used: the bias that leakage
gives narrow modes goes by one over the length."""
Adopt = Callable[[Samples, ModeSet, ModeSet, Sequence[Samples], Sequence[Mode]], Adopted]


def line_tester(samples: Samples, removed: ModeSet | None = None) -> LineTest:
    """Return a test for lines of samples, which knows the lines removed from them.

    What a line that wavers leaves behind is an image of it still.
    """

    def test(frequency_hz: float, weight: NDArray[np.complex128] | None) -> Line | None:
        for line in removed or ():
            reach = line_reach(frequency_hz, samples.duration_s, SELECTION.same_line)
            if math.isclose(line.frequency_hz, frequency_hz, rel_tol=reach):
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
    tries_unsure: bool = False,
) -> Identified:
    """Return what was found more precisely, at more cost.

    Modes under a line are biased by it: the bands that see one are identified once more without
    it.  What may be a mode of light damping is left where it is: without it its bell would stay
    behind, and look like modes.  Then the modes are refined by maximum likelihood.

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
    tries_unsure : bool
        Whether the likelihood is asked for what the selection left out as well.
    """
    selector = selector or BandSelector()
    lines_hz = np.setdiff1d(found.harmonics.frequency_hz, found.doubtful_hz)
    if len(lines_hz):
        parts = [without_lines(part, tuple(lines_hz)) for part in parts]
        sources = bands_without_lines(sources, parts, lines_hz, settings)
        test_line, peaks = line_tester(parts[0], found.harmonics), SpectralPeaks(parts[0])
        again = identify_bands(
            sources, parts[0].channels, settings, test_line, explains, peaks, selector
        )
        images = found.poles.chosen(found.poles.status == PoleStatus.HARMONIC)
        found = replace(
            again,
            harmonics=found.harmonics,
            poles=again.poles.joined(images),
            doubtful_hz=found.doubtful_hz,
        )
    candidates = _candidates(sources, settings, selector) if tries_unsure else []
    adopted = without_doubtful(
        adopt(parts[0], found.modes, found.harmonics, _long(parts), candidates),
        NewModeTest(parts[0], settings, found.harmonics, explains),
    )
    forced = [found.modes.modes[index] for index in adopted.forced]
    found = replace(found, modes=adopted.modes, poles=renumbered(found.poles, adopted.origin))
    return with_forced(found, forced)


def _candidates(
    sources: Sequence[BandCovariance | None],
    settings: IdentificationSettings,
    selector: BandSelector,
) -> list[Mode]:
    """Return what may be modes beside those selected."""
    selections = [selector.select(source, settings) for source in sources if source is not None]
    return candidates_among([each for both in selections for each in both])


def _long(parts: Sequence[Samples]) -> list[Samples]:
    """Return the further parts that a likelihood of spectra may use."""
    least_s = LEAST_PART * parts[0].duration_s
    return [part for part in parts[1:] if part.duration_s >= least_s]
