"""Options that several commands share as a whole, each group one record.

A command marked with :func:`grouped` takes such a record where its help shows the single options.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, Field, field, fields, is_dataclass, MISSING
import inspect
from pathlib import Path
from typing import Annotated, Any, cast, TYPE_CHECKING

import typer

from autonomous_modal_analysis.console.options import (
    channel_names,
    Channels,
    LayoutPath,
    Mark,
    numbers,
    RecordingPath,
    RobotName,
    SampleRate,
    setting_option,
    Spindle,
    Topics,
    Unit,
)
from excitation_planner.rapid_options import RapidOptions
from excitation_planner.request import PlanRequest
from modal_core.channel import SensorLayout
from modal_core.errors import SettingsError
from modal_core.files.real_path import real_path
from modal_core.files.yaml_file import load_yaml
from modal_core.settings.schema import parameter_values, read_values, SettingField, settings_of
from oma_identifier.settings import IdentificationSettings
from robot_bridge.playback_settings import PlaybackSettings

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.modal_result import ModalResult
    from autonomous_modal_analysis.api.recording import Recording
    from autonomous_modal_analysis.api.settings import Settings
    from autonomous_modal_analysis.console.terminal import ProgressCallback
    from structural_model.flexible_joint_model import FlexibleJointModel


@dataclass(frozen=True, slots=True)
class Reading:
    """What of a recording is used, and how a plain array is to be read."""

    topic: Topics = None
    sample_rate_hz: SampleRate = None
    unit: Unit = None
    channels: Channels = None
    mark: Mark = None
    spindle: Spindle = None

    def open_file(self, path: Path, to_look: bool = False) -> 'Recording':
        """Open a recording; ``to_look`` also when it has nothing to identify.

        Raises
        ------
        RecordingError
            It cannot be read.
        """
        import autonomous_modal_analysis as ama

        return ama.open(
            path,
            topics=tuple(self.topic) if self.topic else None,
            sample_rate_hz=self.sample_rate_hz,
            unit=self.unit,
            channel_names=channel_names(self.channels),
            to_look=to_look,
            mark=self.mark,
            spindle=self.spindle,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Source(Reading):
    """Which recording, what of it, and how a plain array is to be read."""

    recording: RecordingPath

    def open(self, to_look: bool = False) -> 'Recording':
        """Open the recording; ``to_look`` also when it has nothing to identify.

        Raises
        ------
        RecordingError
            It cannot be read.
        """
        return self.open_file(self.recording, to_look)

    def parameters(self) -> dict[str, object]:
        """Return the same as parameters of the replay node.

        Raises
        ------
        SettingsError
            Only a part is to be used.
        """
        if self.mark:
            raise SettingsError('a recording is played as a whole', where='--mark')
        if self.spindle:
            raise SettingsError('responses and joints alone are played', where='--spindle')
        return {
            'recording': str(real_path(self.recording)),
            'topics': self.topic or [''],
            'sample_rate_hz': self.sample_rate_hz or 0.0,
            'unit': self.unit or '',
            'channels': list(channel_names(self.channels) or ('',)),
        }


@dataclass(frozen=True, slots=True)
class Identifier:
    """How a recording is identified."""

    settings: IdentificationSettings = field(default_factory=IdentificationSettings)
    layout: LayoutPath = None
    robot: RobotName = None

    def identify(self, recording: 'Recording', progress: 'ProgressCallback') -> 'ModalResult':
        """Identify a recording.

        Raises
        ------
        ModalAnalysisError
            A setting is out of range, there is no such robot or layout, or the recording cannot
            be identified.
        """
        settings = cast('Settings', asdict(self.settings))
        robot = self.robot or None
        return recording.identify(layout=self.layout, robot=robot, progress=progress, **settings)

    def sensors(self) -> SensorLayout | None:
        """Return the sensor layout: the one named, else the robot's own.

        Raises
        ------
        ModalAnalysisError
            It cannot be read, or does not fit the robot.
        """
        from autonomous_modal_analysis.api.robot import sensors_of

        return sensors_of(self.robot, self.motion(), self.layout)

    def motion(self) -> 'FlexibleJointModel | None':
        """Return the model of the robot that was named; None without one.

        Raises
        ------
        ModelError
            There is no such robot.
        """
        from autonomous_modal_analysis.api.robot import read_robot

        return read_robot(self.robot) if self.robot else None

    def parameters(self) -> dict[str, object]:
        """Return the same as parameters of the identifier node."""
        from modal_core.channel import LAYOUT_FILE
        from structural_model.robot_files import robot_folder

        layout = real_path(self.layout) if self.layout else ''
        if self.robot and not layout:
            layout = robot_folder(self.robot) / LAYOUT_FILE
        return {
            **parameter_values(self.settings),
            'layout_file': str(layout),
            'robot': self.robot or '',
        }


@dataclass(frozen=True, slots=True)
class Playing:
    """How a recording is played."""

    settings: PlaybackSettings = field(default_factory=PlaybackSettings)
    remap: Annotated[
        list[str] | None, typer.Option(help='old:=new topic; may be given more than once.')
    ] = None

    def parameters(self) -> dict[str, object]:
        """Return the same as parameters of the replay node."""
        return {**parameter_values(self.settings), 'remap': self.remap or ['']}


IN_DEGREES = ('start_position', 'approach_from')
"""Of a plan request: commands take these as controller angles or as the names of poses."""


@dataclass(frozen=True, slots=True)
class Wish:
    """What is asked of the planner: a file, and what is given beside it."""

    request: Annotated[
        Path | None, typer.Option(help='YAML file with any fields of a plan request.')
    ] = None
    changes: dict[str, Any] = field(
        default_factory=dict, metadata={'changes': PlanRequest, 'without': IN_DEGREES}
    )

    def values(self) -> dict[str, Any]:
        """Return what was asked, by field of a plan request; an option overrides the file.

        Raises
        ------
        SettingsError
            The file cannot be read, or a field is unknown or out of range.
        """
        asked = load_yaml(self.request) if self.request else {}
        return read_values(PlanRequest, asked | self.changes, where=self.request or '')

    def plan_request(self, **others: Any) -> PlanRequest:
        """Return the request; ``others`` hold where neither file nor options say anything.

        Raises
        ------
        SettingsError
            A field is unknown or out of range.
        """
        return PlanRequest(**others | self.values())


@dataclass(frozen=True, slots=True)
class Program:
    """A plan as a program of the controller: where it is written, and what it calls things."""

    rapid: Annotated[
        Path | None, typer.Option(help='Write the plan as a RAPID module to load by hand.')
    ] = None
    options: RapidOptions = field(default_factory=RapidOptions)


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Let a command take groups of options; its own options stand after them."""
    groups: dict[str, type[Any]] = {}
    options: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        if is_dataclass(parameter.annotation):
            groups[name] = parameter.annotation  # type: ignore[assignment]
            options.extend(_options(groups[name], parameter.kind))
        else:
            options.append(parameter)

    # What must be given stands first, whichever group it is of.
    options.sort(key=lambda option: option.default is not inspect.Parameter.empty)

    def run(**values: Any) -> None:
        made = {name: _take(group, values) for name, group in groups.items()}
        command(**made, **values)

    run.__name__, run.__doc__ = command.__name__, command.__doc__
    run.__annotations__ = {item.name: item.annotation for item in options}
    run.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    return run


