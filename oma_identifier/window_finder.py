"""What is in the samples of window after window: poles, modes, lines, refined modes."""

from functools import partial

import numpy as np

from modal_core.samples import Samples
from modal_core.work.free_memory import give_back, LARGE_BYTES
from oma_identifier.identify_bands import identify_bands
from oma_identifier.methods import identify_by, method_named
from oma_identifier.motion import PeakTest
from oma_identifier.moving_lines import MovingLine, with_moving, without_moving
from oma_identifier.one_thread import one_thread
from oma_identifier.past_samples import PastSamples
from oma_identifier.refine_found import refine_found
from oma_identifier.refinement import Refiner
from oma_identifier.selection import (
    BandSelector,
    Identified,
    line_evidence,
    without_explained,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import line_at, SpectralPeaks
from oma_identifier.subspace import RecordStreams


class WindowFinder:
    """Identifies a window by what is carried over from the last one and its new samples.

    Parameters
    ----------
    settings : IdentificationSettings
        Method, band, orders and limits.
    """

    def __init__(self, settings: IdentificationSettings) -> None:
        self._settings = settings
        self._newest = RecordStreams(settings)
        self._refiner = Refiner()
        self._selector = BandSelector()
        self._past = PastSamples(settings.reach_s)
        method_named(settings.method)

    def find(self, samples: Samples, explains: PeakTest) -> Identified:
        """Return what is found in the cleaned samples of the next window.

        Raises
        ------
        IdentificationError
            They are too few, or say nothing.
        numpy.linalg.LinAlgError
            They cannot be solved.
        """
        with one_thread():
            if self._settings.method == 'ssi_cov':
                return self._found(samples, explains)
            samples = self._past.up_to(samples)
            return self.found_by_method(samples, explains)

    def found_by_method(self, samples: Samples, explains: PeakTest) -> Identified:
        """Return what a method without covariances finds in samples, of a window or a record."""
        known = None if samples.known is None else samples.known.astype(np.float64)
        return identify_by(self._settings.method, samples, self._settings, known, explains)

    def _found(self, samples: Samples, explains: PeakTest) -> Identified:
        moving: tuple[MovingLine, ...] = ()
        if self._settings.refines:
            samples, moving = without_moving(samples)
        self._newest.add(samples)
        sources = self._newest.results()
        found = identify_bands(
            sources,
            samples.channels,
            self._settings,
            partial(line_at, samples),
            explains,
            SpectralPeaks(samples),
            self._selector,
        )
        evidence = line_evidence(samples, found) if len(found.sure_lines_hz) else None
        found = without_explained(found, evidence)
        if not self._settings.refines:
            return found
        if samples.acceleration.nbytes >= LARGE_BYTES:
            give_back()
        found = refine_found(
            [samples],
            found,
            sources,
            self._settings,
            explains,
            self._refiner.adopt,
            self._selector,
        )
        return with_moving(without_explained(found, evidence), moving)
