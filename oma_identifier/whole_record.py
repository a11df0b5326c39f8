"""A record of any length identified as one, in bounded memory."""

from dataclasses import dataclass, replace

import numpy as np

from modal_core.errors import IdentificationError
from modal_core.mode import Mode, ModeSet
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.samples import Samples
from oma_identifier.covariance import WhenFull
from oma_identifier.identify import explain, identify_bands
from oma_identifier.motion import never, PeakTest
from oma_identifier.result import WindowResult
from oma_identifier.selection import (
    harmonic,
    Identified,
    SAME_LINE,
    with_lines,
    without_explained,
    without_modes,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import Line, LineEvidence, SingularValueSpectrum
from oma_identifier.subspace import RecordStreams

MOST_STRETCHES = 4
"""Sets of channels kept apart; the longest is identified."""


@dataclass(slots=True)
class _Stretch:
    """Windows with the same channels and rate."""

    streams: RecordStreams
    samples: Samples
    spectrum: SingularValueSpectrum
    n_windows: int = 0
    n_only_lines: int = 0
    explains: PeakTest = never
    evidence: LineEvidence | None = None


@dataclass(slots=True)
class _Sighting:
    line: Line
    n_windows: int = 1


class WholeRecord:
    """Collects what identifying the whole record needs, window after window.

    Parameters
    ----------
    settings : IdentificationSettings
        As for the windows.
    """

    def __init__(self, settings: IdentificationSettings) -> None:
        self._settings = settings
        self._stretches: list[_Stretch] = []
        self._sightings: list[_Sighting] = []
        self._start_ns = 0
        self._end_ns = 0
        self._n_windows = 0
        self._quality = DataQuality()

    def add(
        self,
        samples: Samples,
        found: Identified,
        spectrum: SingularValueSpectrum,
        quality: DataQuality,
        explains: PeakTest = never,
        ahead: RecordStreams | None = None,
        evidence: LineEvidence | None = None,
    ) -> None:
        """Add one identified window, the streams it was identified from, and what its lines do."""
        if self._n_windows == 0:
            self._start_ns = samples.start_ns
        self._end_ns = samples.end_ns
        self._n_windows += 1
        stretch = self._stretch(samples, spectrum)
        stretch.n_windows += 1
        stretch.n_only_lines += len(found.harmonics) > 0 and len(found.modes) == 0
        stretch.streams.add(samples, ahead)
        stretch.streams.release()
        stretch.explains = explains
        if stretch.evidence is not None:
            evidence = stretch.evidence.joined(evidence)
        stretch.evidence = evidence
        stretch.spectrum = _mean(stretch.spectrum, spectrum, stretch.n_windows)
        self._quality = _joined(self._quality, quality)
        for mode in found.harmonics:
            self._see(Line(mode.frequency_hz, mode.shape, 0.0))

    def _stretch(self, samples: Samples, spectrum: SingularValueSpectrum) -> _Stretch:
        """Return the stretch these samples belong to; channels that come or go start another."""
        for stretch in self._stretches:
            same_channels = stretch.samples.channels == samples.channels
            if same_channels and stretch.samples.sample_rate_hz == samples.sample_rate_hz:
                return stretch
        empty = replace(samples, acceleration=samples.acceleration[:0].copy())
        newest = _Stretch(RecordStreams(self._settings, WhenFull.JOIN), empty, spectrum)
        longest = sorted(self._stretches, key=lambda stretch: stretch.n_windows, reverse=True)
        self._stretches = [*longest[: MOST_STRETCHES - 1], newest]
        return newest

    def _see(self, line: Line) -> None:
        for sighting in self._sightings:
            if abs(sighting.line.frequency_hz / line.frequency_hz - 1.0) < SAME_LINE:
                sighting.n_windows += 1
                return
        self._sightings.append(_Sighting(line))

    def _line(self, frequency_hz: float) -> Line | None:
        """Return the line most windows saw there."""
        for sighting in self._sightings:
            near = abs(sighting.line.frequency_hz / frequency_hz - 1.0) < SAME_LINE
            if near and 2 * sighting.n_windows >= self._n_windows:
                return sighting.line
        return None

    def _removed(self, found: ModeSet) -> tuple[Mode, ...]:
        """Return lines that most windows were freed of, so that no pole shows them any more."""
        known = found.frequency_hz
        return tuple(
            harmonic(sighting.line)
            for sighting in self._sightings
            if 2 * sighting.n_windows >= self._n_windows
            and len(sighting.line.shape) == len(found.channel_names)
            and not np.any(np.abs(known / sighting.line.frequency_hz - 1.0) < SAME_LINE)
        )

    def identify(self) -> WindowResult:
        """Identify all windows added so far as one record.

        Raises
        ------
        IdentificationError
            None was added.
        """
        if not self._stretches:
            raise IdentificationError(
                'nothing to identify', expected='at least one window that can be identified'
            )
        longest = max(self._stretches, key=lambda stretch: stretch.n_windows)
        quality = self._quality
        if len(self._stretches) > 1:
            quality = replace(quality, flags=(*quality.flags, 'channels_changed'))
        found = identify_bands(
            longest.streams.results(),
            longest.samples.channels,
            self._settings,
            self._line,
            longest.explains,
        )
        found = without_explained(found, longest.evidence)
        if 2 * longest.n_only_lines > longest.n_windows:
            # What lines leave behind of their modulation adds up over a record, and most windows
            # have nothing else: a mode would have shown in them.
            found = without_modes(found)
        found = with_lines(found, self._removed(found.harmonics))
        return WindowResult(
            index=-1,
            start_ns=self._start_ns,
            end_ns=self._end_ns,
            modes=found.modes,
            harmonics=found.harmonics,
            poles=found.poles,
            spectrum=longest.spectrum,
            quality=explain(quality, found),
        )


def _mean(
    mean: SingularValueSpectrum, newest: SingularValueSpectrum, n_windows: int
) -> SingularValueSpectrum:
    if mean.singular_value.shape != newest.singular_value.shape:
        return mean
    step = (newest.singular_value - mean.singular_value) / n_windows
    return replace(mean, singular_value=mean.singular_value + step)


def _joined(first: DataQuality, second: DataQuality) -> DataQuality:
    """Join the health of two windows: everything that was ever found."""
    known = {channel.name: channel for channel in first.channels}
    for channel in second.channels:
        known[channel.name] = _joined_channel(known.get(channel.name), channel)
    flags = tuple(dict.fromkeys((*first.flags, *second.flags)))
    return DataQuality(flags=flags, channels=tuple(known.values()))


def _joined_channel(first: ChannelQuality | None, second: ChannelQuality) -> ChannelQuality:
    if first is None:
        return second
    return replace(
        second,
        n_interpolated=max(first.n_interpolated, second.n_interpolated),
        n_lost=max(first.n_lost, second.n_lost),
        n_duplicates=max(first.n_duplicates, second.n_duplicates),
        n_reordered=max(first.n_reordered, second.n_reordered),
        jitter_std_s=max(first.jitter_std_s, second.jitter_std_s),
        rms=max(first.rms, second.rms),
        kurtosis=float(np.fmax(first.kurtosis, second.kurtosis)),
        noise_rms=float(np.fmax(first.noise_rms, second.noise_rms)),
        excluded=first.excluded and second.excluded,
        flags=tuple(dict.fromkeys((*first.flags, *second.flags))),
    )