def _options(group: type[Any], kind: Any) -> Iterator[inspect.Parameter]:
    """Yield the options of a group: its fields, and the settings of those that are settings."""
    for item in fields(group):
        if 'changes' in item.metadata:
            for each in _changes(item):
                option = setting_option(each, changes=True)
                yield inspect.Parameter(each.name, kind, default=None, annotation=option)
        elif is_dataclass(item.type):
            for each in settings_of(cast(type[Any], item.type)):
                yield inspect.Parameter(
                    each.name, kind, default=each.default, annotation=setting_option(each)
                )
        else:
            default = inspect.Parameter.empty if item.default is MISSING else item.default
            yield inspect.Parameter(item.name, kind, default=default, annotation=item.type)


def _take(group: type[Any], values: dict[str, Any]) -> Any:
    """Take the values of a group's options out of all values."""
    taken: dict[str, Any] = {}
    for item in fields(group):
        if 'changes' in item.metadata:
            given = {each.name: (each, values.pop(each.name)) for each in _changes(item)}
            taken[item.name] = {
                name: _entries(each, value)
                for name, (each, value) in given.items()
                if value is not None
            }
        elif is_dataclass(item.type):
            settings = cast(type[Any], item.type)
            own = {each.name: values.pop(each.name) for each in settings_of(settings)}
            taken[item.name] = settings(**own)
        else:
            taken[item.name] = values.pop(item.name)
    return group(**taken)


def _changes(item: Field[Any]) -> Iterator[SettingField]:
    """Yield the settings that a field of changes may change."""
    for each in settings_of(item.metadata['changes']):
        if each.name not in item.metadata['without']:
            yield each


def _entries(setting: SettingField, value: Any) -> Any:
    """Return the value of an option; one that is a list is given with commas."""
    if not setting.many:
        return value
    if setting.kind is float:
        return list(numbers(value, f'--{setting.name.replace("_", "-")}'))
    return [part.strip() for part in value.split(',')]
