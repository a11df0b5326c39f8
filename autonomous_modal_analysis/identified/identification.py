"""From a recording to its modes: the pipeline run over a file, faster than real time."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import mode

from autonomous_modal_analysis.console.terminal import ProgressCallback
from autonomous_modal_analysis.identified.joint_sliding import SlidingWatch
from autonomous_modal_analysis.identified.measured_force import measured_force
from autonomous_modal_analysis.identified.plan_record import recorded_edge_hz
from autonomous_modal_analysis.identified.remarks import remarks
from autonomous_modal_analysis.identified.results import Identification, IdentifiedWindow
from autonomous_modal_analysis.spectrogram import SpectrogramWatch
from modal_core.channel import SensorLayout
from modal_core.errors import IdentificationError, LayoutError, SettingsError
from modal_core.measurements import JointSamples
from modal_core.samples import Samples
from modal_core.window import Window
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.of_robot import as_on_arm
from modal_recordings.open_recording import Recording
from modal_reports import Spectrogram
from oma_identifier.covariance import analysed_band, below_edge
from oma_identifier.known_force import KnownForce
from oma_identifier.motion import RobotMotion
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.result import NO_MODE, ONLY_LINES, WindowResult
from oma_identifier.settings import IdentificationSettings
from oma_identifier.windows_ahead import WindowsAhead

UNUSED = {
    'stamp_unconfirmed': 'their stamps agree with nothing else',
    'rate_unconfirmed': 'stamps and counters confirm no rate',
    'rate_refused': 'stamps and counters contradict the rate',
    'clock_apart': 'they keep another time than the others',
    'channel_sent_twice': 'another topic sends channels of the same names',
    'too_many_sources': 'too many sources',
    'overload': 'one source ran too far ahead of the others',
    'joints_unconfirmed': 'stamps of joint states that agree with nothing else',
}
"""Why messages take no part, by the code of the buffer."""
WINDOWS_SHARE = 0.8
"""Of the time of a recording, in its windows: of eight records of random families (384600 and
384601 of four) the whole took 0.4 to 0.8 of it in three, and next to nothing in five."""


@dataclass(frozen=True, slots=True)
class IdentifiedRecording:
    """What one recording holds.

    Parameters
    ----------
    identification : Identification
        Modes of the whole recording and of its windows.
    whole : WindowResult
        Poles and spectrum behind the modes of the whole recording.
    parts : tuple of Samples
        What it was identified from: stretches between gaps, without rigid motion and lines of
        drives, the longest first; of a long recording at a lower rate.
    spectrogram : Spectrogram or None
        Of what was measured, over time and joint speed; None of a recording that is too short.
    """

    identification: Identification
    whole: WindowResult
    parts: tuple[Samples, ...] = ()
    spectrogram: Spectrogram | None = None


def identify_recording(
    recording: Recording,
    settings: IdentificationSettings,
    layout: SensorLayout | None = None,
    progress: ProgressCallback = lambda _: None,
    robot: RobotMotion | None = None,
) -> IdentifiedRecording:
    """Identify a recording window by window and as a whole.

    Parameters
    ----------
    recording : Recording
        From :func:`modal_recordings.open_recording.open_recording`.
    settings : IdentificationSettings
        The defaults need no knob.  Without an upper end of the band, that of the excitation is
        taken from a plan in the recording.
    layout : SensorLayout or None
        Links, places and directions of the channels.
    progress : callable
        Told the fraction done, 0..1.
    robot : RobotMotion or None
        Model that predicts rigid motion and drive lines from the joint states.

    Raises
    ------
    RecordingError
        The recording cannot be read or holds no responses.
    IdentificationError
        It cannot be identified with these settings at all.
    """
    if isinstance(recording, ArrayRecording) and settings.gyroscopes:
        recording = recording.with_gyroscopes()
    recording = as_on_arm(recording, robot.joint_names if robot is not None else (), layout)
    asked, settings = settings, below_edge(settings, recorded_edge_hz(recording))
    force = measured_force(recording) if settings.method == 'force' else None
    pipeline = IdentificationPipeline(settings, layout, robot=robot, force=force, only_whole=True)
    sliding, spectra = SlidingWatch(robot), SpectrogramWatch(robot)
    windows: list[IdentifiedWindow] = []
    rates_hz: list[float] = []
    read_until: list[float] = []

    def take(results: Iterable[WindowResult]) -> None:
        # Poles and spectra of single windows are dropped: a day has thousands of windows.
        for result in results:
            windows.append(identified_window(result))
            progress(WINDOWS_SHARE * read_until[len(windows) - 1])

    def identify(window: Window) -> None:
        _check_band(window, asked)
        rates_hz.append(window.samples.sample_rate_hz)
        read_until.append(recording.fraction_read)
        spectra.add(window)
        take(ahead.identify(window))

    pipeline.add_speed(recording.spindle_speed())
    with WindowsAhead(pipeline) as ahead:
        for measurement in recording.measurements():
            pipeline.add(measurement)
            if isinstance(measurement, JointSamples):
                sliding.add(measurement)
            for window in pipeline.windows():
                identify(window)
        for window in pipeline.finish():
            identify(window)
        take(ahead.rest())
    _check_windows(windows, pipeline, recording)
    whole = _whole(windows, pipeline, recording)
    progress(1.0)
    return IdentifiedRecording(
        identification=Identification(
            modes=whole.modes,
            windows=tuple(windows),
            channels=pipeline.channels,
            quality=whole.quality,
            settings=settings,
            band=analysed_band(mode(rates_hz), pipeline.record.identified_s, asked, settings),
            harmonics=whole.harmonics,
            damage=(*recording.damage(), *_unused(pipeline)),
            remarks=(
                *_left_out(recording, force),
                *remarks(whole, windows, mode(rates_hz), settings),
            ),
            sliding=sliding.found(),
        ),
        whole=whole,
        parts=tuple(pipeline.record.parts()),
        spectrogram=spectra.found(),
    )


def _left_out(recording: Recording, force: KnownForce | None) -> tuple[str, ...]:
    """Return what is no response; a force that takes part is not left out."""
    if force is None:
        return recording.left_out
    used = f'{force.name} left out'
    return tuple(note for note in recording.left_out if not note.startswith(used))


def identified_window(result: WindowResult) -> IdentifiedWindow:
    """Keep of a window what results and reports show."""
    return IdentifiedWindow(
        index=result.index,
        start_ns=result.start_ns,
        end_ns=result.end_ns,
        modes=result.modes,
        quality=result.quality,
        harmonics=result.harmonics,
        pose=result.pose,
    )


def _check_band(window: Window, settings: IdentificationSettings) -> None:
    """Refuse a band that reaches beyond what the samples can hold."""
    highest_hz = window.samples.sample_rate_hz / 2.0
    if settings.max_frequency_hz is not None and settings.max_frequency_hz > highest_hz:
        raise SettingsError(
            'above half the sample rate',
            where='max_frequency_hz',
            found=settings.max_frequency_hz,
            expected=f'<= {highest_hz:g}',
        )


def _unused(pipeline: IdentificationPipeline) -> tuple[str, ...]:
    """Return what was read and not used, one statement each."""
    counters = pipeline.buffer.counters
    return tuple(
        counters.texts.get(reason, f'{counters.reasons[reason]} messages not used: {words}')
        for reason, words in UNUSED.items()
        if reason in counters.reasons
    )


def _check_windows(
    windows: Sequence[IdentifiedWindow], pipeline: IdentificationPipeline, recording: Recording
) -> None:
    """Say why there is nothing to identify, where that is so."""
    path, layout = str(recording.path), pipeline.buffer.layout
    if not windows and layout is not None and 'not_in_layout' in pipeline.buffer.counters.reasons:
        expected = ', '.join(channel.name for channel in layout.channels)
        raise LayoutError(
            f'{layout.name} names no channel of the recording', where=path, expected=expected
        )
    texts = pipeline.buffer.counters.texts
    if not windows and texts:
        raise IdentificationError('; '.join(texts.values()), where=path)
    if not windows and (lost := (*recording.damage(), *_unused(pipeline))):
        raise IdentificationError(f'nothing to identify: {"; ".join(lost)}', where=path)
    if not windows and not pipeline.buffer.channels:
        raise IdentificationError('no accelerations in the recording', where=path)
    if not windows:
        info = recording.info()
        unusable = [topic for topic in info.topics if topic.channels and not topic.usable]
        if unusable and not info.channels:
            said = '; '.join(f'{topic.name}: {topic.reason}' for topic in unusable)
            raise IdentificationError(said, where=path)
        raise IdentificationError(
            'too short for the window',
            where=path,
            found=f'{(info.end_ns - info.start_ns) / 1e9:.4g} s',
            expected=f'{pipeline.settings.window_s:g} s, or a tenth of that at least',
            advice='give a shorter window_s (--window-s)',
        )


def _whole(
    windows: Sequence[IdentifiedWindow], pipeline: IdentificationPipeline, recording: Recording
) -> WindowResult:
    """Identify the whole; where neither it nor any window can be, say what the windows say."""
    try:
        return pipeline.whole()
    except IdentificationError as error:
        known = any(window.quality.identifiable or len(window.modes) for window in windows)
        reasons = {window.quality.reason for window in windows} - {NO_MODE, ONLY_LINES}
        if known or not reasons:
            raise
        raise IdentificationError('; '.join(sorted(reasons)), where=str(recording.path)) from error
