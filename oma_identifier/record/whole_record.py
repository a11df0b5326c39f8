"""A record of any length identified as one, in bounded memory."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from modal_core.errors import IdentificationError
from modal_core.mode import ModeSet
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.samples import Samples
from oma_identifier.covariance import COVARIANCE
from oma_identifier.motion import Cleaned, never, PeakTest
from oma_identifier.record.kept_record import KeptRecord
from oma_identifier.record.line_count import LineCount
from oma_identifier.record.steadiness import N_PARTS, steadiness
from oma_identifier.record.window_length import too_slow
from oma_identifier.record.window_means import WindowMeans
from oma_identifier.record.with_means import with_means, without_mixtures
from oma_identifier.result import result_of, WindowResult
from oma_identifier.selection import Identified, nothing_in, with_lines, without_modes
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import SingularValueSpectrum

MOST_BYTES = 128 * 2**20
"""Of samples kept: six channels at 100 Hz for 15 hours, 42 at 512 Hz for 26 minutes.  With a
quarter of it, ten minutes of two large structures (55 and 83 channels, 60 and 40 modes) were kept
at a quarter of the rate, and what windows of lower orders told above that was 51 modes of 91; as
one record 82 are found."""
MOST_BYTES_ALONE = 256 * 2**20
"""The same for methods whose windows cannot stand in."""
MOST_STRETCHES = 4
"""Sets of channels kept apart; the longest is identified."""
BY_WINDOWS = 'ssi_cov'
"""The method whose records may have gaps, and bands that only windows tell of."""
CHANGED = 'channels_changed'
VARIES = 'modes_vary'
"""Flag of a record in whose windows a mode has frequencies that differ beyond chance."""
SHORT_WINDOWS = 'windows_too_short'
"""Flag of a record with a mode so slow that most windows did not show it."""
FEW_WINDOWS = 'few_windows'
"""Flag of a record with modes of which most windows gave none."""


class Identify(Protocol):
    """Identifies a record of which stretches may be missing."""

    def __call__(
        self, parts: Sequence[Samples], explains: PeakTest, *, is_compared: bool = False
    ) -> Identified:
        """Identify parts, or one that is compared with others of the record."""


@dataclass(slots=True)
class _Stretch:
    """Windows with the same channels and rate; ``last`` as found in the last one, with ids."""

    kept: KeptRecord
    spectrum: SingularValueSpectrum
    last: Identified
    means: WindowMeans = field(default_factory=WindowMeans)
    lines: LineCount = field(default_factory=LineCount)
    removed: LineCount = field(default_factory=LineCount)
    explains: PeakTest = never
    n_windows: int = 0
    n_without: int = 0
    seen_s: float = 0.0


@dataclass(frozen=True, slots=True)
class TakenWindow:
    """A window whose samples are part of a record: a share of them is new."""

    stretch: _Stretch
    share: float

    def note(self, found: Identified) -> None:
        """Note what was found in it, its modes with their ids, window after window."""
        stretch = self.stretch
        stretch.last = found
        stretch.n_without += len(found.modes) == 0
        stretch.lines.add(found.harmonics)
        if self.share > 0.0:
            stretch.means.add(found.modes, self.share)


class WholeRecord:
    """Collects what identifying the whole record needs, window after window.

    The samples are kept, and identified as one stretch is.  Where they are too many for the
    memory they are kept at a lower rate: what lies above that is taken from the windows, which
    are many periods long there.

    Parameters
    ----------
    settings : IdentificationSettings
        As for the windows.
    identify : callable
        Identifies stretches between gaps, the longest first.
    """

    def __init__(self, settings: IdentificationSettings, identify: Identify) -> None:
        self._settings = settings
        self._identify = identify
        self._stretches: list[_Stretch] = []
        self._start_ns = 0
        self._end_ns = 0
        self._quality: DataQuality | None = None
        self._ahead: Identified | None = None

    def take(
        self, cleaned: Cleaned, spectrum: SingularValueSpectrum, quality: DataQuality
    ) -> 'TakenWindow':
        """Take in the samples of a window; what is found in it is noted when it is known."""
        samples = cleaned.samples
        if self._quality is None:
            self._start_ns, self._quality = samples.start_ns, DataQuality()
        self._end_ns, self._ahead = samples.end_ns, None
        stretch = self._stretch(samples, spectrum)
        new_s = stretch.kept.add(samples)
        stretch.seen_s += new_s
        stretch.n_windows += 1
        stretch.explains = cleaned.explains
        stretch.spectrum = _mean(stretch.spectrum, spectrum, stretch.n_windows)
        stretch.removed.add(cleaned.lines)
        self._quality = _joined(self._quality, quality)
        return TakenWindow(stretch, new_s / samples.duration_s)

    def look_ahead(self) -> None:
        """Identify the samples taken, while what is in their windows is not known yet.

        Most of the work of :meth:`identify`, if no more samples are taken.
        """
        if self._stretches and self._settings.method == BY_WINDOWS:
            # What cannot be identified is said by :meth:`identify`.
            with suppress(IdentificationError, np.linalg.LinAlgError):
                self._ahead = self._of_samples(self._longest)

    def _stretch(self, samples: Samples, spectrum: SingularValueSpectrum) -> _Stretch:
        """Return the stretch these samples belong to; channels that come or go start another."""
        for stretch in self._stretches:
            if stretch.kept.fits(samples):
                return stretch
        by_windows = self._settings.method == BY_WINDOWS
        kept = KeptRecord(samples, MOST_BYTES if by_windows else MOST_BYTES_ALONE)
        newest = _Stretch(kept, spectrum, nothing_in(samples, self._settings.method))
        longest = sorted(self._stretches, key=lambda stretch: stretch.seen_s, reverse=True)
        self._stretches = [*longest[: MOST_STRETCHES - 1], newest]
        return newest

    @property
    def _longest(self) -> _Stretch:
        if not self._stretches:
            raise IdentificationError(
                'nothing to identify', expected='at least one window that can be identified'
            )
        return max(self._stretches, key=lambda stretch: stretch.seen_s)

    def parts(self) -> list[Samples]:
        """Return the samples of what is identified, in stretches between gaps."""
        return self._longest.kept.parts()

    @property
    def identified_s(self) -> float:
        """Length of what is identified: the longest time with the same channels [s]."""
        return self._longest.seen_s

    def identify(self) -> WindowResult:
        """Identify all windows added so far as one record.

        Raises
        ------
        IdentificationError
            None was added.
        """
        longest, quality = self._longest, self._quality or DataQuality()
        found, varies = self._joined(longest)
        if longest.means.n_independent < N_PARTS and self._settings.method == BY_WINDOWS:
            steady = steadiness(found.modes, longest.kept.parts()[0], self._modes_of)
            found = with_means(replace(found, modes=steady.modes), steady.lacking)
            varies = varies or steady.varies
        flags = (*quality.flags, *self._flags(longest, found), *([VARIES] if varies else []))
        quality = replace(quality, flags=flags)
        return result_of(found, longest.spectrum, quality, (self._start_ns, self._end_ns))

    def flags_of(self, modes: ModeSet) -> tuple[str, ...]:
        """Return what to say of the windows where modes have the ids they have there."""
        share_of = self._longest.means.share_of
        return (SHORT_WINDOWS,) if too_slow(modes, self._settings.window_s, share_of) else ()

    def _modes_of(self, samples: Samples) -> ModeSet:
        return self._identify([samples], self._longest.explains, is_compared=True).modes

    def _flags(self, longest: _Stretch, found: Identified) -> Iterator[str]:
        if len(self._stretches) > 1:
            yield CHANGED
        if len(found.modes) and 2 * longest.n_without > longest.n_windows:
            yield FEW_WINDOWS

    def _joined(self, longest: _Stretch) -> tuple[Identified, bool]:
        """Return what the samples say, and above the rate they are kept at the windows.

        And whether the windows of a mode disagree.
        """
        kept = longest.kept
        if self._settings.method != BY_WINDOWS:
            self._check_one(kept, kept.parts())
        found = self._of_samples(longest)
        means = without_mixtures(longest.means.means(), found.modes)
        varies = any(mean.varies for mean in means)
        if not kept.is_decimated:
            found = with_means(found, means)
            return with_lines(found, longest.removed.usual(found.harmonics)), varies
        above_hz = COVARIANCE.upper * kept.sample_rate_hz
        found = with_means(found, means, above_hz, longest.last)
        found = with_lines(found, longest.removed.usual(found.harmonics))
        lines = longest.lines.usual(found.harmonics)
        above = [line for line in lines if line.frequency_hz >= above_hz]
        return with_lines(found, above), varies

    def _of_samples(self, longest: _Stretch) -> Identified:
        kept = longest.kept
        least_hz = self._settings.min_frequency_hz or 0.0
        if kept.is_decimated and least_hz >= COVARIANCE.upper * kept.sample_rate_hz:
            return without_modes(longest.last)
        return self._ahead or self._identify(kept.parts(), longest.explains)

    def _check_one(self, kept: KeptRecord, parts: Sequence[Samples]) -> None:
        """Refuse what a method without covariances and likelihood cannot join."""
        if kept.is_decimated or len(parts) > 1:
            raise IdentificationError(
                f'{self._settings.method} cannot identify this record as one',
                found='a gap' if len(parts) > 1 else 'too many samples to keep',
                expected='one stretch of samples',
                advice='use ssi_cov, or shorten the record',
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
        interrupted_ns=tuple(dict.fromkeys((*first.interrupted_ns, *second.interrupted_ns))),
        far_values=tuple(dict.fromkeys((*first.far_values, *second.far_values))),
        excluded=first.excluded and second.excluded,
        flags=tuple(dict.fromkeys((*first.flags, *second.flags))),
    )
