"""Whether a mode that only the likelihood found may be reported.

It has not been through the selection, so what excludes candidates there excludes it here: it lies
outside the analysed band, on a line, at the edge of an excited band, or where motion of the robot
explains a peak.
"""

from dataclasses import dataclass, replace
import logging

import numpy as np

from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.covariance import plan_bands
from oma_identifier.motion import PeakTest
from oma_identifier.refinement import Adopted, NEW
from oma_identifier.selection.selection import is_edge
from oma_identifier.selection.thresholds import SELECTION
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import line_at, SPECTRA, SpectralPeaks

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class NewModeTest:
    """What speaks against new modes of one stretch.

    Parameters
    ----------
    samples : Samples
        The stretch.
    settings : IdentificationSettings
        The analysed band.
    lines : ModeSet
        Known harmonics.
    explains : callable
        Tells a peak that motion of the robot explains from a mode.
    """

    samples: Samples
    settings: IdentificationSettings
    lines: ModeSet
    explains: PeakTest

    def passes(self, modes: list[Mode]) -> list[bool]:
        """Tell for each mode whether nothing speaks against it."""
        bands = plan_bands(self.samples.sample_rate_hz, self.samples.duration_s, self.settings)
        low, high = bands[-1].low_hz, bands[0].high_hz
        peaks = SpectralPeaks(self.samples)
        reasons = [self._against(mode, (low, high), peaks) for mode in modes]
        for mode, why in zip(modes, reasons, strict=True):
            if why:
                log.debug('%.4g Hz, of the likelihood alone: %s', mode.frequency_hz, why)
        return [not why for why in reasons]

    def _against(self, mode: Mode, band_hz: tuple[float, float], peaks: SpectralPeaks) -> str:
        """Say what speaks against a mode; empty where nothing does."""
        if not band_hz[0] < mode.frequency_hz < band_hz[1]:
            return f'outside the band of {band_hz[0]:.4g} to {band_hz[1]:.4g} Hz'
        if self._is_line(mode):
            return 'a line, or beside one'
        if not _stands_out(mode, peaks):
            return 'no peak of the spectrum, or an edge'
        if self.explains(mode.frequency_hz, _half_width_hz(mode), mode.shape):
            return "the robot's own motion explains it"
        return ''

    def _is_line(self, mode: Mode) -> bool:
        if mode.damping_ratio > SELECTION.line_damping:
            return False
        near = np.abs(self.lines.frequency_hz / mode.frequency_hz - 1.0) < SELECTION.line_damping
        line = line_at(self.samples, mode.frequency_hz)
        return bool(near.any()) or line.stands_out(SPECTRA.line_chance)


def _half_width_hz(mode: Mode) -> float:
    return mode.damping_ratio * mode.frequency_hz


def _stands_out(mode: Mode, peaks: SpectralPeaks) -> bool:
    if is_edge(peaks, mode.frequency_hz, mode.damping_ratio):
        return False
    chance = peaks.chance(mode.frequency_hz, _half_width_hz(mode))
    return chance is None or chance < SELECTION.peak_chance


def without_doubtful(adopted: Adopted, test: NewModeTest) -> Adopted:
    """Return the modes without new ones that something speaks against."""
    new = [index for index, origin in enumerate(adopted.origin) if origin == NEW]
    if not new:
        return adopted
    credible = test.passes([adopted.modes.modes[index] for index in new])
    doubtful = {index for index, good in zip(new, credible, strict=True) if not good}
    kept = [index for index in range(len(adopted.origin)) if index not in doubtful]
    modes = tuple(adopted.modes.modes[index] for index in kept)
    origin = tuple(adopted.origin[index] for index in kept)
    return replace(adopted, modes=replace(adopted.modes, modes=modes), origin=origin)
