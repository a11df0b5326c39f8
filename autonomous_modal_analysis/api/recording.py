"""A recording: what it holds, its samples, its modes."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.api.modal_result import ModalResult
from autonomous_modal_analysis.api.optional import optional
from autonomous_modal_analysis.api.result import Columns, Result
from autonomous_modal_analysis.api.robot import Layout, read_robot, Robot, sensors_of
from autonomous_modal_analysis.api.settings import checked_settings, Settings
from autonomous_modal_analysis.api.uniform_samples import uniform_samples, UniformSamples
from autonomous_modal_analysis.console.terminal import no_progress, ProgressCallback
from autonomous_modal_analysis.identified.identification import identify_recording
from autonomous_modal_analysis.identified.results import plain
from modal_core.errors import SettingsError
from modal_core.files.version import software
from modal_core.units import named_unit
import modal_recordings
from modal_recordings import Attachment, MessageRecording, RecordingInfo
from modal_recordings.messages import attached_software, save_attachments


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Result):
    """A recording that has been opened; :func:`autonomous_modal_analysis.open` returns it.

    What it holds (``info``, and with it the text of the object) and its samples are read at their
    first use, and kept.

    Parameters
    ----------
    source : MessageRecording or ArrayRecording
        The recording itself.
    name : str
        What to call it, usually its file.
    """

    source: modal_recordings.Recording
    name: str

    @cached_property
    def info(self) -> RecordingInfo:
        """Topics, channels, rates, gaps and damage; the recording is read once for it."""
        return self.source.info()

    @cached_property
    def bridge_events(self) -> tuple[str, ...]:
        """What the bridge to a robot said last; empty without one."""
        from modal_recordings.bridge_events import last_events

        return last_events(self.source) if isinstance(self.source, MessageRecording) else ()

    @cached_property
    def attachments(self) -> tuple[Attachment, ...]:
        """Files it carries: robot, sensor layout, software that wrote it; none of arrays."""
        return self.source.attachments()

    def save_attachments(self, folder: str | Path) -> list[Path]:
        """Write the files it carries into a folder, which then is one of a robot (``--robot``).

        Parameters
        ----------
        folder : path
            Made when missing; nothing in it is replaced.

        Returns
        -------
        list of Path
            What was written; empty where it carries none.

        Raises
        ------
        RecordingError
            One cannot be read, has no plain file name, or is there already; then none is written.
        OSError
            The folder cannot be written to.
        """
        return save_attachments(self.attachments, Path(folder), self.source.path)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Names of the channels."""
        return self.info.channels

    @property
    def duration_s(self) -> float:
        """Time from the first to the last sample [s]."""
        return self.info.duration_s

    @property
    def sample_rates_hz(self) -> dict[str, float]:
        """Rate of each topic with accelerations [Hz]."""
        return {
            topic.name: topic.measured_rate_hz or topic.declared_rate_hz
            for topic in self.info.topics
            if topic.usable and set(topic.channels) <= set(self.info.channels)
        }

    @cached_property
    def samples(self) -> UniformSamples:
        """All channels on one uniform grid, as the identifier puts them there.

        Raises
        ------
        RecordingError
            The samples are not one uninterrupted stretch.
        """
        return uniform_samples(self.source, self.info)

    @property
    def sample_rate_hz(self) -> float:
        """Rate of the rows of :meth:`to_array` [Hz]."""
        return self.samples.sample_rate_hz

    def to_array(self) -> NDArray[np.float64]:
        """Return all accelerations on one uniform grid.

        Returns
        -------
        (n_samples, n_channels) array [SI units]
            At ``sample_rate_hz``, columns as ``channel_names``.  Short gaps are filled in; a
            channel that is flat, clipped or lost samples is NaN throughout, but for plain arrays.

        Raises
        ------
        RecordingError
            The samples are not one uninterrupted stretch.
        """
        return self.samples.acceleration.copy()

    def to_dataframe(self) -> Any:
        """Return the samples as a :class:`pandas.DataFrame`, index the time [s] from the first.

        Raises
        ------
        ModalAnalysisError
            pandas is not installed, or the samples are not one uninterrupted stretch.
        """
        pandas = optional('pandas')
        samples = self.samples
        time_s = np.arange(len(samples.acceleration)) / samples.sample_rate_hz
        return pandas.DataFrame(
            samples.acceleration.copy(),
            index=pandas.Index(time_s, name='time_s'),
            columns=list(samples.channel_names),
        )

    def export(self, path: str | Path) -> tuple[str, ...]:
        """Write the samples into a file of another program, on one uniform clock, in SI units.

        Parameters
        ----------
        path : path
            Its ending says which kind: .uff or .unv (58b), .mat, .nc, .parquet, .csv.

        Returns
        -------
        tuple of str
            Channels that are left out: flat, clipped, or with samples lost.

        Raises
        ------
        SettingsError
            The ending says nothing, or no channel is left.
        ModalAnalysisError
            The samples are not one uninterrupted stretch, or a library is not installed.
        OSError
            It cannot be written.
        """
        from autonomous_modal_analysis.export import export_samples, ExportedSamples

        samples = self.samples
        good = [bool(np.isfinite(column).all()) for column in samples.acceleration.T]
        names = [named_unit(name)[0] for name in samples.channel_names]
        both = [*zip(names, samples.units, good, strict=True)]
        if not any(good):
            raise SettingsError('no channel to write', where=self.name)
        exported = ExportedSamples(
            values=samples.acceleration[:, good],
            sample_rate_hz=samples.sample_rate_hz,
            names=tuple(name for name, _, is_good in both if is_good),
            units=tuple(unit for _, unit, is_good in both if is_good),
            about={'recording': self.name, 'software': software()},
        )
        export_samples(Path(path), exported)
        return tuple(name for name, _, is_good in both if not is_good)

    def to_mcap(self, path: str | Path) -> Path:
        """Write the recording as MCAP, which ``ama replay`` plays to live nodes.

        Parameters
        ----------
        path : path
            The .mcap file to write.

        Returns
        -------
        Path
            The same.

        Raises
        ------
        ModalAnalysisError
            It has neither times nor a rate.
        """
        return modal_recordings.to_mcap(self.source, path)

    def identify(
        self,
        *,
        layout: Layout | None = None,
        robot: Robot | None = None,
        progress: ProgressCallback = no_progress,
        **settings: Unpack[Settings],
    ) -> ModalResult:
        """Identify the recording window by window and as a whole, as ``ama identify`` does.

        Parameters
        ----------
        layout : SensorLayout, mapping, path or None
            Links, places and directions of the channels; None: the robot's own.
        robot : str, path, FlexibleJointModel or None
            Whose rigid motion and drive lines, predicted from joint states, are taken out.
        progress : callable
            Told the fraction done, 0..1.
        **settings
            As for :func:`autonomous_modal_analysis.identify`.

        Returns
        -------
        ModalResult

        Raises
        ------
        ModalAnalysisError
            The recording cannot be read or identified, there is no such robot, or a setting is
            unknown or out of range.
        """
        checked = checked_settings(settings)
        model = None if robot is None else read_robot(robot)
        sensors = sensors_of(robot, model, layout)
        found = identify_recording(self.source, checked, sensors, progress, model)
        return ModalResult(found, self.name, model, sensors, self.source)

    def headline(self) -> str:
        """Say how long it is and how many channels it has."""
        info = self.info
        damaged = f', damaged: {"; ".join(info.damage)}' if info.damage else ''
        return (
            f'Recording {self.name}: {info.kind}, {info.duration_s:.6g} s, '
            f'{len(info.channels)} channels{damaged}'
        )

    def columns(self) -> Columns:
        """Return the topics."""
        topics = self.info.topics
        return {
            'topic': [topic.name for topic in topics],
            'message_type': [topic.message_type for topic in topics],
            'n_samples': [topic.n_samples for topic in topics],
            'sample_rate_hz': [t.measured_rate_hz or t.declared_rate_hz for t in topics],
            'channels': [topic.channels for topic in topics],
            'usable': [topic.usable for topic in topics],
        }

    def shown(self) -> Columns:
        """Return the topics that would be used, as texts."""
        used = [topic for topic in self.info.topics if topic.usable]
        return {
            'topic': [topic.name for topic in used],
            'rate [Hz]': [f'{t.measured_rate_hz or t.declared_rate_hz:.6g}' for t in used],
            'samples': [str(topic.n_samples) for topic in used],
            'channels': [listed(topic.channels) for topic in used],
        }

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama info --json`` prints."""
        found: Any = plain(
            {
                **asdict(self.info),
                'duration_s': self.info.duration_s,
                'channels': self.info.channels,
                'bridge_events': self.bridge_events,
                'software': attached_software(self.attachments),
                'attachments': [
                    {
                        **{'name': each.name, 'media_type': each.media_type},
                        **{'n_bytes': each.n_bytes, 'problem': each.problem},
                    }
                    for each in self.attachments
                ],
            }
        )
        return dict(found)


def open_recording(
    path: str | Path,
    *,
    topics: Sequence[str] | None = None,
    sample_rate_hz: float | None = None,
    unit: str | None = None,
    channel_names: Sequence[str] | None = None,
    to_look: bool = False,
    mark: str | None = None,
    spindle: str | None = None,
) -> Recording:
    """Open a recording: rosbag2 folder, .mcap, .db3, ROS 1 .bag, arrays, files of other programs.

    Arrays are .npy, .csv, .tsv or .txt, the others .npz, .uff, .mat, .h5, .nc, .wav,
    .lvm, .tdms or .mf4.
    Neither ROS nor its messages need to be installed.

    Parameters
    ----------
    path : path
        File or folder.
    topics : sequence of str or None
        Use only these topics of messages, or arrays of a file.
    sample_rate_hz : float [Hz] or None
        Rate of a plain array, where neither the file nor ``<file>.yaml`` says it.
    unit : str or None
        Unit of a plain array: m/s^2, g, mm/s, um, um/m, ...
    channel_names : sequence of str or None
        Names of the columns of a plain array.
    to_look : bool
        Open it also when it has nothing to identify.
    mark : str or None
        Channel or column that is high while the robot moves (``ama plan --digital-output``): the
        recording is cut to that.
    spindle : str or None
        Topic (Float64), channel or column with the speed of a spindle [rpm], unless its name or
        unit says Hz or rad/s; None: the topic ``/spindle_speed_rpm`` where there is one.

    Returns
    -------
    Recording

    Raises
    ------
    ModalAnalysisError
        In one line: file, topic or field, what was found and what was expected.

    Examples
    --------
    >>> import numpy as np
    >>> import autonomous_modal_analysis as ama
    >>> np.savetxt('beam.csv', np.random.default_rng(1).normal(size=(6000, 2)), '%.6f', ',',
    ...            header='tip [g],middle [g]', comments='')
    >>> recording = ama.open('beam.csv', sample_rate_hz=100)
    >>> recording
    Recording beam.csv: csv, 59.99 s, 2 channels
      topic  rate [Hz]  samples     channels
       beam        100     6000  tip, middle
    >>> recording.to_array().shape
    (6000, 2)
    """
    opened = modal_recordings.open_recording(
        path,
        sample_rate_hz=sample_rate_hz,
        unit=unit,
        channels=channel_names,
        topics=topics,
        to_look=to_look,
        mark=mark,
        spindle=spindle,
    )
    return Recording(opened, Path(path).name)


MOST_NAMED = 3


def listed(names: Sequence[str]) -> str:
    """Name a few; of many say how many and which come first and last."""
    if len(names) <= MOST_NAMED:
        return ', '.join(names)
    return f'{len(names)}: {names[0]} ... {names[-1]}'
