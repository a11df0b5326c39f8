"""Measurements in, tracked modes out: the data path of the identifier, read top to bottom.

The same object serves the node, the command line and the model gap.  It reads no clock: time
comes with the samples.

    measurements → SampleBuffer → Window → RobotSignals (rigid motion and drive lines removed)
      → cleaned_of_one_kind (velocities and displacements differentiated beside accelerations)
      → Synchroniser (late sensors put in step) → SensorChanges (changed ones told apart)
      → RecordStreams (condition, output covariance per band)
      → identify_bands (block Hankel, poles per model order, stabilise, cluster, select with σ)
      → Refiner (maximum likelihood where it holds)
      → ModeTracker → WindowResult
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
import logging

import numpy as np

from modal_core.channel import Channel, SensorLayout
from modal_core.errors import IdentificationError
from modal_core.free_memory import give_back, LARGE_BYTES
from modal_core.measurements import Measurement
from modal_core.mode import ModeSet
from modal_core.quality import DataQuality
from modal_core.samples import Samples
from modal_core.window import Pose, Window
from oma_identifier.identify import (
    check_samples,
    identify_bands,
    identify_parts,
    refine_found,
    result_of,
)
from oma_identifier.intake import SampleBuffer
from oma_identifier.methods import identify_by, method_named
from oma_identifier.motion import (
    Cleaned,
    PeakTest,
    RobotMotion,
    RobotSignals,
    split_inputs,
    with_flags,
    with_inputs,
)
from oma_identifier.one_kind import cleaned_of_one_kind
from oma_identifier.one_thread import one_thread
from oma_identifier.quality import SureDamping
from oma_identifier.record import WholeRecord
from oma_identifier.refinement import Refiner
from oma_identifier.result import WindowResult
from oma_identifier.selection import (
    BandSelector,
    Identified,
    line_evidence,
    no_poles,
    with_lines,
    without_explained,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import (
    empty_spectrum,
    line_at,
    REFRESHED,
    SingularValueSpectrum,
    SlidingSpectrum,
    SpectralPeaks,
)
from oma_identifier.subspace import RecordStreams
from oma_identifier.synchrony import SensorChanges, Synchroniser
from oma_identifier.tracking import ModeTracker, TrackedModes

log = logging.getLogger(__name__)


class IdentificationPipeline:
    """Identifies window after window and keeps the ids of the modes.

    Parameters
    ----------
    settings : IdentificationSettings or None
        None: the defaults.
    layout : SensorLayout or None
        The sensors to expect; None: whatever arrives.
    tracker : ModeTracker or None
        From a checkpoint; None: ids start at 1.
    robot : RobotMotion or None
        Model that predicts rigid motion and lines of the drives from joint states; None: slow
        motion is filtered, and large motion recognised by its size.
    only_whole : bool
        The spectra of single windows are not looked at: where windows overlap, only as many are
        made as that of the whole record needs.
    keeps_record : bool
        Whether :meth:`whole` will be asked for; samples are kept for it.
    """

    def __init__(
        self,
        settings: IdentificationSettings | None = None,
        layout: SensorLayout | None = None,
        tracker: ModeTracker | None = None,
        robot: RobotMotion | None = None,
        *,
        only_whole: bool = False,
        keeps_record: bool = True,
    ) -> None:
        self.settings = settings or IdentificationSettings()
        self.tracker = tracker or ModeTracker()
        self.last_tracked: TrackedModes | None = None
        self._buffer = SampleBuffer(self.settings, layout)
        self._robot_signals = RobotSignals(robot)
        self._synchroniser = Synchroniser()
        self._sensor_changes = SensorChanges()
        self._newest = RecordStreams(self.settings)
        self._keeps_record = keeps_record
        self._record = WholeRecord(self.settings, self._identify_parts)
        self._refiner = Refiner()
        self._damping = SureDamping()
        self._selector = BandSelector()
        refreshed = 1.0 if only_whole else REFRESHED
        self._spectra = SlidingSpectrum(self.settings.max_frequency_hz, refreshed)
        method_named(self.settings.method)

    def _forget(self) -> None:
        """Begin the whole record anew: its sensors were not in step."""
        self._record = WholeRecord(self.settings, self._identify_parts)
        self._damping = SureDamping()

    @property
    def buffer(self) -> SampleBuffer:
        """The sample buffer, for its counters."""
        return self._buffer

    @property
    def channels(self) -> tuple[Channel, ...]:
        """All channels that are expected or have been seen."""
        return self._buffer.channels

    def add(self, measurement: Measurement) -> None:
        """Take in samples or joint states, in order of arrival."""
        self._buffer.add(measurement)

    def windows(self) -> Iterator[Window]:
        """Yield the windows that are complete."""
        yield from self._buffer.windows()

    def finish(self) -> Iterator[Window]:
        """Yield what is left at the end of a record, the last window being partial."""
        yield from self._buffer.finish()

    def identify(self, window: Window) -> WindowResult:
        """Identify the modes of one window.

        A window whose start follows from the last one costs only its new samples.  A window that
        cannot be identified gives no mode; its quality says why.
        """
        if not window.quality.identifiable:
            return self._without_modes(window, window.quality)
        try:
            with one_thread():
                return self._identify(window)
        except (IdentificationError, np.linalg.LinAlgError) as error:
            quality = replace(window.quality, identifiable=False, reason=str(error))
            return self._without_modes(window, quality)

    def _identify(self, window: Window) -> WindowResult:
        cleaned = cleaned_of_one_kind(self._robot_signals.clean(window))
        check_samples(cleaned.samples)
        every = cleaned.samples
        cleaned = self._synchroniser.align(cleaned)
        peaks = self._synchroniser.take_peaks()
        cleaned = self._sensor_changes.mark(every, peaks, cleaned, window.pose)
        del peaks  # Large where channels are many.
        if self._synchroniser.corrects_earlier:
            self._forget()
        samples = cleaned.samples
        spectrum = self._spectra.of(samples)
        if samples.acceleration.nbytes >= LARGE_BYTES:
            give_back()
        if self.settings.method == 'csi':
            cleaned = replace(cleaned, samples=with_inputs(samples, cleaned.motion))
        window = replace(window, quality=with_flags(window.quality, cleaned))
        try:
            found = self._found(cleaned)
        except (IdentificationError, np.linalg.LinAlgError):
            # Too little for a window is not too little for the record.
            self._keep(cleaned, _nothing(samples, self.settings.method), spectrum, window.quality)
            raise
        if samples.acceleration.nbytes >= LARGE_BYTES:
            give_back()
        found = self._with_sure_damping(with_lines(found, cleaned.lines), window.quality)
        self.last_tracked = self._tracked(found.modes, samples.channels, window.pose)
        found = replace(found, modes=self.last_tracked.modes)
        self._keep(cleaned, found, spectrum, window.quality)
        return _result(window, found, spectrum)

    def _keep(
        self,
        cleaned: Cleaned,
        found: Identified,
        spectrum: SingularValueSpectrum,
        quality: DataQuality,
    ) -> None:
        if self._keeps_record:
            self._record.add(cleaned, found, spectrum, quality)

    def _found(self, cleaned: Cleaned) -> Identified:
        """Identify a window by what is carried over from the last one and its new samples."""
        samples = cleaned.samples
        if self.settings.method != 'ssi_cov':
            return self._found_by_method(samples, cleaned.explains)
        self._newest.add(samples)
        sources = self._newest.results()
        found = identify_bands(
            sources,
            samples.channels,
            self.settings,
            partial(line_at, samples),
            cleaned.explains,
            SpectralPeaks(samples),
            self._selector,
        )
        # Where hops are short a search for lines that nobody suspects would cost too much.
        looks = self.settings.refines or len(found.harmonics)
        evidence = line_evidence(samples, found) if looks else None
        found = without_explained(found, evidence)
        if not self.settings.refines:
            return found
        if samples.acceleration.nbytes >= LARGE_BYTES:
            give_back()
        found = refine_found(
            [samples],
            found,
            sources,
            self.settings,
            cleaned.explains,
            self._refiner.adopt,
            self._selector,
        )
        return without_explained(found, evidence)

    def _with_sure_damping(self, found: Identified, quality: DataQuality) -> Identified:
        return replace(found, modes=self._damping.of_window(found.modes, quality))

    def _tracked(
        self, modes: ModeSet, channels: Sequence[Channel], pose: Pose | None
    ) -> TrackedModes:
        """Give modes their ids; what a channel was before it changed is another one to them."""
        names = {c.name: f'{c.name} since {c.since_ns}' for c in channels if c.since_ns}
        own = tuple(names.get(name, name) for name in modes.channel_names)
        tracked = self.tracker.update(replace(modes, channel_names=own), pose)
        as_sent = replace(tracked.modes, channel_names=modes.channel_names)
        return replace(tracked, modes=as_sent)

    def _found_by_method(self, samples: Samples, explains: PeakTest) -> Identified:
        responses, inputs = split_inputs(samples)
        return identify_by(self.settings.method, responses, self.settings, inputs, explains)

    def _identify_parts(self, parts: Sequence[Samples], explains: PeakTest) -> Identified:
        """Identify a record of which stretches may be missing."""
        if self.settings.method == 'ssi_cov':
            return identify_parts(parts, self.settings, explains)
        return self._found_by_method(parts[0], explains)

    def _without_modes(self, window: Window, quality: DataQuality) -> WindowResult:
        log.debug('window %d: %s', window.index, quality.reason)
        self.last_tracked = self.tracker.update(ModeSet((), window.samples.channel_names))
        found = _nothing(window.samples, self.settings.method)
        return _result(replace(window, quality=quality), found, empty_spectrum())

    @property
    def record(self) -> WholeRecord:
        """What :meth:`whole` identifies."""
        return self._record

    def whole(self) -> WindowResult:
        """Identify everything seen so far as one record.

        Memory does not grow with the record: beyond a bound its samples are kept at a lower rate,
        and what lies above is taken from the windows.

        Raises
        ------
        IdentificationError
            No window could be identified yet.
        """
        with one_thread():
            result = self._record.identify()
        modes = self._damping.of_record(result.modes)
        return replace(result, modes=self.tracker.label(modes))


def _nothing(samples: Samples, method: str) -> Identified:
    none = ModeSet((), samples.channel_names, method)
    return Identified(none, none, no_poles(len(samples.channels)))


def _result(window: Window, found: Identified, spectrum: SingularValueSpectrum) -> WindowResult:
    span_ns = window.samples.start_ns, window.samples.end_ns
    return result_of(found, spectrum, window.quality, span_ns, window.index, window.pose)
