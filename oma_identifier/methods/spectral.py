"""Frequency domain decomposition, plain and enhanced, as methods of the catalogue."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.covariance import plan_bands
from oma_identifier.methods.decomposition import decompose, Decomposition
from oma_identifier.methods.fdd import efdd, fdd
from oma_identifier.motion import never, PeakTest
from oma_identifier.selection import (
    harmonic,
    Identified,
    is_line,
    line_evidence,
    lines_among,
    no_poles,
    SELECTION,
    Suspect,
    suspicious,
    without_explained,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import line_at


@dataclass(frozen=True, slots=True)
class _Peak:
    """A mode read off a spectrum."""

    mode: Mode
    is_too_certain: bool = False
    is_unresolved: bool = False
    line_reach: float = SELECTION.sharp

    @property
    def frequency_hz(self) -> float:
        return self.mode.frequency_hz

    @property
    def damping_ratio(self) -> float:
        return self.mode.damping_ratio


class SpectralMethod:
    """Makes modes of the peaks of a spectrum; every peak may be a line."""

    needs_inputs = False
    find: ClassVar[Callable[..., ModeSet]]

    def identify(
        self,
        samples: Samples,
        settings: IdentificationSettings,
        inputs: NDArray[np.float64] | None = None,
        explains: PeakTest = never,
    ) -> Identified:
        """Identify the modes of one stretch."""
        bands = plan_bands(samples.sample_rate_hz, samples.duration_s, settings)
        band_hz = bands[-1].low_hz, bands[0].high_hz
        spectrum = decompose(samples)
        modes = type(self).find(samples, spectrum, band_hz)
        peaks = [_Peak(mode) for mode in modes]
        suspects = [*suspicious(peaks), *self.suspects(samples, spectrum, band_hz)]
        lines = lines_among(suspects, partial(line_at, samples))
        kept = tuple(
            peak.mode
            for peak in peaks
            if not is_line(peak, lines)
            and not explains(
                peak.frequency_hz,
                peak.frequency_hz * np.nan_to_num(peak.damping_ratio),
                peak.mode.shape,
            )
        )
        found = Identified(
            replace(modes, modes=kept),
            replace(modes, modes=tuple(harmonic(line) for line in lines)),
            no_poles(len(samples.channels)),
        )
        return without_explained(found, line_evidence(samples, found), anywhere=True)

    def suspects(
        self, samples: Samples, spectrum: Decomposition, band_hz: tuple[float, float]
    ) -> list[Suspect]:
        """Return where lines may be besides the modes; unless overridden, nowhere."""
        return []


class Fdd(SpectralMethod):
    """Peaks of the first singular value: no damping and no deviation, both are NaN."""

    name = 'fdd'
    find = fdd


class Efdd(SpectralMethod):
    """Bells fitted by their likelihood, which tells the deviations."""

    name = 'efdd'
    find = efdd

    def suspects(
        self, samples: Samples, spectrum: Decomposition, band_hz: tuple[float, float]
    ) -> list[Suspect]:
        """Return all peaks: that of a line has no bell, and gives no mode."""
        return [Suspect(mode.frequency_hz) for mode in fdd(samples, spectrum, band_hz)]
