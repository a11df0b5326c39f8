"""Measurements in, tracked modes out: the data path of the identifier, read top to bottom.

The same object serves the node, the command line and the model gap.  It reads no clock: time
comes with the samples::

    measurements → SampleBuffer → Window → RobotSignals (rigid motion and drive lines removed)
      → cleaned_of_one_kind (velocities and displacements differentiated beside accelerations)
      → Interruptions (what a sensor did not hear filled in from the others)
      → Synchroniser (late sensors put in step) → SensorChanges (changed ones told apart)
      → WindowFinder:
          RecordStreams (condition, output covariance per band)
          → identify_bands (block Hankel, poles per model order, stabilise, cluster, select with σ)
          → Refiner (maximum likelihood where it holds)
      → ModeTracker → WindowResult
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
import logging

import numpy as np

from modal_core.channel import Channel, SensorLayout
from modal_core.errors import IdentificationError
from modal_core.measurements import JointSamples, Measurement
from modal_core.mode import ModeSet
from modal_core.quality import DataQuality
from modal_core.samples import Samples
from modal_core.spindle_speed import SpindleSpeed
from modal_core.window import Pose, Window
from modal_core.work.free_memory import give_back, LARGE_BYTES
from oma_identifier.identify import check_samples, identify_parts
from oma_identifier.intake import SampleBuffer
from oma_identifier.known_force import KnownForce
from oma_identifier.motion import (
    Cleaned,
    PeakTest,
    RobotMotion,
    RobotSignals,
    with_flags,
    with_inputs,
)
from oma_identifier.one_kind import cleaned_of_one_kind
from oma_identifier.one_thread import one_thread
from oma_identifier.quality import SureDamping, without_unheard
from oma_identifier.record import TakenWindow, WholeRecord
from oma_identifier.result import result_of, WindowResult
from oma_identifier.selection import (
    Identified,
    nothing_in,
    with_lines,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import (
    empty_spectrum,
    REFRESHED,
    SingularValueSpectrum,
    SlidingSpectrum,
)
from oma_identifier.synchrony import Interruptions, SensorChanges, Synchroniser
from oma_identifier.tracking import ModeTracker, TrackedModes
from oma_identifier.window_finder import WindowFinder

log = logging.getLogger(__name__)
NOT_IDENTIFIABLE = IdentificationError, np.linalg.LinAlgError
"""What samples raise that hold no modes, or too little of them."""


@dataclass(frozen=True, slots=True)
class BegunWindow:
    """A window that can be looked for modes in.

    Parameters
    ----------
    window : Window
        With what is known of its health.
    corrects_earlier : bool
        The whole record begins anew with it: its sensors were not in step.
    cleaned : Cleaned or None
        Its samples in step; None where they cannot be identified.
    spectrum : SingularValueSpectrum
        Of these.
    taken : TakenWindow or None
        Its part in the whole record, where that is kept.
    """

    window: Window
    corrects_earlier: bool = False
    cleaned: Cleaned | None = None
    spectrum: SingularValueSpectrum = field(default_factory=empty_spectrum)
    taken: TakenWindow | None = None

    @property
    def wanted(self) -> tuple[Samples, PeakTest]:
        """What :meth:`WindowFinder.find` takes."""
        if self.cleaned is None:
            raise ValueError('this window cannot be identified')
        return self.cleaned.samples, self.cleaned.explains

    def note(self, found: Identified) -> None:
        """Let the whole record know what was found."""
        if self.taken is not None:
            self.taken.note(found)


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
    force : KnownForce or None
        Measured beside the responses; ``force`` needs it.
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
        force: KnownForce | None = None,
        only_whole: bool = False,
        keeps_record: bool = True,
    ) -> None:
        self.settings = settings or IdentificationSettings()
        self.tracker = tracker or ModeTracker()
        self.last_tracked: TrackedModes | None = None
        self._buffer = SampleBuffer(self.settings, layout)
        self.speed: SpindleSpeed | None = None
        self._has_robot, self._force = robot is not None, force
        self._robot_signals = RobotSignals(robot)
        self._interruptions = Interruptions()
        self._synchroniser = Synchroniser()
        self._sensor_changes = SensorChanges()
        self.finder = WindowFinder(self.settings)
        self._keeps_record = keeps_record
        self._record = WholeRecord(self.settings, self._identify_parts)
        self._damping = SureDamping()
        refreshed = 1.0 if only_whole else REFRESHED
        self._spectra = SlidingSpectrum(self.settings.max_frequency_hz, refreshed)

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

    def add_speed(self, speed: SpindleSpeed | None) -> None:
        """Take in the speed of a spindle, before the windows that it belongs to."""
        if speed is not None:
            self.speed = speed if self.speed is None else self.speed.joined(speed)

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
        begun = self.begin(window)
        return self.conclude(begun, lambda: self.finder.find(*begun.wanted))

    def begin(self, window: Window) -> BegunWindow:
        """Clean the samples of a window, and put them in step."""
        if not window.quality.identifiable:
            return BegunWindow(window)
        corrects_earlier = False
        try:
            with one_thread():
                cleaned = self._cleaned(window)
                corrects_earlier = self._synchroniser.corrects_earlier
                spectrum = self._spectra.of(cleaned.samples)
        except NOT_IDENTIFIABLE as error:
            return self._begun(BegunWindow(_refused(window, error), corrects_earlier))
        if cleaned.samples.acceleration.nbytes >= LARGE_BYTES:
            give_back()
        cleaned = self._with_inputs(cleaned, window.joints)
        cleaned = replace(cleaned, samples=self._with_speed(cleaned.samples))
        window = replace(window, quality=with_flags(window.quality, cleaned))
        return self._begun(BegunWindow(window, corrects_earlier, cleaned, spectrum))

    def _begun(self, begun: BegunWindow) -> BegunWindow:
        """Let the whole record have the samples of a window."""
        if begun.corrects_earlier:
            self._record = WholeRecord(self.settings, self._identify_parts)
        if begun.cleaned is None or not self._keeps_record:
            return begun
        taken = self._record.take(begun.cleaned, begun.spectrum, begun.window.quality)
        return replace(begun, taken=taken)

    def _cleaned(self, window: Window) -> Cleaned:
        cleaned = cleaned_of_one_kind(self._robot_signals.clean(window))
        check_samples(cleaned.samples)
        cleaned = self._interruptions.mend(cleaned)
        every = cleaned.samples
        cleaned = self._synchroniser.align(cleaned)
        peaks = self._synchroniser.take_peaks()
        return self._sensor_changes.mark(every, peaks, cleaned, window.pose)

    def _with_speed(self, samples: Samples) -> Samples:
        if self.speed is None:
            return samples
        return replace(samples, speed=self.speed.between(samples.start_ns, samples.end_ns))

    def _with_inputs(self, cleaned: Cleaned, joints: JointSamples | None) -> Cleaned:
        """Return a window with the motion of its joints, where it is on the responses' clock."""
        if self.settings.method == 'force':
            if self._force is None:
                raise IdentificationError(
                    'force needs a measured force',
                    found='no force channel',
                    expected='a table with a column in N beside the responses',
                    advice='use ssi_cov, or record the cutting force',
                )
            return replace(cleaned, samples=self._force.beside(cleaned.samples))
        if self.settings.method == 'csi' and cleaned.motion is None:
            raise IdentificationError(
                "csi needs the joints' motion",
                found='no joint states that cover the window and fit its responses',
                advice='use ssi_cov, or record joint states',
            )
        known = self.settings.known_motion and self._has_robot
        if joints is None or not (known or self.settings.method == 'csi'):
            return cleaned
        n_joints = joints.position.shape[1]
        return replace(cleaned, samples=with_inputs(cleaned.samples, cleaned.motion, n_joints))

    def conclude(self, begun: BegunWindow, find: Callable[[], Identified]) -> WindowResult:
        """Give the modes of a window their ids, and keep what the whole record needs.

        Parameters
        ----------
        begun : BegunWindow
            Windows are concluded in the order in which they were begun.
        find : callable
            Returns what is in its samples, or raises as :meth:`WindowFinder.find` does.
        """
        if begun.corrects_earlier:
            self._damping = SureDamping()
        window, cleaned = begun.window, begun.cleaned
        if cleaned is None:
            return self._without_modes(window)
        try:
            found = find()
        except NOT_IDENTIFIABLE as error:
            # Too little for a window is not too little for the record.
            begun.note(nothing_in(cleaned.samples, self.settings.method))
            return self._without_modes(_refused(window, error))
        samples = cleaned.samples
        if samples.acceleration.nbytes >= LARGE_BYTES:
            give_back()
        found = self._with_sure_damping(with_lines(found, cleaned.lines), window.quality)
        self.last_tracked = self._tracked(found.modes, samples.channels, window.pose)
        found = replace(found, modes=self.last_tracked.modes)
        begun.note(found)
        heard = without_unheard(found.modes, window.quality.channels)
        return _result(window, replace(found, modes=heard), begun.spectrum)

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

    def _identify_parts(
        self, parts: Sequence[Samples], explains: PeakTest, *, is_compared: bool = False
    ) -> Identified:
        """Identify a record of which stretches may be missing, or a part that is compared."""
        parts = [self._with_speed(part) for part in parts]
        if self.settings.method == 'ssi_cov':
            return identify_parts(parts, self.settings, explains, is_compared=is_compared)
        return self.finder.found_by_method(parts[0], explains)

    def _without_modes(self, window: Window) -> WindowResult:
        log.debug('window %d: %s', window.index, window.quality.reason)
        self.last_tracked = self.tracker.update(ModeSet((), window.samples.channel_names))
        return _result(window, nothing_in(window.samples, self.settings.method), empty_spectrum())

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
        modes = self.tracker.label(self._damping.of_record(result.modes))
        modes = without_unheard(modes, result.quality.channels)
        flags = (*result.quality.flags, *self._record.flags_of(modes))
        return replace(result, modes=modes, quality=replace(result.quality, flags=flags))


def _refused(window: Window, error: Exception) -> Window:
    """Return a window whose quality says why nothing is found in it."""
    quality = replace(window.quality, identifiable=False, reason=str(error))
    return replace(window, quality=quality)


def _result(window: Window, found: Identified, spectrum: SingularValueSpectrum) -> WindowResult:
    span_ns = window.samples.start_ns, window.samples.end_ns
    return result_of(found, spectrum, window.quality, span_ns, window.index, window.pose)
